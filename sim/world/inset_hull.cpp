// A brick's hull moved inwards by a margin m (metres), so that Bullet's margin fills it up again.
//
// Moving all faces inwards by m moves a vertex v of the bottom to v + m (d + n): n the tile's unit
// normal, and d the vector in the plane whose products with the inward unit normals i_1 and i_2 of
// both edges at v are 1,
//   d = (i_1 + i_2) / (1 + i_1 . i_2)
// At a sharp corner |d| is large, and short edges would turn round: their ends come together at the
// rate (d_k - d_(k+1)) . e for the edge's unit direction e, which bounds m.
#include "sim/world/inset_hull.h"

#include <algorithm>

namespace kirireel {
namespace {

// Half of Bullet's usual margin of 0.04 m.
constexpr double kLargestMargin = 0.02;     // metres
constexpr double kMarginOfThickness = 0.2;  // so that three fifths of the thickness remain
constexpr double kLargestEdgeLoss = 0.5;    // of an edge's length

/// For each vertex of the bottom: how far it moves, in the plane, for a unit inset of the edges.
std::vector<Vector3> insetDirections(const Brick& brick) {
  const std::size_t count = brick.bottom.size();
  std::vector<Vector3> inwards(count);
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3 edge = brick.bottom[(k + 1) % count] - brick.bottom[k];
    inwards[k] = brick.normal.cross(edge).normalized();
  }
  std::vector<Vector3> directions(count);
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3& before = inwards[(k + count - 1) % count];
    // The one vector in their plane whose products with both normals are 1.
    directions[k] = (before + inwards[k]) / (1 + before.dot(inwards[k]));
  }
  return directions;
}

// The wanted margin, or less where an edge would lose too much.
double marginFor(const Brick& brick, const std::vector<Vector3>& directions) {
  double margin = std::min(kLargestMargin, kMarginOfThickness * brick.thickness);
  const std::size_t count = brick.bottom.size();
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t next = (k + 1) % count;
    const Vector3 edge = brick.bottom[next] - brick.bottom[k];
    const double lossRate = (directions[k] - directions[next]).dot(edge.normalized());
    // An edge between two obtuse outer corners may as well grow.
    if (lossRate > 0) margin = std::min(margin, kLargestEdgeLoss * edge.norm() / lossRate);
  }
  return margin;
}

}  // namespace

double contactMargin(const Brick& brick) {
  double margin = 0;
  for (const BrickPiece& piece : convexPieces(brick)) {
    margin = std::max(margin, insetHull(piece.shape).margin);
  }
  return margin;
}

InsetHull insetHull(const Brick& brick) {
  const std::vector<Vector3> directions = insetDirections(brick);
  InsetHull hull;
  hull.margin = marginFor(brick, directions);
  for (std::size_t k = 0; k < brick.bottom.size(); ++k) {
    hull.points.emplace_back(brick.bottom[k] + hull.margin * (directions[k] + brick.normal));
  }
  for (std::size_t k = 0; k < brick.top.size(); ++k) {
    hull.points.emplace_back(brick.top[k] + hull.margin * (directions[k] - brick.normal));
  }
  return hull;
}

}  // namespace kirireel
