#include "sim/trajectory/trajectory.h"

#include "sim/scene/scene_parts.h"

namespace kirireel {

void Sample::transfer(StateTape& tape) {
  tape.transfer(time, poses, jointGap, targetError, penetration, pinned, steps);
  // Whether there is something comes first, so that playing back knows what to read.
  bool known = mechanics.has_value();
  tape.transfer(known);
  if (!known) return mechanics.reset();
  if (!mechanics) mechanics.emplace();
  tape.transfer(*mechanics);
}

// Bricks are made from the scene's tiles as the run makes them.
Subject subjectOf(const Scene& scene) {
  std::vector<Brick> bricks = makeBricks(scene.model.tiles, scene.brick);
  PairForces pairForces = tiesOf(scene, bricks).pairForces;
  return {.model = scene.model,
          .brickRule = scene.brick,
          .bricks = std::move(bricks),
          .ground = scene.environment.ground,
          .obstacles = obstacleFaces(scene.environment.obstacles),
          .pairForces = std::move(pairForces),
          .settings = {}};
}

}  // namespace kirireel
