/// Improvement of a found path as a whole.
#pragma once

#include <optional>

#include "sim/path/continuation.h"
#include "sim/run/geometric_path.h"
#include "sim/run/mechanism_path.h"
#include "sim/run/search_budget.h"

namespace kirireel::path {

/// The path with the same ends that minimises the squared second differences of all positions and
/// rotations. It is smoother and has none of the jumps of a path that was followed state by state.
/// Joints stay closed. If they are open along the path, they may open at a price: all of them with
/// hardly more than the least largest opening if the budget allows, or in the same modes. Bricks
/// that may touch by `contacts` are kept apart. The path keeps its symmetries. Absent if the path
/// cannot be improved, if it has more freedom than the budget allows, or if it has more than 250
/// bricks. The caller compares the two. Charges `budget`. Ends early if it is spent or if
/// `shouldContinue`, which may be empty, returns false.
std::optional<run::MechanismPath> smoothed(const scene::Scene& scene,
                                           const run::GeometricPath& found,
                                           scene::ContactFilter contacts, run::SearchBudget& budget,
                                           const PathObserver& shouldContinue = {});

}  // namespace kirireel::path
