// The area of a union of polygons, in two steps.
//
// 1. Polygons that overlap no other add their own areas: the shoelace sum
//    1/2 sum (x_k y_(k+1) - x_(k+1) y_k). Two convex parts overlap unless the normal of a side of
//    one separates them. Overlapping polygons form groups.
// 2. A group is cut into horizontal slabs at all corners and at all crossings of sides. Within a
//    slab no sides cross, so the covered length is linear in y and its value half way times the
//    height is the exact area. Sides that go up count +1, those that go down -1; from left to right
//    a stretch is covered if the sum is not 0 (non-zero winding).
//
// Cost: a test for each pair of polygons with overlapping boxes, and O(m l) for a group of m sides
// and as many crossings, if a horizontal line crosses l of them: their order changes little from
// slab to slab.
//
// J. L. Bentley, "Algorithms for Klee's rectangle problems", 1977 (for rectangles); M. de Berg et
// al., Computational Geometry, 3rd edition, 2008, section 2.1.
#include "sim/trajectory/union_area.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include <Eigen/Geometry>

#include "sim/base/disjoint_sets.h"
#include "sim/base/geometry.h"
#include "sim/base/interruption.h"
#include "sim/model/convex_parts.h"

namespace kirireel::trajectory {
namespace {

using Vector2 = Eigen::Vector2d;
using Polygon = std::vector<Vector2>;

// Polygons whose overlap is below this fraction of their size only touch.
constexpr double kTouching = 1e-12;

double signedArea(const Polygon& polygon) {
  double area = 0;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    // From the first corner, so a polygon far from the origin loses no digits.
    area += 0.5 * crossZ(polygon[k] - polygon[0], polygon[(k + 1) % polygon.size()] - polygon[0]);
  }
  return area;
}

Eigen::AlignedBox2d boxOf(const Polygon& polygon) {
  Eigen::AlignedBox2d box;
  for (const Vector2& corner : polygon) box.extend(corner);
  return box;
}

std::vector<Polygon> convexPartsOf(const Polygon& polygon) {
  std::vector<Vector3> corners;
  for (const Vector2& corner : polygon) corners.emplace_back(corner.x(), corner.y(), 0);
  std::vector<Polygon> parts;
  for (const model::PolygonPart& part : model::convexParts(corners, Vector3::UnitZ())) {
    Polygon& found = parts.emplace_back();
    for (const int corner : part) found.push_back(polygon[static_cast<std::size_t>(corner)]);
  }
  return parts;
}

/// Whether no side of `a` separates `b` from it, up to `tolerance` metres. `a` is anticlockwise.
bool isNotSeparatedBySides(const Polygon& a, const Polygon& b, double tolerance) {
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
  explicit CoveringPiece(Polygon given) : polygon(std::move(given)) {
    area = signedArea(polygon);
    if (area < 0) std::reverse(polygon.begin(), polygon.end());
    area = std::abs(area);
    parts = convexPartsOf(polygon);
    box = boxOf(polygon);
  }

  bool overlaps(const CoveringPiece& other) const {
    const double tolerance =
        kTouching * std::min(box.diagonal().norm(), other.box.diagonal().norm());
    for (const Polygon& a : parts) {
      for (const Polygon& b : other.parts) {
        if (isNotSeparatedBySides(a, b, tolerance) && isNotSeparatedBySides(b, a, tolerance)) {
          return true;
        }
      }
    }
    return false;
  }

  Polygon polygon;
  double area = 0;
  std::vector<Polygon> parts;
  Eigen::AlignedBox2d box;
};

/// The group number of each piece: the index of its first piece.
std::vector<int> groupsOf(const std::vector<CoveringPiece>& pieces) {
  std::vector<std::size_t> order(pieces.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return pieces[i].box.min().x(); });
  DisjointSets groups(pieces.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const CoveringPiece& first = pieces[order[i]];
    for (std::size_t j = i + 1; j < order.size(); ++j) {
      const CoveringPiece& second = pieces[order[j]];
      if (second.box.min().x() >= first.box.max().x()) break;
      if (!first.box.intersects(second.box) || !first.overlaps(second)) continue;
      groups.unite(static_cast<int>(order[i]), static_cast<int>(order[j]));
    }
  }
  return groups.numbers();
}

/// A side that is not horizontal.
struct Side {
  Vector2 low;
  Vector2 high;
  int winding = 1;  ///< 1 if it goes up, else -1

  double xAt(double y) const {
    return low.x() + (y - low.y()) / (high.y() - low.y()) * (high.x() - low.x());
  }
};

/// A side that a horizontal line crosses.
struct EdgeCrossing {
  const Side* side;
  double x = 0;
};

std::vector<Side> sidesOf(const std::vector<const CoveringPiece*>& pieces) {
  std::vector<Side> sides;
  for (const CoveringPiece* piece : pieces) {
    const Polygon& polygon = piece->polygon;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      const Vector2 &from = polygon[k], &to = polygon[(k + 1) % polygon.size()];
      if (from.y() < to.y()) sides.push_back({from, to, 1});
      if (from.y() > to.y()) sides.push_back({to, from, -1});
    }
  }
  std::ranges::stable_sort(sides, {}, [](const Side& side) { return side.low.y(); });
  return sides;
}

/// The heights of all ends and crossings of sides that are sorted by their low ends.
std::vector<double> heightsOf(const std::vector<Side>& sides) {
  std::vector<double> heights;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    heights.insert(heights.end(), {sides[i].low.y(), sides[i].high.y()});
    const Vector2 along = sides[i].high - sides[i].low;
    for (std::size_t j = i + 1; j < sides.size(); ++j) {
      if (sides[j].low.y() >= sides[i].high.y()) break;
      const Vector2 other = sides[j].high - sides[j].low;
      const double sine = crossZ(along, other);
      if (sine == 0) continue;
      const Vector2 between = sides[j].low - sides[i].low;
      const double share = crossZ(between, other) / sine,
                   shareOther = crossZ(between, along) / sine;
      if (share < 0 || share > 1 || shareOther < 0 || shareOther > 1) continue;
      heights.push_back(sides[i].low.y() + share * along.y());
    }
  }
  std::ranges::sort(heights);
  heights.erase(std::unique(heights.begin(), heights.end()), heights.end());
  return heights;
}

/// The covered length of a horizontal line, from its crossings in order.
double coveredLength(const std::vector<EdgeCrossing>& crossings) {
  double length = 0, begin = 0;
  int winding = 0;
  for (const auto& [side, x] : crossings) {
    if (winding == 0) begin = x;
    winding += side->winding;
    if (winding == 0) length += x - begin;
  }
  return length;
}

/// Sorts crossings that are almost in order.
void sortCrossings(std::vector<EdgeCrossing>& crossings) {
  for (std::size_t k = 1; k < crossings.size(); ++k) {
    for (std::size_t j = k; j > 0 && crossings[j].x < crossings[j - 1].x; --j)
      std::swap(crossings[j], crossings[j - 1]);
  }
}

double groupArea(const std::vector<const CoveringPiece*>& pieces) {
  const std::vector<Side> sides = sidesOf(pieces);
  const std::vector<double> heights = heightsOf(sides);
  double area = 0;
  auto next = sides.begin();
  std::vector<EdgeCrossing> crossings;
  for (std::size_t k = 0; k + 1 < heights.size(); ++k) {
    checkInterruption();
    const double middle = 0.5 * (heights[k] + heights[k + 1]);
    std::erase_if(crossings, [&](const EdgeCrossing& c) { return c.side->high.y() <= middle; });
    for (; next != sides.end() && next->low.y() < middle; ++next) {
      if (next->high.y() > middle) crossings.push_back({&*next});
    }
    for (EdgeCrossing& crossing : crossings) crossing.x = crossing.side->xAt(middle);
    sortCrossings(crossings);
    area += coveredLength(crossings) * (heights[k + 1] - heights[k]);
  }
  return area;
}

}  // namespace

double unionArea(const std::vector<std::vector<Eigen::Vector2d>>& polygons) {
  const std::vector<CoveringPiece> pieces(polygons.begin(), polygons.end());
  const std::vector<int> group = groupsOf(pieces);
  std::vector<std::vector<const CoveringPiece*>> groups(pieces.size());
  for (std::size_t i = 0; i < pieces.size(); ++i)
    groups[static_cast<std::size_t>(group[i])].push_back(&pieces[i]);
  double area = 0;
  for (const std::vector<const CoveringPiece*>& members : groups) {
    if (members.empty()) continue;
    area += members.size() == 1 ? members.front()->area : groupArea(members);
  }
  return area;
}

}  // namespace kirireel::trajectory
