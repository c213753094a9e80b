#include "sim/trajectory/trajectory.h"

#include "sim/scene/hinge_springs.h"

namespace kirireel {

Subject subjectOf(const Scene& scene) {
  std::vector<Brick> bricks = makeBricks(scene.model.tiles, scene.brick);
  std::vector<HingeSpring> springs = hingeSprings(scene, bricks);
  return {.model = scene.model,
          .brickRule = scene.brick,
          .bricks = std::move(bricks),
          .ground = scene.environment.ground,
          .obstacles = obstacleFaces(scene.environment.obstacles),
          .hingeSprings = std::move(springs),
          .settings = {}};
}

}  // namespace kirireel
