/// The default deployment: a path of the mechanism, found as geometry and walked at an even pace.
#pragma once

#include <optional>
#include <string>

#include "sim/deploy/continuation.h"
#include "sim/deploy/deployment.h"
#include "sim/deploy/path_choice.h"
#include "sim/deploy/run.h"

namespace kirireel::deploy {

/// A path that arrives.
struct GeometricPath {
  MechanismPath path;                                          ///< its states
  scene::ContactFilter contacts = scene::ContactFilter::None;  ///< that bricks had on it
  std::string contactReason;                                   ///< why, for the summary
  std::string reason;                                          ///< why this path, for the summary
  /// Bricks may touch, yet pass through each other: no other path was found.
  bool passesThrough = false;
  double grown = 0;                 ///< deepest overlap of any pair beyond its start, metres
  double grownAtEnd = 0;            ///< the same in the last state
  bool hasCompliantJoints = false;  ///< no path with exact joints was found
  double opening = 0;               ///< of compliant joints, the largest on the path, metres
  /// Model::rounding is not the last digit of coordinates but how closely the tiles fit.
  bool isFitMeasured = false;
};

/// The paths that were found.
struct GeometricPaths {
  /// Bricks keep out of each other, or may not touch. If none arrives, one that comes near.
  std::optional<GeometricPath> clear;
  /// Bricks keep out of each other, but joints open on the way.
  std::optional<GeometricPath> compliant;
  std::optional<GeometricPath> through;  ///< arrives, but bricks pass through each other
  bool isCutShort = false;               ///< the budget or the caller ended a trial
  bool mayBeExact = false;               ///< joints may stay closed on a path that was not found
  std::string trouble;                   ///< why there is none, for the summary
};

/// Looks for a path from the start to the state nearest to the target: first without contacts;
/// then, where bricks overlap on the way and the scene lets them touch, with contacts; then with
/// compliant joints, for designs that have no freedom and bricks that wedge.
GeometricPaths findGeometricPaths(const scene::Scene& scene, const TargetFindings& atTarget,
                                  SearchBudget& budget, const TrialObserver& observer);

/// The states that a run passes which was chosen because it arrives, as a path that goes on from
/// where the springs rest to the state nearest to the target. `scene` has its path and contacts;
/// `wanted`: those that were given, which may have been left out since.
GeometricPath tracedPath(const scene::Scene& scene, const PathChoice& choice,
                         scene::ContactFilter wanted, const TargetFindings& atTarget,
                         SearchBudget& budget, const TrialObserver& observer);

/// The path to full extension of a scene without a target.
GeometricPaths findExtension(const scene::Scene& scene, SearchBudget& budget,
                             const TrialObserver& observer);

/// Walks a path at an even pace within the scene's PathSettings::walkTime, or its duration where
/// that is shorter. Measures each state; samples lie between two states, with joints closed.
DeploymentResult walk(const scene::Scene& scene, const GeometricPath& found,
                      const AssembledState& nearest, double sampleInterval,
                      const SampleObserver& observer);

}  // namespace kirireel::deploy
