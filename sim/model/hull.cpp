// The convex outline by Andrew's monotone chain.
//
// The points are sorted by x, then by y. Walking them once from left to right, each new point takes
// away those before it at which the chain would turn right; what stays is the lower half of the
// outline. Walking back gives the upper half. This costs O(n log n) for the sorting and O(n) for
// the walks. Corners on a straight side stay, as they are corners of the sheet that springs may
// pull. A. M. Andrew, Another efficient algorithm for convex hulls in two dimensions, Information
// Processing Letters 9, 1979.
#include "sim/model/hull.h"

#include <algorithm>
#include <tuple>

namespace kirireel {
namespace {

struct TilePoint {
  double x, y;
  Corner corner;
};

// By x, then y; a stable sort keeps the first corner of each place first.
std::vector<TilePoint> sortedPoints(const std::vector<Tile>& tiles) {
  std::vector<TilePoint> points;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    for (std::size_t k = 0; k < tiles[i].vertices.size(); ++k) {
      const Vector3& vertex = tiles[i].vertices[k];
      points.push_back({vertex.x(), vertex.y(), {static_cast<int>(i), static_cast<int>(k)}});
    }
  }
  std::stable_sort(points.begin(), points.end(), [](const TilePoint& a, const TilePoint& b) {
    return std::tie(a.x, a.y) < std::tie(b.x, b.y);
  });
  return points;
}

/// Twice the area of a triangle; positive when a, b, c turn left.
double turn(const TilePoint& a, const TilePoint& b, const TilePoint& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// The points that nowhere turn right, one half of the outline (Andrew 1979); the last is left out,
/// it begins the other half.
template <typename Iterator>
void appendHalf(Iterator begin, Iterator end, double rounding, std::vector<Corner>& outline) {
  std::vector<TilePoint> half;
  for (Iterator point = begin; point != end; ++point) {
    while (half.size() > 1 && turn(half[half.size() - 2], half.back(), *point) < -rounding) {
      half.pop_back();
    }
    half.push_back(*point);
  }
  for (std::size_t k = 0; k + 1 < half.size(); ++k) outline.push_back(half[k].corner);
}

}  // namespace

std::vector<Corner> outlineCorners(const std::vector<Tile>& tiles) {
  std::vector<TilePoint> points = sortedPoints(tiles);
  const auto samePlace = [](const TilePoint& a, const TilePoint& b) {
    return a.x == b.x && a.y == b.y;
  };
  points.erase(std::unique(points.begin(), points.end(), samePlace), points.end());
  const double width = points.back().x - points.front().x;
  // Areas smaller than this come from rounding: then a point counts as being on the straight side.
  const double rounding = 1e-9 * width * width;
  std::vector<Corner> outline;
  appendHalf(points.begin(), points.end(), rounding, outline);
  appendHalf(points.rbegin(), points.rend(), rounding, outline);
  return outline;
}

}  // namespace kirireel
