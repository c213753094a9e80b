/// Obstacles as bodies that bricks can be paired with.
#pragma once

#include <optional>
#include <vector>

#include "sim/brick/brick.h"
#include "sim/scene/obstacle.h"

namespace kirireel {

/// A convex piece of an obstacle: a box, a face of a mesh, a sphere.
struct ObstaclePart {
  Brick body;                    ///< its shape; of a sphere the cube round it
  Pose pose;                     ///< where it stays
  std::optional<double> radius;  ///< of a sphere, metres
  double friction = 0;           ///< Coulomb coefficient
  int obstacle = 0;              ///< that it belongs to, from 0
};

/// The parts of all obstacles, in order.
/// Throws InputError for a mesh that cannot be read.
std::vector<ObstaclePart> obstacleParts(const std::vector<Obstacle>& obstacles);

}  // namespace kirireel
