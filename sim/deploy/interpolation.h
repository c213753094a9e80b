/// States of a recorded run between its samples.
#pragma once

#include <memory>
#include <vector>

#include "sim/joints/joint_solver.h"
#include "sim/trajectory/trajectory.h"

namespace kirireel {

/// Finds states between two samples of one run. The mechanism has no straight ways: half way
/// between two closed states, places taken straight and rotations by the shortest turn, its joints
/// gape by the square of the turn. So they are closed again, moving the bricks as little as their
/// masses allow, wherever they are closed in both samples.
class StateInterpolator {
 public:
  /// The subject must outlive the interpolator.
  explicit StateInterpolator(const Subject& subject);

  /// The state at a share of the way from one sample to a later one, 0 to 1, with its time, joint
  /// gap and target error; penetration, pins and steps are the earlier sample's. Where the joints
  /// are closed in both samples (to 1e-9 of a tile), they are closed to that in it as well; where
  /// no such state lies between the two, it is the nearer sample's.
  Sample between(const Sample& from, const Sample& to, double share);

 private:
  bool areClosed(const Sample& sample) const;
  Poses closedBetween(const Sample& from, const Sample& to, double share);
  JointSolver& solverFor(const Sample& from, const Sample& to);

  const Subject& subject_;
  std::vector<Pivot> pivots_;
  double tileSize_;                       ///< metres
  std::unique_ptr<JointSolver> inPlane_;  ///< made when first needed, as is the next
  std::unique_ptr<JointSolver> inSpace_;
};

}  // namespace kirireel
