#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/generate/families.h"
#include "sim/generate/lattice.h"
#include "sim/scene/conditions.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;

TEST(InitialVelocity, MovesTilesAsOneRigidWhole) {
  generate::TessellationShape shape;
  shape.columns = 2;
  shape.rows = 1;
  const model::Model model = generate::makeTessellation(shape);
  const std::vector<brick::Brick> bricks = brick::makeBricks(model.tiles, {});
  const Poses poses = brick::startPoses(model.tiles, bricks);
  const Vector3 linear(1, 2, 3), angular(0.1, -0.2, 0.3);
  const std::vector<Velocity> velocities =
      scene::initialVelocities({{{}, linear, angular, {}}}, bricks, poses);
  const Vector3 between = poses[1].position - poses[0].position;
  const Vector3 apart = velocities[1].linear - velocities[0].linear;
  EXPECT_LT((apart - angular.cross(between)).norm(), 1e-15);
  EXPECT_LT((0.5 * (velocities[0].linear + velocities[1].linear) - linear).norm(), 1e-15);
  EXPECT_EQ(velocities[1].angular, angular);
  // Several velocities of a tile add up.
  const std::vector<Velocity> both = scene::initialVelocities(
      {{{}, linear, {0, 0, 0}, {}}, {{1}, linear, {0, 0, 0}, {}}}, bricks, poses);
  EXPECT_EQ(both[0].linear, linear);
  EXPECT_EQ(both[1].linear, 2 * linear);
}

TEST(InitialVelocity, RefusesTilesThatTheModelDoesNotHave) {
  model::Model model = generate::makeTessellation({});
  model.fileOrder.countsFrom = 1;
  std::vector<scene::InitialVelocity> velocities = {{{1, 2}, {}, {}, {"scene.toml", 3, 1}}};
  scene::numberAsModel(velocities, model);
  EXPECT_THAT(velocities[0].tiles, testing::ElementsAre(0, 1));
  velocities[0].tiles = {0};
  try {
    scene::numberAsModel(velocities, model);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("scene.toml:3:1: error: the model has tiles 1-"));
    EXPECT_THAT(error.what(), HasSubstr("not 0. Correct this number"));
  }
}

}  // namespace
}  // namespace kirireel
