/// Springs that pull the corners of the hull towards a circle or an oblong round it (Liu, Choi and
/// Mahadevan, "Quasicrystal kirigami", 2022).
#pragma once

#include <vector>

#include "sim/actuation/point_spring.h"
#include "sim/brick/brick.h"
#include "sim/brick/load.h"
#include "sim/model/model.h"
#include "sim/scene/scene.h"

namespace kirireel {

/// One damped spring a corner of the hull, from the corner straight out to the curve: an ellipse
/// round the hull's middle in the plane of x and y.
class BoundarySprings {
 public:
  /// The curve is laid round the start; the corners are the model's hull, or those on the convex
  /// outline of its start where the model has none.
  BoundarySprings(const Model& model, const std::vector<Brick>& bricks,
                  const TargetSpringSettings& settings, const BoundaryCurve& curve);

  /// The load on one brick at a pose: its springs, and the settings' damping.
  Load load(int brick, const Pose& pose) const;

  /// Energy stored in all springs, joules.
  double energy(const Poses& poses) const;

  /// The point of the curve that corner k of the hull is pulled to.
  const Vector3& anchor(int k) const { return anchors_[k]; }

 private:
  TargetSpringSettings settings_;
  std::vector<Vector3> anchors_;                   // one a hull corner
  std::vector<std::vector<PointSpring>> springs_;  // of each brick
};

}  // namespace kirireel
