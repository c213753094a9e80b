#include "sim/trajectory/sheet.h"

#include <numbers>

#include <gtest/gtest.h>

namespace kirireel {
namespace {

model::Tile unitSquare(const Vector3& corner) {
  return {
      {corner, corner + Vector3(1, 0, 0), corner + Vector3(1, 1, 0), corner + Vector3(0, 1, 0)}};
}

model::Tile turned(model::Tile tile, const Vector3& axis, double angle) {
  for (Vector3& vertex : tile.vertices) vertex = Eigen::AngleAxisd(angle, axis) * vertex;
  return tile;
}

TEST(Sheet, FlatOverlapIsTheShortestWayApart) {
  const std::vector<trajectory::TileOverlap> found =
      trajectory::tileOverlaps({unitSquare({0, 0, 0}), unitSquare({0.75, 0.1, 0})}, 1e-9);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].depth, 0.25, 1e-15);
  EXPECT_EQ(found[0].tileA, 0);
  EXPECT_EQ(found[0].tileB, 1);
}

// A height of rounding, and planes across each axis, change nothing.
TEST(Sheet, FlatOverlapIsTheSameInEveryPlane) {
  for (const double height : {0.0, 1e-16, -1e-16}) {
    const std::vector<model::Tile> flat = {unitSquare({0, 0, 0}), unitSquare({0.75, 0.1, height})};
    for (const Vector3& axis : {Vector3(Vector3::UnitX()), Vector3(Vector3::UnitY()),
                                Vector3(Vector3(1, 2, 3).normalized())}) {
      for (const double angle : {0.0, std::numbers::pi / 2, 0.7}) {
        const auto found = trajectory::tileOverlaps(
            {turned(flat[0], axis, angle), turned(flat[1], axis, angle)}, 1e-9);
        ASSERT_EQ(found.size(), 1U) << height << ", " << axis.transpose() << ", " << angle;
        EXPECT_NEAR(found[0].depth, 0.25, 1e-14);
      }
    }
  }
}

TEST(Sheet, TouchingTilesDoNotOverlap) {
  const model::Tile square = unitSquare({0, 0, 0});
  EXPECT_TRUE(trajectory::tileOverlaps({square, unitSquare({1, 0.3, 0})}, 1e-9).empty());
  EXPECT_TRUE(trajectory::tileOverlaps({square, unitSquare({0.2, 0.2, 0.1})}, 1e-9).empty());
  // Folded about the shared edge, and about a shared corner.
  EXPECT_TRUE(
      trajectory::tileOverlaps({square, turned(square, Vector3::UnitX(), 1)}, 1e-9).empty());
  EXPECT_TRUE(
      trajectory::tileOverlaps({square, turned(unitSquare({-1, -1, 0}), Vector3::UnitX(), 1)}, 1e-9)
          .empty());
}

TEST(Sheet, CrossingTilesOverlapAsFarAsTheyReachThrough) {
  // A wall through the floor at x = 0.3: from 0.2 below to 0.8 above, and 0.3 and 0.7 to the sides.
  model::Tile wall{{{0.3, 0, -0.2}, {0.3, 1, -0.2}, {0.3, 1, 0.8}, {0.3, 0, 0.8}}};
  const std::vector<trajectory::TileOverlap> found =
      trajectory::tileOverlaps({unitSquare({0, 0, 0}), wall}, 1e-9);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].depth, 0.2, 1e-15);
  // The same, turned and moved.
  const Vector3 axis = Vector3(1, 2, 3).normalized();
  const std::vector<trajectory::TileOverlap> again = trajectory::tileOverlaps(
      {turned(unitSquare({0, 0, 0}), axis, 0.7), turned(wall, axis, 0.7)}, 1e-9);
  ASSERT_EQ(again.size(), 1U);
  EXPECT_NEAR(again[0].depth, 0.2, 1e-14);
}

TEST(Sheet, MeasuresFaults) {
  std::vector<model::Tile> tiles = {unitSquare({0, 0, 0}), unitSquare({1, 0, 0.25})};
  const std::vector<model::Joint> joints = {{{0, 1}, {1, 0}}};
  EXPECT_EQ(model::largestJointGap(joints, tiles), 0.25);
  EXPECT_EQ(trajectory::largestUnevenness(tiles), 0);
  EXPECT_EQ(trajectory::smallestCornerSine(tiles), 1);
  const std::vector<model::Tile> start = tiles;
  tiles[0].vertices[2] = Vector3(0.25, 0.25, 0);
  EXPECT_LT(trajectory::smallestCornerSine(tiles), 0);
  EXPECT_NEAR(trajectory::largestShapeChange(start, tiles), 0.75 * std::numbers::sqrt2, 1e-15);
  tiles[1].vertices[2].z() += 0.4;
  EXPECT_NEAR(trajectory::largestUnevenness(tiles), 0.1,
              0.02);  // saddle: a quarter of it at every corner
}

}  // namespace
}  // namespace kirireel
