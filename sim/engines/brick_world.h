/// The interface between a deployment and physics engines that solve joints by impulses.
#pragma once

#include "sim/base/geometry.h"

namespace kirireel::engines {

/// Bricks simulated by a physics engine.
class BrickWorld {
 public:
  virtual ~BrickWorld() = default;

  /// Adds a force at the centre of mass and a torque, world axes, for the next step only. Newtons
  /// and newton metres. Loads of several calls for one brick add up.
  virtual void applyLoad(int brick, const Vector3& force, const Vector3& torque) = 0;

  /// Advances by exactly `step` seconds, one internal step. `step` is positive.
  virtual void advance(double step) = 0;

  /// Reads the poses and velocities of all bricks. `motion` has to hold as many poses and
  /// velocities as there are bricks.
  virtual void readMotion(Motion& motion) const = 0;

  /// Sets the poses and velocities of all bricks.
  virtual void writeMotion(const Motion& motion) = 0;
};

}  // namespace kirireel::engines
