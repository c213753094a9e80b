// Coulomb friction of a face under the pressure p is the sum over its area of mu p against the
// direction of slip. Here it is a sum over a few points. A polygon is a fan of triangles about its
// centroid c. On a triangle with the side x(t), -1 <= t <= 1, points are c + r (x(t) - c), and
//   integral of f dA = A integral of f r dr dt.
// Three points of Gauss and Jacobi for r are exact up to the fifth power. Along t one point at the
// middle of the side does, or two of Gauss where sides are as long as a triangle's.
// The distance from c, which a turn about c needs, is linear in r, but a root in t: distances are
// scaled by the quotient of its exact mean and that of the points. With d the distance of the side
// from c and u d the place on it, the exact integral of the distance over a triangle is
//   d^3 / 6 [u sqrt(1 + u^2) + asinh u].
//
// If the push is not at the centroid, the pressure is not even, and which one it is depends on how
// bricks give. The points are then moved to q + s (x - c), with q the centre of the push and the
// largest s <= 1 that keeps the polygon within itself: each side at the distance d(c) from the
// centroid allows s = d(q) / d(c).
#include "sim/mechanics/friction_region.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "sim/model/convex_parts.h"
#include "sim/model/model.h"

namespace kirireel::mechanics {
namespace {

constexpr std::array<double, 3> kRadii = {0.212340538239153, 0.5905331355592653,
                                          0.9114120404872961};
constexpr std::array<double, 3> kRadialShares = {0.13965395980290832, 0.4584822127191726,
                                                 0.4018638274779191};
const double kGauss = 1 / std::sqrt(3.0);
constexpr std::size_t kFewSides = 3;  // up to which two points are taken along a side
// Hulls narrower than this fraction of their length are lines, shorter ones points.
constexpr double kNarrow = 1e-9;
// A region shrunk to less than this part is a point.
constexpr double kPoint = 1e-6;

using Polygon = std::vector<Vector3>;

/// The integral of the distance from a point in the plane over a polygon.
double distanceIntegral(const Polygon& polygon, const Vector3& normal, const Vector3& from) {
  const auto primitive = [](double u) { return u * std::sqrt(1 + u * u) + std::asinh(u); };
  double sum = 0;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Vector3 side = polygon[(k + 1) % polygon.size()] - polygon[k];
    const double length = side.norm();
    const double d = length > 0 ? normal.cross(side / length).dot(from - polygon[k]) : 0;
    if (std::abs(d) <= kNarrow * length) continue;
    const double begin = side.dot(polygon[k] - from) / (length * std::abs(d));
    sum += d * d * d / 6 * (primitive(begin + length / std::abs(d)) - primitive(begin));
  }
  return sum;
}

/// The points of one convex polygon, their shares being areas.
void appendFan(const Polygon& polygon, const Vector3& normal, const Vector3& centroid,
               std::vector<RubbingPoint>& points) {
  const bool isFine = polygon.size() <= kFewSides;
  const std::vector<double> places =
      isFine ? std::vector<double>{-kGauss, kGauss} : std::vector<double>{0};
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Vector3 a = polygon[k] - centroid;
    const Vector3 b = polygon[(k + 1) % polygon.size()] - centroid;
    const double area = 0.5 * normal.dot(a.cross(b)) / static_cast<double>(places.size());
    if (!(area > 0)) continue;
    for (const double place : places) {
      const Vector3 onSide = 0.5 * (1 - place) * a + 0.5 * (1 + place) * b;
      for (std::size_t r = 0; r < kRadii.size(); ++r) {
        points.push_back({centroid + kRadii[r] * onSide, kRadialShares[r] * area});
      }
    }
  }
}

/// The corners of the convex hull of points in a plane, anticlockwise about the normal.
Polygon hullOf(const std::vector<Vector3>& points, const Vector3& normal, double flatness) {
  const Vector3& origin = points.front();
  const Vector3 x = normal.unitOrthogonal(), y = normal.cross(x);
  std::vector<Eigen::Vector2d> flat;
  for (const Vector3& point : points) {
    flat.emplace_back(x.dot(point - origin), y.dot(point - origin));
  }
  Polygon hull;
  for (const Eigen::Vector2d& corner : model::convexOutline(std::move(flat), flatness)) {
    hull.push_back(origin + corner.x() * x + corner.y() * y);
  }
  return hull;
}

}  // namespace

std::vector<RubbingPoint> evenPressure(const std::vector<Polygon>& parts) {
  const Vector3 normal = model::tileNormal({parts.front()});
  std::vector<RubbingPoint> points;
  for (const Polygon& part : parts) appendFan(part, normal, model::tileCentroid({part}), points);
  double area = 0, distance = 0;
  Vector3 centroid = Vector3::Zero();
  for (const RubbingPoint& rubbing : points) {
    area += rubbing.share;
    centroid += rubbing.share * rubbing.point;
  }
  centroid /= area;
  for (const RubbingPoint& rubbing : points) {
    distance += rubbing.share * (rubbing.point - centroid).norm();
  }
  double exact = 0;
  for (const Polygon& part : parts) exact += distanceIntegral(part, normal, centroid);
  for (RubbingPoint& rubbing : points) {
    rubbing.point = centroid + exact / distance * (rubbing.point - centroid);
    rubbing.share /= area;
  }
  return points;
}

RubbingRegion::RubbingRegion(const std::vector<Vector3>& touching, const Vector3& normal)
    : normal_(normal) {
  double size = 0;
  for (const Vector3& point : touching) size = std::max(size, (point - touching.front()).norm());
  if (size == 0) return;
  hull_ = hullOf(touching, normal, kNarrow * size);
  if (hull_.size() == 2) {
    centroid_ = 0.5 * (hull_[0] + hull_[1]);
    const Vector3 quarter = 0.25 * (hull_[1] - hull_[0]);
    even_ = {{centroid_ - quarter, 0.5}, {centroid_ + quarter, 0.5}};
  } else if (hull_.size() > 2) {
    centroid_ = model::tileCentroid({hull_});
    even_ = evenPressure({hull_});
  }
}

/// The largest scale up to 1 that keeps the hull within itself when its centroid is moved.
double RubbingRegion::scaleFor(const Vector3& centre) const {
  if (hull_.size() == 2) {
    const Vector3 half = hull_[1] - centroid_;
    return 1 - std::abs((centre - centroid_).dot(half)) / half.squaredNorm();
  }
  double scale = 1;
  for (std::size_t k = 0; k < hull_.size(); ++k) {
    const Vector3 inwards = normal_.cross(hull_[(k + 1) % hull_.size()] - hull_[k]);
    scale = std::min(scale, inwards.dot(centre - hull_[k]) / inwards.dot(centroid_ - hull_[k]));
  }
  return scale;
}

std::vector<RubbingPoint> RubbingRegion::points(const Vector3& centre) const {
  const double scale = scaleFor(centre);
  if (even_.empty() || !(scale > kPoint)) return {{centre, 1}};
  std::vector<RubbingPoint> moved = even_;
  for (RubbingPoint& rubbing : moved) {
    rubbing.point = centre + scale * (rubbing.point - centroid_);
  }
  return moved;
}

}  // namespace kirireel::mechanics
