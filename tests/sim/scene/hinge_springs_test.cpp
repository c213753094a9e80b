#include <cmath>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/brick/stiffness.h"
#include "sim/formats/read_model.h"
#include "sim/generate/lattice.h"
#include "sim/model/convex_parts.h"
#include "sim/scene/scene_needs.h"
#include "sim/scene/scene_parts.h"
#include "tests/support/files.h"
#include "tests/support/refusal.h"

namespace kirireel {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;

/// A sheet of 2 x 2 squares, open by 30 degrees, with springs.
class HingeSpringsOfAScene : public testing::Test {
 protected:
  HingeSpringsOfAScene() { use(model::JointFace::Both); }

  void use(model::JointFace face) {
    generate::TessellationShape shape;
    shape.columns = shape.rows = 2;
    shape.startAngle = 30 * kDegree;
    shape.face = face;
    scene_.model = generate::makeTessellation(shape);
  }

  std::vector<brick::HingeSpring> springs(const std::string& lines = "") {
    if (!lines.empty()) {
      std::ofstream(folder_ / "hinges.txt", std::ios::binary) << lines;
      scene_.hinges.file = folder_ / "hinges.txt";
    }
    std::vector<std::string> warnings;
    scene::completeScene({}, scene_, warnings);
    return scene::hingeSprings(scene_, brick::makeBricks(scene_.model.tiles, scene_.brick));
  }

  std::string refusal(const std::string& lines = "") {
    return test::refusalOf([&] { springs(lines); });
  }

  test::TemporaryFolder folder_;
  scene::Scene scene_;
};

TEST_F(HingeSpringsOfAScene, AreAbsentByDefault) {
  EXPECT_TRUE(springs().empty());
}

TEST_F(HingeSpringsOfAScene, RestAtTheStartByDefault) {
  scene_.hinges.stiffness = 2;
  scene_.hinges.damping = 0.5;
  for (const brick::HingeSpring& spring : springs()) {
    EXPECT_NEAR(spring.rest, 30 * kDegree, 1e-12);
    EXPECT_EQ(spring.stiffness, 2);
    EXPECT_EQ(spring.damping, 0.5);
  }
  scene_.hinges.rest = 60 * kDegree;
  EXPECT_EQ(springs().size(), 4u);
  EXPECT_EQ(springs()[3].rest, 60 * kDegree);
}

TEST_F(HingeSpringsOfAScene, AreOneByOneInAFile) {
  scene_.hinges.stiffness = 2;
  scene_.hinges.rest = 60 * kDegree;
  const std::vector<brick::HingeSpring> found =
      springs("0 1 3 45 0.1\n2 0 - 90  # as stiff as all\n");
  ASSERT_EQ(found.size(), 4u);
  for (const brick::HingeSpring& spring : found) {
    const std::pair<int, int> tiles = std::minmax(spring.hinge.brickA, spring.hinge.brickB);
    const bool isFirst = tiles == std::pair(0, 1);
    const bool isSecond = tiles == std::pair(0, 2);
    EXPECT_EQ(spring.stiffness, isFirst ? 3 : 2);
    EXPECT_EQ(spring.rest, (isFirst ? 45 : isSecond ? 90 : 60) * kDegree);
    EXPECT_EQ(spring.damping, isFirst ? 0.1 : 0);
  }
}

TEST_F(HingeSpringsOfAScene, AreAsStiffAsNecks) {
  scene_.brick.thickness = 0.02;
  scene_.hinges.neck = scene::HingeNeck{0.1, 0.3, 2e9};
  const std::vector<brick::HingeSpring> found = springs("0 1 3\n");
  ASSERT_EQ(found.size(), 4u);
  for (const brick::HingeSpring& spring : found) {
    const bool isOwn = spring.hinge.brickA + spring.hinge.brickB == 1;
    EXPECT_EQ(spring.stiffness, isOwn ? 3 : brick::neckStiffness(2e9, 0.02, 0.1, 0.3));
  }
}

TEST_F(HingeSpringsOfAScene, HaveTheNecksOfTheModel) {
  scene_.brick.thickness = 0.02;
  scene_.hinges.neck = scene::HingeNeck{.youngs = 2e9};
  EXPECT_THAT(refusal(), HasSubstr("`hinge_neck` has only a material, but the model has no neck at "
                                   "the joint between tiles"));
  for (model::Joint& joint : scene_.model.joints) {
    joint.neck = {0.05 + 0.01 * (joint.a.tile + joint.b.tile), 0.3, 0};
  }
  const auto expectWidths = [&](const auto& widthOf) {
    const std::vector<brick::HingeSpring> found = springs();
    ASSERT_EQ(found.size(), 4u);
    for (const brick::HingeSpring& spring : found) {
      EXPECT_EQ(
          spring.stiffness,
          brick::neckStiffness(2e9, 0.02, widthOf(spring.hinge.brickA + spring.hinge.brickB), 0.3));
    }
  };
  expectWidths([](int tiles) { return 0.05 + 0.01 * tiles; });
  // The user's value has priority.
  scene_.hinges.neck = scene::HingeNeck{0.1, 0.3, 2e9};
  expectWidths([](int) { return 0.1; });
}

TEST_F(HingeSpringsOfAScene, MayBeAtOnlySomeHinges) {
  const std::vector<brick::HingeSpring> found = springs("0 1 3\n");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].rest, 30 * kDegree, 1e-12);
}

TEST_F(HingeSpringsOfAScene, AreRefusedIfBricksWouldOverlap) {
  scene_.hinges.stiffness = 1;
  scene_.hinges.rest = -1 * kDegree;
  EXPECT_EQ(refusal(),
            "`hinge_rest`: error: with a rest angle of -1 degrees tiles 0 and 2 overlap. Use [0, "
            "180] degrees");
  scene_.hinges.rest = 181 * kDegree;
  EXPECT_THAT(refusal(), HasSubstr("with a rest angle of 181 degrees tiles 0 and 2 "));
  scene_.hinges.rest.reset();
  EXPECT_THAT(refusal("\n1 3 5 200\n"),
              EndsWith("hinges.txt:2:1: error: with a rest angle of 200 degrees tiles 1 and 3 "
                       "overlap. Use [0, 180] degrees"));
}

TEST_F(HingeSpringsOfAScene, AreRefusedWithoutAxes) {
  use(model::JointFace::Bottom);
  scene_.hinges.stiffness = 1;
  EXPECT_EQ(springs().size(), 4u);  // in the plane
  scene_.solver.planar = false;
  EXPECT_EQ(refusal(),
            "error: springs need hinges, but in space 4 joints at one corner of one face are ball "
            "joints without an axis. Join both faces (column 5 of constraints.txt: 3), or keep the "
            "sheet in its plane (`planar = on`)");
  scene_.model.joints.clear();
  EXPECT_EQ(refusal(),
            "error: springs need hinges, but no two tiles rotate about a common corner or edge. "
            "Remove `hinge_stiffness`");
}

/// A scene of two squares side by side in a FOLD file, folded by 90 degrees along their edge.
scene::Scene foldedByFile(const test::TemporaryFolder& folder, const std::string& faces) {
  std::ofstream(folder / "a.fold", std::ios::binary)
      << R"({"vertices_coords": [[0,0],[1,0],[2,0],[2,1],[1,1],[0,1]], "faces_vertices": )" << faces
      << R"(, "edges_vertices": [[1,4]], "edges_foldAngle": [90]})";
  std::vector<std::string> warnings;
  scene::Scene scene;
  scene.brick.thickness = 0.02;
  scene.model = formats::readModel(folder / "a.fold", std::nullopt, warnings);
  scene.hinges.stiffness = 1;
  return scene;
}

/// The only spring of a scene.
brick::HingeSpring springOf(const scene::Scene& scene) {
  const std::vector<brick::HingeSpring> springs =
      scene::hingeSprings(scene, brick::makeBricks(scene.model.tiles, scene.brick));
  EXPECT_EQ(springs.size(), 1u);
  return springs.at(0);
}

// They rest at the hinge's angle at the target. The same angle folds the sheet there, for either
// orientation of the faces in the file.
TEST(FoldSprings, RestAtTheFoldAnglesOfTheirFile) {
  const test::TemporaryFolder folder;
  for (const char* faces : {"[[0,1,4,5],[1,2,3,4]]", "[[0,1,4,5],[4,3,2,1]]",
                            "[[5,4,1,0],[4,3,2,1]]", "[[1,2,3,4],[0,1,4,5]]"}) {
    scene::Scene scene = foldedByFile(folder, faces);
    const brick::HingeSpring spring = springOf(scene);
    EXPECT_NEAR(std::abs(spring.rest), 90 * kDegree, 1e-15);
    EXPECT_NEAR(spring.hinge.start, 0, 1e-15);
    scene::Scene there = scene;
    there.model.tiles = *scene.model.target;
    EXPECT_NEAR(spring.rest, springOf(there).hinge.start, 1e-15) << faces;
    // A mountain seen from the upper side of the first tile rests on the other side.
    scene.hinges.rest = 20 * kDegree;
    EXPECT_EQ(springOf(scene).rest, std::copysign(20 * kDegree, spring.rest));
    scene.hinges.own = {{0, 1, {}, 40 * kDegree, {}, {}}};
    EXPECT_EQ(springOf(scene).rest, 40 * kDegree);
  }
}

// Each triangle has a hinge to its other half, at rest flat, and one of them to the other square.
TEST(FoldSprings, StayAtTheirEdgeOfSplitTiles) {
  const test::TemporaryFolder folder;
  scene::Scene scene = foldedByFile(folder, "[[0,1,4,5],[1,2,3,4]]");
  scene.model = model::splitTiles(scene.model, {});
  int folded = 0;
  for (const brick::HingeSpring& spring :
       scene::hingeSprings(scene, brick::makeBricks(scene.model.tiles, scene.brick))) {
    EXPECT_TRUE(std::abs(spring.rest) < 1e-12 || spring.rest == 90 * kDegree) << spring.rest;
    folded += spring.rest > 1 ? 1 : 0;
  }
  EXPECT_EQ(folded, 1);
  EXPECT_EQ(scene.model.foldAngles.size(), 2u);
}

// Letters without angles define only the side of a fold.
TEST(FoldSprings, FoldLettersByTheirOwnRest) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "a.fold", std::ios::binary)
      << R"({"vertices_coords": [[0,0],[1,0],[2,0],[2,1],[1,1],[0,1]],
             "faces_vertices": [[0,1,4,5],[1,2,3,4]],
             "edges_vertices": [[1,4]], "edges_assignment": ["M"]})";
  std::vector<std::string> warnings;
  scene::Scene scene = scene::openScene();
  scene.brick.thickness = 0.02;
  scene.model = formats::readModel(folder / "a.fold", std::nullopt, warnings);
  EXPECT_TRUE(scene.model.target);
  scene.hinges.stiffness = 1;
  scene::Scene pulled = scene;
  scene::completeScene({}, pulled, warnings);
  EXPECT_TRUE(pulled.model.target);
  EXPECT_EQ(springOf(pulled).rest, -180 * kDegree);
  scene.hinges.rest = 60 * kDegree;
  scene::completeScene({}, scene, warnings);
  EXPECT_FALSE(scene.model.target);
  EXPECT_EQ(scene.actuation.drive, scene::Drive::None);
  EXPECT_EQ(springOf(scene).rest, -60 * kDegree);
  EXPECT_EQ(scene::sceneNeeds(scene).planar.reason,
            "springs fold the sheet to the angles of its file");
}

// Angles that close around no loop fold the sheet out of its plane, although it has no target.
TEST(FoldSprings, LeaveThePlane) {
  const test::TemporaryFolder folder;
  scene::Scene scene = foldedByFile(folder, "[[0,1,4,5],[1,2,3,4]]");
  scene.model.target.reset();
  EXPECT_EQ(scene::sceneNeeds(scene).planar.reason,
            "springs fold the sheet to the angles of its file");
  scene.hinges.stiffness = 0;
  EXPECT_TRUE(scene::sceneNeeds(scene).planar.on);
}

// The material of tiles defines the bending of split tiles, and of folds by their length scale.
// Requested springs are at the model's own hinges.
TEST(PanelSprings, AreAsStiffAsTheirMaterial) {
  const test::TemporaryFolder folder;
  scene::Scene scene = foldedByFile(folder, "[[0,1,4,5],[1,2,3,4]]");
  scene.hinges.stiffness = 0;
  scene.hinges.rest = 20 * kDegree;
  scene.hinges.panels = scene::PanelMaterial{2e9, 0.3, 0};
  scene.model = model::splitTiles(scene.model, {});
  const auto springs = [&] {
    return scene::hingeSprings(scene, brick::makeBricks(scene.model.tiles, scene.brick));
  };
  const double plate = 2e9 * std::pow(0.02, 3) / (12 * 0.91);
  const double bend = 0.55 * plate * std::cbrt(std::sqrt(2.0) / 0.02);
  ASSERT_EQ(springs().size(), 2u);
  for (const brick::HingeSpring& spring : springs()) {
    EXPECT_NEAR(spring.stiffness, bend, 1e-12 * bend);
    EXPECT_EQ(spring.rest, spring.hinge.start);
  }
  const auto atFold = [&] {
    for (const brick::HingeSpring& spring : springs()) {
      if (spring.rest == 20 * kDegree) return spring.stiffness;
    }
    return 0.0;
  };
  scene.hinges.panels->foldLength = 0.5;
  ASSERT_EQ(springs().size(), 3u);
  EXPECT_NEAR(atFold(), plate / 0.5, 1e-12 * plate);  // the edge is 1 m long
  scene.hinges.stiffness = 7;
  EXPECT_EQ(atFold(), 7);
  scene.hinges.damping = 0.1;
  for (const brick::HingeSpring& spring : springs()) EXPECT_EQ(spring.damping, 0.1);
}

// Panels that touch only at corners have no hinges, which is not an error.
TEST_F(HingeSpringsOfAScene, NeedNoHingesIfOnlyTiles) {
  use(model::JointFace::Bottom);
  scene_.hinges.panels = scene::PanelMaterial{1e9, 0.3, 0.1};
  EXPECT_TRUE(springs().empty());
}

TEST(SplitScenes, HoldAndMoveAllPartsOfATile) {
  scene::Scene scene;
  scene.model = generate::makeTessellation({});
  scene.timeline = {{scene::Trigger{}, scene::timeline::Pin{{5}}, {"`pin`"}},
                    {scene::Trigger{}, scene::timeline::Unpin{{5, 6}}, {}}};
  scene.velocities = {{{2, 5}, Vector3::UnitX(), Vector3::Zero(), {}}, {}};
  scene::splitTiles({5, 6}, scene);
  EXPECT_EQ(std::get<scene::timeline::Pin>(scene.timeline[0].action).tiles,
            (std::vector<int>{5, 16}));
  EXPECT_EQ(std::get<scene::timeline::Unpin>(scene.timeline[1].action).tiles,
            (std::vector<int>{5, 16, 6, 17}));
  EXPECT_EQ(scene.velocities[0].tiles, (std::vector<int>{2, 5, 16}));
  EXPECT_TRUE(scene.velocities[1].tiles.empty());  // all
  // Concave tiles are cut into ears, which are joined in any order.
  scene::Scene concave;
  concave.model.tiles = {model::Tile{{{0, 0, 0},
                                      {1, 0.9, 0},
                                      {2, 0, 0},
                                      {1.1, 1, 0},
                                      {2, 2, 0},
                                      {1, 1.1, 0},
                                      {0, 2, 0},
                                      {0.9, 1, 0}}}};
  concave.timeline = {{scene::Trigger{}, scene::timeline::Pin{{0}}, {"`pin`"}}};
  scene::splitTiles({}, concave);
  EXPECT_EQ(std::get<scene::timeline::Pin>(concave.timeline[0].action).tiles,
            (std::vector<int>{0, 1, 2, 3, 4, 5}));
}

TEST(SplitScenes, RefuseWhatNamesTilesOrTheirCorners) {
  const auto refusal = [](scene::Scene scene) -> std::string {
    scene.model = generate::makeTessellation({});
    try {
      scene::splitTiles({}, scene);
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  scene::Scene scene;
  scene.grips.emplace_back();
  EXPECT_EQ(refusal(scene),
            "error: `split_tiles` renumbers tiles, so drags, chains of targets, grips and files of "
            "hinges do not work with it. Remove one of them");
  scene.grips.clear();
  EXPECT_EQ(refusal(scene), "accepted");
  scene.timeline = {{scene::Trigger{}, scene::timeline::Drag{}, {}}};
  EXPECT_THAT(refusal(scene), HasSubstr("renumbers"));
  scene.timeline.clear();
  scene.hinges.own.emplace_back();
  EXPECT_THAT(refusal(scene), HasSubstr("renumbers"));
}

TEST_F(HingeSpringsOfAScene, RefuseInvalidLines) {
  const auto refused = [&](const std::string& line) { return refusal(line + "\n"); };
  EXPECT_THAT(refused("0 1 -2"),
              EndsWith("hinges.txt:1:5: error: '-2' is not a stiffness in [0, 1e12] N m/rad, or - "
                       "for the value of all hinges; correct it"));
  EXPECT_THAT(refused("0 1 2 a"), HasSubstr("'a' is not a rest angle in [-360, 360] degrees"));
  EXPECT_THAT(refused("0 1 2 3 -1"), HasSubstr("'-1' is not a damping in [0, 1e12] N m s/rad"));
  EXPECT_THAT(refused("0 1 nan"), HasSubstr("'nan' is not a stiffness"));
  EXPECT_THAT(refused("0 4 1"),
              EndsWith(":1:3: error: the model has tiles 0-3, not 4. Correct this number"));
  EXPECT_THAT(refused("0"), HasSubstr("this line has 1 column. A hinge has tile, tile, stiffness"));
  EXPECT_THAT(refused("0 3 1"),
              EndsWith(":1:1: error: tiles 0 and 3 have no common corner or edge to "
                       "rotate about. Remove this line"));
  EXPECT_THAT(refused("0 1 1\n1 0 2"),
              EndsWith(":2:1: error: this hinge is already on line 1. Remove one of them"));
}

}  // namespace
}  // namespace kirireel
