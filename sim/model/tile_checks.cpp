// What a polygon needs to become a brick: vertices that differ, an area, a plane, sides that do not
// cross; and what a target needs to be a target of these tiles.
//
// Every threshold is a part of the tile's diameter (its largest distance between vertices) or of
// the model's size, and the largest or smallest value that real designs have stands beside it. The
// checks run from the cheap and basic to those that build on them: the plane of a tile without
// area, for one, is not defined.
#include "sim/model/tile_checks.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "sim/model/convex_parts.h"

namespace kirireel {
namespace {

// Vertices nearer than this part of a tile's diameter are one vertex typed twice.
// Smallest met in the models at hand: 4e-3 (mobius).
constexpr double kSameVertex = 1e-9;
// Least area as a part of the squared diameter. Smallest met: 0.13 (stampfli24).
constexpr double kLeastArea = 1e-6;
// Largest distance of a vertex from its tile's plane as a part of the diameter, so that optimised
// designs pass. Largest met: 1.4e-5 (sphere-to-saddle).
constexpr double kFlatness = 1e-2;
// A change of shape below this part of the model's size is rounding of the file. Largest met among
// exact designs: 3e-7 (square2disk, written with 9 digits).
constexpr double kSameShape = 1e-6;
// A change of shape above this part of a tile is another model's target. Largest met: 7e-4
// (sphere-to-saddle).
constexpr double kOtherShape = 0.2;

// All pairs: O(n^2) with at most 300 vertices.
double diameter(const Tile& tile) {
  double largest = 0;
  for (std::size_t b = 0; b < tile.vertices.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      largest = std::max(largest, (tile.vertices[a] - tile.vertices[b]).squaredNorm());
    }
  }
  return std::sqrt(largest);
}

/// What follows compares all pairs of a tile's vertices.
void checkVertexCount(const TileTable& table, int tile) {
  const std::size_t count = table.tiles[tile].vertices.size();
  if (count <= kMostTileVertices) return;
  throw inputErrorAt(table.at(tile),
                     fmt::format("tile {} has {} vertices, at most {} are allowed; "
                                 "split it into convex tiles",
                                 table.countsFrom + tile, count, kMostTileVertices));
}

/// Whether a tile's outline goes to a hole and back along one line at two vertices in one place.
bool leadsToHole(const std::vector<Vector3>& vertices, std::size_t a, std::size_t b,
                 double tolerance) {
  const std::size_t count = vertices.size();
  const auto isSame = [&](std::size_t first, std::size_t second) {
    const bool areTwo =
        first != second && (first != a || second != b) && (first != b || second != a);
    return areTwo && (vertices[first] - vertices[second]).norm() <= tolerance;
  };
  return isSame((a + count - 1) % count, (b + 1) % count) ||
         isSame((a + 1) % count, (b + count - 1) % count);
}

// All pairs: two vertices at one place need not follow each other.
void checkDistinctVertices(const TileTable& table, int tile, double extent) {
  const std::vector<Vector3>& vertices = table.tiles[tile].vertices;
  const double tolerance = kSameVertex * extent;
  for (size_t b = 0; b < vertices.size(); ++b) {
    for (size_t a = 0; a < b; ++a) {
      if ((vertices[a] - vertices[b]).norm() > tolerance) continue;
      // Drawing programs cut a polygon with a hole open along a line, which gives two vertices at
      // each end of it.
      if (leadsToHole(vertices, a, b, tolerance)) {
        throw inputErrorAt(
            table.at(tile, static_cast<int>(b)),
            fmt::format(
                "tile {} has a hole, to which its outline leads and back at its vertices {} "
                "and {}; tiles have none: divide it into tiles without holes, joined to "
                "each other",
                table.countsFrom + tile, table.countsFrom + a, table.countsFrom + b));
      }
      throw inputErrorAt(
          table.at(tile, static_cast<int>(b)),
          fmt::format("vertex {} of tile {} is where its vertex {} is; a tile's "
                      "vertices are all different: correct it or delete it",
                      table.countsFrom + b, table.countsFrom + tile, table.countsFrom + a));
    }
  }
}

// Against the square of the diameter, so that needles are refused whatever their size.
void checkArea(const TileTable& table, int tile, double extent) {
  if (tileArea(table.tiles[tile]) > kLeastArea * extent * extent) return;
  throw inputErrorAt(table.at(tile),
                     fmt::format("tile {} has no area; its vertices must enclose some: list them "
                                 "in order round the tile, not all on one line",
                                 table.countsFrom + tile));
}

// Against the plane of Newell's normal through the mean of the vertices.
void checkFlatness(const TileTable& table, int tile, double extent) {
  const std::vector<Vector3>& vertices = table.tiles[tile].vertices;
  const Vector3 normal = tileNormal(table.tiles[tile]);
  // The plane goes through the mean of the vertices, so that one bad vertex does not put all others
  // off.
  Vector3 middle = Vector3::Zero();
  for (const Vector3& vertex : vertices) middle += vertex / static_cast<double>(vertices.size());
  const double allowed = kFlatness * extent;
  for (size_t k = 0; k < vertices.size(); ++k) {
    const double height = std::abs((vertices[k] - middle).dot(normal));
    if (height <= allowed) continue;
    throw inputErrorAt(table.at(tile, static_cast<int>(k)),
                       fmt::format("vertex {} of tile {} is {:.3g} m off the tile's plane, at most "
                                   "{:.3g} is allowed; flatten the tile or split it into triangles",
                                   table.countsFrom + k, table.countsFrom + tile, height, allowed));
  }
}

/// Whether all corners turn left and the whole turns once: what most tiles do, and quick to see.
bool isSurelySimple(const std::vector<Vector3>& vertices, const Vector3& normal) {
  double turned = 0;
  const std::size_t count = vertices.size();
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3 before = vertices[k] - vertices[(k + count - 1) % count];
    const Vector3 after = vertices[(k + 1) % count] - vertices[k];
    const double area = before.cross(after).dot(normal);
    if (area <= 0) return false;
    // The exterior angles of a simple polygon add up to 2 pi; a star that winds twice gives 4 pi.
    // Between them lies the limit.
    turned += std::atan2(area, before.dot(after));
  }
  return turned < 3 * std::numbers::pi;
}

/// The point of the stretch a-b that is nearest to the line through c and d.
Vector3 meetingPoint(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d) {
  const Vector3 along = (d - c).normalized();
  const Vector3 side = b - a, towards = a - c;
  const Vector3 across = side - along.dot(side) * along;
  const Vector3 apart = towards - along.dot(towards) * along;
  const double square = across.squaredNorm();
  const double share = square > 0 ? std::clamp(-apart.dot(across) / square, 0.0, 1.0) : 0.5;
  return a + share * side;
}

/// Sides meet nowhere but at their common corner, so that the tile has one inside in one piece.
void checkSimple(const TileTable& table, int tile, double extent) {
  const std::vector<Vector3>& vertices = table.tiles[tile].vertices;
  const Vector3 normal = tileNormal(table.tiles[tile]);
  // This takes O(n), the comparison of all sides O(n^2).
  if (isSurelySimple(vertices, normal)) return;
  const auto crossing = crossingSides(vertices, normal, kSameVertex * extent);
  if (!crossing) return;
  const auto [first, second] = *crossing;
  const auto side = [&](int k) {
    const int next = (k + 1) % static_cast<int>(vertices.size());
    return fmt::format("from vertex {} to {}", table.countsFrom + k, table.countsFrom + next);
  };
  const InputError error = inputErrorAt(
      table.at(tile, second),
      fmt::format("tile {} crosses or touches itself: its side {} meets the one {}; list its "
                  "vertices in order round the tile, and a tile in two pieces as two",
                  table.countsFrom + tile, side(second), side(first)));
  const std::size_t count = vertices.size();
  throw CrossedTile(error, table.tiles[tile],
                    meetingPoint(vertices[first], vertices[(first + 1) % count], vertices[second],
                                 vertices[(second + 1) % count]));
}

void checkSameCounts(const TileTable& target, const TileTable& start) {
  const size_t common = std::min(target.tiles.size(), start.tiles.size());
  for (size_t i = 0; i < common; ++i) {
    const int tile = static_cast<int>(i);
    const size_t wanted = start.tiles[i].vertices.size();
    const size_t found = target.tiles[i].vertices.size();
    if (found == wanted) continue;
    throw inputErrorAt(target.at(tile),
                       fmt::format("target tile {} has {} vertices, the tile at {} has {}; write "
                                   "the same tiles with the same vertices in the same order",
                                   tile, found, start.shortName(tile), wanted));
  }
  if (target.tiles.size() == start.tiles.size()) return;
  throw inputErrorAt(
      {target.file},
      fmt::format("the target has {} tiles, {} has {}; write one target tile for "
                  "each tile, in the same order",
                  target.tiles.size(), start.file.filename().string(), start.tiles.size()));
}

/// How much a tile's edges and diagonals change from start to target, the worst of them.
struct ShapeChange {
  int tile = 0;
  int vertexA = 0;
  int vertexB = 0;
  double startDistance = 0;
  double targetDistance = 0;

  double size() const { return std::abs(targetDistance - startDistance); }
};

// Over all pairs of vertices: a rigid tile keeps all their distances.
ShapeChange shapeChange(const Tile& start, const Tile& target, int tile) {
  ShapeChange worst;
  worst.tile = tile;
  for (size_t b = 0; b < start.vertices.size(); ++b) {
    for (size_t a = 0; a < b; ++a) {
      const double before = (start.vertices[a] - start.vertices[b]).norm();
      const double after = (target.vertices[a] - target.vertices[b]).norm();
      if (std::abs(after - before) <= worst.size()) continue;
      worst = {tile, static_cast<int>(a), static_cast<int>(b), before, after};
    }
  }
  return worst;
}

}  // namespace

std::string TileTable::shortName(int tile) const {
  return toString({file.filename(), sources[tile].line});
}

void checkTiles(const TileTable& table) {
  for (size_t i = 0; i < table.tiles.size(); ++i) {
    const int tile = static_cast<int>(i);
    checkVertexCount(table, tile);
    const double extent = diameter(table.tiles[i]);
    checkDistinctVertices(table, tile, extent);
    checkArea(table, tile, extent);
    checkFlatness(table, tile, extent);
    checkSimple(table, tile, extent);
  }
}

void checkTarget(const TileTable& target, const Model& start, const TileTable& table,
                 std::vector<std::string>& warnings) {
  checkSameCounts(target, table);
  const double allowed = kOtherShape * tileSize(start);
  const double rounding = kSameShape * modelSize(start);
  ShapeChange worst;
  int changed = 0;
  for (size_t i = 0; i < start.tiles.size(); ++i) {
    const int tile = static_cast<int>(i);
    const ShapeChange change = shapeChange(start.tiles[i], target.tiles[i], tile);
    if (change.size() > allowed) {
      throw inputErrorAt(target.at(tile, change.vertexB),
                         fmt::format("vertices {} and {} of target tile {} are {:.4g} m apart, at "
                                     "{} {:.4g}; a target is the same rigid tiles moved: correct "
                                     "it or give this model's own",
                                     change.vertexA, change.vertexB, tile, change.targetDistance,
                                     table.shortName(tile), change.startDistance));
    }
    changed += change.size() > rounding ? 1 : 0;
    if (change.size() > worst.size()) worst = change;
  }
  if (changed == 0) return;
  warnings.push_back(
      fmt::format("{}: warning: {} target tiles are not quite their tiles' shape, "
                  "this one least: a length differs by {:.2g} m; rigid tiles can "
                  "only come near such a target",
                  toString(target.at(worst.tile)), changed, worst.size()));
}

}  // namespace kirireel
