#include <cmath>

#include <gtest/gtest.h>

#include "render/report/inspection.h"

namespace kirireel {
namespace {

/// A square of side 2 around a middle, outward along the given axis.
model::Tile squareFacing(const Vector3& normal, const Vector3& middle) {
  const Quaternion turn = Quaternion::FromTwoVectors(Vector3::UnitZ(), normal);
  model::Tile tile;
  for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    tile.vertices.push_back(middle + turn * Vector3(x, y, 0));
  }
  return tile;
}

TEST(LineOfSight, SeesThreeFacesOfACube) {
  std::vector<model::Tile> tiles;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const Vector3 normal = side * Vector3::Unit(axis);
      tiles.push_back(squareFacing(normal, normal));
    }
  }
  const report::LineOfSight sight(tiles, Vector3(1, 1.5, 2).normalized());
  for (std::size_t k = 0; k < tiles.size(); ++k) {
    EXPECT_EQ(sight.isVisible(model::tileCentroid(tiles[k]), k), k % 2 == 1) << k;
  }
}

TEST(LineOfSight, NothingHidesTilesOfAFlatSheet) {
  // Side by side, and seen along their edges.
  const std::vector<model::Tile> tiles = {squareFacing({0, 0, 1}, {0, 0, 0}),
                                          squareFacing({0, 0, 1}, {2, 0, 0})};
  for (const Vector3& eye : {Vector3(0, 0, 1), Vector3(0, 0.6, 0.8), Vector3(1, 0, 0)}) {
    EXPECT_TRUE(report::LineOfSight(tiles, eye).isVisible({0, 0, 0}, 0)) << eye.transpose();
  }
}

TEST(LineOfSight, EndsAtTheBoundaryOfATile) {
  const std::vector<model::Tile> tiles = {squareFacing({0, 0, 1}, {0, 0, 0}),
                                          squareFacing({0, 0, -1}, {1, 0, 5})};
  const report::LineOfSight sight(tiles, {0, 0, 1});
  EXPECT_TRUE(sight.isVisible({-0.01, 0, 0}, 0));
  EXPECT_FALSE(sight.isVisible({0.01, 0, 0}, 0));
  EXPECT_TRUE(sight.isVisible({1, 0, 5}, 1));  // the other is behind
}

}  // namespace
}  // namespace kirireel
