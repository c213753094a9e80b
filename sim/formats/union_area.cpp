// The area of a union of polygons, in two steps.
//
// 1. Polygons that overlap no other add their own areas. Two convex parts overlap unless the normal
//    of a side of one separates them.
// 2. GEOS computes the area of the union of all others.
//
// Step 1 tests each pair of polygons with overlapping boxes. Most sheets need no more.
#include "sim/formats/union_area.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include <Eigen/Geometry>

#include "sim/base/geometry.h"
#include "sim/base/interruption.h"
#include "sim/formats/geos_plane.h"
#include "sim/model/convex_parts.h"

namespace kirireel::formats {
namespace {

// Polygons whose overlap is below this fraction of their size only touch.
constexpr double kTouching = 1e-12;

std::vector<PlaneRing> convexPartsOf(const PlaneRing& polygon) {
  std::vector<Vector3> corners;
  for (const Vector2& corner : polygon) corners.emplace_back(corner.x(), corner.y(), 0);
  std::vector<PlaneRing> parts;
  for (const model::PolygonPart& part : model::convexParts(corners, Vector3::UnitZ())) {
    PlaneRing& found = parts.emplace_back();
    for (const int corner : part) found.push_back(polygon[static_cast<std::size_t>(corner)]);
  }
  return parts;
}

/// Whether no side of `a` separates `b` from it, up to `tolerance` metres. `a` is anticlockwise.
bool isNotSeparatedBySides(const PlaneRing& a, const PlaneRing& b, double tolerance) {
  for (std::size_t k = 0; k < a.size(); ++k) {
    const Vector2 side = (a[(k + 1) % a.size()] - a[k]).normalized();
    double deepest = -std::numeric_limits<double>::infinity();
    for (const Vector2& corner : b) deepest = std::max(deepest, crossZ(side, corner - a[k]));
    if (deepest <= tolerance) return false;
  }
  return true;
}

/// A polygon, anticlockwise, with data for the overlap test.
struct CoveringPiece {
  explicit CoveringPiece(PlaneRing given) : polygon(std::move(given)) {
    area = ringArea(polygon);
    if (area < 0) std::reverse(polygon.begin(), polygon.end());
    area = std::abs(area);
    parts = convexPartsOf(polygon);
    box = boundingBox(polygon);
  }

  bool overlaps(const CoveringPiece& other) const {
    const double tolerance =
        kTouching * std::min(box.diagonal().norm(), other.box.diagonal().norm());
    for (const PlaneRing& a : parts) {
      for (const PlaneRing& b : other.parts) {
        if (isNotSeparatedBySides(a, b, tolerance) && isNotSeparatedBySides(b, a, tolerance)) {
          return true;
        }
      }
    }
    return false;
  }

  PlaneRing polygon;
  double area = 0;
  std::vector<PlaneRing> parts;
  Eigen::AlignedBox2d box;
};

/// Whether each piece overlaps another.
std::vector<bool> findOverlapping(const std::vector<CoveringPiece>& pieces) {
  std::vector<std::size_t> order(pieces.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t i) { return pieces[i].box.min().x(); });
  std::vector<bool> areOverlapping(pieces.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const CoveringPiece& first = pieces[order[i]];
    for (std::size_t j = i + 1; j < order.size(); ++j) {
      const CoveringPiece& second = pieces[order[j]];
      if (second.box.min().x() >= first.box.max().x()) break;
      if (!first.box.intersects(second.box) || !first.overlaps(second)) continue;
      areOverlapping[order[i]] = areOverlapping[order[j]] = true;
    }
  }
  return areOverlapping;
}

}  // namespace

double unionArea(const std::vector<PlaneRing>& polygons) {
  checkInterruption();
  const std::vector<CoveringPiece> pieces(polygons.begin(), polygons.end());
  const std::vector<bool> areOverlapping = findOverlapping(pieces);
  double area = 0;
  std::vector<PlaneRing> overlapping;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (!areOverlapping[i]) {
      area += pieces[i].area;
      continue;
    }
    // From a corner of the first polygon, so distant polygons lose no digits.
    PlaneRing& ring = overlapping.emplace_back(pieces[i].polygon);
    for (Vector2& corner : ring) corner -= polygons.front().front();
  }
  if (overlapping.empty()) return area;
  GeosPlane plane;
  return area + plane.area(plane.united(overlapping));
}

}  // namespace kirireel::formats
