// Every engine is judged by closed forms and by the direct solver at short steps.
#include <cmath>

#include <gtest/gtest.h>

#include "sim/study/exact_sheet.h"
#include "sim/study/stepped_scene.h"

namespace kirireel {
namespace {

std::vector<Engine> availableEngines() {
  std::vector<Engine> found;
  for (const Engine engine :
       {Engine::Direct, Engine::SequentialImpulse, Engine::Nncg, Engine::Dantzig, Engine::MultiBody,
        Engine::Chipmunk, Engine::Box2d, Engine::Mujoco}) {
    if (isAvailable(engine)) found.push_back(engine);
  }
  return found;
}

Method fineMethod(Engine engine) {
  return {engine, 240, engine == Engine::Direct ? 1 : 8, 100};
}

/// One square without target that slides and turns.
struct FreeSquare {
  Scene scene;
  std::vector<Brick> bricks;
  Motion motion;

  explicit FreeSquare(double damping) {
    scene = sheetScene(1, true);
    scene.environment.linearDamping = scene.environment.angularDamping = damping;
    bricks = makeBricks(scene.model.tiles, scene.brick);
    motion = {startPoses(scene.model.tiles, bricks), {{{1, 2, 0}, {0, 0, 3}}}};
  }

  void run(Engine engine, int steps, const Load& load) {
    const auto dynamics = dynamicsMaker(fineMethod(engine))(scene, bricks, motion.poses);
    for (int step = 0; step < steps; ++step) {
      dynamics->advance(motion, 1.0 / 240,
                        [&](const Poses&, std::vector<Load>& loads) { loads[0] = load; });
    }
  }
};

TEST(Engines, ForcesAccelerateAsNewtonSays) {
  Load load;
  load.force << 2, -1, 0, 0, 0, 0.5;
  for (const Engine engine : availableEngines()) {
    SCOPED_TRACE(toString(engine));
    FreeSquare square(0);
    square.run(engine, 240, load);
    const double rounding = engine == Engine::Box2d ? 1e-3 : 1e-10;  // of single precision
    EXPECT_LT((square.motion.velocities[0].linear - Vector3(3, 1, 0)).norm(),
              rounding);  // measured 1e-13, Box2D 2e-4
    const double spin = 3 + 0.5 / square.bricks[0].inertia(2, 2);
    EXPECT_NEAR(square.motion.velocities[0].angular.z(), spin, rounding);  // measured 4e-13, 2e-4
  }
}

TEST(Engines, DampingLeavesItsShareOfTheVelocity) {
  for (const Engine engine : availableEngines()) {
    if (engine == Engine::MultiBody) continue;  // damps by a rule of its own
    SCOPED_TRACE(toString(engine));
    FreeSquare square(0.05);
    square.run(engine, 240, {});
    EXPECT_NEAR(square.motion.velocities[0].linear.x(), 0.95, 1e-4);   // measured 5e-6
    EXPECT_NEAR(square.motion.velocities[0].angular.z(), 2.85, 3e-4);  // measured 2e-5
  }
}

TEST(Engines, OpenASheetAsTheDirectSolverDoes) {
  // One point a hinge: redundant rows are too much for Dantzig's pivoting.
  const Scene scene = sheetScene(2, true, JointFace::Bottom);
  SteppedScene reference(scene, {Engine::Direct, 7680});
  for (int step = 0; step < 7680 / 2; ++step) reference.advance();
  for (const Engine engine : availableEngines()) {
    SCOPED_TRACE(toString(engine));
    SteppedScene run(scene, fineMethod(engine));
    for (int step = 0; step < 120; ++step) run.advance();
    ASSERT_TRUE(run.isFinite());
    const double apart = vertexError(run.tiles(), reference.tiles()).max;
    EXPECT_LT(apart, 0.02) << "angle " << openingAngle(run.motion().poses);
    EXPECT_LT(run.gap(), 1e-3);
  }
}

TEST(Engines, SayWhatTheyAre) {
  EXPECT_EQ(toString(bulletBaseline()), "sequential impulse 20 x 50");
  EXPECT_EQ(toString(Method{Engine::Direct, 60}), "direct 1/60 s");
  EXPECT_EQ(toString(Method{Engine::Nncg, 240, 4, 50, 0.8}), "nncg 4 x 50 erp 0.8");
}

}  // namespace
}  // namespace kirireel
