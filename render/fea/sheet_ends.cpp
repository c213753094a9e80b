// An end of a sheet is what a person would hold: the edges that face outwards there. They are found
// in the plane of a flat sheet. Any other sheet is projected along its thinnest axis.
//
// - Axes: the sides of the smallest rectangle around all points. Rhombi have two such rectangles.
//   Let u be the direction of a rectangle's longer side. The rectangle with the larger sum counts:
//
//       sum over links of x^2 (x^2 + d^2),    x = u . (p - m),    d = u . (c_2 - c_1)
//
//   p is the link's point, m the mean of all p, c_1 and c_2 are the middles of its two polygons.
//   The result rotates with the sheet. It does not change if tiles are mirrored or renumbered. The
//   sum is large if links are far apart along u and connect polygons along u.
// - An edge is inside the sheet if another edge lies farther out along the axis from its midpoint:
//   it is a side of a slit or of a hole.

#include "render/fea/sheet_ends.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/model/sheet_frame.h"

namespace kirireel::fea {
namespace {

constexpr double kFlatSheet = 1e-3;      ///< of the size: tiles lie side by side
constexpr double kSameExtent = 1e-9;     ///< relative
constexpr double kSameDirection = 1e-6;  ///< radians
constexpr double kSameWeight = 1e-7;     ///< relative

/// Polygons seen along one of the sheet's axes.
class EndFinder {
 public:
  EndFinder(const std::vector<std::vector<Vector3>>& polygons, const Matrix3& axes, double tileSize)
      : polygons_(polygons), axes_(axes), tileSize_(tileSize) {
    for (const auto& polygon : polygons) {
      for (const Vector3& corner : polygon) box_.extend(axes.transpose() * corner);
      normals_.push_back(doubledVectorArea(polygon).normalized());
    }
  }

  const Eigen::AlignedBox3d& box() const { return box_; }

  /// The edges at the end of an axis, `sign` -1 or 1, seen along the axis `seen`.
  std::vector<PolygonEdge> edgesAt(int axis, double sign, int seen) const {
    const Vector3 out = sign * axes_.col(axis);
    const double extreme = sign > 0 ? box_.max()[axis] : -box_.min()[axis];
    const double reach = tileSize_ + kSameExtent * box_.sizes().norm();
    std::vector<PolygonEdge> found;
    for (int p = 0; p < static_cast<int>(polygons_.size()); ++p) {
      const std::vector<Vector3>& polygon = polygons_[p];
      for (int e = 0; e < static_cast<int>(polygon.size()); ++e) {
        const Vector3& a = polygon[e];
        const Vector3& b = polygon[(e + 1) % polygon.size()];
        const Vector3 outward = (b - a).normalized().cross(normals_[p]);
        const bool isNear = extreme - std::min(out.dot(a), out.dot(b)) <= reach;
        if (!isNear || outward.dot(out) < std::sqrt(0.5) - kSameDirection) continue;
        if (isUnobstructed(0.5 * (a + b), axis, sign, 3 - axis - seen)) found.push_back({p, e});
      }
    }
    return found;
  }

 private:
  /// Whether no edge lies farther out on the line through a point along the axis, as seen along the
  /// third axis; `across` is the one across both.
  bool isUnobstructed(const Vector3& point, int axis, double sign, int across) const {
    const Vector3 at = axes_.transpose() * point;
    const double tolerance = kSameExtent * box_.sizes().norm();
    for (const std::vector<Vector3>& polygon : polygons_) {
      for (std::size_t k = 0; k < polygon.size(); ++k) {
        const Vector3 a = axes_.transpose() * polygon[k];
        const Vector3 b = axes_.transpose() * polygon[(k + 1) % polygon.size()];
        if ((a[across] > at[across]) == (b[across] > at[across])) continue;
        const double share = (at[across] - a[across]) / (b[across] - a[across]);
        const double crossing = a[axis] + share * (b[axis] - a[axis]);
        if (sign * (crossing - at[axis]) > tolerance) return false;
      }
    }
    return true;
  }

  const std::vector<std::vector<Vector3>>& polygons_;
  Matrix3 axes_;
  double tileSize_;
  std::vector<Vector3> normals_;
  Eigen::AlignedBox3d box_;  ///< in the sheet's axes
};

}  // namespace

EndEdges findEndEdges(const std::vector<std::vector<Vector3>>& polygons,
                      const std::vector<PolygonLink>& links, double tileSize) {
  EndEdges ends;
  Eigen::AlignedBox3d box;
  std::vector<model::Tile> tiles;
  std::vector<Vector3> middles;
  for (const auto& polygon : polygons) {
    for (const Vector3& point : polygon) box.extend(point);
    tiles.push_back({polygon});
    middles.push_back(meanPoint(polygon));
  }
  if (polygons.empty()) return ends;
  std::vector<Vector3> places;
  for (const PolygonLink& link : links) places.push_back(link.point);
  const Vector3 middle = places.empty() ? Vector3::Zero() : meanPoint(places);
  const auto weight = [&](const Vector3& direction) {
    double sum = 0;
    for (const PolygonLink& link : links) {
      const double x = direction.dot(link.point - middle);
      const double d = direction.dot(middles[link.second] - middles[link.first]);
      sum += x * x * (x * x + d * d);
    }
    return sum;
  };
  const auto frame = model::sheetFrame(tiles, kFlatSheet * box.sizes().norm());
  ends.isFlat = frame.has_value();
  if (frame) {
    std::vector<Eigen::Vector2d> points;
    for (const auto& polygon : polygons) {
      for (const Vector3& point : polygon) points.emplace_back(frame->toFrame(point).head<2>());
    }
    const double turn =
        model::smallestRectangleAngle(std::move(points), 0, [&](const Eigen::Vector2d& direction) {
          return weight(direction.x() * frame->x + direction.y() * frame->y);
        });
    ends.axes = frame->axes() * Eigen::AngleAxisd(turn, Vector3::UnitZ()).toRotationMatrix();
  }
  const EndFinder finder(polygons, ends.axes, tileSize);
  const Vector3 sizes = finder.box().sizes();
  for (int axis = 1; axis < (ends.isFlat ? 2 : 3); ++axis) {
    const double more = sizes[axis] - sizes[ends.longest];
    const double least = (1 + kSameWeight) * weight(ends.axes.col(ends.longest));
    const bool isEqual = std::abs(more) <= kSameExtent * sizes.norm();
    if (isEqual ? weight(ends.axes.col(axis)) > least : more > 0) ends.longest = axis;
  }
  int seen = 2;
  if (!ends.isFlat) finder.box().sizes().minCoeff(&seen);
  for (int k = 0; k < 6; ++k) {
    if (k / 2 == seen) continue;
    ends.edges[k] = finder.edgesAt(k / 2, k % 2 == 0 ? -1 : 1, seen);
  }
  return ends;
}

}  // namespace kirireel::fea
