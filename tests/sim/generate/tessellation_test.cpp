#include <numbers>
#include <set>

#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/formats/read_model.h"
#include "sim/generate/lattice.h"
#include "tests/support/files.h"
#include "tests/support/refusal.h"

namespace kirireel {
namespace {

using test::TemporaryFolder;
namespace fs = std::filesystem;
constexpr double kPi = std::numbers::pi;

std::string messageFor(const generate::TessellationShape& shape) {
  return test::refusalOf([&] { generate::makeTessellation(shape); });
}

TEST(Tessellation, StaysClosedAndRigidAtEveryAngle) {
  generate::TessellationShape shape;
  shape.columns = 5;
  shape.rows = 4;
  shape.length = 1.7;
  shape.width = 0.6;
  const model::Model model = generate::makeTessellation(shape);
  for (double angle = 0; angle <= kPi; angle += kPi / 16) {
    const std::vector<model::Tile> tiles = generate::tessellationTiles(shape, angle);
    for (const model::Joint& joint : model.joints) {
      EXPECT_EQ(tiles[joint.a.tile].vertices[joint.a.vertex],
                tiles[joint.b.tile].vertices[joint.b.vertex]);
    }
    for (const model::Tile& tile : tiles) {
      const auto& v = tile.vertices;
      EXPECT_NEAR((v[1] - v[0]).norm(), 1.7, 2e-15);          // measured 9e-16
      EXPECT_NEAR((v[3] - v[0]).norm(), 0.6, 2e-15);          // measured 8e-16
      EXPECT_NEAR((v[1] - v[0]).dot(v[3] - v[0]), 0, 2e-15);  // measured 1.2e-15
    }
  }
}

TEST(Tessellation, NeighboursOpenByTheAngle) {
  generate::TessellationShape shape;
  shape.columns = 2;
  shape.rows = 1;
  const std::vector<model::Tile> tiles = generate::tessellationTiles(shape, 0.8);
  const auto direction = [&](int tile) {
    const Vector3 edge = tiles[tile].vertices[1] - tiles[tile].vertices[0];
    return std::atan2(edge.y(), edge.x());
  };
  EXPECT_NEAR(direction(0), -0.4, 1e-15);
  EXPECT_NEAR(direction(1), 0.4, 1e-15);
}

TEST(Tessellation, ClosedSheetIsTheGridOfTiles) {
  generate::TessellationShape shape;
  shape.columns = 3;
  shape.rows = 2;
  shape.length = 2;
  const model::Model model = generate::makeTessellation(shape);
  ASSERT_EQ(model.tiles.size(), 6u);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 2; ++j) {
      const Vector3 corner(2 * i - 3, j - 1, 0);
      const auto& vertices = model.tiles[i * 2 + j].vertices;
      EXPECT_EQ(vertices[0], corner);
      EXPECT_EQ(vertices[1], corner + Vector3(2, 0, 0));
      EXPECT_EQ(vertices[2], corner + Vector3(2, 1, 0));
      EXPECT_EQ(vertices[3], corner + Vector3(0, 1, 0));
    }
  }
  EXPECT_EQ(model.joints.size(), 7u);  // columns (rows - 1) + rows (columns - 1)
}

using JointNumbers = std::set<std::set<std::pair<int, int>>>;

JointNumbers jointNumbers(const model::Model& model) {
  JointNumbers numbers;
  for (const model::Joint& joint : model.joints) {
    numbers.insert(
        {std::pair(joint.a.tile, joint.a.vertex), std::pair(joint.b.tile, joint.b.vertex)});
  }
  return numbers;
}

TEST(Tessellation, MatchesThePublishedTenByTen) {
  const fs::path published = fs::path(KIRIREEL_SOURCE_DIR) / "../shared/models/tess_m10_n10";
  if (!fs::exists(published)) GTEST_SKIP() << published << " is not there";
  std::vector<std::string> warnings;
  const model::Model theirs = formats::readModelFolder(published, warnings);
  generate::TessellationShape shape;
  shape.columns = shape.rows = 10;
  const model::Model ours = generate::makeTessellation(shape);
  EXPECT_EQ(jointNumbers(ours), jointNumbers(theirs));
  double worst = 0;
  for (size_t i = 0; i < 100; ++i) {
    EXPECT_EQ(ours.tiles[i].vertices, theirs.tiles[i].vertices);
    for (size_t k = 0; k < 4; ++k) {
      const Vector3 expected = (*theirs.target)[i].vertices[k];
      worst = std::max(worst, ((*ours.target)[i].vertices[k] - expected).norm());
    }
  }
  EXPECT_LT(worst, 1e-13);  // measured 6e-15
}

TEST(Tessellation, ShippedModelsAreWhatTheGeneratorMakes) {
  generate::TessellationShape square;
  generate::TessellationShape rectangles;
  rectangles.columns = 10;
  rectangles.rows = 6;
  rectangles.length = 2;
  rectangles.targetAngle = 60 * kPi / 180;
  const std::pair<std::string, generate::TessellationShape> shipped[] = {
      {"tessellation_4x4", square}, {"tessellation_10x6_rectangles", rectangles}};
  for (const auto& [name, shape] : shipped) {
    const TemporaryFolder folder;
    formats::writeModelFolder(generate::makeTessellation(shape), folder.path());
    for (const std::string file : {"vertices.txt", "constraints.txt", "target.txt"}) {
      const fs::path path = fs::path(KIRIREEL_SOURCE_DIR) / "data" / name / file;
      ASSERT_TRUE(fs::exists(path)) << path;
      EXPECT_TRUE(test::bytesOf(folder.path() / file) == test::bytesOf(path)) << path;
    }
  }
}

TEST(Tessellation, RefusesValuesOutOfRange) {
  generate::TessellationShape shape;
  shape.columns = 0;
  EXPECT_EQ(messageFor(shape),
            "tessellation: error: 0 columns and 4 rows; give at least 1 of each, and at most "
            "250000 tiles in all");
  shape.columns = 100000;
  EXPECT_EQ(messageFor(shape),
            "tessellation: error: 100000 columns and 4 rows; give at least 1 of each, and at most "
            "250000 tiles in all");
  shape = {};
  shape.length = -1;
  EXPECT_EQ(messageFor(shape),
            "tessellation: error: the length of a tile is -1 m; give at least 1e-06, and at most "
            "250000 for 4 tiles in a row");
  shape = {};
  shape.width = std::nan("");
  EXPECT_EQ(messageFor(shape),
            "tessellation: error: the width of a tile is nan m; give at least 1e-06, and at most "
            "250000 for 4 tiles in a row");
  shape = {};
  shape.startAngle = -kPi / 2;
  EXPECT_EQ(messageFor(shape),
            "tessellation: error: the start angle is -90 degrees, but must be in [0, 180]");
  shape = {};
  shape.targetAngle = 2 * kPi;
  EXPECT_EQ(messageFor(shape),
            "tessellation: error: the target angle is 360 degrees, but must be in [0, 180]");
}

}  // namespace
}  // namespace kirireel
