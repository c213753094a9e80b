// Obstacles as bricks that stay where they are: a box is one brick, each face of a mesh a brick
// without thickness, a sphere the cube round it, which the broad phase needs, with its radius.
#include "sim/world/obstacle_parts.h"

namespace kirireel {
namespace {

ObstaclePart makePart(const Tile& floor, double thickness, double friction, int obstacle) {
  ObstaclePart part;
  part.body = makeBrick(floor, {.thickness = thickness});
  part.pose = startPoses({floor}, {part.body}).front();
  part.friction = friction;
  part.obstacle = obstacle;
  return part;
}

void append(const Obstacle& obstacle, int number, std::vector<ObstaclePart>& parts) {
  const double diameter = 2 * obstacle.radius;
  switch (obstacle.shape) {
    case Obstacle::Shape::Box:
      parts.push_back(makePart(boxFloor(obstacle, obstacle.size), obstacle.size.z(),
                               obstacle.friction, number));
      return;
    case Obstacle::Shape::Sphere:
      parts.push_back(makePart(boxFloor(obstacle, Vector3::Constant(diameter)), diameter,
                               obstacle.friction, number));
      parts.back().radius = obstacle.radius;
      return;
    case Obstacle::Shape::Mesh:
      for (const Tile& face : obstacleFaces(obstacle)) {
        // A face without thickness keeps bricks off on the side from which they come: no plane that
        // held on one side at the start holds on the other.
        parts.push_back(makePart(face, 0, obstacle.friction, number));
      }
  }
}

}  // namespace

std::vector<ObstaclePart> obstacleParts(const std::vector<Obstacle>& obstacles) {
  std::vector<ObstaclePart> parts;
  for (std::size_t k = 0; k < obstacles.size(); ++k) {
    append(obstacles[k], static_cast<int>(k), parts);
  }
  return parts;
}

}  // namespace kirireel
