/// Bullet's rigid-body world with point joints: the baseline solver. No Bullet header is needed to
/// use it.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/brick/brick.h"
#include "sim/scene/scene.h"

namespace kirireel {

/// A btDiscreteDynamicsWorld in double precision that holds one convex hull a brick, one point
/// joint a pivot, and the ground if there is one.
class BulletWorld {
 public:
  /// `iterations` of the sequential-impulse solver in each step; the environment gives gravity,
  /// damping, contacts and ground.
  BulletWorld(const std::vector<Brick>& bricks, const Poses& start, std::span<const Pivot> pivots,
              const Environment& environment, int iterations);
  ~BulletWorld();
  BulletWorld(const BulletWorld&) = delete;
  BulletWorld& operator=(const BulletWorld&) = delete;

  /// Adds a force at the centre of mass and a torque, world axes, for the next step alone.
  void applyLoad(int brick, const Vector3& force, const Vector3& torque);

  /// Advances by exactly `step` seconds, one internal step.
  void advance(double step);

  /// Reads the poses and velocities of all bricks.
  void readMotion(Motion& motion) const;

  /// Sets the poses and velocities of all bricks.
  void writeMotion(const Motion& motion);

 private:
  struct Internals;
  std::unique_ptr<Internals> internals_;
};

/// The version of Bullet in use, e.g. "3.24".
std::string bulletVersion();

}  // namespace kirireel
