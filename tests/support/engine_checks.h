// Checks of every engine by closed forms and by the direct solver at short steps.
#pragma once

#include <gtest/gtest.h>

#include "sim/study/exact_sheet.h"
#include "sim/study/stepped_scene.h"

namespace kirireel::test {

inline study::Method fineMethod(const study::Engine& engine) {
  return {engine, 240, engine == study::kDirect ? 1 : 8, 100};
}

/// One square without target that slides and turns.
struct FreeSquare {
  scene::Scene scene;
  std::vector<brick::Brick> bricks;
  Motion motion;

  explicit FreeSquare(double damping) {
    scene = study::sheetScene(1, true);
    scene.environment.linearDamping = scene.environment.angularDamping = damping;
    bricks = brick::makeBricks(scene.model.tiles, scene.brick);
    motion = {brick::startPoses(scene.model.tiles, bricks), {{{1, 2, 0}, {0, 0, 3}}}};
  }

  void run(const study::Engine& engine, int steps, const brick::Load& load) {
    const auto dynamics = study::dynamicsMaker(fineMethod(engine))(scene, bricks, motion.poses);
    for (int step = 0; step < steps; ++step) {
      dynamics->advance(motion, 1.0 / 240,
                        [&](const Poses&, std::vector<brick::Load>& loads) { loads[0] = load; });
    }
  }
};

/// `rounding` of the engine's arithmetic.
inline void expectForcesAccelerate(const study::Engine& engine, double rounding) {
  SCOPED_TRACE(engine.name);
  brick::Load load;
  load.force << 2, -1, 0, 0, 0, 0.5;
  FreeSquare square(0);
  square.run(engine, 240, load);
  EXPECT_LT((square.motion.velocities[0].linear - Vector3(3, 1, 0)).norm(),
            rounding);  // measured 1e-13, Box2D 2e-4
  const double spin = 3 + 0.5 / square.bricks[0].inertia(2, 2);
  EXPECT_NEAR(square.motion.velocities[0].angular.z(), spin, rounding);  // measured 4e-13, 2e-4
}

inline void expectDampingLeavesItsShare(const study::Engine& engine) {
  SCOPED_TRACE(engine.name);
  FreeSquare square(0.05);
  square.run(engine, 240, {});
  EXPECT_NEAR(square.motion.velocities[0].linear.x(), 0.95, 1e-4);   // measured 5e-6
  EXPECT_NEAR(square.motion.velocities[0].angular.z(), 2.85, 3e-4);  // measured 2e-5
}

/// The sheet after half a second, by short steps of the direct solver.
inline std::vector<model::Tile> openedSheet(const scene::Scene& scene) {
  study::SteppedScene reference(scene, {study::kDirect, 7680});
  for (int step = 0; step < 7680 / 2; ++step) reference.advance();
  return reference.tiles();
}

inline void expectOpensSheet(const study::Engine& engine, const scene::Scene& scene,
                             const std::vector<model::Tile>& opened) {
  SCOPED_TRACE(engine.name);
  study::SteppedScene run(scene, fineMethod(engine));
  for (int step = 0; step < 120; ++step) run.advance();
  ASSERT_TRUE(run.isFinite());
  const double apart = trajectory::vertexDistance(run.tiles(), opened).largest;
  EXPECT_LT(apart, 0.02) << "angle " << study::openingAngle(run.motion().poses);
  EXPECT_LT(run.gap(), 1e-3);
}

}  // namespace kirireel::test
