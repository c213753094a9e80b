#include "sim/model/sheet_frame.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "sim/formats/joint_faces.h"
#include "sim/formats/tile_checks.h"
#include "sim/generate/lattice.h"
#include "sim/model/convex_parts.h"
#include "sim/model/isometry.h"

namespace kirireel {
namespace {

model::Model sheet() {
  generate::TessellationShape shape;
  shape.columns = 3;
  shape.rows = 2;
  return generate::makeTessellation(shape);
}

void place(const model::RigidMotion& motion, std::vector<model::Tile>& tiles) {
  for (model::Tile& tile : tiles) {
    for (Vector3& vertex : tile.vertices) vertex = motion.apply(vertex);
  }
}

model::Model placed(model::Model model, const model::RigidMotion& motion) {
  place(motion, model.tiles);
  if (model.target) place(motion, *model.target);
  return model;
}

model::RigidMotion randomMotion(std::mt19937& random) {
  std::normal_distribution<double> normal;
  const Quaternion turn =
      Quaternion(normal(random), normal(random), normal(random), normal(random)).normalized();
  return {turn.toRotationMatrix(), {normal(random), normal(random), normal(random)}};
}

/// The normal of a tube is its axis in any position. A cube has no such axis; its normal is z.
TEST(SheetFrames, OfATubeHasItsAxis) {
  model::Model tube;
  const auto corner = [](int k, double z) {
    return Vector3(std::cos(k * std::numbers::pi / 3), std::sin(k * std::numbers::pi / 3), z);
  };
  for (int k = 0; k < 6; ++k) {
    model::Tile& tile = tube.tiles.emplace_back();
    tile.vertices = {corner(k, 0), corner(k + 1, 0), corner(k + 1, 5), corner(k, 5)};
  }
  EXPECT_TRUE(model::viewFrame(tube).isHorizontal());
  std::mt19937 random(5);
  for (int k = 0; k < 20; ++k) {
    const model::RigidMotion motion = randomMotion(random);
    const Vector3 axis = motion.rotation.col(2);
    // Measured: 4e-16.
    EXPECT_NEAR(model::viewFrame(placed(tube, motion)).normal.cross(axis).norm(), 0, 1e-14);
  }
  for (model::Tile& tile : tube.tiles) {
    for (Vector3& vertex : tile.vertices) vertex.z() *= 1 / std::sqrt(12.5);
  }
  EXPECT_TRUE(model::viewFrame(placed(tube, randomMotion(random))).isHorizontal());
}

TEST(SheetFrames, OfHorizontalSheetsKeepAllBits) {
  model::Model model = sheet();
  place({Matrix3::Identity(), {0.1, 0.2, 0.3}}, model.tiles);
  const auto frame = model::sheetFrame(model.tiles, 1e-9);
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->isHorizontal());
  const std::vector<model::Tile> seen = model::toFrame(*frame, model.tiles);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    for (std::size_t k = 0; k < seen[i].vertices.size(); ++k) {
      EXPECT_EQ(seen[i].vertices[k].head<2>(), model.tiles[i].vertices[k].head<2>());
      EXPECT_EQ(frame->toWorld(seen[i].vertices[k]), model.tiles[i].vertices[k]);
    }
  }
  // The upper side is that of +z even if all tiles are clockwise.
  for (model::Tile& tile : model.tiles) std::ranges::reverse(tile.vertices);
  EXPECT_EQ(model::sheetFrame(model.tiles, 1e-9)->normal, Vector3::UnitZ());
}

TEST(SheetFrames, TurnWithTheSheet) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 20; ++trial) {
    const model::RigidMotion motion = randomMotion(random);
    std::vector<model::Tile> tiles = placed(sheet(), motion).tiles;
    const auto frame = model::sheetFrame(tiles, 1e-9);
    ASSERT_TRUE(frame);
    // Measured 6e-16.
    EXPECT_NEAR((frame->normal - motion.rotation.col(2)).norm(), 0, 1e-14);
    EXPECT_NEAR((frame->x.cross(frame->y) - frame->normal).norm(), 0, 1e-14);
    EXPECT_NEAR((frame->toWorld(frame->toFrame({1, 2, 3})) - Vector3(1, 2, 3)).norm(), 0, 1e-14);
    // One clockwise tile of six does not decide.
    std::ranges::reverse(tiles.front().vertices);
    EXPECT_NEAR((model::sheetFrame(tiles, 1e-9)->normal - motion.rotation.col(2)).norm(), 0, 1e-14);
  }
}

TEST(SheetFrames, AreAbsentIfOneVertexLeavesThePlane) {
  std::mt19937 random(2);
  model::Model model = placed(sheet(), randomMotion(random));
  const Vector3 normal = model::sheetFrame(model.tiles, 1e-9)->normal;
  model.tiles[2].vertices[1] += 1e-6 * normal;
  EXPECT_FALSE(model::sheetFrame(model.tiles, 1e-8));
}

// Coordinates with two decimals: 0.02 is less than five of their digits.
TEST(SheetFrames, AreAbsentForLayersInAFileWithFewDigits) {
  for (int axis = 0; axis < 3; ++axis) {
    model::Model model;
    for (const double level : {0.0, 0.02}) {
      model::Tile tile;
      for (const auto& [x, y] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
        const Vector3 vertex(x, y, level);
        tile.vertices.emplace_back(vertex[(3 - axis) % 3], vertex[(4 - axis) % 3],
                                   vertex[(5 - axis) % 3]);
      }
      model.tiles.push_back(tile);
    }
    model.rounding = 0.005;
    EXPECT_FALSE(model::sheetFrame(model)) << axis;
    for (Vector3& vertex : model.tiles[1].vertices) vertex[(axis + 2) % 3] = 0;
    EXPECT_TRUE(model::sheetFrame(model)) << axis;
  }
}

TEST(SheetFrames, TurnOneClockwiseTileInAnyPlane) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 5; ++trial) {
    const model::Model whole = placed(sheet(), randomMotion(random));
    model::Model model = whole;
    std::ranges::reverse(model.tiles[4].vertices);
    std::ranges::reverse((*model.target)[4].vertices);
    formats::TileTable table;
    table.file = "vertices.txt";
    table.tiles = model.tiles;
    for (int line = 1; line <= 6; ++line) table.sources.push_back({line, {}});
    std::vector<std::string> warnings;
    formats::turnClockwiseTiles(table, model, warnings);
    ASSERT_EQ(warnings.size(), 1U);
    EXPECT_EQ(warnings[0],
              "vertices.txt:5: repaired: 1 of 6 tiles runs clockwise seen from the side of most "
              "tiles; reversed, and written in the file's own order");
    EXPECT_EQ(model.tiles[4].vertices, whole.tiles[4].vertices);
  }
}

// The rigid motion nearest to a target that is the start seen from below turns the sheet over. A
// sheet whose target lies in its plane stays on its side.
TEST(SheetFrames, AlignedSheetsStayOnTheirSide) {
  std::mt19937 random(4);
  for (int trial = 0; trial < 5; ++trial) {
    const model::RigidMotion motion = randomMotion(random);
    model::Model flat = sheet();
    Matrix3 mirror = Matrix3::Identity();
    mirror(0, 0) = -1;
    flat.target = flat.tiles;
    place({mirror, {0, 0, 0}}, *flat.target);
    model::Model model = placed(flat, motion);
    model::alignStartToTarget(model, {});
    EXPECT_NEAR((model::tileNormal(model.tiles[0]) - motion.rotation.col(2)).norm(), 0, 1e-12);
  }
}

TEST(SheetFrames, OutlinesInAnyPlaneHaveTheSameCorners) {
  std::mt19937 random(6);
  const std::vector<model::Corner> outline = model::outlineCorners(sheet().tiles);
  const auto numbers = [](std::vector<model::Corner> corners) {
    std::vector<std::pair<int, int>> found;
    for (const model::Corner& corner : corners) found.emplace_back(corner.tile, corner.vertex);
    std::ranges::sort(found);
    return found;
  };
  for (int trial = 0; trial < 20; ++trial) {
    model::RigidMotion motion = randomMotion(random);
    motion.translation *= 1000;  // coordinates of one place differ by up to 1e-12
    const std::vector<model::Tile> tiles = placed(sheet(), motion).tiles;
    const auto frame = model::sheetFrame(tiles, 1e-8);
    ASSERT_TRUE(frame);
    const std::vector<model::Corner> turned = model::outlineCorners(model::toFrame(*frame, tiles));
    EXPECT_EQ(numbers(turned), numbers(outline));
  }
}

// A rhombus has two smallest rectangles, mirror images of each other. The weight prefers one of its
// sides, at any rotation.
TEST(SheetFrames, WeightsChooseBetweenEqualRectangles) {
  const double skew = 0.5;
  for (const bool isFirst : {true, false}) {
    for (double turn = -3; turn < 3; turn += 0.37) {
      const auto at = [&](double angle) {
        return Eigen::Vector2d(std::cos(turn + angle), std::sin(turn + angle));
      };
      const Eigen::Vector2d a = at(0), b = at(std::numbers::pi / 2 - skew);
      const Eigen::Vector2d side = isFirst ? a : b;
      const double angle = model::smallestRectangleAngle(
          {-a - b, a - b, a + b, b - a}, 0,
          [&](const Eigen::Vector2d& along) { return std::abs(along.dot(side)); });
      // A side of the rectangle lies along it or across it. Measured: 2e-16.
      EXPECT_NEAR(std::sin(4 * (std::atan2(side.y(), side.x()) - angle)), 0, 1e-12);
      EXPECT_GT(std::cos(4 * (std::atan2(side.y(), side.x()) - angle)), 0);
    }
  }
}

TEST(SheetFrames, JointsInAnyPlaneAreThroughTheThickness) {
  std::mt19937 random(5);
  model::Model model = placed(sheet(), randomMotion(random));
  formats::chooseJointFaces(model, formats::FaceRule::Fold);
  for (const model::Joint& joint : model.joints) EXPECT_EQ(joint.face, model::JointFace::Both);
}

}  // namespace
}  // namespace kirireel
