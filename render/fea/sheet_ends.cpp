// An end of a sheet is what a person would hold: the edges that face outwards there. They are found
// in a plane. A flat sheet lies in it; of any other sheet it is seen along the axis in which it is
// thinnest.
//
// - Axes: the smallest rectangle round a set of points has a side along an edge of their convex
//   hull (H. Freeman, R. Shapira, Determining the minimum-area encasing rectangle for an arbitrary
//   closed curve, Commun. ACM 18, 1975). All hull edges are tried. Equal rectangles: the one that
//   is turned least from the world's axes.
// - An edge whose midpoint sees another edge on its way out along the axis is inside: it is a bank
//   of a slit or lies at a hole.

#include "render/fea/sheet_ends.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace kirireel::fea {
namespace {

using Plane = Eigen::Vector2d;

constexpr double kFlatSheet = 1e-3;      ///< of the size: tiles lie side by side
constexpr double kSameExtent = 1e-9;     ///< relative: rectangles count as equal
constexpr double kSameDirection = 1e-6;  ///< radians

double crossOf(const Plane& a, const Plane& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Anticlockwise, without points on straight sides (Andrew's monotone chain).
std::vector<Plane> convexHull(std::vector<Plane> points) {
  const auto before = [](const Plane& a, const Plane& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  };
  std::ranges::sort(points, before);
  std::vector<Plane> hull;
  const auto append = [&hull](const Plane& point, std::size_t first) {
    while (hull.size() >= first + 2 &&
           crossOf(hull.back() - hull[hull.size() - 2], point - hull[hull.size() - 2]) <= 0) {
      hull.pop_back();
    }
    hull.push_back(point);
  };
  for (const Plane& point : points) append(point, 0);
  const std::size_t upper = hull.size() - 1;
  for (auto point = points.rbegin(); point != points.rend(); ++point) append(*point, upper);
  hull.pop_back();
  return hull;
}

/// The area of the rectangle round the points whose sides are turned so from the axes.
double rectangleArea(const std::vector<Plane>& points, double angle) {
  const Eigen::Rotation2Dd back(-angle);
  Eigen::AlignedBox2d box;
  for (const Plane& point : points) box.extend(back * point);
  return box.sizes().prod();
}

/// The turn of the smallest rectangle's sides from the axes, in (-pi / 4, pi / 4].
double turnOfSheet(const std::vector<Plane>& points) {
  const std::vector<Plane> hull = convexHull(points);
  double best = 0;
  double least = rectangleArea(hull, 0);
  for (std::size_t k = 0; k < hull.size(); ++k) {
    const Plane side = hull[(k + 1) % hull.size()] - hull[k];
    const double quarter = std::numbers::pi / 2;
    double angle = std::atan2(side.y(), side.x());
    angle -= quarter * std::ceil(angle / quarter - 0.5);
    const double area = rectangleArea(hull, angle);
    const bool isSame = std::abs(area - least) <= kSameExtent * least;
    const bool isTurnedLess = std::abs(angle) < std::abs(best) - kSameDirection;
    if (isSame ? isTurnedLess : area < least) {
      best = angle;
      least = area;
    }
  }
  return best;
}

/// Polygons seen along one of the sheet's axes.
class EndFinder {
 public:
  EndFinder(const std::vector<std::vector<Vector3>>& polygons, const Matrix3& axes, double tileSize)
      : polygons_(polygons), axes_(axes), tileSize_(tileSize) {
    for (const auto& polygon : polygons) {
      Vector3 normal = Vector3::Zero();
      for (std::size_t k = 0; k < polygon.size(); ++k) {
        const Vector3 next = polygon[(k + 1) % polygon.size()] - polygon[0];
        normal += (polygon[k] - polygon[0]).cross(next);
        box_.extend(axes.transpose() * polygon[k]);
      }
      normals_.push_back(normal.normalized());
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
        if (seesOut(0.5 * (a + b), axis, sign, 3 - axis - seen)) found.push_back({p, e});
      }
    }
    return found;
  }

 private:
  /// Whether no edge lies farther out on the line through a point along the axis, as seen along the
  /// third axis; `across` is the one across both.
  bool seesOut(const Vector3& point, int axis, double sign, int across) const {
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

EndEdges findEndEdges(const std::vector<std::vector<Vector3>>& polygons, double tileSize) {
  EndEdges ends;
  Eigen::AlignedBox3d box;
  std::vector<Plane> points;
  for (const auto& polygon : polygons) {
    for (const Vector3& point : polygon) {
      box.extend(point);
      points.emplace_back(point.head<2>());
    }
  }
  if (points.empty()) return ends;
  ends.isFlat = box.sizes().z() <= kFlatSheet * box.sizes().norm();
  if (ends.isFlat) {
    const double turn = turnOfSheet(points);
    ends.axes = Eigen::AngleAxisd(turn, Vector3::UnitZ()).toRotationMatrix();
  }
  const EndFinder finder(polygons, ends.axes, tileSize);
  int seen = 2;
  if (!ends.isFlat) finder.box().sizes().minCoeff(&seen);
  for (int k = 0; k < 6; ++k) {
    if (k / 2 == seen) continue;
    ends.edges[k] = finder.edgesAt(k / 2, k % 2 == 0 ? -1 : 1, seen);
  }
  return ends;
}

}  // namespace kirireel::fea
