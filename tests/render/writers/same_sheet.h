/// Compares a sheet read from a drawing with the drawn sheet.
#pragma once

#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "sim/model/model.h"

namespace kirireel::test {

using CornerPair = std::pair<std::pair<int, int>, std::pair<int, int>>;

inline Vector3 meanCorner(const std::vector<model::Tile>& tiles) {
  Vector3 sum = Vector3::Zero();
  int count = 0;
  for (const model::Tile& tile : tiles) {
    for (const Vector3& v : tile.vertices) {
      sum += v;
      ++count;
    }
  }
  return sum / count;
}

/// The corner of `tiles` at a corner's position, of the tile with the same centroid.
inline std::pair<int, int> cornerLike(const model::Model& model, const model::Corner& corner,
                                      const std::vector<model::Tile>& tiles, const Vector3& moved,
                                      double tolerance) {
  const Vector3 centre = model::tileCentroid(model.tiles[corner.tile]) + moved;
  const Vector3 place = model.tiles[corner.tile].vertices[corner.vertex] + moved;
  for (int t = 0; t < std::ssize(tiles); ++t) {
    if ((model::tileCentroid(tiles[t]) - centre).norm() > tolerance) continue;
    for (int k = 0; k < std::ssize(tiles[t].vertices); ++k) {
      if ((tiles[t].vertices[k] - place).norm() <= tolerance) return {t, k};
    }
  }
  return {-1, -1};
}

inline CornerPair sorted(std::pair<int, int> a, std::pair<int, int> b) {
  return a < b ? CornerPair{a, b} : CornerPair{b, a};
}

/// Expects the tiles and joints of the drawing, in any order and any position in the plane. Corners
/// are compared by position.
inline void expectSameSheet(const model::Model& read, const model::Model& drawn,
                            const std::string& what) {
  ASSERT_EQ(read.tiles.size(), drawn.tiles.size()) << what;
  ASSERT_EQ(read.joints.size(), drawn.joints.size()) << what;
  const Vector3 moved = meanCorner(read.tiles) - meanCorner(drawn.tiles);
  // Sides that nearly coincide become one in a drawing: the kinks of this one's slits.
  const double share = drawn.name.starts_with("square") && drawn.name.ends_with("circle")
                           ? 2e-4
                           : 1e-9;  // measured 3e-13
  const double tolerance = share * model::tileSize(drawn);
  std::set<std::pair<int, int>> found;
  for (int t = 0; t < std::ssize(drawn.tiles); ++t) {
    for (int k = 0; k < std::ssize(drawn.tiles[t].vertices); ++k) {
      found.insert(cornerLike(drawn, {t, k}, read.tiles, moved, tolerance));
    }
  }
  std::size_t corners = 0;
  for (const model::Tile& tile : read.tiles) corners += tile.vertices.size();
  EXPECT_EQ(found.size(), corners) << what;
  EXPECT_FALSE(found.contains({-1, -1})) << what;
  std::set<CornerPair> expected, got;
  for (const model::Joint& joint : drawn.joints) {
    expected.insert(sorted(cornerLike(drawn, joint.a, read.tiles, moved, tolerance),
                           cornerLike(drawn, joint.b, read.tiles, moved, tolerance)));
  }
  for (const model::Joint& joint : read.joints) {
    EXPECT_EQ(joint.face, model::JointFace::Both);
    got.insert(sorted({joint.a.tile, joint.a.vertex}, {joint.b.tile, joint.b.vertex}));
  }
  EXPECT_EQ(got, expected) << what;
}

}  // namespace kirireel::test
