#include "sim/trajectory/trajectory.h"

#include "sim/scene/scene_parts.h"

namespace kirireel::trajectory {

// Bricks are made from the scene's tiles as the run makes them.
Subject subjectOf(const scene::Scene& scene) {
  std::vector<brick::Brick> bricks = brick::makeBricks(scene.model.tiles, scene.brick);
  brick::PairForces pairForces = scene::tiesOf(scene, bricks).pairForces;
  return {.model = scene.model,
          .brickRule = scene.brick,
          .bricks = std::move(bricks),
          .ground = scene.environment.ground,
          .obstacles = scene::obstacleFaces(scene.environment.obstacles),
          .pairForces = std::move(pairForces),
          .settings = {}};
}

}  // namespace kirireel::trajectory
