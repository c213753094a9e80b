// Coulomb friction of a face under the pressure p is the sum over its area of mu p against the
// direction of slip. Here it is a sum over a few points. A polygon is cut from its centroid c to
// the middles of its sides, so each corner has a quadrilateral
//   x(s, t) = (1 - s)(1 - t) c + s (1 - t) m + s t (corner) + (1 - s) t n,      0 <= s, t <= 1,
// with the middles m and n of the sides at the corner. Gauss' two points for s and t give 2 x 2
// points with the shares |dx/ds x dx/dt| / 4. A slender quadrilateral has 6 x 1 points instead: in
// fast spin the part near c resists slip most. The distance from c, which a turn about c needs, is
// no polynomial: distances are scaled by the quotient of its exact mean and that of the points.
// With d the distance of a side from c and u d the position on it, the exact integral of the
// distance over the triangle from c to the side is
//   d^3 / 6 [u sqrt(1 + u^2) + asinh u].
//
// If the resultant of the pressure is not at the centroid, the pressure is not uniform. Its
// distribution depends on the deformation of the bricks, which is not computed. The points are then
// moved to q + s (x - c), with q the point of the resultant and the largest s <= 1 that keeps the
// polygon within itself: each side at the distance d(c) from the centroid allows s = d(q) / d(c).
#include "sim/mechanics/friction_region.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "sim/model/convex_parts.h"
#include "sim/model/model.h"

namespace kirireel::mechanics {
namespace {

/// One of Gauss' points on [0, 1], with its weight.
struct GaussPlace {
  double at;
  double weight;
};
constexpr std::array<GaussPlace, 1> kMiddle = {{{0.5, 1}}};
const std::array<GaussPlace, 2> kPlaces = {
    {{0.5 - 0.5 / std::sqrt(3.0), 0.5}, {0.5 + 0.5 / std::sqrt(3.0), 0.5}}};
// Abramowitz and Stegun, Handbook of Mathematical Functions, table 25.4.
constexpr std::array<GaussPlace, 6> kSlenderPlaces = {{{0.033765242898424, 0.085662246189585},
                                                       {0.169395306766868, 0.180380786524069},
                                                       {0.380690406958402, 0.233956967286346},
                                                       {0.619309593041598, 0.233956967286346},
                                                       {0.830604693233132, 0.180380786524069},
                                                       {0.966234757101576, 0.085662246189585}}};
// A quadrilateral is slender if its length is more than this many times its width.
constexpr double kSlender = 3;
// Hulls narrower than this fraction of their length are lines, shorter ones points.
constexpr double kNarrow = 1e-9;
// A region that is scaled by less than this factor is a point.
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

/// Gauss' points along a quadrilateral's length, if its width is as given.
std::span<const GaussPlace> placesAlong(double length, double width) {
  if (length > kSlender * width) return kSlenderPlaces;
  if (width > kSlender * length) return kMiddle;
  return kPlaces;
}

/// The points of one convex polygon, their shares being areas.
void appendPoints(const Polygon& polygon, const Vector3& normal, const Vector3& centroid,
                  std::vector<FrictionPoint>& points) {
  const std::size_t count = polygon.size();
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3 corner = polygon[k] - centroid;
    const Vector3 m = 0.5 * (corner + polygon[(k + count - 1) % count] - centroid);
    const Vector3 n = 0.5 * (corner + polygon[(k + 1) % count] - centroid);
    const double ofS = (m + corner - n).norm(), ofT = (n + corner - m).norm();
    for (const auto& [s, weightOfS] : placesAlong(ofS, ofT)) {
      for (const auto& [t, weightOfT] : placesAlong(ofT, ofS)) {
        const Vector3 place = s * (1 - t) * m + s * t * corner + (1 - s) * t * n;
        const Vector3 alongS = (1 - t) * m + t * (corner - n);
        const Vector3 alongT = s * (corner - m) + (1 - s) * n;
        const double area = weightOfS * weightOfT * normal.dot(alongS.cross(alongT));
        if (area > 0) points.push_back({centroid + place, area});
      }
    }
  }
}

/// The corners of the convex hull of points in a plane, anticlockwise about the normal. The first
/// corner is the first of the points that is one: the order does not change if all points turn.
Polygon hullOf(const std::vector<Vector3>& points, const Vector3& normal, double flatness) {
  const Vector3& origin = points.front();
  const Vector3 x = normal.unitOrthogonal(), y = normal.cross(x);
  std::vector<Eigen::Vector2d> flat;
  for (const Vector3& point : points) {
    flat.emplace_back(x.dot(point - origin), y.dot(point - origin));
  }
  std::vector<Eigen::Vector2d> outline = model::convexOutline(flat, flatness);
  const auto first = std::find_first_of(flat.begin(), flat.end(), outline.begin(), outline.end());
  std::ranges::rotate(outline, std::ranges::find(outline, *first));
  Polygon hull;
  for (const Eigen::Vector2d& corner : outline) {
    hull.push_back(origin + corner.x() * x + corner.y() * y);
  }
  return hull;
}

}  // namespace

std::vector<FrictionPoint> evenPressure(const std::vector<Polygon>& parts) {
  const Vector3 normal = model::tileNormal({parts.front()});
  std::vector<FrictionPoint> points;
  for (const Polygon& part : parts) {
    appendPoints(part, normal, model::tileCentroid({part}), points);
  }
  double area = 0, distance = 0;
  Vector3 centroid = Vector3::Zero();
  for (const FrictionPoint& part : points) {
    area += part.share;
    centroid += part.share * part.point;
  }
  centroid /= area;
  for (const FrictionPoint& part : points) {
    distance += part.share * (part.point - centroid).norm();
  }
  double exact = 0;
  for (const Polygon& part : parts) exact += distanceIntegral(part, normal, centroid);
  for (FrictionPoint& part : points) {
    part.point = centroid + exact / distance * (part.point - centroid);
    part.share /= area;
  }
  return points;
}

FrictionRegion::FrictionRegion(const std::vector<Vector3>& touching, const Vector3& normal)
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
double FrictionRegion::scaleFor(const Vector3& centre) const {
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

std::vector<FrictionPoint> FrictionRegion::points(const Vector3& centre) const {
  const double scale = scaleFor(centre);
  if (even_.empty() || !(scale > kPoint)) return {{centre, 1}};
  std::vector<FrictionPoint> moved = even_;
  for (FrictionPoint& part : moved) {
    part.point = centre + scale * (part.point - centroid_);
  }
  return moved;
}

}  // namespace kirireel::mechanics
