/// A path of the mechanism with its figures, and its playback at an even pace.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "sim/deploy/continuation.h"
#include "sim/deploy/path_evaluation.h"
#include "sim/deploy/result.h"
#include "sim/deploy/run.h"

namespace kirireel::deploy {

/// A path, and what is known of it.
struct GeometricPath {
  MechanismPath path;                                          ///< its states
  scene::ContactFilter contacts = scene::ContactFilter::None;  ///< that bricks had on it
  std::string contactReason;                                   ///< why, for the summary
  std::string reason;                                          ///< why this path, for the summary
  std::string closedWords;  ///< of a path to the second compact state: how it ends
  PathEvaluation evaluation;                                   ///< its figures
  bool hasCompliantJoints = false;                             ///< joints may be open on the way
  /// Model::rounding is not the last digit of coordinates but how closely the tiles fit.
  bool isFitMeasured = false;
};

/// Joints that are open by less, in tiles, are closed.
inline constexpr double kExactShare = 1e-10;

/// Whether a path is longer than the shortest extension that counts.
bool isExtension(const scene::Scene& scene, const MechanismPath& path);

/// Finds states between two neighbouring states of a path. Joints that are closed in both are
/// closed in between, too.
class StatesBetween {
 public:
  /// The path must outlive this.
  StatesBetween(const scene::Scene& scene, const GeometricPath& found);

  /// The state at a share, 0 to 1, of the way from the state before `state` to it.
  Poses at(std::size_t state, double share);

 private:
  bool isOpen(const Poses& state) const;
  Poses smoothAt(std::size_t state, double share) const;
  void keepIfMoreClosed(const Poses& tried, Poses& poses) const;

  const GeometricPath& found_;
  double tile_;  // metres
  SymmetricStates symmetries_;
  std::vector<model::Brick> bricks_;
  std::vector<model::Pivot> pivots_;
  std::unique_ptr<Dynamics> projection_;  // closes joints
};

/// Walks a path at an even pace within the scene's PathSettings::walkTime, or its duration where
/// that is shorter. Measures each state; samples lie between two states, with joints closed.
DeploymentResult walk(const scene::Scene& scene, const GeometricPath& found,
                      const AssembledState& nearest, double sampleInterval,
                      const SampleObserver& observer);

}  // namespace kirireel::deploy
