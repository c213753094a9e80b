#include "sim/scene/scene.h"

#include <gtest/gtest.h>

#include "sim/generate/lattice.h"
#include "sim/scene/scene_needs.h"

namespace kirireel {
namespace {

scene::Scene sheetScene() {
  scene::Scene scene;
  scene.model = generate::makeTessellation({});
  return scene;
}

void expectNeed(const scene::Need& need, bool on, const std::string& reason) {
  EXPECT_EQ(need.on, on);
  EXPECT_EQ(need.reason, reason);
}

TEST(SceneNeeds, FlatStartAndTargetArePlanar) {
  scene::Scene scene = sheetScene();
  expectNeed(scene::sceneNeeds(scene).planar, true, "start and target lie in horizontal planes");
  scene.model.target.reset();
  expectNeed(scene::sceneNeeds(scene).planar, true, "the start lies in a horizontal plane");
}

TEST(SceneNeeds, OneTiltedTileIsNotPlanar) {
  scene::Scene scene = sheetScene();
  scene.model.tiles[3].vertices[2].z() += 1e-6;
  expectNeed(scene::sceneNeeds(scene).planar, false, "the start is not flat");
  scene = sheetScene();
  (*scene.model.target)[3].vertices[2].z() += 1e-6;
  expectNeed(scene::sceneNeeds(scene).planar, false, "the target is not flat");
}

TEST(SceneNeeds, AnotherHeightIsOutOfThePlane) {
  scene::Scene scene = sheetScene();
  for (model::Tile& tile : *scene.model.target) {
    for (Vector3& vertex : tile.vertices) vertex.z() += 0.5;
  }
  expectNeed(scene::sceneNeeds(scene).planar, false, "start and target lie at different heights");
}

TEST(SceneNeeds, ATileThatIsTurnedOverLeavesThePlane) {
  scene::Scene scene = sheetScene();
  std::vector<Vector3>& vertices = (*scene.model.target)[3].vertices;
  std::swap(vertices[0], vertices[2]);  // a square about its diagonal
  expectNeed(scene::sceneNeeds(scene).planar, false, "tiles are turned over at the target");
}

TEST(SceneNeeds, RoundingIsFlat) {
  scene::Scene scene = sheetScene();
  scene.model.tiles[3].vertices[2].z() += 1e-12;
  EXPECT_TRUE(scene::sceneNeeds(scene).planar.on);
}

TEST(SceneNeeds, GravityIsPlanarOnlyOnTheGround) {
  scene::Scene scene = sheetScene();
  scene.environment.gravity = {0, 0, -10};
  expectNeed(scene::sceneNeeds(scene).planar, false, "gravity pulls out of the plane");
  scene.environment.ground = scene::Ground{};
  EXPECT_TRUE(scene::sceneNeeds(scene).planar.on);
  scene.environment.ground = scene::Ground{-0.5};
  expectNeed(scene::sceneNeeds(scene).planar, false, "the sheet does not lie on the ground");
  scene.environment.ground = scene::Ground{};
  scene.environment.gravity = {0, 0, 10};
  expectNeed(scene::sceneNeeds(scene).planar, false, "gravity pulls out of the plane");
  scene.environment.gravity = {0.1, 0, -10};
  expectNeed(scene::sceneNeeds(scene).planar, false, "gravity is not vertical");
}

TEST(SceneNeeds, GravityAlongThePlaneIsPlanarForLigaments) {
  scene::Scene scene = sheetScene();
  scene.environment.gravity = {0, -10, 0};
  expectNeed(scene::sceneNeeds(scene).planar, false, "gravity is not vertical");
  scene.hinges.ligament.emplace();
  EXPECT_TRUE(scene::sceneNeeds(scene).planar.on);
  scene.environment.gravity = {0, -10, -1e-3};
  expectNeed(scene::sceneNeeds(scene).planar, false, "gravity is not vertical");
}

TEST(SceneNeeds, TheUserCanOverrideThePlane) {
  scene::Scene scene = sheetScene();
  scene.solver.planar = false;
  expectNeed(scene::sceneNeeds(scene).planar, false, "requested");
  scene.model.tiles[0].vertices[0].z() = 1;
  scene.solver.planar = true;
  expectNeed(scene::sceneNeeds(scene).planar, true, "requested");
}

TEST(SceneNeeds, ContactsFollowTheFilter) {
  scene::Scene scene = sheetScene();
  scene.environment.contacts = scene::ContactFilter::All;
  expectNeed(scene::sceneNeeds(scene).contacts, true, "all bricks may touch");
  scene.environment.contacts = scene::ContactFilter::Unjoined;
  expectNeed(scene::sceneNeeds(scene).contacts, true, "unjoined bricks may touch");
  scene.environment.contacts = scene::ContactFilter::None;
  expectNeed(scene::sceneNeeds(scene).contacts, false, "not requested");
  scene.environment.contacts = scene::ContactFilter::Auto;
  expectNeed(scene::sceneNeeds(scene).contacts, false, "unless bricks touch on the path");
}

TEST(SceneNeeds, ASingleBrickTouchesNone) {
  scene::Scene scene;
  scene.model = generate::makeTessellation({1, 1});
  expectNeed(scene::sceneNeeds(scene).contacts, false, "a single brick");
}

TEST(SceneNeeds, GroundIsAContactOnlyInSpace) {
  scene::Scene scene = sheetScene();
  expectNeed(scene::sceneNeeds(scene).ground, false, "no ground");
  scene.environment.ground = scene::Ground{};
  expectNeed(scene::sceneNeeds(scene).ground, false,
             "planar: gravity is the normal load, only friction is modelled");
  scene.solver.planar = false;
  expectNeed(scene::sceneNeeds(scene).ground, true, "bricks may touch the ground");
}

TEST(LowestPoint, OfAModelIsOverStartAndTarget) {
  model::Model model = generate::makeTessellation({});
  EXPECT_EQ(scene::lowestPoint(model), 0);
  model.tiles[2].vertices[1].z() = -0.5;
  EXPECT_EQ(scene::lowestPoint(model), -0.5);
  (*model.target)[5].vertices[0].z() = -2;
  EXPECT_EQ(scene::lowestPoint(model), -2);
  model.target.reset();
  EXPECT_EQ(scene::lowestPoint(model), -0.5);
}

TEST(LowestPoint, OfASceneCountsTheThickness) {
  // A tile that faces down is thickened downwards.
  scene::Scene scene;
  scene.model.tiles = {{{{0, 0, 3}, {0, 1, 3}, {1, 1, 3}, {1, 0, 3}}}};
  scene.brick.thickness = 0.25;
  EXPECT_NEAR(scene::lowestPoint(scene), 2.75, 1e-15);
  scene.model.target = {{{{{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}}}};
  EXPECT_NEAR(scene::lowestPoint(scene), 1, 1e-15);
}

}  // namespace
}  // namespace kirireel
