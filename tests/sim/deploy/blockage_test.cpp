#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/deploy/deployment.h"
#include "sim/run/assembled_state.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;

model::Tile squareAt(double x, double z) {
  return {{{x, 0, z}, {x + 1, 0, z}, {x + 1, 1, z}, {x, 1, z}}};
}

/// Two unit squares hinged at the bottom along x = 1; the target folds the second by `angle`, above
/// zero towards the tops.
scene::Scene foldedPair(double angle) {
  scene::Scene scene;
  scene.model.tiles = {squareAt(0, 0), squareAt(1, 0)};
  scene.model.joints = {{{0, 1}, {1, 0}}, {{0, 2}, {1, 3}}};
  scene.model.target = scene.model.tiles;
  for (Vector3& vertex : (*scene.model.target)[1].vertices) {
    const double reach = vertex.x() - 1;
    vertex = {1 + reach * std::cos(angle), vertex.y(), reach * std::sin(angle)};
  }
  scene.environment.contacts = scene::ContactFilter::All;
  return scene;
}

std::vector<run::BlockingPair> blockingOf(const scene::Scene& scene) {
  return run::blockingPairs(scene, run::assembleAtTarget(scene).restPoses);
}

TEST(Blockage, AFoldAwayFromTheJointsIsFree) {
  EXPECT_TRUE(blockingOf(foldedPair(-1)).empty());
}

TEST(Blockage, AFoldTowardsTheTopsIsFreedByJointsThere) {
  const std::vector<run::BlockingPair> pairs = blockingOf(foldedPair(1));
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_EQ(pairs[0].tileA, 0);
  EXPECT_EQ(pairs[0].tileB, 1);
  EXPECT_EQ(pairs[0].freeingFace, model::JointFace::Top);
  EXPECT_GT(pairs[0].overlap, 1e-3);
  EXPECT_LT(pairs[0].overlap, 0.02);  // not more than the bricks are thick
  EXPECT_THAT(run::describe(pairs[0], 0), HasSubstr("tiles 0 and 1 by "));
  EXPECT_THAT(run::describe(pairs[0], 1), HasSubstr("tiles 1 and 2 by "));
  EXPECT_THAT(run::describe(pairs[0], 0), HasSubstr("joints on the top"));
}

TEST(Blockage, ThinnerBricksFreeTilesThatLieOnEachOther) {
  scene::Scene scene = foldedPair(0);
  scene.model.joints.clear();
  scene.model.target = {squareAt(0, 0), squareAt(0.3, 0.011)};
  const std::vector<run::BlockingPair> pairs = blockingOf(scene);
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_NEAR(pairs[0].overlap, 0.009, 1e-9);
  EXPECT_FALSE(pairs[0].freeingFace);
  EXPECT_LE(pairs[0].freeingThickness, 0.011 + 1e-4);
  EXPECT_GT(pairs[0].freeingThickness, 0.9 * 0.011);
}

TEST(Blockage, TilesThatCrossAreFreedByNoThickness) {
  scene::Scene scene = foldedPair(0);
  scene.model.joints.clear();
  model::Tile upright;
  for (const Vector3& point : squareAt(0, 0).vertices) {
    upright.vertices.push_back({0.5, point.y(), point.x() - 0.5});
  }
  scene.model.target = {squareAt(0, 0), upright};
  scene.model.tiles = {squareAt(0, 0), squareAt(2, 0)};
  const std::vector<run::BlockingPair> pairs = blockingOf(scene);
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_EQ(pairs[0].freeingThickness, 0);
  EXPECT_THAT(run::describe(pairs[0], 0), HasSubstr("the tiles themselves overlap"));
}

TEST(Blockage, NothingBlocksWithoutContacts) {
  scene::Scene scene = foldedPair(1);
  scene.environment.contacts = scene::ContactFilter::None;
  EXPECT_TRUE(blockingOf(scene).empty());
  scene.environment.contacts = scene::ContactFilter::Unjoined;
  EXPECT_TRUE(blockingOf(scene).empty());
}

TEST(Blockage, ARunThatIsStoppedByContactReportsWhere) {
  const run::DeploymentResult result = deploy::deploy(foldedPair(1), 1.0 / 60, nullptr);
  EXPECT_EQ(result.outcome, run::Outcome::Locked) << result.reason;
  EXPECT_THAT(result.reason, HasSubstr("contact stops tiles 0 and 1"));
  EXPECT_EQ(result.blocking.size(), 1u);
  EXPECT_LT(result.accuracy.penetrationOutsidePivotsMax, 1e-4);  // of a tile of 1 m
}

}  // namespace
}  // namespace kirireel
