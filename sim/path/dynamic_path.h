/// Selects the path of a run with dynamics.
#pragma once

#include <optional>
#include <string>

#include "sim/path/planner.h"
#include "sim/run/result.h"
#include "sim/run/search.h"

namespace kirireel::path {

/// The selected path and the reason for the selection.
struct DynamicPath {
  scene::PathSettings path;                                    ///< Straight or Guided
  std::string reason;                                          ///< one short phrase for the summary
  scene::ContactFilter contacts = scene::ContactFilter::None;  ///< of the run; never Auto
  PlannedPath guide;  ///< the kinematic path that guides the tiles; empty if none was searched
};

/// Selects a path if the scene leaves the choice to the program. A path that the scene names is
/// kept. A straight pull is tried first, as a complete run without contacts, ground and gravity. It
/// is taken if it reaches the equilibrium of the scene's springs near the target, and bricks that
/// may touch do not overlap. Otherwise springs guide the tiles along the path of planPath(). If
/// there is no pull to a target and the tiles' misfit jams exact joints, joints are compliant.
/// `observer` may be empty. `straightPull` holds the result of an earlier trial, which is not
/// repeated, or receives it.
DynamicPath chooseDynamicPath(const scene::Scene& scene, const run::AssembledState& nearest,
                              run::SearchBudget& budget, const run::TrialObserver& observer,
                              std::optional<run::TrialEnd>& straightPull);

}  // namespace kirireel::path
