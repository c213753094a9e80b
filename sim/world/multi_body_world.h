/// Bullet's world of multibodies, which PyBullet runs: a baseline without contacts. No Bullet
/// header is needed to use it.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "sim/brick/brick.h"
#include "sim/scene/scene.h"
#include "sim/world/brick_world.h"

namespace kirireel {

/// A btMultiBodyDynamicsWorld in double precision: each brick a multibody without links, each pivot
/// a point joint between two of them. Nothing collides.
class MultiBodyWorld : public BrickWorld {
 public:
  /// `iterations` of the solver in each step; the environment gives gravity and damping.
  MultiBodyWorld(const std::vector<Brick>& bricks, const Poses& start,
                 std::span<const Pivot> pivots, const Environment& environment, int iterations);
  ~MultiBodyWorld() override;

  void applyLoad(int brick, const Vector3& force, const Vector3& torque) override;
  void advance(double step) override;
  void readMotion(Motion& motion) const override;
  void writeMotion(const Motion& motion) override;

 private:
  struct Internals;
  std::unique_ptr<Internals> internals_;
};

}  // namespace kirireel
