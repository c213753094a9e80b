/// A kinematic path with its figures, and its playback at constant speed.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "sim/run/mechanism_path.h"
#include "sim/run/path_evaluation.h"
#include "sim/run/result.h"
#include "sim/run/run.h"

namespace kirireel::run {

/// A path and its properties.
struct GeometricPath {
  MechanismPath path;                                          ///< its states
  scene::ContactFilter contacts = scene::ContactFilter::None;  ///< contacts along the path
  std::string contactReason;                                   ///< for the contacts, in the summary
  std::string reason;                                          ///< for this path, in the summary
  std::string closedWords;          ///< how a path to the second compact state ends; else empty
  PathEvaluation evaluation;        ///< its figures
  bool hasCompliantJoints = false;  ///< joints may open along the path
};

/// Whether a path has the minimum length of an extension.
bool isExtension(const scene::Scene& scene, const MechanismPath& path);

/// Interpolates two neighbouring states of a path. Joints that are closed in both stay closed.
class StatesBetween {
 public:
  /// Keeps a reference to the path.
  StatesBetween(const scene::Scene& scene, const GeometricPath& found);

  /// The state at a share ([0, 1]) between the state before `state` and `state`.
  Poses at(std::size_t state, double share);
  /// kMomentsBetween equidistant states before `state` and after the one before it, by the cubic
  /// through at(1/3) and at(2/3). The search and the run measure overlaps in these states.
  std::vector<Poses> moments(std::size_t state);

 private:
  bool isOpen(const Poses& state) const;
  Poses smoothAt(std::size_t state, double share) const;

  const GeometricPath& found_;
  double tile_;  // metres
  SymmetricStates symmetries_;
  std::vector<brick::Brick> bricks_;
  std::vector<brick::Pivot> pivots_;
  double closedGap_;                      // of tiles with a misfit, metres
  std::unique_ptr<Dynamics> projection_;  // closes joints
};

/// Plays back a path at constant speed, in the shorter of PathSettings::playTime and the scene's
/// duration. Measures each state. Samples are interpolated between states, with joints closed.
DeploymentResult playBack(const scene::Scene& scene, const GeometricPath& found,
                          const AssembledState& nearest, double sampleInterval,
                          const SampleObserver& observer);

}  // namespace kirireel::run
