/// Gravity and the damping of free flight.
#pragma once

#include "sim/brick/brick.h"
#include "sim/brick/load.h"
#include "sim/scene/scene.h"

namespace kirireel {

/// Adds gravity and the environment's damping to a brick's load. Damping takes the given part of
/// the velocity away each second, as a viscous force in proportion to mass and inertia.
void addEnvironmentLoad(const Environment& environment, const Brick& brick, const Pose& pose,
                        Load& load);

}  // namespace kirireel
