// Every engine is judged by closed forms and by the direct solver at short steps.
#include <cmath>

#include <gtest/gtest.h>

#include "sim/study/exact_sheet.h"
#include "sim/study/stepped_scene.h"

namespace kirireel {
namespace {

std::vector<study::Engine> availableEngines() {
  std::vector<study::Engine> found;
  for (const study::Engine engine :
       {study::Engine::Direct, study::Engine::SequentialImpulse, study::Engine::Nncg,
        study::Engine::Dantzig, study::Engine::MultiBody, study::Engine::Chipmunk,
        study::Engine::Box2d, study::Engine::Mujoco}) {
    if (study::isAvailable(engine)) found.push_back(engine);
  }
  return found;
}

study::Method fineMethod(study::Engine engine) {
  return {engine, 240, engine == study::Engine::Direct ? 1 : 8, 100};
}

/// One square without target that slides and turns.
struct FreeSquare {
  scene::Scene scene;
  std::vector<model::Brick> bricks;
  Motion motion;

  explicit FreeSquare(double damping) {
    scene = study::sheetScene(1, true);
    scene.environment.linearDamping = scene.environment.angularDamping = damping;
    bricks = model::makeBricks(scene.model.tiles, scene.brick);
    motion = {model::startPoses(scene.model.tiles, bricks), {{{1, 2, 0}, {0, 0, 3}}}};
  }

  void run(study::Engine engine, int steps, const model::Load& load) {
    const auto dynamics = study::dynamicsMaker(fineMethod(engine))(scene, bricks, motion.poses);
    for (int step = 0; step < steps; ++step) {
      dynamics->advance(motion, 1.0 / 240,
                        [&](const Poses&, std::vector<model::Load>& loads) { loads[0] = load; });
    }
  }
};

TEST(Engines, ForcesAccelerateAsNewtonSays) {
  model::Load load;
  load.force << 2, -1, 0, 0, 0, 0.5;
  for (const study::Engine engine : availableEngines()) {
    SCOPED_TRACE(study::toString(engine));
    FreeSquare square(0);
    square.run(engine, 240, load);
    const double rounding = engine == study::Engine::Box2d ? 1e-3 : 1e-10;  // of single precision
    EXPECT_LT((square.motion.velocities[0].linear - Vector3(3, 1, 0)).norm(),
              rounding);  // measured 1e-13, Box2D 2e-4
    const double spin = 3 + 0.5 / square.bricks[0].inertia(2, 2);
    EXPECT_NEAR(square.motion.velocities[0].angular.z(), spin, rounding);  // measured 4e-13, 2e-4
  }
}

TEST(Engines, DampingLeavesItsShareOfTheVelocity) {
  for (const study::Engine engine : availableEngines()) {
    if (engine == study::Engine::MultiBody) continue;  // damps by a rule of its own
    SCOPED_TRACE(study::toString(engine));
    FreeSquare square(0.05);
    square.run(engine, 240, {});
    EXPECT_NEAR(square.motion.velocities[0].linear.x(), 0.95, 1e-4);   // measured 5e-6
    EXPECT_NEAR(square.motion.velocities[0].angular.z(), 2.85, 3e-4);  // measured 2e-5
  }
}

TEST(Engines, OpenASheetAsTheDirectSolverDoes) {
  // One point a hinge: redundant rows are too much for Dantzig's pivoting.
  const scene::Scene scene = study::sheetScene(2, true, model::JointFace::Bottom);
  study::SteppedScene reference(scene, {study::Engine::Direct, 7680});
  for (int step = 0; step < 7680 / 2; ++step) reference.advance();
  for (const study::Engine engine : availableEngines()) {
    SCOPED_TRACE(study::toString(engine));
    study::SteppedScene run(scene, fineMethod(engine));
    for (int step = 0; step < 120; ++step) run.advance();
    ASSERT_TRUE(run.isFinite());
    const double apart = study::vertexError(run.tiles(), reference.tiles()).max;
    EXPECT_LT(apart, 0.02) << "angle " << study::openingAngle(run.motion().poses);
    EXPECT_LT(run.gap(), 1e-3);
  }
}

TEST(Engines, SayWhatTheyAre) {
  EXPECT_EQ(study::toString(study::bulletBaseline()), "sequential impulse 20 x 50");
  EXPECT_EQ(study::toString(study::Method{study::Engine::Direct, 60}), "direct 1/60 s");
  EXPECT_EQ(study::toString(study::Method{study::Engine::Nncg, 240, 4, 50, 0.8}),
            "nncg 4 x 50 erp 0.8");
}

}  // namespace
}  // namespace kirireel
