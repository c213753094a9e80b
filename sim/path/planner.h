/// Selection of a kinematic path: all candidates, their evaluation and their order.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/run/assembled_state.h"
#include "sim/run/geometric_path.h"
#include "sim/run/path_evaluation.h"
#include "sim/run/search.h"
#include "sim/run/search_budget.h"

namespace kirireel::path {

/// The path that was selected, and all that were tried.
struct PlannedPath {
  std::optional<run::GeometricPath> path;       ///< absent if the scene needs dynamics
  std::vector<run::PathEvaluation> candidates;  ///< in the order in which they were tried
  bool isCutShort = false;                      ///< the budget or the caller ended a candidate
  std::string trouble;                          ///< why there is no path, for the summary
};

/// The contacts of a path with contacts: all, if the scene leaves the choice open.
scene::ContactFilter contactsIfOn(scene::ContactFilter requested);

/// Whether a path arrives without overlaps of bricks that may touch.
bool isCollisionFree(const scene::Scene& scene, const run::GeometricPath& found);

/// Whether bricks that may touch overlap on a path by more than rounding.
bool overlaps(const scene::Scene& scene, const run::GeometricPath& found);

/// Tries the candidates from the start to the state nearest to the target, until one arrives with
/// exact joints and without overlaps. If none does, selects the best one. The result is never
/// empty. `mustBeClosed`: the caller uses no path with open joints, so none is improved.
PlannedPath planPath(const scene::Scene& scene, const run::AssembledState& nearest,
                     run::SearchBudget& budget, const run::TrialObserver& observer,
                     bool mustBeClosed = false);

/// Whether a path is longer than another by more than 2%.
bool extendsFarther(const run::GeometricPath& path, const run::GeometricPath& other);

/// The path to full extension of a scene without a target.
PlannedPath planExtension(const scene::Scene& scene, run::SearchBudget& budget,
                          const run::TrialObserver& observer);

/// A warning about overlaps on the selected path, with suggestions; empty without overlaps.
std::string overlapWarning(const scene::Scene& scene, const PlannedPath& planned);

}  // namespace kirireel::path
