/// Gravity and the damping of free flight.
#pragma once

#include <span>
#include <vector>

#include "sim/brick/brick.h"
#include "sim/brick/load.h"
#include "sim/scene/scene.h"

namespace kirireel {

/// Adds gravity and the environment's damping to the load of each of these bricks, which are the
/// first of those that have poses and loads. Damping takes the given part of the velocity away each
/// second, as a viscous force in proportion to mass and inertia.
void addEnvironmentLoads(const Environment& environment, std::span<const Brick> bricks,
                         const Poses& poses, std::vector<Load>& loads);

}  // namespace kirireel
