#include "sim/world/inset_hull.h"

#include <algorithm>

namespace kirireel {
namespace {

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

double marginFor(const Brick& brick, const std::vector<Vector3>& directions) {
  double margin = std::min(kLargestMargin, kMarginOfThickness * brick.thickness);
  const std::size_t count = brick.bottom.size();
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t next = (k + 1) % count;
    const Vector3 edge = brick.bottom[next] - brick.bottom[k];
    const double lossRate = (directions[k] - directions[next]).dot(edge.normalized());
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
