/// A damped spring between a point of a brick and a point of the world.
#pragma once

#include "sim/brick/load.h"

namespace kirireel {

/// What the spring pulls at, and how.
struct PointSpring {
  Vector3 point = Vector3::Zero();   ///< of the brick, in its axes
  Vector3 anchor = Vector3::Zero();  ///< in the world, metres
  double stiffness = 0;              ///< N/m, from 0
  double damping = 0;                ///< N s/m of the point's velocity, from 0
};

/// Adds the spring's force and its torque about the centre of mass to the brick's load.
/// Forces of the damper are in the load's damping, not in its force, which is that at zero
/// velocity.
void addPointSpring(const PointSpring& spring, const Pose& pose, Load& load);

/// Energy that the spring stores, joules.
double pointSpringEnergy(const PointSpring& spring, const Pose& pose);

}  // namespace kirireel
