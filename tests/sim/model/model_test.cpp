#include "sim/model/model.h"

#include <gtest/gtest.h>

#include "sim/generate/lattice.h"

namespace kirireel {
namespace {

// An L-shaped polygon, not convex: area 3, centroid (5/6, 5/6).
model::Tile ell() {
  return {{{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}}};
}

TEST(Tile, AreaAndCentroidOfAnySimplePolygon) {
  EXPECT_DOUBLE_EQ(model::tileArea(ell()), 3);
  EXPECT_LT((model::tileCentroid(ell()) - Vector3(5.0 / 6, 5.0 / 6, 0)).norm(), 1e-15);
  EXPECT_EQ(model::tileNormal(ell()), Vector3::UnitZ());
}

TEST(Tile, NormalTurnsWithTheOrderAndTheTile) {
  model::Tile tile = ell();
  std::reverse(tile.vertices.begin(), tile.vertices.end());
  EXPECT_EQ(model::tileNormal(tile), -Vector3::UnitZ());
  const Quaternion turn = rotationFromVector({1.0, -0.4, 2.0});
  for (Vector3& vertex : tile.vertices) vertex = turn * vertex + Vector3(1e3, -1e3, 1e3);
  // measured 4e-14: rounding of coordinates of 1e3
  EXPECT_LT((model::tileNormal(tile) + turn * Vector3::UnitZ()).norm(), 1e-12);
}

TEST(Model, SizesOfAClosedSheet) {
  generate::TessellationShape shape;
  shape.columns = 3;
  shape.rows = 4;
  shape.length = 2;
  const model::Model model = generate::makeTessellation(shape);
  EXPECT_DOUBLE_EQ(model::modelSize(model), std::hypot(6.0, 4.0));
  EXPECT_DOUBLE_EQ(model::tileSize(model), 1.5);
  EXPECT_EQ(model::modelSize(model::Model{}), 0);
  EXPECT_EQ(model::tileSize(model::Model{}), 0);
}

}  // namespace
}  // namespace kirireel
