/// Which path brings a model to its target.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/deploy/arrival.h"
#include "sim/deploy/assembled_state.h"
#include "sim/deploy/search.h"
#include "sim/deploy/search_budget.h"
#include "sim/scene/scene.h"

namespace kirireel::deploy {

/// A path, and why it was taken.
struct PathChoice {
  scene::PathSettings path;  ///< Straight or Guided
  std::string reason;        ///< one short phrase for the summary
  bool isFound = false;      ///< it arrives, among bricks that touch where they may
  bool isClear = false;      ///< no bricks met on it
  bool isCutShort = false;   ///< the budget ended the search for it
  /// A path that arrives where bricks pass through each other.
  std::optional<scene::PathSettings> through = std::nullopt;
  std::string throughReason = {};  ///< why that was taken, one short phrase
};

/// What is known of the target before the search.
struct TargetFindings {
  AssembledState nearest;  ///< see assembleAtTarget()
  bool isBlocked = false;  ///< bricks would overlap there; see blockingPairs()
};

/// Chooses the scene's path where that is left to the program. Tries paths without contacts, ground
/// and gravity first (a path that joints forbid is no path with them either), from the simplest on,
/// exact joints before compliant ones, stiff ones before soft ones, and takes the first that
/// arrives where the scene's springs come to rest near the target. Where bricks run into each other
/// on it, paths are tried with contacts, joints opening by at most a hundredth of a tile; fewer
/// where bricks have no room at the target. Where none arrives, the one that comes nearest without
/// overlaps is taken, and the reason says whether wider joints would arrive. A
/// path that the scene names is kept. Springs without stiffness pull to nothing. Where nothing
/// pulls to a target and the tiles' misfit makes exact joints lock, joints are compliant
/// throughout. Trials are as the run itself. A trial may cost a third of what is left of the
/// budget: one that is cut short is no trial that failed, and the reason tells of it. `observer`
/// may be empty. `trials` holds how the first trials ended, which are not made again, and gets the
/// others, but not one that the observer stopped.
PathChoice choosePath(const scene::Scene& scene, const TargetFindings& atTarget,
                      SearchBudget& budget, const TrialObserver& observer,
                      std::vector<TrialEnd>& trials);

// ------------------------------------------------------------------------------------------------
// What is wrong with a target, told before the run.

/// One line each, with figures in metres and in tiles, where the scene's target is torn (its own
/// joints are open there by more than a thousandth of a tile), turned over, or out of reach of
/// rigid tiles by more than a tenth of a tile, and where a start was moved onto its target although
/// its place counts (ground, obstacles). Empty where all is well, or nothing pulls to the target.
std::vector<std::string> targetWarnings(const scene::Scene& scene);

/// The same where no state with closed joints was found within a tenth of a tile, beyond what rigid
/// tiles by themselves miss; empty otherwise.
std::string reachWarning(const scene::Scene& scene, const AssembledState& nearest);

}  // namespace kirireel::deploy
