#include <gtest/gtest.h>

#include "tests/support/engine_checks.h"

namespace kirireel {
namespace {

const std::vector<study::Engine> kEngines = {study::kDirect, study::kSequentialImpulse,
                                             study::kNncg, study::kDantzig, study::kMultiBody};

TEST(Engines, ForcesAccelerateAsNewtonSays) {
  for (const study::Engine& engine : kEngines) test::expectForcesAccelerate(engine, 1e-10);
}

TEST(Engines, DampingLeavesItsShareOfTheVelocity) {
  for (const study::Engine& engine : kEngines) {
    if (engine == study::kMultiBody) continue;  // has its own rule of damping
    test::expectDampingLeavesItsShare(engine);
  }
}

TEST(Engines, OpenASheetLikeTheDirectSolver) {
  // One point a hinge: redundant rows are too much for Dantzig's pivoting.
  const scene::Scene scene = study::sheetScene(2, true, model::JointFace::Bottom);
  const std::vector<model::Tile> opened = test::openedSheet(scene);
  for (const study::Engine& engine : kEngines) test::expectOpensSheet(engine, scene, opened);
}

TEST(Engines, HaveNames) {
  EXPECT_EQ(study::toString(study::bulletBaseline()), "sequential impulse 20 x 50");
  EXPECT_EQ(study::toString(study::Method{study::kDirect, 60}), "direct 1/60 s");
  EXPECT_EQ(study::toString(study::Method{study::kNncg, 240, 4, 50, 0.8}), "nncg 4 x 50 erp 0.8");
}

}  // namespace
}  // namespace kirireel
