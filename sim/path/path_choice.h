/// Selects the path that brings a model to its target.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/run/arrival.h"
#include "sim/run/assembled_state.h"
#include "sim/run/search.h"
#include "sim/run/search_budget.h"
#include "sim/scene/scene.h"

namespace kirireel::path {

/// The selected path and the reason for the selection.
struct PathChoice {
  scene::PathSettings path;      ///< Straight or Guided
  std::string reason;            ///< one short phrase for the summary
  bool isFound = false;          ///< it reaches the target, without overlaps if contacts are on
  bool isCollisionFree = false;  ///< no collision on the path
  bool isCutShort = false;       ///< the budget was spent before the search ended
  /// A path that reaches the target, but with overlaps.
  std::optional<scene::PathSettings> through = std::nullopt;
  std::string throughReason = {};  ///< reason for that selection, one short phrase
};

/// Results about the target that are known before the search.
struct TargetFindings {
  run::AssembledState nearest;  ///< see assembleAtTarget()
  bool isBlocked = false;       ///< bricks would overlap there; see blockingPairs()
};

/// Selects a path if the scene leaves the choice to the program. A path that the scene names is
/// kept. First tries paths without contacts, ground and gravity: a path that joints forbid stays
/// forbidden with them. The order is from simple to complex: exact joints before compliant ones,
/// stiff before soft. The first path that reaches the equilibrium of the scene's springs near the
/// target is taken. If bricks overlap on it, paths are tried with contacts and with joints that
/// open by at most a hundredth of a tile. If no path arrives, the one that comes nearest without
/// overlaps is taken. The reason then reports whether wider joints would arrive. Springs without
/// stiffness do not pull. If there is no pull to a target and the tiles' misfit jams exact joints,
/// all joints are compliant. A trial has the same settings as the run. A trial may use a third of
/// the remaining budget. Running out of budget is not a failure, and the reason mentions it.
/// `observer` may be empty. `trials` holds the results of earlier trials, which are not repeated.
/// New results are appended, except for a trial that the observer stopped.
PathChoice choosePath(const scene::Scene& scene, const TargetFindings& atTarget,
                      run::SearchBudget& budget, const run::TrialObserver& observer,
                      std::vector<run::TrialEnd>& trials);

// ------------------------------------------------------------------------------------------------
// Warnings about the target, issued before the run.

/// One line per problem, with figures in metres and in tiles. The target's own joints are open by
/// more than a thousandth of a tile, the target is turned over, or rigid tiles miss it by more than
/// a tenth of a tile. Another warning is about a start that was aligned to its target although
/// ground or obstacles fix its position. Empty without problems or without a pull to the target.
std::vector<std::string> targetWarnings(const scene::Scene& scene);

/// Warns if no state with closed joints was found within a tenth of a tile of the target, beyond
/// the distance that single rigid tiles miss. Otherwise empty.
std::string reachWarning(const scene::Scene& scene, const run::AssembledState& nearest);

}  // namespace kirireel::path
