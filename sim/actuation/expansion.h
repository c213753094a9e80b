/// Expansion: every brick is pushed away from the common centre (PyKirigami's --cm_expansion).
#pragma once

#include <vector>

#include "sim/brick/brick.h"
#include "sim/brick/load.h"
#include "sim/scene/scene.h"

namespace kirireel {

/// The centre of mass of all bricks, metres.
Vector3 centreOfMass(const std::vector<Brick>& bricks, const Poses& poses);

/// F = k (x - centre) - c v on a brick's centre of mass, and the torque damping of the settings.
/// The push grows outwards, so it is taken at the start of a step: its stiffness is zero, only the
/// damping is implicit.
Load expansionLoad(const TargetSpringSettings& settings, const Vector3& centre, const Pose& pose);

}  // namespace kirireel
