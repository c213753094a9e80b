// Ear clipping and merging, as in the header, and a test for crossing sides.
//
// All decisions use sines of angles, so they do not depend on the size of the tile. With a, b, c
// the previous, the current and the next corner,
//   sine(b) = (b - a) x (c - b) / (|b - a| |c - b|)      positive for a left turn
// is the sine of the turn at b. A left corner can be an ear. A right corner beyond rounding makes
// the polygon concave there. Orientation tests use plain doubles, not exact predicates. Nearly
// collinear corners are treated alike for either sign of the rounding error, since every threshold
// (>= 1e-12) is far above rounding (1e-16).
#include "sim/model/convex_parts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>

#include <fmt/format.h>

#include "sim/base/error.h"

namespace kirireel::model {
namespace {

using Vector2 = Eigen::Vector2d;

// Largest sine by which a corner of a convex tile may turn inwards. Corners within a straight side
// carry rounding, and optimised designs dent it by a degree. Deepest in real designs: 0.0195
// (hexagon_shear_w4_h2_i4_f0). The limit of the sum is twice that, which detects a bay made of many
// small turns.
constexpr double kStraightCorner = 0.03;
constexpr double kStraightInAll = 0.06;
// Largest sine by which a corner of a part may turn inwards: rounding of straight sides.
constexpr double kPartCorner = 1e-3;
// A corner with a larger sine turns left and can be an ear.
constexpr double kEar = 1e-9;

/// The sine of the turn at b from the side a-b to b-c: positive to the left.
double turnSine(const Vector2& a, const Vector2& b, const Vector2& c) {
  const Vector2 before = b - a, after = c - b;
  return crossZ(before, after) / (before.norm() * after.norm());
}

std::vector<Vector2> flattened(std::span<const Vector3> corners, const Vector3& normal) {
  // The direction of the axes about the normal is arbitrary, since only signs of areas matter.
  const Vector3 x = normal.unitOrthogonal();
  const Vector3 y = normal.cross(x);
  std::vector<Vector2> points;
  for (const Vector3& corner : corners) {
    // Differences from the first corner keep the precision of tiles far from the origin.
    const Vector3 from = corner - corners.front();
    points.emplace_back(x.dot(from), y.dot(from));
  }
  return points;
}

/// Whether p lies in the triangle or on its boundary.
bool holds(const Vector2& a, const Vector2& b, const Vector2& c, const Vector2& p) {
  // The tolerance is an area relative to the squared side. A corner on a side counts as inside,
  // which prevents an ear through a touching corner.
  const auto isLeft = [&](const Vector2& from, const Vector2& to) {
    return crossZ(to - from, p - from) >= -1e-12 * (to - from).squaredNorm();
  };
  return isLeft(a, b) && isLeft(b, c) && isLeft(c, a);
}

/// The ring of remaining corners during ear clipping.
class EarClipper {
 public:
  // Rates all corners once. Later only the neighbours of a removed ear change.
  explicit EarClipper(std::vector<Vector2> points) : points_(std::move(points)) {
    ring_.resize(points_.size());
    std::iota(ring_.begin(), ring_.end(), 0);
    for (std::size_t k = 0; k < ring_.size(); ++k) qualities_.push_back(quality(triangleAt(k)));
  }

  // The triangles in the order of their removal.
  std::vector<std::array<int, 3>> triangles() {
    std::vector<std::array<int, 3>> cut;
    // Each ear removes one corner of the polygon. The last three corners are the last triangle.
    while (ring_.size() > 3) {
      const std::size_t ear = bestEar();
      cut.push_back(triangleAt(ear));
      ring_.erase(ring_.begin() + static_cast<std::ptrdiff_t>(ear));
      qualities_.erase(qualities_.begin() + static_cast<std::ptrdiff_t>(ear));
      // Only the two neighbours of the ear have a new triangle now.
      const std::size_t count = ring_.size();
      for (const std::size_t k : {(ear + count - 1) % count, ear % count}) {
        qualities_[k] = quality(triangleAt(k));
      }
    }
    cut.push_back({ring_[0], ring_[1], ring_[2]});
    return cut;
  }

 private:
  // Corner k of the ring with the previous and the next corner.
  std::array<int, 3> triangleAt(std::size_t k) const {
    const std::size_t count = ring_.size();
    return {ring_[(k + count - 1) % count], ring_[k], ring_[(k + 1) % count]};
  }

  /// The smallest sine of a triangle's angles; negative at a right turn.
  double quality(const std::array<int, 3>& t) const {
    const auto [a, b, c] = t;
    return std::min({turnSine(points_[a], points_[b], points_[c]),
                     turnSine(points_[b], points_[c], points_[a]),
                     turnSine(points_[c], points_[a], points_[b])});
  }

  // Whether no other corner of the ring lies in the triangle. The cut would leave it outside.
  bool isEmpty(const std::array<int, 3>& t) const {
    return std::none_of(ring_.begin(), ring_.end(), [&](int k) {
      if (std::find(t.begin(), t.end(), k) != t.end()) return false;
      return holds(points_[t[0]], points_[t[1]], points_[t[2]], points_[k]);
    });
  }

  /// Ring position of the best ear. If rounding leaves no ear, of the least bad corner.
  std::size_t bestEar() const {
    std::vector<std::size_t> order(ring_.size());
    std::iota(order.begin(), order.end(), 0);
    // Rounding must not choose between equal ears: compare sines to nine digits.
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return std::round(1e9 * qualities_[a]) > std::round(1e9 * qualities_[b]);
    });
    for (const std::size_t k : order) {
      // The corners are sorted, so no ear follows the first right turn.
      if (!(qualities_[k] > kEar)) break;
      if (isEmpty(triangleAt(k))) return k;
    }
    return order.front();
  }

  std::vector<Vector2> points_;
  std::vector<int> ring_;
  std::vector<double> qualities_;  ///< of each corner in the ring
};

/// Merges two parts across the diagonal from `from` to `to` (direction in the first part).
PolygonPart joined(const PolygonPart& first, const PolygonPart& second, int from, int to) {
  const auto place = [](const PolygonPart& part, int corner) {
    return static_cast<std::size_t>(std::find(part.begin(), part.end(), corner) - part.begin());
  };
  PolygonPart whole;
  // Around the first part from `to` to `from`, then around the second.
  for (std::size_t k = 0, at = place(first, to); k < first.size(); ++k) {
    whole.push_back(first[(at + k) % first.size()]);
  }
  for (std::size_t k = 1, at = place(second, from); k + 1 < second.size(); ++k) {
    whole.push_back(second[(at + k) % second.size()]);
  }
  return whole;
}

// Whether no corner of a part turns right by more than rounding.
bool staysConvex(const PolygonPart& part, const std::vector<Vector2>& points) {
  const std::size_t count = part.size();
  for (std::size_t k = 0; k < count; ++k) {
    const double sine = turnSine(points[part[(k + count - 1) % count]], points[part[k]],
                                 points[part[(k + 1) % count]]);
    if (sine < -kPartCorner) return false;
  }
  return true;
}

/// The part with the side `from`-`to` in this direction; the end if there is none.
std::vector<PolygonPart>::iterator partWithSide(std::vector<PolygonPart>& parts, int from, int to) {
  return std::find_if(parts.begin(), parts.end(), [&](const PolygonPart& part) {
    const auto at = std::find(part.begin(), part.end(), from);
    if (at == part.end()) return false;
    return (at + 1 == part.end() ? part.front() : *(at + 1)) == to;
  });
}

/// Removes each diagonal in turn if the merged part stays convex.
void mergeParts(std::vector<PolygonPart>& parts, const std::vector<Vector2>& points) {
  // The parts change as diagonals disappear, so the triangles that name the diagonals are copied.
  const std::vector<PolygonPart> triangles = parts;
  for (const PolygonPart& triangle : triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int from = triangle[k], to = triangle[(k + 1) % 3];
      if (from > to) continue;  // each diagonal once
      const auto first = partWithSide(parts, from, to);
      const auto second = partWithSide(parts, to, from);
      // A side of the outline, or a diagonal that an earlier merge removed.
      if (first == parts.end() || second == parts.end()) continue;
      PolygonPart whole = joined(*first, *second, from, to);
      if (!staysConvex(whole, points)) continue;
      *first = std::move(whole);
      parts.erase(second);
    }
  }
}

/// The distance of two segments.
double distance(const Vector2& a, const Vector2& b, const Vector2& c, const Vector2& d) {
  const auto toStretch = [](const Vector2& p, const Vector2& from, const Vector2& to) {
    return (nearestOnSegment(p, from, to) - p).norm();
  };
  // Either the nearest points include an end of one segment, or the segments cross.
  const double ofEnds =
      std::min({toStretch(a, c, d), toStretch(b, c, d), toStretch(c, a, b), toStretch(d, a, b)});
  // Two segments cross if the ends of each lie on both sides of the other, and at one point. Of
  // segments on one line the sides are rounding, and these points are apart.
  const double ofC = crossZ(b - a, c - a), ofD = crossZ(b - a, d - a);
  const double ofA = crossZ(d - c, a - c), ofB = crossZ(d - c, b - c);
  if ((ofC > 0) == (ofD > 0) || (ofA > 0) == (ofB > 0)) return ofEnds;
  const Vector2 onFirst = a + ofA / (ofA - ofB) * (b - a);
  const Vector2 onSecond = c + ofC / (ofC - ofD) * (d - c);
  return std::min(ofEnds, (onFirst - onSecond).norm());
}

}  // namespace

// In space, without projection: called for every tile, and most are convex.
bool isConvexPolygon(std::span<const Vector3> corners, const Vector3& normal) {
  double inAll = 0;
  const std::size_t count = corners.size();
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3 before = (corners[k] - corners[(k + count - 1) % count]).normalized();
    const Vector3 after = (corners[(k + 1) % count] - corners[k]).normalized();
    const double sine = before.cross(after).dot(normal);
    if (sine < -kStraightCorner) return false;
    // Only inward turns count.
    inAll -= std::min(sine, 0.0);
  }
  return inAll <= kStraightInAll;
}

// The first crossing in the order of the sides.
std::optional<std::pair<int, int>> crossingSides(std::span<const Vector3> corners,
                                                 const Vector3& normal, double tolerance) {
  const std::vector<Vector2> points = flattened(corners, normal);
  const int count = static_cast<int>(points.size());
  const auto at = [&](int k) -> const Vector2& { return points[k % count]; };
  for (int i = 0; i < count; ++i) {
    // The next side runs back along this one.
    const Vector2 along = at(i + 1) - at(i), next = at(i + 2) - at(i + 1);
    const bool turnsBack =
        along.dot(next) < 0 && std::abs(crossZ(along, next)) < 1e-9 * along.norm() * next.norm();
    if (turnsBack) return std::pair{i, (i + 1) % count};
    // Sides i and i + 1 share a corner, which is allowed. Compares all pairs: O(n^2), n <= 300.
    for (int j = i + 2; j < count; ++j) {
      // The last side shares a corner with the first.
      if ((j + 1) % count == i) continue;
      if (distance(at(i), at(i + 1), at(j), at(j + 1)) <= tolerance) return std::pair{i, j};
    }
  }
  return std::nullopt;
}

std::vector<std::array<int, 3>> trianglesOf(std::span<const Vector3> corners,
                                            const Vector3& normal) {
  if (!isConvexPolygon(corners, normal)) {
    return EarClipper(flattened(corners, normal)).triangles();
  }
  std::vector<std::array<int, 3>> fan;
  for (int k = 2; k < static_cast<int>(corners.size()); ++k) fan.push_back({0, k - 1, k});
  return fan;
}

std::vector<PolygonPart> convexParts(std::span<const Vector3> corners, const Vector3& normal) {
  if (isConvexPolygon(corners, normal)) {
    PolygonPart all(corners.size());
    std::iota(all.begin(), all.end(), 0);
    return {all};
  }
  const std::vector<Vector2> points = flattened(corners, normal);
  std::vector<PolygonPart> parts;
  for (const std::array<int, 3>& triangle : EarClipper(points).triangles()) {
    parts.emplace_back(triangle.begin(), triangle.end());
  }
  mergeParts(parts, points);
  return parts;
}

// ------------------------------------------------------------------------------------------------
// Convex hull. The points are processed from left to right. Each new point removes previous points
// at which the chain does not turn left, which gives the lower half. The upper half is built from
// right to left in the same manner.

namespace {

/// Appends one half of the hull of points sorted by x. Omits the last point, which begins the other
/// half.
template <typename Iterator>
void appendHalf(Iterator begin, Iterator end, double flatness, std::vector<Vector2>& outline) {
  const std::size_t first = outline.size();
  for (Iterator point = begin; point != end; ++point) {
    while (outline.size() > first + 1) {
      const Vector2 along = outline.back() - outline[outline.size() - 2];
      if (crossZ(along, *point - outline.back()) > flatness * along.norm()) break;
      outline.pop_back();
    }
    outline.push_back(*point);
  }
  outline.pop_back();
}

}  // namespace

std::vector<Eigen::Vector2d> convexOutline(std::vector<Eigen::Vector2d> points, double flatness) {
  std::ranges::sort(points, {}, [](const Vector2& p) { return std::tuple(p.x(), p.y()); });
  std::vector<Vector2> outline;
  if (points.empty()) return outline;
  appendHalf(points.begin(), points.end(), flatness, outline);
  appendHalf(points.rbegin(), points.rend(), flatness, outline);
  return outline;
}

// ------------------------------------------------------------------------------------------------
// The hull of the sheet's corners. Corners on a straight side are kept, because springs may pull
// them.

namespace {

/// Coordinates nearer than this fraction of the sheet's larger side are equal.
constexpr double kSameCoordinate = 1e-9;

struct TilePoint {
  double x, y;
  Corner corner;
};

/// Merges values that are connected by gaps of at most `least` into their minimum. In rotated or
/// distant sheets one coordinate occurs as several that differ by rounding.
void joinNearValues(std::vector<TilePoint>& points, double TilePoint::*value, double least) {
  std::vector<double*> rising;
  for (TilePoint& point : points) rising.push_back(&(point.*value));
  std::ranges::sort(rising, {}, [](const double* at) { return *at; });
  double last = *rising.front(), first = last;
  for (double* const at : rising) {
    if (*at - last > least) first = *at;
    last = *at;
    *at = first;
  }
}

// By x, then y. A stable sort keeps the first corner at each position first.
std::vector<TilePoint> sortedPoints(const std::vector<Tile>& tiles) {
  std::vector<TilePoint> points;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    for (std::size_t k = 0; k < tiles[i].vertices.size(); ++k) {
      const Vector3& vertex = tiles[i].vertices[k];
      points.push_back({vertex.x(), vertex.y(), {static_cast<int>(i), static_cast<int>(k)}});
    }
  }
  const auto [left, right] = std::ranges::minmax(points, {}, &TilePoint::x);
  const auto [low, high] = std::ranges::minmax(points, {}, &TilePoint::y);
  const double least = kSameCoordinate * std::max(right.x - left.x, high.y - low.y);
  joinNearValues(points, &TilePoint::x, least);
  joinNearValues(points, &TilePoint::y, least);
  std::stable_sort(points.begin(), points.end(), [](const TilePoint& a, const TilePoint& b) {
    return std::tie(a.x, a.y) < std::tie(b.x, b.y);
  });
  return points;
}

}  // namespace

std::vector<Corner> outlineCorners(const std::vector<Tile>& tiles) {
  std::vector<TilePoint> points = sortedPoints(tiles);
  const auto samePlace = [](const TilePoint& a, const TilePoint& b) {
    return a.x == b.x && a.y == b.y;
  };
  points.erase(std::unique(points.begin(), points.end(), samePlace), points.end());
  std::vector<Eigen::Vector2d> places;
  for (const TilePoint& point : points) places.emplace_back(point.x, point.y);
  // A corner this much inside its side is on it: the distance comes from rounding.
  const double rounding = kSameCoordinate * (places.back() - places.front()).norm();
  std::vector<Corner> outline;
  for (const Eigen::Vector2d& place : convexOutline(std::move(places), -rounding)) {
    const auto at = [&](const TilePoint& point) {
      return point.x == place.x() && point.y == place.y();
    };
    outline.push_back(std::ranges::find_if(points, at)->corner);
  }
  return outline;
}

// ------------------------------------------------------------------------------------------------
// Splits tiles into triangles with hinges between them. Rigid parts can then model bending.
//
// A convex polygon with n corners is cut by the n - 3 diagonals from one corner, the apex. The apex
// has the smallest sum of diagonals: sheets bend more easily along short diagonals, and the
// triangles are less thin. Concave tiles are cut into ears (convex_parts.h). Two parts with a
// common diagonal are joined at both its ends on the bottom face: two point joints on one line are
// a hinge. Joints of the tile move to the first part with their corner. One part is enough, since
// the other parts at this corner are joined to it.

namespace {

/// Corner numbers of one part within its original tile.
using Part = std::vector<int>;

double diagonalsFrom(const Tile& tile, std::size_t corner) {
  double sum = 0;
  // The sum includes sides, which hardly changes the choice.
  for (const Vector3& vertex : tile.vertices) sum += (vertex - tile.vertices[corner]).norm();
  return sum;
}

std::vector<Part> partsOf(const Tile& tile) {
  std::vector<Part> parts;
  for (const auto& triangle : tileTriangles(tile))
    parts.emplace_back(triangle.begin(), triangle.end());
  return parts;
}

Tile cut(const Tile& tile, const Part& part) {
  Tile result;
  for (const int corner : part) result.vertices.push_back(tile.vertices[corner]);
  return result;
}

/// Splits tiles one by one.
class Splitter {
 public:
  explicit Splitter(const Model& model) : model_(model) {}

  // First the corners, then the tiles in both states, then the hinges between the parts.
  void split(int tile) {
    const std::vector<Part> parts = partsOf(model_.tiles[tile]);
    std::vector<int> numbers = {tile};
    for (std::size_t k = 1; k < parts.size(); ++k) {
      // The numbers that cutTiles() will assign to the parts after the first.
      numbers.push_back(static_cast<int>(model_.tiles.size()) + static_cast<int>(k) - 1);
    }
    // Before cutting, while corner numbers still refer to the whole tile.
    moveCorners(tile, parts, numbers);
    moveFolds(tile, parts, numbers);
    cutTiles(model_.tiles, tile, parts);
    if (model_.target) cutTiles(*model_.target, tile, parts);
    joinParts(parts, numbers);
    if (!model_.pulledTiles) return;
    std::vector<int>& pulled = *model_.pulledTiles;
    if (std::find(pulled.begin(), pulled.end(), tile) == pulled.end()) return;
    pulled.insert(pulled.end(), numbers.begin() + 1, numbers.end());
  }

  Model take() { return std::move(model_); }

 private:
  /// Adds hinges at both ends of each common side of two parts.
  void joinParts(const std::vector<Part>& parts, const std::vector<int>& numbers) {
    for (std::size_t b = 1; b < parts.size(); ++b) {
      for (std::size_t a = 0; a < b; ++a) {
        std::vector<Joint> hinge;
        for (int i = 0; i < 3; ++i) {
          const auto found = std::find(parts[b].begin(), parts[b].end(), parts[a][i]);
          if (found == parts[b].end()) continue;
          const int j = static_cast<int>(found - parts[b].begin());
          Joint& end = hinge.emplace_back(Joint{{numbers[a], i}, {numbers[b], j}});
          end.isWithinTile = true;
        }
        // Parts with only one common corner are connected through the parts between them.
        if (hinge.size() < 2) continue;
        model_.joints.insert(model_.joints.end(), hinge.begin(), hinge.end());
      }
    }
  }

  // Moves corners of joints, hull and repairs to the first part that has them.
  void moveCorners(int tile, const std::vector<Part>& parts, const std::vector<int>& numbers) {
    const auto move = [&](Corner& corner) {
      if (corner.tile != tile) return;
      for (std::size_t k = 0; k < parts.size(); ++k) {
        const auto found = std::find(parts[k].begin(), parts[k].end(), corner.vertex);
        if (found == parts[k].end()) continue;
        corner = {numbers[k], static_cast<int>(found - parts[k].begin())};
        return;
      }
    };
    for (Joint& joint : model_.joints) {
      move(joint.a);
      move(joint.b);
    }
    if (model_.hull) std::ranges::for_each(*model_.hull, move);
    for (Repair& repair : model_.repairs) std::ranges::for_each(repair.corners, move);
  }

  // Moves a fold to the part with its edge: two corners in common with the other tile.
  void moveFolds(int tile, const std::vector<Part>& parts, const std::vector<int>& numbers) {
    const std::vector<Tile>& tiles = model_.tiles;
    const auto moved = [&](int own, int other) {
      if (own != tile) return own;
      const auto isShared = [&](int corner) {
        return std::ranges::count(tiles[other].vertices, tiles[tile].vertices[corner]) > 0;
      };
      for (std::size_t k = 0; k < parts.size(); ++k) {
        if (std::ranges::count_if(parts[k], isShared) >= 2) return numbers[k];
      }
      return own;
    };
    std::map<std::pair<int, int>, double> folds;
    for (const auto& [pair, angle] : model_.foldAngles) {
      folds[{moved(pair.first, pair.second), moved(pair.second, pair.first)}] = angle;
    }
    model_.foldAngles = std::move(folds);
  }

  static void cutTiles(std::vector<Tile>& tiles, int tile, const std::vector<Part>& parts) {
    const Tile whole = tiles[tile];
    tiles[tile] = cut(whole, parts[0]);
    for (std::size_t k = 1; k < parts.size(); ++k) tiles.push_back(cut(whole, parts[k]));
  }

  Model model_;
};

}  // namespace

std::vector<std::array<int, 3>> tileTriangles(const Tile& tile) {
  if (!isConvexPolygon(tile.vertices, tileNormal(tile))) {
    return trianglesOf(tile.vertices, tileNormal(tile));
  }
  const int count = static_cast<int>(tile.vertices.size());
  int apex = 0;
  for (int k = 1; k < count; ++k) {
    // Rounding must not choose between equal corners.
    if (diagonalsFrom(tile, k) < (1 - 1e-9) * diagonalsFrom(tile, apex)) apex = k;
  }
  std::vector<std::array<int, 3>> triangles;
  for (int k = 1; k + 1 < count; ++k) {
    triangles.push_back({apex, (apex + k) % count, (apex + k + 1) % count});
  }
  return triangles;
}

Model splitTiles(const Model& model, const std::vector<int>& tiles) {
  const int first = model.fileOrder.countsFrom;
  const int end = first + static_cast<int>(model.tiles.size());
  std::vector<int> requested = tiles;
  if (requested.empty()) {
    requested.resize(model.tiles.size());
    std::iota(requested.begin(), requested.end(), first);
  }
  Splitter splitter(model);
  for (int& tile : requested) {
    if (tile < first || tile >= end) {
      throw InputError(
          fmt::format("error: there are tiles {}-{} to split, not {}; correct the number", first,
                      end - 1, tile));
    }
    tile -= first;
    if (model.tiles[tile].vertices.size() > 3) splitter.split(tile);
  }
  Model result = splitter.take();
  result.drawing.reset();  // its faces are not the parts
  result.tileNames.clear();
  // Parts have their own order.
  if (!result.fileOrder.isReversed.empty()) result.fileOrder.isReversed.resize(result.tiles.size());
  for (const int tile : requested) {
    if (result.fileOrder.isReversed.empty() || model.tiles[tile].vertices.size() == 3) continue;
    result.fileOrder.isReversed[tile] = false;
  }
  return result;
}

}  // namespace kirireel::model
