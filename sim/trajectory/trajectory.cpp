#include "sim/trajectory/trajectory.h"

namespace kirireel {

Subject subjectOf(const Scene& scene) {
  return {.model = scene.model,
          .brickRule = scene.brick,
          .bricks = makeBricks(scene.model.tiles, scene.brick),
          .ground = scene.environment.ground,
          .obstacles = obstacleFaces(scene.environment.obstacles),
          .settings = {}};
}

}  // namespace kirireel
