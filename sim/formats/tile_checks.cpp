// Checks that a polygon can become a brick: distinct vertices, an area, a plane, and sides that do
// not cross. Also checks that a target fits these tiles.
//
// Every threshold is a fraction of the tile's diameter (its largest distance between vertices) or
// of the model's size. A comment gives the most extreme value in real designs. Later checks rely on
// earlier ones. For example, a tile without area has no plane.
#include "sim/formats/tile_checks.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sim/base/words.h"
#include "sim/formats/repairs.h"
#include "sim/formats/text_table.h"
#include "sim/formats/written_digits.h"
#include "sim/model/convex_parts.h"
#include "sim/model/sheet_frame.h"

namespace kirireel::formats {
namespace {

// Vertices nearer than this fraction of a tile's diameter are one vertex written twice. Smallest
// distance in the available models: 4e-3 (mobius).
constexpr double kSameVertex = 1e-9;
// Minimum area as a fraction of the squared diameter. Smallest in real designs: 0.13 (stampfli24).
constexpr double kMinArea = 1e-6;
// Largest distance of a vertex from its tile's plane as a fraction of the diameter. It admits
// optimised designs. Largest in real designs: 1.4e-5 (sphere-to-saddle).
constexpr double kFlatness = 1e-2;
// A change of shape below this fraction of the model's size is rounding in the file. Largest among
// exact designs: 3e-7 (square2disk, written with 9 digits).
constexpr double kSameShape = 1e-6;
// A change of shape above this fraction of a tile means that the target is of another model.
// Largest in real designs: 7e-4 (sphere-to-saddle).
constexpr double kOtherShape = 0.2;

// All pairs: O(n^2) with at most 300 vertices.
double diameter(const model::Tile& tile) {
  double largest = 0;
  for (std::size_t b = 0; b < tile.vertices.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      largest = std::max(largest, (tile.vertices[a] - tile.vertices[b]).squaredNorm());
    }
  }
  return std::sqrt(largest);
}

/// Limits the cost of the later checks, which compare all pairs of a tile's vertices.
void checkVertexCount(const TileTable& table, int tile) {
  const std::size_t count = table.tiles[tile].vertices.size();
  if (count <= model::kMaxTileVertices) return;
  throw inputErrorAt(table.at(tile),
                     fmt::format("tile {} has {} vertices, at most {} are allowed; "
                                 "split it into convex tiles",
                                 table.countsFrom + tile, count, model::kMaxTileVertices));
}

/// Whether the outline goes to a hole and back along one line, at two vertices with equal
/// positions.
bool leadsToHole(const std::vector<Vector3>& vertices, int a, int b, double tolerance) {
  const int count = static_cast<int>(vertices.size());
  const auto isSame = [&](int first, int second) {
    const bool areTwo =
        first != second && (first != a || second != b) && (first != b || second != a);
    return areTwo && (vertices[first] - vertices[second]).norm() <= tolerance;
  };
  return isSame((a + count - 1) % count, (b + 1) % count) ||
         isSame((a + 1) % count, (b + count - 1) % count);
}

void checkDistinctVertices(const TileTable& table, int tile) {
  const auto repeated = repeatedVertices(table.tiles[tile]);
  if (!repeated) return;
  const auto [a, b] = *repeated;
  const std::vector<Vector3>& vertices = table.tiles[tile].vertices;
  // Drawing programs open a polygon with a hole along a line. Each end of the line then has two
  // vertices.
  if (leadsToHole(vertices, a, b, kSameVertex * diameter(table.tiles[tile]))) {
    throw inputErrorAt(
        table.at(tile, b),
        fmt::format("tile {} has a hole, connected to its outline at vertices {} and {}. Tiles "
                    "cannot have holes. Divide it into tiles without holes and join them",
                    table.countsFrom + tile, table.countsFrom + a, table.countsFrom + b));
  }
  throw inputErrorAt(
      table.at(tile, b),
      fmt::format(
          "vertex {} of tile {} is at the position of its vertex {}. Correct it or delete it",
          table.countsFrom + b, table.countsFrom + tile, table.countsFrom + a));
}

void checkArea(const TileTable& table, int tile) {
  if (hasArea(table.tiles[tile])) return;
  throw inputErrorAt(
      table.at(tile),
      fmt::format(
          "tile {} has no area. List its vertices in order around the tile, not all on one line",
          table.countsFrom + tile));
}

// Relative to the plane of Newell's normal through the mean of the vertices.
void checkFlatness(const TileTable& table, int tile) {
  const std::vector<Vector3>& vertices = table.tiles[tile].vertices;
  const Vector3 normal = model::tileNormal(table.tiles[tile]);
  // The plane goes through the mean of the vertices. One bad vertex then has little effect on the
  // others.
  Vector3 middle = Vector3::Zero();
  for (const Vector3& vertex : vertices) middle += vertex / static_cast<double>(vertices.size());
  const double allowed = kFlatness * diameter(table.tiles[tile]);
  for (size_t k = 0; k < vertices.size(); ++k) {
    const double height = std::abs((vertices[k] - middle).dot(normal));
    if (height <= allowed) continue;
    throw inputErrorAt(table.at(tile, static_cast<int>(k)),
                       fmt::format("vertex {} of tile {} is {:.3g} off the tile's plane, at most "
                                   "{:.3g} is allowed; flatten the tile or split it into triangles",
                                   table.countsFrom + k, table.countsFrom + tile, height, allowed));
  }
}

/// Fast sufficient test: all corners turn left and the outline turns once. True for most tiles.
bool isSurelySimple(const std::vector<Vector3>& vertices, const Vector3& normal) {
  double turned = 0;
  const std::size_t count = vertices.size();
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3 before = vertices[k] - vertices[(k + count - 1) % count];
    const Vector3 after = vertices[(k + 1) % count] - vertices[k];
    const double area = before.cross(after).dot(normal);
    if (area <= 0) return false;
    // The exterior angles of a simple polygon add up to 2 pi. A star with two turns has 4 pi. The
    // limit lies between them.
    turned += std::atan2(area, before.dot(after));
  }
  return turned < 3 * std::numbers::pi;
}

/// The point of the segment a-b nearest to the line through c and d.
Vector3 meetingPoint(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d) {
  const Vector3 along = (d - c).normalized();
  const Vector3 side = b - a, towards = a - c;
  const Vector3 across = side - along.dot(side) * along;
  const Vector3 apart = towards - along.dot(towards) * along;
  const double square = across.squaredNorm();
  const double share = square > 0 ? std::clamp(-apart.dot(across) / square, 0.0, 1.0) : 0.5;
  return a + share * side;
}

/// Sides may only meet at common corners. The tile then has one connected interior.
void checkSimple(const TileTable& table, int tile) {
  const std::vector<Vector3>& vertices = table.tiles[tile].vertices;
  const auto crossing = crossingSides(table.tiles[tile]);
  if (!crossing) return;
  const auto [first, second] = *crossing;
  const auto side = [&](int k) {
    const int next = (k + 1) % static_cast<int>(vertices.size());
    return fmt::format("from vertex {} to {}", table.countsFrom + k, table.countsFrom + next);
  };
  const InputError error = inputErrorAt(
      table.at(tile, second),
      fmt::format("tile {} crosses or touches itself: its side {} meets the side {}. List its "
                  "vertices in order around the tile, and list separate pieces as separate tiles",
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
    const size_t expected = start.tiles[i].vertices.size();
    const size_t found = target.tiles[i].vertices.size();
    if (found == expected) continue;
    throw inputErrorAt(
        target.at(tile),
        fmt::format("target tile {} has {} vertices, the tile at {} has {}; write "
                    "the same tiles with the same vertices in the same order",
                    start.countsFrom + tile, found, start.shortName(tile), expected));
  }
  if (target.tiles.size() == start.tiles.size()) return;
  throw inputErrorAt(
      {target.file},
      fmt::format("the target has {}, {} has {}; write one target tile for each tile, in the same "
                  "order",
                  counted(target.tiles.size(), "tile"), start.file.filename().string(),
                  start.tiles.size()));
}

/// The largest change of a tile's edges and diagonals from start to target.
struct ShapeChange {
  int tile = 0;
  int vertexA = 0;
  int vertexB = 0;
  double startDistance = 0;
  double targetDistance = 0;

  double size() const { return std::abs(targetDistance - startDistance); }
};

// Over all pairs of vertices, since a rigid tile keeps all their distances.
ShapeChange shapeChange(const model::Tile& start, const model::Tile& target, int tile) {
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

// Compares all pairs: two coinciding vertices need not be consecutive.
std::optional<std::pair<int, int>> repeatedVertices(const model::Tile& tile) {
  const std::vector<Vector3>& vertices = tile.vertices;
  const double tolerance = kSameVertex * diameter(tile);
  for (std::size_t b = 0; b < vertices.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      if ((vertices[a] - vertices[b]).norm() > tolerance) continue;
      return std::pair(static_cast<int>(a), static_cast<int>(b));
    }
  }
  return std::nullopt;
}

// Relative to the square of the diameter. This rejects needles of any size.
bool hasArea(const model::Tile& tile) {
  const double extent = diameter(tile);
  return model::tileArea(tile) > kMinArea * extent * extent;
}

std::optional<std::pair<int, int>> crossingSides(const model::Tile& tile) {
  const Vector3 normal = model::tileNormal(tile);
  // This test is O(n), the comparison of all sides O(n^2).
  if (isSurelySimple(tile.vertices, normal)) return std::nullopt;
  return model::crossingSides(tile.vertices, normal, kSameVertex * diameter(tile));
}

std::string TileTable::shortName(int tile) const {
  return kirireel::toString({file.filename(), sources[tile].line});
}

void checkTiles(const TileTable& table) {
  for (size_t i = 0; i < table.tiles.size(); ++i) {
    const int tile = static_cast<int>(i);
    checkVertexCount(table, tile);
    checkDistinctVertices(table, tile);
    checkArea(table, tile);
    checkFlatness(table, tile);
    checkSimple(table, tile);
  }
}

void checkTargets(const std::vector<TileTable>& targets, const model::Model& start,
                  const TileTable& table, std::vector<std::string>& warnings) {
  const double allowed = kOtherShape * model::tileSize(start);
  const double rounding = kSameShape * model::modelSize(start);
  ShapeChange worst;
  FileLocation worstPlace;
  int changed = 0, changedTargets = 0;
  for (const TileTable& target : targets) {
    checkSameCounts(target, table);
    const int before = changed;
    for (size_t i = 0; i < start.tiles.size(); ++i) {
      const int tile = static_cast<int>(i);
      const ShapeChange change = shapeChange(start.tiles[i], target.tiles[i], tile);
      if (change.size() > allowed) {
        throw inputErrorAt(
            target.at(tile, change.vertexB),
            fmt::format(
                "vertices {} and {} of target tile {} are {:.4g} apart, but at {} {:.4g}. The "
                "target must have the same rigid tiles. Correct it, or use this model's target",
                table.countsFrom + change.vertexA, table.countsFrom + change.vertexB,
                table.countsFrom + tile, change.targetDistance, table.shortName(tile),
                change.startDistance));
      }
      changed += change.size() > rounding ? 1 : 0;
      if (change.size() <= worst.size()) continue;
      worst = change;
      worstPlace = target.at(change.tile);
    }
    changedTargets += changed > before ? 1 : 0;
  }
  if (changed == 0) return;
  warnings.push_back(fmt::format(
      "{}: warning: {}{}. Here a length differs most, by {:.2g}. Rigid tiles can only come near {}",
      toString(worstPlace),
      counted(changed, "target tile has a slightly different shape",
              "target tiles have slightly different shapes"),
      targets.size() > 1 ? fmt::format(" in {} of {} targets", changedTargets, targets.size()) : "",
      worst.size(), targets.size() > 1 ? "these targets" : "this target"));
}

void notePadding(const TileTable& table, model::Model& model, std::vector<std::string>& warnings) {
  if (table.padded.empty()) return;
  model::Repair repair;
  repair.place = toString(table.at(table.padded.front()));
  repair.found = fmt::format("in {} of {} tiles a vertex is listed again, or NaN in place of one",
                             table.padded.size(), table.tiles.size());
  repair.done = "removed as padding";
  repair.advice = "list each vertex of a tile once";
  for (const int tile : table.padded) repair.corners.push_back({tile, 0});
  noteRepair(std::move(repair), model, warnings);
}

// Only the start decides: a tile has the same vertex order in every state.
void turnClockwiseTiles(const TileTable& table, model::Model& model,
                        std::vector<std::string>& warnings) {
  const double flat = model::flatTolerance(model::modelSize(model), roundingOf(model.tiles));
  const std::optional<model::SheetFrame> frame = model::sheetFrame(model.tiles, flat);
  if (!frame) return;
  std::vector<bool> clockwise(model.tiles.size());
  std::transform(
      model.tiles.begin(), model.tiles.end(), clockwise.begin(),
      [&](const model::Tile& tile) { return model::tileNormal(tile).dot(frame->normal) < 0; });
  const auto count = std::count(clockwise.begin(), clockwise.end(), true);
  if (count == 0) return;
  // In a spatial sheet the orientation of tiles decides which side is the top face. Reversing all
  // tiles would swap the top and bottom joints.
  const bool isFolded = model.target && !model::isParallel(*frame, *model.target, flat);
  if (isFolded && count == std::ssize(model.tiles)) {
    warnings.push_back(
        fmt::format("{}: warning: all tiles run clockwise seen from above, so bricks extend "
                    "downwards. List their vertices anticlockwise to extend bricks upwards",
                    table.file.string()));
    return;
  }
  const int first =
      static_cast<int>(std::find(clockwise.begin(), clockwise.end(), true) - clockwise.begin());
  model::Repair repair;
  repair.place = toString(table.at(first));
  repair.found = fmt::format("{} of {} tiles run{} clockwise seen from {}", count,
                             model.tiles.size(), count == 1 ? "s" : "",
                             frame->isHorizontal() ? "above" : "the side of most tiles");
  repair.done = "reversed, and written in the file's own order";
  repair.advice = "list their vertices anticlockwise";
  for (int tile = 0; tile < std::ssize(clockwise); ++tile) {
    if (clockwise[tile]) repair.corners.push_back({tile, 0});
  }
  noteRepair(std::move(repair), model, warnings);
  // Reversing the vertices is its own inverse.
  const int countsFrom = model.fileOrder.countsFrom;
  model.fileOrder.isReversed = clockwise;
  model = model::inFileOrder(std::move(model));
  model.fileOrder = {countsFrom, std::move(clockwise)};
}

}  // namespace kirireel::formats
