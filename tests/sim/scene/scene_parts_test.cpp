#include "sim/scene/scene_parts.h"

#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/formats/read_model.h"
#include "sim/generate/lattice.h"
#include "tests/support/files.h"
#include "tests/support/refusal.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;

/// A sheet and its parts.
class ScenePartsTest : public testing::Test {
 protected:
  ScenePartsTest() {
    scene_.model = generate::makeTessellation({});
    scene_.model.name = "sheet";
  }

  void complete() { scene::completeScene(parts_, scene_, warnings_); }

  std::string refusal() {
    return test::refusalOf([&] { complete(); });
  }

  test::TemporaryFolder folder_;
  scene::Scene scene_;
  scene::SceneParts parts_;
  std::vector<std::string> warnings_;
};

TEST_F(ScenePartsTest, ATargetReplacesTheModels) {
  generate::TessellationShape shape;
  shape.startAngle = 0.4;
  const model::Model open = generate::makeTessellation(shape);
  formats::writeTiles(open.tiles, folder_ / "open.txt");
  parts_.targets = {folder_ / "open.txt"};
  scene_.alignment.requested = false;
  complete();
  EXPECT_EQ(scene_.model.target->at(3).vertices, open.tiles[3].vertices);
  EXPECT_TRUE(scene_.timeline.empty());
}

TEST_F(ScenePartsTest, SeveralTargetsAreAChain) {
  formats::writeTiles(scene_.model.tiles, folder_ / "a.txt");
  formats::writeTiles(*scene_.model.target, folder_ / "b.txt");
  parts_.targets = {folder_ / "a.txt", folder_ / "a.txt", folder_ / "b.txt"};
  complete();
  ASSERT_EQ(scene_.timeline.size(), 3u);
  EXPECT_EQ(scene_.timeline[0].when.kind, scene::Trigger::Kind::After);
  EXPECT_EQ(scene_.timeline[1].when.kind, scene::Trigger::Kind::AtTarget);
  EXPECT_EQ(std::get<scene::timeline::GoTo>(scene_.timeline[1].action).tiles.size(), 16u);
  EXPECT_TRUE(std::get<scene::timeline::GoTo>(scene_.timeline[2].action).file.empty());
}

TEST_F(ScenePartsTest, PinsFixedPairsAndLinksAreAdded) {
  const std::size_t joints = scene_.model.joints.size();
  parts_.pinned = {0, 5};
  parts_.fixed = {{0, 1}};
  parts_.links = {{0, 0, 15, 2}};
  complete();
  ASSERT_EQ(scene_.model.joints.size(), joints + 2);
  EXPECT_EQ(scene_.model.joints[joints].kind, model::JointKind::Fixed);
  EXPECT_EQ(scene_.model.joints[joints + 1].kind, model::JointKind::Link);
  EXPECT_GT(scene_.model.joints[joints + 1].apart.norm(), 1);
  ASSERT_EQ(scene_.timeline.size(), 1u);
  EXPECT_EQ(scene::actionName(scene_.timeline[0].action), "pin");
}

/// The largest distance of a tile's vertices from their expected positions.
double targetDistance(const model::Model& model, int tile) {
  double largest = 0;
  for (std::size_t k = 0; k < model.tiles[tile].vertices.size(); ++k) {
    const Vector3 gap = model.tiles[tile].vertices[k] - (*model.target)[tile].vertices[k];
    largest = std::max(largest, gap.norm());
  }
  return largest;
}

TEST_F(ScenePartsTest, ATargetIsMovedOntoTheStartByPinnedTiles) {
  const std::vector<model::Tile> before = scene_.model.tiles;
  scene::SceneParts parts;
  parts.pinned = {0};
  scene::completeScene(parts, scene_, warnings_);
  EXPECT_LT(targetDistance(scene_.model, 0), 1e-14);  // measured 4e-16
  EXPECT_TRUE(scene_.alignment.byHeld);
  EXPECT_GT(scene_.alignment.moved, 0.1);
  EXPECT_NEAR(scene_.alignment.turned, 3.14159265358979323846 / 4, 1e-12);
}

TEST_F(ScenePartsTest, PinsOfTheTimelineCountOnlyIfTheyComeFirst) {
  scene::Scene later = scene_;
  scene_.timeline = {{{}, scene::timeline::Pin{{5}}, {"scene.toml"}}};
  scene::completeScene({}, scene_, warnings_);
  EXPECT_LT(targetDistance(scene_.model, 5), 1e-14);
  later.timeline = {{{scene::Trigger::Kind::AtTime, 1}, scene::timeline::Pin{{5}}, {"scene.toml"}}};
  scene::completeScene({}, later, warnings_);
  EXPECT_GT(targetDistance(later.model, 5), 0.1);
  EXPECT_FALSE(later.alignment.byHeld);
}

// A tile that is released later can still reach its target. It does not define the position of the
// sheet.
TEST_F(ScenePartsTest, TilesThatAreReleasedLaterDoNotAlign) {
  scene::Scene freed = scene_;
  freed.timeline = {
      {scene::Trigger{}, scene::timeline::Pin{{0}}, {"scene.toml", 1}},
      {{scene::Trigger::Kind::AtTime, 1}, scene::timeline::Unpin{}, {"scene.toml", 2}}};
  std::vector<std::string> warnings;
  scene::completeScene({}, freed, warnings);
  EXPECT_FALSE(freed.alignment.byHeld);
}

TEST_F(ScenePartsTest, ATargetKeepsItsPositionOnRequest) {
  const std::vector<model::Tile> before = scene_.model.tiles;
  for (model::Tile& tile : *scene_.model.target) {
    for (Vector3& vertex : tile.vertices) vertex.z() -= 1;
  }
  scene_.alignment.requested = false;
  complete();
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(scene_.model.tiles[i].vertices, before[i].vertices);
  }
  EXPECT_EQ(scene_.alignment.moved, 0);
  scene_.alignment.requested = true;
  complete();
  EXPECT_GE(scene_.alignment.moved, 1);
  EXPECT_THAT(scene::describe(scene_.alignment), HasSubstr("the target was moved by up to "));
  EXPECT_THAT(scene::describe(scene_.alignment), HasSubstr("(`align = false` keeps its position)"));
}

/// The tiles, rotated and moved far from their first position.
std::vector<model::Tile> elsewhere(std::vector<model::Tile> tiles, double angle) {
  const Quaternion turn(Eigen::AngleAxisd(angle, Vector3(1, -2, 0.5).normalized()));
  for (model::Tile& tile : tiles) {
    for (Vector3& vertex : tile.vertices) vertex = turn * vertex + Vector3(30, -20, 10);
  }
  return tiles;
}

/// The largest distance of corresponding vertices.
double distance(const std::vector<model::Tile>& a, const std::vector<model::Tile>& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t k = 0; k < a[i].vertices.size(); ++k) {
      largest = std::max(largest, (a[i].vertices[k] - b[i].vertices[k]).norm());
    }
  }
  return largest;
}

// Invariant: the positions of targets in their files do not matter, and the start keeps its own.
TEST_F(ScenePartsTest, EveryTargetIsMovedOntoTheStart) {
  scene::Scene plain = scene_;
  scene::completeScene({}, plain, warnings_);
  const std::vector<model::Tile> start = scene_.model.tiles, target = *scene_.model.target;
  formats::writeTiles(elsewhere(target, 1), folder_ / "a.txt");
  formats::writeTiles(elsewhere(target, std::numbers::pi), folder_ / "b.txt");
  parts_.targets = {folder_ / "a.txt", folder_ / "b.txt"};
  complete();
  EXPECT_EQ(distance(scene_.model.tiles, start), 0);
  EXPECT_LT(distance(*scene_.model.target, *plain.model.target), 1e-13);
  const auto& goTo = std::get<scene::timeline::GoTo>(scene_.timeline[0].action);
  EXPECT_LT(distance(goTo.tiles, *plain.model.target), 1e-13);
}

// A flat target that lies upside down is the same target.
TEST_F(ScenePartsTest, ATargetUpsideDownIsTurnedOver) {
  scene::Scene plain = scene_;
  scene::completeScene({}, plain, warnings_);
  for (model::Tile& tile : *scene_.model.target) {
    for (Vector3& vertex : tile.vertices) vertex = {vertex.x(), -vertex.y(), 2 - vertex.z()};
  }
  complete();
  EXPECT_LT(distance(*scene_.model.target, *plain.model.target), 1e-13);  // measured below 1e-14
}

TEST_F(ScenePartsTest, PyKirigamisRuleMovesTheStart) {
  const std::vector<model::Tile> target = *scene_.model.target;
  scene_.model.tiles = elsewhere(scene_.model.tiles, 1);
  scene_.alignment.movesStart = true;
  complete();
  EXPECT_EQ(distance(*scene_.model.target, target), 0);
  EXPECT_THAT(scene::describe(scene_.alignment), HasSubstr("the start was moved by up to "));
}

TEST_F(ScenePartsTest, NumbersOfMissingTilesAreRefused) {
  parts_.pinned = {16};
  EXPECT_EQ(refusal(), "`pin`: error: the model has tiles 0-15, not 16. Correct this number");
  parts_ = {};
  parts_.fixed = {{3, 16}};
  EXPECT_EQ(refusal(), "`fix`: error: the model has tiles 0-15, not 16. Correct this number");
  parts_.fixed = {{3, 3}};
  EXPECT_EQ(refusal(), "`fix`: error: tile 3 cannot be joined to itself. Name two tiles");
  parts_ = {};
  parts_.links = {{3, 4, 5, 0}};
  EXPECT_EQ(refusal(), "`link`: error: tile 3 has vertices 0-3, not 4. Correct this number");
  const model::Joint& joint = scene_.model.joints.front();
  parts_.links = {{joint.a.tile, joint.a.vertex, joint.b.tile, joint.b.vertex}};
  EXPECT_THAT(refusal(),
              HasSubstr("are at the same position. Join them in constraints.txt instead"));
}

TEST_F(ScenePartsTest, ATargetOfAnotherShapeIsRefused) {
  generate::TessellationShape shape;
  shape.columns = 5;
  formats::writeTiles(generate::makeTessellation(shape).tiles, folder_ / "other.txt");
  parts_.targets = {folder_ / "other.txt"};
  EXPECT_THAT(refusal(), HasSubstr("other.txt: error: the target has 20 tiles, sheet has 16"));
}

TEST_F(ScenePartsTest, TheTimelineMustFitTheModel) {
  using namespace scene::timeline;
  const FileLocation where{"scene.toml", 4, 1};
  const auto refusalOf = [&](const Action& action, scene::Trigger when = {}) {
    scene_.timeline = {{when, action, where}};
    return refusal();
  };
  const std::string at = "scene.toml:4:1: error: ";
  EXPECT_EQ(refusalOf(Unpin{{20}}), at + "the model has tiles 0-15, not 20. Correct this number");
  EXPECT_EQ(refusalOf(Drag{16, {}, {Vector3::Zero()}}),
            at + "the model has tiles 0-15, not 16. Correct this number");
  EXPECT_EQ(refusalOf(Drag{2, 4, {Vector3::Zero()}}),
            at + "tile 2 has vertices 0-3, not 4. Correct this number");
  EXPECT_THAT(refusalOf(GoTo{folder_ / "none.txt", {}}), HasSubstr("none.txt: error: "));
  scene_.model.target.reset();
  EXPECT_THAT(refusalOf(Quit{}, {scene::Trigger::Kind::AtTarget}),
              HasSubstr(at + "this entry needs a target, but there is none. Add target.txt"));
}

}  // namespace
}  // namespace kirireel
