// Concave polygons as convex parts: areas and corners of the parts add up.
#include "sim/model/convex_parts.h"

#include <set>

#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "tests/support/polygons.h"

namespace kirireel {
namespace {

using test::lShape;
using test::randomStar;
using test::starShape;

model::Tile partOf(const model::Tile& tile, const model::PolygonPart& part) {
  model::Tile piece;
  for (const int corner : part) piece.vertices.push_back(tile.vertices[corner]);
  return piece;
}

/// The sines of the turns at a tile's corners; negative at reflex corners.
std::vector<double> cornerSines(const model::Tile& tile) {
  std::vector<double> sines;
  const std::size_t count = tile.vertices.size();
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3 before = tile.vertices[k] - tile.vertices[(k + count - 1) % count];
    const Vector3 after = tile.vertices[(k + 1) % count] - tile.vertices[k];
    sines.push_back(test::cross2(before, after) / (before.norm() * after.norm()));
  }
  return sines;
}

double minSine(const model::Tile& tile) {
  return std::min(1.0, std::ranges::min(cornerSines(tile)));
}

int reflexCorners(const model::Tile& tile) {
  return static_cast<int>(
      std::ranges::count_if(cornerSines(tile), [](double sine) { return sine < 0; }));
}

void expectSoundParts(const model::Tile& tile) {
  const std::vector<model::PolygonPart> parts = model::convexParts(tile.vertices, Vector3::UnitZ());
  double area = 0;
  std::set<int> corners;
  for (const model::PolygonPart& part : parts) {
    const model::Tile piece = partOf(tile, part);
    EXPECT_GE(minSine(piece), -1e-3);
    EXPECT_GT(model::tileNormal(piece).z(), 0);
    area += model::tileArea(piece);
    corners.insert(part.begin(), part.end());
  }
  EXPECT_NEAR(area, model::tileArea(tile), 1e-13 * model::tileArea(tile));  // measured 1e-15
  EXPECT_EQ(corners.size(), tile.vertices.size());
  // Hertel and Mehlhorn: each remaining diagonal is needed at a reflex corner, which needs at most
  // two.
  EXPECT_LE(static_cast<int>(parts.size()), 2 * reflexCorners(tile) + 1);
  double ofTriangles = 0;
  const auto triangles = model::trianglesOf(tile.vertices, Vector3::UnitZ());
  EXPECT_EQ(triangles.size(), tile.vertices.size() - 2);
  for (const auto& triangle : triangles) {
    ofTriangles += model::tileArea(partOf(tile, {triangle.begin(), triangle.end()}));
  }
  EXPECT_NEAR(ofTriangles, model::tileArea(tile), 1e-13 * model::tileArea(tile));
}

TEST(ConvexParts, AreValidForKnownShapes) {
  expectSoundParts(lShape());
  expectSoundParts(starShape(4, 2, 0.7));
  expectSoundParts(starShape(5, 2, 0.3));
  expectSoundParts(starShape(9, 1, 0.9));
  EXPECT_EQ(model::convexParts(lShape().vertices, Vector3::UnitZ()).size(), 2U);
  // A comb, and corners in the middle of straight sides.
  expectSoundParts({{{0, 0, 0},
                     {7, 0, 0},
                     {7, 3, 0},
                     {6, 3, 0},
                     {6, 1, 0},
                     {5, 1, 0},
                     {5, 3, 0},
                     {3, 3, 0},
                     {3, 1, 0},
                     {2, 1, 0},
                     {1, 1, 0},
                     {1, 3, 0},
                     {0, 3, 0}}});
  // A spiral.
  expectSoundParts({{{0, 0, 0},
                     {5, 0, 0},
                     {5, 5, 0},
                     {1, 5, 0},
                     {1, 2, 0},
                     {3, 2, 0},
                     {3, 3, 0},
                     {2, 3, 0},
                     {2, 4, 0},
                     {4, 4, 0},
                     {4, 1, 0},
                     {0, 1, 0}}});
}

TEST(ConvexParts, AreValidForRandomShapes) {
  std::mt19937 random(1);
  for (int round = 0; round < 500; ++round) {
    expectSoundParts(randomStar(random, 4 + static_cast<int>(random() % 40)));
  }
  expectSoundParts(randomStar(random, 300));
}

TEST(ConvexParts, ConvexTilesStayWhole) {
  const std::vector<Vector3> square = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  EXPECT_EQ(model::convexParts(square, Vector3::UnitZ()),
            (std::vector<model::PolygonPart>{{0, 1, 2, 3}}));
  // Optimised designs have dents of one degree. Four degrees are a bay.
  const auto dented = [](double degrees) {
    const double depth = std::tan(0.5 * degrees * kDegree);
    return std::vector<Vector3>{{0, 0, 0}, {1, depth, 0}, {2, 0, 0}, {1, 2, 0}};
  };
  EXPECT_TRUE(model::isConvexPolygon(dented(1), Vector3::UnitZ()));
  EXPECT_FALSE(model::isConvexPolygon(dented(4), Vector3::UnitZ()));
  EXPECT_EQ(model::convexParts(dented(4), Vector3::UnitZ()).size(), 2U);
}

TEST(ConvexParts, ManySmallTurnsAreABay) {
  // A crescent whose inner arc turns by a degree at each corner.
  std::vector<Vector3> crescent;
  for (int k = 0; k <= 90; ++k) {
    crescent.emplace_back(std::cos(k * kDegree), std::sin(k * kDegree), 0);
  }
  for (int k = 90; k >= 0; --k) {
    crescent.emplace_back(0.7 * std::cos(k * kDegree), 0.7 * std::sin(k * kDegree), 0);
  }
  EXPECT_FALSE(model::isConvexPolygon(crescent, Vector3::UnitZ()));
  EXPECT_GT(model::convexParts(crescent, Vector3::UnitZ()).size(), 1U);
}

TEST(ConvexParts, CrossingSidesAreFound) {
  const Vector3 up = Vector3::UnitZ();
  EXPECT_FALSE(model::crossingSides(lShape().vertices, up, 1e-9));
  EXPECT_FALSE(model::crossingSides(starShape(7, 2, 0.1).vertices, up, 1e-9));
  const std::vector<Vector3> dented = {{0, 0, 0}, {2, 0, 0}, {1, 1, 0}, {2, 2, 0}, {0, 2, 0}};
  const std::vector<Vector3> crossed = {{0, 0, 0}, {3, 0, 0}, {3, 2, 0}, {1, -1, 0}, {0, 2, 0}};
  EXPECT_FALSE(model::crossingSides(dented, up, 1e-9));
  EXPECT_TRUE(model::crossingSides(crossed, up, 1e-9));
  // A corner that touches a far side: two pieces.
  EXPECT_TRUE(model::crossingSides(
      std::vector<Vector3>{{0, 0, 0}, {4, 0, 0}, {4, 2, 0}, {2, 0, 0}, {0, 2, 0}}, up, 1e-9));
}

/// Opposite arms of a plus have sides on one line. They are apart in any direction.
TEST(ConvexParts, SidesOnOneLineDoNotCross) {
  const std::vector<Vector3> plus = {{1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {3, 1, 0},
                                     {3, 2, 0}, {2, 2, 0}, {2, 3, 0}, {1, 3, 0},
                                     {1, 2, 0}, {0, 2, 0}, {0, 1, 0}, {1, 1, 0}};
  for (int k = 0; k < 1000; ++k) {
    const Matrix3 turn = (Eigen::AngleAxisd(0.1 * k, Vector3::UnitZ()) *
                          Eigen::AngleAxisd(1.7 * k, Vector3::UnitX()))
                             .toRotationMatrix();
    std::vector<Vector3> turned;
    for (const Vector3& corner : plus) turned.push_back(turn * corner);
    EXPECT_FALSE(model::crossingSides(turned, turn * Vector3::UnitZ(), 1e-9)) << k;
  }
}

TEST(ConvexParts, SplitTilesAreHingedAlongTheirCuts) {
  model::Model model;
  model.tiles = {starShape(5, 2, 0.8)};
  const model::Model split = model::splitTiles(model, {});
  ASSERT_EQ(split.tiles.size(), 8U);
  EXPECT_EQ(split.joints.size(), 2U * 7);
  double area = 0;
  for (const model::Tile& tile : split.tiles) area += model::tileArea(tile);
  EXPECT_NEAR(area, model::tileArea(model.tiles[0]), 1e-14);
  for (const model::Joint& joint : split.joints) {
    EXPECT_EQ(split.tiles[joint.a.tile].vertices[joint.a.vertex],
              split.tiles[joint.b.tile].vertices[joint.b.vertex]);
  }
}

}  // namespace
}  // namespace kirireel
