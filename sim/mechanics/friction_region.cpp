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

namespace kirireel::mechanics {
namespace {

constexpr std::array<double, 3> kRadii = {0.212340538239153, 0.5905331355592653,
                                          0.9114120404872961};
constexpr std::array<double, 3> kRadialShares = {0.13965395980290832, 0.4584822127191726,
                                                 0.4018638274779191};
const double kGauss = 1 / std::sqrt(3.0);
constexpr std::size_t kFewSides = 3;  // up to which two points are taken along a side
// Hulls narrower than this part of their length are lines, shorter ones points.
constexpr double kNarrow = 1e-9;
// A region shrunk to less than this part is a point.
constexpr double kPoint = 1e-6;

using Polygon = std::vector<Vector3>;

/// Twice the vector area, by Newell's formula about a point.
Vector3 doubleArea(const Polygon& polygon, const Vector3& about) {
  Vector3 sum = Vector3::Zero();
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    sum += (polygon[k] - about).cross(polygon[(k + 1) % polygon.size()] - about);
  }
  return sum;
}

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

/// The centroid of a convex polygon.
Vector3 centroidOf(const Polygon& polygon, const Vector3& normal) {
  Vector3 sum = Vector3::Zero();
  double whole = 0;
  for (std::size_t k = 1; k + 1 < polygon.size(); ++k) {
    const double area = normal.dot((polygon[k] - polygon[0]).cross(polygon[k + 1] - polygon[0]));
    sum += area / 3 * (polygon[0] + polygon[k] + polygon[k + 1]);
    whole += area;
  }
  return sum / whole;
}

/// The corners of the convex hull, anticlockwise about the normal (A. M. Andrew, 1979).
Polygon hullOf(const std::vector<Vector3>& all, const Vector3& normal, double tolerance) {
  const Vector3 x = normal.unitOrthogonal(), y = normal.cross(x);
  Polygon sorted = all;
  std::ranges::sort(sorted, [&](const Vector3& a, const Vector3& b) {
    const double dx = x.dot(a - b);
    return dx != 0 ? dx < 0 : y.dot(a - b) < 0;
  });
  Polygon hull;
  const auto addChain = [&](const auto& points) {
    const std::size_t first = hull.size();
    for (const Vector3& point : points) {
      const auto turnsRight = [&] {
        const Vector3& last = hull.back();
        const Vector3 side = last - hull[hull.size() - 2];
        return normal.dot(side.cross(point - last)) <= tolerance * side.norm();
      };
      while (hull.size() >= first + 2 && turnsRight()) hull.pop_back();
      hull.push_back(point);
    }
    hull.pop_back();
  };
  addChain(sorted);
  std::ranges::reverse(sorted);
  addChain(sorted);
  return hull;
}

/// Moves the points so that they have their centroid elsewhere, and shrinks their pattern.
std::vector<RubbingPoint> movedTo(const Vector3& centre, double scale, const Vector3& centroid,
                                  std::vector<RubbingPoint> points) {
  if (!(scale > kPoint)) return {{centre, 1}};
  for (RubbingPoint& rubbing : points) {
    rubbing.point = centre + std::min(1.0, scale) * (rubbing.point - centroid);
  }
  return points;
}

}  // namespace

std::vector<RubbingPoint> evenPressure(const std::vector<Polygon>& parts) {
  const Vector3 normal = doubleArea(parts.front(), parts.front().front()).normalized();
  std::vector<RubbingPoint> points;
  for (const Polygon& part : parts) appendFan(part, normal, centroidOf(part, normal), points);
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

std::vector<RubbingPoint> rubbingPoints(const std::vector<Vector3>& touching, const Vector3& normal,
                                        const Vector3& centre) {
  double size = 0;
  for (const Vector3& point : touching) size = std::max(size, (point - touching.front()).norm());
  if (size == 0) return {{centre, 1}};
  const Polygon hull = hullOf(touching, normal, kNarrow * size);
  if (hull.size() < 2) return {{centre, 1}};
  if (hull.size() == 2) {
    const Vector3 middle = 0.5 * (hull[0] + hull[1]), quarter = 0.25 * (hull[1] - hull[0]);
    const double off = (centre - middle).dot(quarter) / (2 * quarter.squaredNorm());
    return movedTo(centre, 1 - std::abs(off), middle,
                   {{middle - quarter, 0.5}, {middle + quarter, 0.5}});
  }
  const Vector3 centroid = centroidOf(hull, normal);
  double scale = 1;
  for (std::size_t k = 0; k < hull.size(); ++k) {
    const Vector3 inwards = normal.cross(hull[(k + 1) % hull.size()] - hull[k]);
    scale = std::min(scale, inwards.dot(centre - hull[k]) / inwards.dot(centroid - hull[k]));
  }
  return movedTo(centre, scale, centroid, evenPressure({hull}));
}

}  // namespace kirireel::mechanics
