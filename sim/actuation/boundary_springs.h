/// Springs that pull the corners of the hull towards a circle or an oblong round it (Liu, Choi and
/// Mahadevan, "Quasicrystal kirigami", 2022).
#pragma once

#include <vector>

#include "sim/actuation/drive_force.h"
#include "sim/actuation/point_spring.h"

namespace kirireel {

/// One damped spring a corner of the hull, from the corner straight out to the curve: an ellipse
/// round the hull's middle in the plane of x and y.
class BoundarySprings : public DriveForce {
 public:
  /// The curve is laid round the start; the corners are the model's hull, or those on the convex
  /// outline of its start where the model has none. Throws InputError for a hull that the model
  /// names and that cannot be.
  /// The middle of the hull must not be one of its corners. `bricks` are those of the model's
  /// tiles.
  BoundarySprings(const Model& model, const std::vector<Brick>& bricks,
                  const TargetSpringSettings& settings, const BoundaryCurve& curve);

  void addLoads(const Poses& poses, std::vector<Load>& loads) const override;
  double energy(const Poses& poses) const override;
  void addFreeForces(const Poses&, std::vector<Vector3>&) const override {}
  bool isEndless() const override { return false; }

  /// The point of the curve that corner k of the hull is pulled to.
  const Vector3& anchor(int k) const { return anchors_[k]; }

 private:
  TargetSpringSettings settings_;
  std::vector<Vector3> anchors_;                   // one a hull corner
  std::vector<std::vector<PointSpring>> springs_;  // of each brick
};

}  // namespace kirireel
