#include <algorithm>
#include <numeric>

#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/generate/lattice.h"
#include "sim/model/convex_parts.h"

namespace kirireel {
namespace {

double area(const std::vector<model::Tile>& tiles) {
  return std::accumulate(tiles.begin(), tiles.end(), 0.0, [](double sum, const model::Tile& tile) {
    return sum + model::tileArea(tile);
  });
}

double opening(const model::Model& model, const std::vector<model::Tile>& tiles) {
  double worst = 0;
  for (const model::Joint& joint : model.joints) {
    worst = std::max(worst, (tiles.at(joint.a.tile).vertices.at(joint.a.vertex) -
                             tiles.at(joint.b.tile).vertices.at(joint.b.vertex))
                                .norm());
  }
  return worst;
}

TEST(SplitTiles, PartsCoverTheSheetAndStayTogether) {
  generate::TessellationShape shape;
  shape.length = 2;
  const model::Model whole = generate::makeTessellation(shape);
  const model::Model split = model::splitTiles(whole, {});
  EXPECT_EQ(split.tiles.size(), 32U);
  EXPECT_EQ(split.joints.size(), 24U + 2 * 16);
  EXPECT_EQ(std::ranges::count_if(split.joints, &model::Joint::isWithinTile), 2 * 16);
  EXPECT_NEAR(area(split.tiles), area(whole.tiles), 1e-12);
  EXPECT_NEAR(area(*split.target), area(whole.tiles), 1e-12);
  EXPECT_LT(opening(split, split.tiles), 1e-15);
  EXPECT_LT(opening(split, *split.target), 1e-14);
  for (const model::Tile& tile : split.tiles) EXPECT_GT(model::tileNormal(tile).z(), 0.99);
}

TEST(SplitTiles, CornersOfTheHullAndOfRepairsDoNotMove) {
  model::Model whole = generate::makeTessellation({});
  whole.hull.emplace();
  for (int tile = 0; tile < 4; ++tile) {
    for (int vertex = 0; vertex < 4; ++vertex) whole.hull->push_back({tile, vertex});
  }
  whole.repairs.push_back({.corners = {{3, 2}, {2, 3}}});
  const model::Model split = model::splitTiles(whole, {});
  const auto place = [](const model::Model& model, const model::Corner& corner) {
    return model.tiles.at(corner.tile).vertices.at(corner.vertex);
  };
  for (std::size_t k = 0; k < whole.hull->size(); ++k) {
    EXPECT_EQ(place(split, split.hull->at(k)), place(whole, whole.hull->at(k))) << k;
  }
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(place(split, split.repairs[0].corners[k]), place(whole, whole.repairs[0].corners[k]));
  }
}

TEST(SplitTiles, QuadIsCutAlongItsShorterDiagonal) {
  model::Model model;
  model.tiles = {{{{0, 0, 0}, {1, 0, 0}, {3, 3, 0}, {0, 1, 0}}}};
  const model::Model split = model::splitTiles(model, {0});
  ASSERT_EQ(split.tiles.size(), 2U);
  for (const model::Tile& tile : split.tiles) {
    EXPECT_EQ(std::count(tile.vertices.begin(), tile.vertices.end(), Vector3(1, 0, 0)), 1);
    EXPECT_EQ(std::count(tile.vertices.begin(), tile.vertices.end(), Vector3(0, 1, 0)), 1);
  }
}

TEST(SplitTiles, OnlyTheGivenTilesAreSplit) {
  model::Model model = generate::makeTessellation({});
  model.pulledTiles = std::vector<int>{3};
  const model::Model split = model::splitTiles(model, {3, 8});
  EXPECT_EQ(split.tiles.size(), 18U);
  EXPECT_EQ(split.tiles[0].vertices, model.tiles[0].vertices);
  EXPECT_EQ(split.pulledTiles, (std::vector<int>{3, 16}));
  try {
    model::splitTiles(model, {16});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "error: there are tiles 0-15 to split, not 16; correct the number");
  }
}

}  // namespace
}  // namespace kirireel
