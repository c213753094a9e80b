#include "sim/model/model.h"

#include <gtest/gtest.h>

#include "sim/model/lattice.h"

namespace kirireel {
namespace {

// An L-shaped polygon, not convex: area 3, centroid (5/6, 5/6).
Tile ell() {
  return {{{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}}};
}

TEST(Tile, AreaAndCentroidOfAnySimplePolygon) {
  EXPECT_DOUBLE_EQ(tileArea(ell()), 3);
  EXPECT_LT((tileCentroid(ell()) - Vector3(5.0 / 6, 5.0 / 6, 0)).norm(), 1e-15);
  EXPECT_EQ(tileNormal(ell()), Vector3::UnitZ());
}

TEST(Tile, NormalTurnsWithTheOrderAndTheTile) {
  Tile tile = ell();
  std::reverse(tile.vertices.begin(), tile.vertices.end());
  EXPECT_EQ(tileNormal(tile), -Vector3::UnitZ());
  const Quaternion turn = rotationFromVector({1.0, -0.4, 2.0});
  for (Vector3& vertex : tile.vertices) vertex = turn * vertex + Vector3(1e3, -1e3, 1e3);
  // measured 4e-14: the digits that coordinates of 1e3 have left
  EXPECT_LT((tileNormal(tile) + turn * Vector3::UnitZ()).norm(), 1e-12);
}

TEST(Model, SizesOfAClosedSheet) {
  TessellationShape shape;
  shape.columns = 3;
  shape.rows = 4;
  shape.length = 2;
  const Model model = makeTessellation(shape);
  EXPECT_DOUBLE_EQ(modelSize(model), std::hypot(6.0, 4.0));
  EXPECT_DOUBLE_EQ(tileSize(model), 1.5);
  EXPECT_EQ(modelSize(Model{}), 0);
  EXPECT_EQ(tileSize(Model{}), 0);
}

}  // namespace
}  // namespace kirireel
