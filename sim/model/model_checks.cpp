// Checks that a polygon can become a brick: distinct vertices, an area, a plane, and sides that do
// not cross. Also checks that a target fits these tiles.
//
// Every threshold is a fraction of the tile's diameter (its largest distance between
// vertices) or of the model's size. A comment gives the most extreme value in real
// designs. Later checks rely on earlier ones. For example, a tile without area has no
// plane.
#include "sim/model/model_checks.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <set>
#include <tuple>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>

#include "sim/base/disjoint_sets.h"
#include "sim/base/error.h"
#include "sim/model/convex_parts.h"
#include "sim/model/sheet_frame.h"
#include "sim/model/text_table.h"

namespace kirireel::model {
namespace {

// Vertices nearer than this fraction of a tile's diameter are one vertex written twice. Smallest
// distance in the available models: 4e-3 (mobius).
constexpr double kSameVertex = 1e-9;
// Minimum area as a fraction of the squared diameter. Smallest in real designs: 0.13 (stampfli24).
constexpr double kLeastArea = 1e-6;
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
double diameter(const Tile& tile) {
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
  if (count <= kMostTileVertices) return;
  throw inputErrorAt(table.at(tile),
                     fmt::format("tile {} has {} vertices, at most {} are allowed; "
                                 "split it into convex tiles",
                                 table.countsFrom + tile, count, kMostTileVertices));
}

/// Whether the outline goes to a hole and back along one line, at two vertices with equal
/// positions.
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

// Compares all pairs: two coinciding vertices need not be consecutive.
void checkDistinctVertices(const TileTable& table, int tile, double extent) {
  const std::vector<Vector3>& vertices = table.tiles[tile].vertices;
  const double tolerance = kSameVertex * extent;
  for (size_t b = 0; b < vertices.size(); ++b) {
    for (size_t a = 0; a < b; ++a) {
      if ((vertices[a] - vertices[b]).norm() > tolerance) continue;
      // Drawing programs open a polygon with a hole along a line. Each end of the line then has two
      // vertices.
      if (leadsToHole(vertices, a, b, tolerance)) {
        throw inputErrorAt(
            table.at(tile, static_cast<int>(b)),
            fmt::format("tile {} has a hole, connected to its outline at vertices {} and {}. Tiles "
                        "cannot have holes. Divide it into tiles without holes and join them",
                        table.countsFrom + tile, table.countsFrom + a, table.countsFrom + b));
      }
      throw inputErrorAt(
          table.at(tile, static_cast<int>(b)),
          fmt::format(
              "vertex {} of tile {} is at the position of its vertex {}. Correct it or delete it",
              table.countsFrom + b, table.countsFrom + tile, table.countsFrom + a));
    }
  }
}

// Relative to the square of the diameter. This rejects needles of any size.
void checkArea(const TileTable& table, int tile, double extent) {
  if (tileArea(table.tiles[tile]) > kLeastArea * extent * extent) return;
  throw inputErrorAt(
      table.at(tile),
      fmt::format(
          "tile {} has no area. List its vertices in order around the tile, not all on one line",
          table.countsFrom + tile));
}

// Relative to the plane of Newell's normal through the mean of the vertices.
void checkFlatness(const TileTable& table, int tile, double extent) {
  const std::vector<Vector3>& vertices = table.tiles[tile].vertices;
  const Vector3 normal = tileNormal(table.tiles[tile]);
  // The plane goes through the mean of the vertices. One bad vertex then has little effect on the
  // others.
  Vector3 middle = Vector3::Zero();
  for (const Vector3& vertex : vertices) middle += vertex / static_cast<double>(vertices.size());
  const double allowed = kFlatness * extent;
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
    // The exterior angles of a simple polygon add up to 2 pi, those of a star with two turns to 4
    // pi. The limit lies between them.
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
void checkSimple(const TileTable& table, int tile, double extent) {
  const std::vector<Vector3>& vertices = table.tiles[tile].vertices;
  const Vector3 normal = tileNormal(table.tiles[tile]);
  // This test is O(n), the comparison of all sides O(n^2).
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
      fmt::format("the target has {} tiles, {} has {}; write one target tile for "
                  "each tile, in the same order",
                  target.tiles.size(), start.file.filename().string(), start.tiles.size()));
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
  return kirireel::toString({file.filename(), sources[tile].line});
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
    if (change.size() > worst.size()) worst = change;
  }
  if (changed == 0) return;
  warnings.push_back(
      fmt::format("{}: warning: {} target tiles have slightly different shapes. Here a length "
                  "differs most, by {:.2g}. Rigid tiles can only come near this target",
                  toString(target.at(worst.tile)), changed, worst.size()));
}

// ------------------------------------------------------------------------------------------------
// The number of written digits, as explained in the header.
//
// std::to_chars gives the shortest decimal digits that read back as the same double (for such an
// algorithm see F. Loitsch, Printing floating-point numbers quickly and accurately with integers,
// PLDI 2010). A coordinate written as 0.866 becomes 866e-3 again: 3 digits, the last at 10^-3.
// Trailing zeros hide the last place of some numbers. The finest last place of all coordinates is
// therefore the decimal place of the file's rounding.

namespace {

// A number with this many significant digits was not rounded for writing: doubles have 15 to 17.
constexpr int kAllDigits = 15;
// Two roundings of one point differ by at most one unit along each axis: sqrt(3), plus a margin for
// the precision of doubles.
constexpr double kAcrossDigits = 1.75;
// Corners further apart than this fraction of an edge are different, even if digits are coarse.
constexpr double kVisible = 0.05;
// Finer places, metres, need no check for multiples of a coarser step.
constexpr double kFine = 1e-9;
// Digits coarser than this fraction of an edge would distort tiles beyond use. Such numbers are
// exact.
constexpr double kCoarse = 0.01;
// Numbers are exact if all are multiples of several last places, with at most this many such steps.
// Otherwise a common step is chance: 0.866 and 0.5 are even, 0.866025 is a multiple of 0.000025.
constexpr std::int64_t kTypedStep = 5;
constexpr std::int64_t kTypedSteps = 10'000;

/// A number's shortest text in scientific notation.
struct Digits {
  int count = 0;     ///< significant digits
  int exponent = 0;  ///< of the first digit
  int last() const { return exponent - count + 1; }
};

/// Empty for 0, which does not change by rounding.
Digits digitsOf(double value) {
  Digits digits;
  if (value == 0) return digits;
  char buffer[40];
  const char* const text = buffer;
  const char* const end =
      std::to_chars(buffer, buffer + sizeof buffer, std::abs(value), std::chars_format::scientific)
          .ptr;
  const char* const power = std::find(text, end, 'e');
  digits.count = static_cast<int>(power - text - std::count(text, power, '.'));
  const char* const sign = power + 1;
  std::from_chars(*sign == '+' ? sign + 1 : sign, end, digits.exponent);
  return digits;
}

template <typename Visit>
void forEachCoordinate(const std::vector<Tile>& tiles, const Visit& visit) {
  for (const Tile& tile : tiles) {
    for (const Vector3& vertex : tile.vertices) {
      for (const double value : vertex) visit(value);
    }
  }
}

/// Whether most numbers below the largest decade have as many significant digits as those in it.
/// With fixed decimals they would have fewer.
bool countsSignificant(const std::vector<Digits>& all, int most, int highest) {
  int lower = 0, full = 0;
  for (const Digits& digits : all) {
    if (digits.exponent >= highest) continue;
    ++lower;
    full += digits.count == most ? 1 : 0;
  }
  // Fewer numbers could agree by chance.
  constexpr int kEnough = 8;
  return lower >= kEnough && 2 * full > lower;
}

Model modelOf(const std::vector<Tile>& tiles) {
  Model model;
  model.tiles = tiles;
  return model;
}

}  // namespace

// A power of ten, or 0.
double lastPlace(const std::vector<Tile>& tiles) {
  std::vector<Digits> all;
  int most = 0, finest = 0, highest = 0;
  for (const Tile& tile : tiles) {
    for (const Vector3& vertex : tile.vertices) {
      for (const double value : vertex) {
        const Digits digits = digitsOf(value);
        if (digits.count == 0) continue;
        // One number with all its digits shows that the file was not rounded.
        if (digits.count >= kAllDigits) return 0;
        finest = all.empty() ? digits.last() : std::min(finest, digits.last());
        highest = all.empty() ? digits.exponent : std::max(highest, digits.exponent);
        most = std::max(most, digits.count);
        all.push_back(digits);
      }
    }
  }
  if (all.empty()) return 0;
  // With a fixed number of significant digits, the largest numbers have the coarsest last place. It
  // bounds the error of all numbers.
  const int place = countsSignificant(all, most, highest) ? highest + 1 - most : finest;
  return std::pow(10.0, place);
}

double roundingOf(const std::vector<Tile>& tiles) {
  return roundingOf(tiles, lastPlace(tiles));
}

// Decides whether this last place comes from rounding. 0 if the numbers are exact.
double roundingOf(const std::vector<Tile>& tiles, double place) {
  if (place == 0 || place > kCoarse * tileSize(modelOf(tiles))) return 0;
  if (place < kFine) return place;
  std::int64_t step = 0, largest = 0;
  forEachCoordinate(tiles, [&](double value) {
    const auto places = static_cast<std::int64_t>(std::llround(value / place));
    step = std::gcd(step, places);
    largest = std::max(largest, std::abs(places));
  });
  return step >= kTypedStep && largest <= kTypedSteps * step ? 0 : place;
}

double samePlaceTolerance(const std::vector<Tile>& tiles) {
  const Model model = modelOf(tiles);
  const double byDigits = std::min(kAcrossDigits * lastPlace(tiles), kVisible * tileSize(model));
  return std::max(byDigits, kSamePlace * modelSize(model));
}

// ------------------------------------------------------------------------------------------------
// Repairs of unusual but unambiguous input.
//
// A repair requires that no other reading of the file makes sense. The program reports its
// place, and `--strict` refuses it. A repair is a `Repair` of the model and one line among the
// warnings.

namespace {

// A sheet is flat if its vertices deviate from a plane by less than this fraction of its size.
constexpr double kLevelStart = 1e-9;

/// "1 joint is", "3 joints are".
std::string countOf(std::size_t count, const char* what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? " is" : "s are");
}

/// Maximum distance of vertices of a flat sheet from its plane, metres.
double flatToleranceAsRead(const std::vector<Tile>& tiles, double size) {
  // Rounded numbers may differ by their last digit. The factor allows for the precision of doubles.
  return std::max(kLevelStart * size, 1.01 * roundingOf(tiles));
}

}  // namespace

std::string toString(const Repair& repair) {
  return fmt::format("{}: repaired: {}; {}", repair.place, repair.found, repair.done);
}

void noteRepair(Repair repair, Model& model, std::vector<std::string>& warnings) {
  warnings.push_back(toString(repair));
  model.repairs.push_back(std::move(repair));
}

void notePadding(const TileTable& table, Model& model, std::vector<std::string>& warnings) {
  if (table.padded.empty()) return;
  Repair repair;
  repair.place = toString(table.at(table.padded.front()));
  repair.found = fmt::format("{} of {} tiles list a vertex again, or NaN in place of one",
                             table.padded.size(), table.tiles.size());
  repair.done = "removed as padding";
  repair.advice = "list each vertex of a tile once";
  for (const int tile : table.padded) repair.corners.push_back({tile, 0});
  noteRepair(std::move(repair), model, warnings);
}

void refuseRepairs(const Model& model) {
  if (model.repairs.empty()) return;
  const Repair& repair = model.repairs.front();
  throw InputError(fmt::format("{}: error: {}; {}, or remove `strict` to have it repaired",
                               repair.place, repair.found, repair.advice));
}

void noteNoJoints(const std::filesystem::path& file, Model& model,
                  std::vector<std::string>& warnings) {
  noteRepair({file.string(),
              "the file is empty",
              "the tiles are read as loose",
              "write the line \"# no joints\" if the tiles are loose",
              {}},
             model, warnings);
}

RoundedCorners::RoundedCorners(const Model& model)
    : lastPlace_(lastPlace(model.tiles)), least_(0.5 * lastPlace_) {}

// Reports only the first place and counts the others.
void RoundedCorners::add(const Joint& joint, double gap, const std::string& place) {
  // Gaps below half a last digit do not come from rounding in the file.
  if (lastPlace_ == 0 || gap < least_) return;
  if (repair_.corners.empty()) repair_.place = place;
  repair_.corners.push_back(joint.a);
  largest_ = std::max(largest_, gap);
}

void RoundedCorners::note(Model& model, std::vector<std::string>& warnings) {
  if (repair_.corners.empty()) return;
  const std::size_t count = repair_.corners.size();
  repair_.found =
      fmt::format("the corners of {} joint{} are {}{:.2g} apart, by rounding to {:g}", count,
                  count == 1 ? "" : "s", count == 1 ? "" : "up to ", largest_, lastPlace_);
  repair_.done = count == 1 ? "joined at one corner" : "joined at one corner each";
  repair_.advice = "write the same numbers for both corners";
  noteRepair(std::move(repair_), model, warnings);
}

void dropRepeatedJoints(JointTable& table, Model& model, std::vector<std::string>& warnings) {
  using CornerNumbers = std::pair<int, int>;
  // Line of the first row that holds these two corners on this face (1 or 2).
  std::map<std::tuple<CornerNumbers, CornerNumbers, int>, int> firstLine;
  std::vector<JointRow> kept;
  Repair repair;
  int firstRepeated = 0;
  for (JointRow& row : table.rows) {
    CornerNumbers a{row.values[0], row.values[1]};
    CornerNumbers b{row.values[2], row.values[3]};
    // The order of the two ends has no effect.
    if (b < a) std::swap(a, b);
    const bool hasFaces = row.kind == JointKind::Pivot && row.values[4] >= 1 && row.values[4] <= 3;
    int newFaces = 0, line = 0;
    // Faces are bits: 1 bottom, 2 top, 3 both. Rows "bottom" and "top" at one corner therefore add
    // up to "both", and a later "both" repeats them.
    for (const int face : {1, 2}) {
      if (!hasFaces || (row.values[4] & face) == 0) continue;
      const auto [entry, isNew] = firstLine.try_emplace({a, b, face}, row.line);
      if (isNew) newFaces |= face;
      if (!isNew && line == 0) line = entry->second;
    }
    const bool repeats = hasFaces && newFaces != row.values[4];
    if (repeats && repair.place.empty()) {
      repair.place = kirireel::toString({table.file, row.line});
      firstRepeated = line;
    }
    if (repeats) repair.corners.push_back({row.values[0], row.values[1]});
    // Skip rows without new faces. Rows with some new faces keep only those.
    if (repeats && newFaces == 0) continue;
    if (repeats) row.values[4] = newFaces;
    kept.push_back(row);
  }
  if (repair.corners.empty()) return;
  table.rows = std::move(kept);
  const std::string earlier =
      firstRepeated > 0 ? fmt::format(", first in line {}", firstRepeated) : "";
  repair.found = fmt::format("{} listed again{}", countOf(repair.corners.size(), "joint"), earlier);
  repair.done = "repeated joints are removed, regardless of the order of their ends";
  repair.advice = "delete the repeated lines";
  noteRepair(std::move(repair), model, warnings);
}

// The shift applies to all four numbers of every row.
void repairBase(JointTable& table, const TileTable& tiles, Model& model,
                std::vector<std::string>& warnings) {
  // The rows have zero-based numbers, computed with the format's default base. With the other base
  // they are one lower or one higher.
  const int other = 1 - table.countsFrom;
  const int shift = table.countsFrom - other;
  // A file that fits the default base is never changed, even if it also fits the other one.
  if (namesExistingCorners(table, tiles.tiles, 0) ||
      !namesExistingCorners(table, tiles.tiles, shift)) {
    return;
  }
  for (JointRow& row : table.rows) {
    for (std::size_t entry = 0; entry < 4; ++entry) row.values[entry] += shift;
  }
  const int defaultBase = std::exchange(table.countsFrom, other);
  model.fileOrder.countsFrom = other;
  Repair repair;
  repair.place = table.file.string();
  repair.found = fmt::format("tiles and vertices of all {} joints count from {}, not from {}",
                             table.rows.size(), other, defaultBase);
  repair.done = fmt::format("they are read as counted from {}", other);
  repair.advice = fmt::format("{} all tile and vertex numbers",
                              defaultBase > other ? "add 1 to" : "subtract 1 from");
  noteRepair(std::move(repair), model, warnings);
}

// Only the start decides: a tile has the same vertex order in every state.
void turnClockwiseTiles(const TileTable& table, Model& model, std::vector<std::string>& warnings) {
  const double size = modelSize(model);
  const std::optional<SheetFrame> frame =
      sheetFrame(model.tiles, flatToleranceAsRead(model.tiles, size));
  if (!frame) return;
  std::vector<bool> clockwise(model.tiles.size());
  std::transform(model.tiles.begin(), model.tiles.end(), clockwise.begin(),
                 [&](const Tile& tile) { return tileNormal(tile).dot(frame->normal) < 0; });
  const auto count = std::count(clockwise.begin(), clockwise.end(), true);
  if (count == 0) return;
  // In a spatial sheet the orientation of tiles decides which side is the top face. Reversing all
  // tiles would swap the top and bottom joints.
  const bool isFolded =
      model.target && !isParallel(*frame, *model.target, flatToleranceAsRead(*model.target, size));
  if (isFolded && count == std::ssize(model.tiles)) {
    warnings.push_back(
        fmt::format("{}: warning: all tiles run clockwise seen from above, so bricks extend "
                    "downwards. List their vertices anticlockwise to extend bricks upwards",
                    table.file.string()));
    return;
  }
  const int first =
      static_cast<int>(std::find(clockwise.begin(), clockwise.end(), true) - clockwise.begin());
  Repair repair;
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
  model = inFileOrder(std::move(model));
  model.fileOrder = {countsFrom, std::move(clockwise)};
}

// ------------------------------------------------------------------------------------------------
// Checks of a list of joints, in the order of reading: existing numbers, valid faces, two different
// tiles, and finally the distance of their corners. Each message has the file's own line, column
// and numbers, which count from 0 or from 1.

namespace {

// Corners further apart than this fraction of a tile come from a wrong index. Largest in real
// designs: 3.5e-4 (cube2sphere_w3_h3).
constexpr double kTooFar = 0.05;

FileLocation locationOf(const JointTable& table, const JointRow& row, int entry) {
  return {table.file, row.line, row.columns[entry]};
}

// `entry` is 0 or 2.
void checkTileNumber(const JointTable& table, const TileTable& tiles, const JointRow& row,
                     int entry) {
  const int count = static_cast<int>(tiles.tiles.size());
  const int tile = row.values[entry];
  if (tile >= 0 && tile < count) return;
  throw inputErrorAt(
      locationOf(table, row, entry),
      fmt::format("{} has tiles {}-{}, not {}. Correct this column", tiles.file.filename().string(),
                  table.countsFrom, table.countsFrom + count - 1, table.countsFrom + tile));
}

// `entry` is 1 or 3, a vertex of the tile in the previous entry.
void checkVertexNumber(const JointTable& table, const TileTable& tiles, const JointRow& row,
                       int entry) {
  const int tile = row.values[entry - 1];
  const int vertex = row.values[entry];
  const int count = static_cast<int>(tiles.tiles[tile].vertices.size());
  if (vertex >= 0 && vertex < count) return;
  // A vertex number above the last may also mean that the tile lacks a vertex.
  const std::string advice =
      vertex < 0 ? "correct this column"
                 : "correct this column or add the vertex at " + tiles.shortName(tile);
  throw inputErrorAt(locationOf(table, row, entry),
                     fmt::format("tile {} has vertices {}-{}, not {}; {}", table.countsFrom + tile,
                                 table.countsFrom, table.countsFrom + count - 1,
                                 table.countsFrom + vertex, advice));
}

void checkFace(const JointTable& table, const JointRow& row) {
  if (row.values[4] >= 1 && row.values[4] <= 3) return;
  throw inputErrorAt(
      locationOf(table, row, 4),
      fmt::format("there is no face {}; write 1 (bottom), 2 (top) or 3 (both)", row.values[4]));
}

void checkTwoTiles(const JointTable& table, const JointRow& row) {
  if (row.values[0] != row.values[2]) return;
  throw inputErrorAt(locationOf(table, row, 2),
                     fmt::format("tile {} is joined to itself; correct this column or delete this "
                                 "line",
                                 table.countsFrom + row.values[0]));
}

Joint toJoint(const JointRow& row) {
  return {{row.values[0], row.values[1]},
          {row.values[2], row.values[3]},
          static_cast<JointFace>(row.values[4]),
          JointKind::Pivot,
          Vector3::Zero(),
          false,
          row.neck};
}

}  // namespace

double startGap(const Model& model, const Joint& joint) {
  const Vector3& a = model.tiles[joint.a.tile].vertices[joint.a.vertex];
  const Vector3& b = model.tiles[joint.b.tile].vertices[joint.b.vertex];
  return (a - b).norm();
}

bool namesExistingCorners(const JointTable& table, const std::vector<Tile>& tiles, int shift) {
  return std::all_of(table.rows.begin(), table.rows.end(), [&](const JointRow& row) {
    // Entries 0 and 2 are tiles, the following ones vertices. All are shifted by the same amount,
    // since a file counts both from 0 or both from 1.
    for (const int entry : {0, 2}) {
      const int tile = row.values[entry] + shift;
      const int vertex = row.values[entry + 1] + shift;
      if (tile < 0 || tile >= std::ssize(tiles) || vertex < 0) return false;
      if (vertex >= std::ssize(tiles[tile].vertices)) return false;
    }
    return true;
  });
}

void setNeck(int joint, const Neck& neck, const FileLocation& location, JointTable& table) {
  if (joint < 0 || joint >= std::ssize(table.rows)) {
    throw inputErrorAt(location, fmt::format("a neck names joint {}, but there are joints 0-{}; "
                                             "correct the number",
                                             joint, std::ssize(table.rows) - 1));
  }
  // Rejects NaN and impossible sizes.
  const bool isPossible = neck.width > neck.kerf / 2 && neck.kerf >= 0 && neck.length >= neck.kerf &&
                          neck.width <= kMaxCoordinate && neck.length <= kMaxCoordinate;
  if (!isPossible) {
    throw inputErrorAt(
        location, fmt::format("the neck of joint {} is {} wide and {} long, its kerf {}; a width "
                              "is > half the kerf, a kerf >= 0 and a length at least the kerf: "
                              "correct them",
                              joint, neck.width, neck.length, neck.kerf));
  }
  if (table.rows[joint].neck) {
    throw inputErrorAt(location, fmt::format("joint {} has two necks; delete one of them", joint));
  }
  table.rows[joint].neck = neck;
}

std::vector<Joint> checkedJoints(const JointTable& table, const TileTable& tiles) {
  std::vector<Joint> joints;
  joints.reserve(table.rows.size());
  for (const JointRow& row : table.rows) {
    for (const int entry : {0, 2}) {
      // Check the tile first, since it gives the number of vertices.
      checkTileNumber(table, tiles, row, entry);
      checkVertexNumber(table, tiles, row, entry + 1);
    }
    checkFace(table, row);
    checkTwoTiles(table, row);
    joints.push_back(toJoint(row));
  }
  return joints;
}

void checkClosed(const JointTable& table, Model& model, const TileTable& tiles,
                 std::vector<std::string>& warnings) {
  const double allowed = kTooFar * tileSize(model);
  const double samePlace = samePlaceTolerance(model.tiles);
  RoundedCorners rounded(model);
  double worst = 0;
  int worstLine = 0;
  int open = 0;
  for (size_t i = 0; i < model.joints.size(); ++i) {
    const Joint& joint = model.joints[i];
    const double gap = startGap(model, joint);
    // A wrong number joins corners that are far apart.
    if (gap > allowed) {
      throw inputErrorAt(
          {table.file, table.rows[i].line},
          fmt::format("vertex {} of tile {} and vertex {} of tile {} are {:.3g} "
                      "apart at the start, at most {:.3g} is allowed; correct this "
                      "joint or the vertices at {} and {}",
                      table.countsFrom + joint.a.vertex, table.countsFrom + joint.a.tile,
                      table.countsFrom + joint.b.vertex, table.countsFrom + joint.b.tile, gap,
                      allowed, tiles.shortName(joint.a.tile), tiles.shortName(joint.b.tile)));
    }
    // Rounding explains the gap: the corners are one point.
    if (gap <= samePlace) {
      rounded.add(joint, gap, kirireel::toString({table.file, table.rows[i].line}));
      continue;
    }
    // The first steps of a run close larger gaps.
    ++open;
    if (gap <= worst) continue;
    worst = gap;
    worstLine = table.rows[i].line;
  }
  rounded.note(model, warnings);
  if (open == 0) return;
  warnings.push_back(
      fmt::format("{}: warning: {} joints are open at the start, this one most, by {:.2g}. The "
                  "run closes them",
                  kirireel::toString({table.file, worstLine}), open, worst));
}

// ------------------------------------------------------------------------------------------------
// Corners at the same point, by vertex number or by position.
//
// By position: corners coincide if their distance is within the tolerance in every state. A grid
// of cubic cells has the tolerance as cell width and stores one corner for each distinct position.
// A new corner is compared with the corners in its own cell and the 26 cells around it, which
// contain all corners within the tolerance. n corners therefore cost O(n), not O(n^2). Coinciding
// corners are merged in a disjoint-set forest. Coincidence within a tolerance is not transitive: a
// chain of close positions becomes one vertex. The file is refused if this merges two corners of
// one tile.

namespace {

// Corners at more positions within one tolerance are refused as ambiguous.
constexpr std::size_t kMostInACell = 100;

const Vector3& placeOf(const std::vector<Tile>& tiles, const Corner& corner) {
  return tiles[corner.tile].vertices[corner.vertex];
}

std::vector<Corner> allCorners(const std::vector<Tile>& tiles) {
  std::vector<Corner> corners;
  for (int tile = 0; tile < std::ssize(tiles); ++tile) {
    for (int vertex = 0; vertex < std::ssize(tiles[tile].vertices); ++vertex) {
      corners.push_back({tile, vertex});
    }
  }
  return corners;
}

/// Corners merged pair by pair into groups.
class CornerGroups {
 public:
  // Initially each corner is its own group.
  explicit CornerGroups(const std::vector<Tile>& tiles) : corners_(allCorners(tiles)) {
    first_.push_back(0);
    for (const Tile& tile : tiles) {
      first_.push_back(first_.back() + static_cast<int>(tile.vertices.size()));
    }
    parents_.resize(corners_.size());
    std::iota(parents_.begin(), parents_.end(), 0);
  }

  const std::vector<Corner>& corners() const { return corners_; }

  void merge(const Corner& a, const Corner& b) {
    const int rootA = root(indexOf(a)), rootB = root(indexOf(b));
    // The lower number becomes the root. Groups then do not depend on the order of merging.
    parents_[std::max(rootA, rootB)] = std::min(rootA, rootB);
  }

  /// Zero-based numbers of the groups, in the order of their first corners.
  CornerNumbers numbers() {
    CornerNumbers result(first_.size() - 1);
    std::map<int, int> known;
    for (int k = 0; k < std::ssize(corners_); ++k) {
      const int number = known.try_emplace(root(k), static_cast<int>(known.size())).first->second;
      result[corners_[k].tile].push_back(number);
    }
    return result;
  }

 private:
  int indexOf(const Corner& corner) const { return first_[corner.tile] + corner.vertex; }

  // The lowest corner of a group.
  int root(int index) {
    while (parents_[index] != index) {
      // Path halving keeps the trees flat.
      parents_[index] = parents_[parents_[index]];
      index = parents_[index];
    }
    return index;
  }

  std::vector<Corner> corners_;
  std::vector<int> first_;
  std::vector<int> parents_;
};

/// Finds corners that coincide in every state in less than quadratic time, by a grid in the first
/// state. The cell width is the tolerance.
class NearCorners {
 public:
  NearCorners(const std::vector<const std::vector<Tile>*>& states, std::filesystem::path file)
      : states_(states), file_(std::move(file)) {
    for (const std::vector<Tile>* tiles : states) {
      tolerance_ = std::max(tolerance_, samePlaceTolerance(*tiles));
    }
  }

  /// Adds a corner. Returns one earlier corner for each position that coincides with it.
  std::vector<Corner> add(const Corner& corner) {
    const Cell home = cellOf(corner);
    std::vector<Corner> found;
    bool isNewPlace = true;
    for (const Cell& cell : cellsAround(home)) {
      const auto residents = cells_.find(cell);
      if (residents == cells_.end()) continue;
      for (const Corner& other : residents->second) {
        const double apart = largestDistance(corner, other);
        if (apart <= tolerance_) found.push_back(other);
        // Most coinciding corners are bitwise equal. They need no entry of their own, which keeps
        // cells small.
        if (apart == 0) isNewPlace = false;
      }
    }
    if (isNewPlace) settle(corner, cells_[home]);
    return found;
  }

  /// Throws InputError when two corners of one tile have the same number.
  void requireDistinctCorners(const CornerNumbers& numbers) const {
    for (std::size_t tile = 0; tile < numbers.size(); ++tile) {
      std::vector<int> sorted = numbers[tile];
      std::sort(sorted.begin(), sorted.end());
      if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) refuse(tile);
    }
  }

 private:
  // Cell numbers are whole numbers stored as doubles: coordinate / tolerance can exceed the range
  // of int.
  using Cell = std::array<double, 3>;
  struct CellHash {
    std::size_t operator()(const Cell& cell) const {
      std::size_t hash = 0;
      for (const double number : cell) hash = 1000003 * hash + std::hash<double>()(number);
      return hash;
    }
  };

  Cell cellOf(const Corner& corner) const {
    const Vector3& place = placeOf(*states_.front(), corner);
    return {std::floor(place.x() / tolerance_), std::floor(place.y() / tolerance_),
            std::floor(place.z() / tolerance_)};
  }

  /// A cell and its 26 neighbours.
  static std::vector<Cell> cellsAround(const Cell& home) {
    std::vector<Cell> cells;
    for (const int x : {-1, 0, 1}) {
      for (const int y : {-1, 0, 1}) {
        for (const int z : {-1, 0, 1}) cells.push_back({home[0] + x, home[1] + y, home[2] + z});
      }
    }
    return cells;
  }

  // Over all states, metres.
  double largestDistance(const Corner& a, const Corner& b) const {
    double largest = 0;
    for (const std::vector<Tile>* tiles : states_) {
      largest = std::max(largest, (placeOf(*tiles, a) - placeOf(*tiles, b)).norm());
    }
    return largest;
  }

  // Too many positions within one tolerance are ambiguous and slow.
  void settle(const Corner& corner, std::vector<Corner>& residents) const {
    residents.push_back(corner);
    if (residents.size() > kMostInACell) refuse(static_cast<std::size_t>(corner.tile));
  }

  [[noreturn]] void refuse(std::size_t tile) const {
    throw inputErrorAt(
        {file_},
        fmt::format("corners at tile {} are within {:.2g}, below the precision of their digits, "
                    "but are different vertices. Give joined corners the same vertex number",
                    tile, tolerance_));
  }

  const std::vector<const std::vector<Tile>*>& states_;
  std::filesystem::path file_;
  double tolerance_ = 0;                                           ///< metres
  std::unordered_map<Cell, std::vector<Corner>, CellHash> cells_;  ///< one corner per position
};

}  // namespace

std::vector<Joint> jointsOfSharedNumbers(const CornerNumbers& numbers) {
  std::map<int, std::vector<Corner>> holders;
  for (int tile = 0; tile < std::ssize(numbers); ++tile) {
    for (int vertex = 0; vertex < std::ssize(numbers[tile]); ++vertex) {
      holders[numbers[tile][vertex]].push_back({tile, vertex});
    }
  }
  std::vector<Joint> joints;
  for (const auto& [number, corners] : holders) {
    for (std::size_t k = 1; k < corners.size(); ++k) {
      joints.push_back({corners[k - 1], corners[k], JointFace::Bottom});
    }
  }
  return joints;
}

namespace {

CornerNumbers coincidingNumbers(const std::vector<const std::vector<Tile>*>& states,
                                const std::filesystem::path& file) {
  CornerGroups groups(*states.front());
  NearCorners near(states, file);
  for (const Corner& corner : groups.corners()) {
    for (const Corner& other : near.add(corner)) groups.merge(corner, other);
  }
  CornerNumbers numbers = groups.numbers();
  near.requireDistinctCorners(numbers);
  return numbers;
}

}  // namespace

std::vector<Joint> jointsOfCoincidingCorners(const std::vector<const std::vector<Tile>*>& states,
                                             const std::filesystem::path& file) {
  return jointsOfSharedNumbers(coincidingNumbers(states, file));
}

namespace {

/// Tiles that share numbers, directly or through others, are one part.
DisjointSets partsByNumbers(const CornerNumbers& numbers) {
  DisjointSets parts(numbers.size());
  std::map<int, int> holder;
  for (int tile = 0; tile < std::ssize(numbers); ++tile) {
    for (const int number : numbers[tile]) {
      parts.unite(holder.emplace(number, tile).first->second, tile);
    }
  }
  return parts;
}

}  // namespace

CornerNumbers meshNumbers(const CornerNumbers& numbers,
                          const std::vector<const std::vector<Tile>*>& states,
                          const std::filesystem::path& file) {
  DisjointSets parts = partsByNumbers(numbers);
  const auto isWhole = [&](int tile) { return parts.lowestOf(tile) == parts.lowestOf(0); };
  if (std::ranges::all_of(numbersBelow(numbers.size()), isWhole)) return numbers;
  // At each place, the numbers of each part. Two numbers of one part are the sides of a slit.
  const CornerNumbers places = coincidingNumbers(states, file);
  std::map<int, std::map<int, std::set<int>>> numbersAt;
  for (std::size_t tile = 0; tile < numbers.size(); ++tile) {
    const int part = parts.lowestOf(static_cast<int>(tile));
    for (std::size_t k = 0; k < numbers[tile].size(); ++k) {
      numbersAt[places[tile][k]][part].insert(numbers[tile][k]);
    }
  }
  std::map<int, int> merged;
  for (const auto& [place, byPart] : numbersAt) {
    int lowest = -1;
    for (const auto& [part, own] : byPart) {
      if (own.size() > 1) continue;
      if (lowest < 0 || *own.begin() < lowest) lowest = *own.begin();
    }
    for (const auto& [part, own] : byPart) {
      if (own.size() == 1) merged[*own.begin()] = lowest;
    }
  }
  CornerNumbers result = numbers;
  for (std::vector<int>& tile : result) {
    for (int& number : tile) {
      if (const auto found = merged.find(number); found != merged.end()) number = found->second;
    }
  }
  return result;
}

// Requires exact equality. Writing and reading a mesh then loses nothing.
CornerNumbers sharedNumbers(const Model& model, bool withTopJoints) {
  CornerGroups groups(model.tiles);
  for (const Joint& joint : model.joints) {
    if (joint.kind != JointKind::Pivot) continue;
    if (!withTopJoints && joint.face == JointFace::Top) continue;
    const auto coincide = [&](const std::vector<Tile>& tiles) {
      return placeOf(tiles, joint.a) == placeOf(tiles, joint.b);
    };
    if (coincide(model.tiles) && (!model.target || coincide(*model.target)) &&
        std::ranges::all_of(model.waypoints, coincide)) {
      groups.merge(joint.a, joint.b);
    }
  }
  return groups.numbers();
}

// ------------------------------------------------------------------------------------------------
// Selects the faces of joints from the deployed shape.
//
// A brick is a tile thickened along its normal. Two bricks that fold towards each other on the side
// of their normals collide there unless the joint is on that side. With normals n_a and n_b and the
// unit direction e of the common edge, the first tile on its left,
//   s = (n_a x n_b) . e          the sine of the fold: s > 0 a mountain, s < 0 a valley
// decides between top and bottom. Tiles with only a common vertex have no common edge. There the
// direction between the centroids replaces the normal of the edge, and normals that converge along
// it are a valley. PyKirigami points the edge from its lower to its higher vertex number, not
// anticlockwise. Its sign therefore depends on the numbering. This rule is kept for files made for
// it.

namespace {

// Below this sine between normals a fold is flat, and its sign comes from rounding.
constexpr double kFlatFold = 1e-6;

/// The common edge of a joint's tiles: two vertices of the first tile, the joint's own first.
using SharedEdge = std::pair<int, int>;

// The previous (-1) or next (+1) vertex around the tile.
int neighbour(const Tile& tile, int vertex, int step) {
  const int count = static_cast<int>(tile.vertices.size());
  return (vertex + step + count) % count;
}

std::optional<SharedEdge> sharedEdge(const Joint& joint, const Tile& a, const Tile& b,
                                     double tolerance) {
  // Four pairs of edges can coincide: the neighbours on either side of both corners.
  for (const int stepA : {1, -1}) {
    for (const int stepB : {1, -1}) {
      const int endA = neighbour(a, joint.a.vertex, stepA);
      const int endB = neighbour(b, joint.b.vertex, stepB);
      const double gap = (a.vertices[endA] - b.vertices[endB]).norm();
      if (gap <= tolerance) return SharedEdge{joint.a.vertex, endA};
    }
  }
  return std::nullopt;
}

/// Direction of the edge: anticlockwise around the tile, or from the lower to the higher number.
Vector3 edgeDirection(const Tile& tile, const SharedEdge& edge, FaceRule rule) {
  const Vector3 away = tile.vertices[edge.second] - tile.vertices[edge.first];
  const bool forward = rule == FaceRule::PyKirigami ? edge.first < edge.second
                                                    : neighbour(tile, edge.first, 1) == edge.second;
  return (forward ? away : Vector3(-away)).normalized();
}

// The face of one joint, from the fold about the common edge or from converging normals.
JointFace faceOf(const Joint& joint, const std::vector<Tile>& tiles, FaceRule rule,
                 double tolerance) {
  const Tile& a = tiles[joint.a.tile];
  const Tile& b = tiles[joint.b.tile];
  const Vector3 normalA = tileNormal(a);
  const Vector3 normalB = tileNormal(b);
  if (const std::optional<SharedEdge> edge = sharedEdge(joint, a, b, tolerance)) {
    const double sine = normalA.cross(normalB).dot(edgeDirection(a, *edge, rule));
    const bool top = rule == FaceRule::PyKirigami ? sine > kFlatFold : sine < -kFlatFold;
    return top ? JointFace::Top : JointFace::Bottom;
  }
  const Vector3 across = (tileCentroid(b) - tileCentroid(a)).normalized();
  const bool converging = (normalB - normalA).dot(across) < -kFlatFold;
  return converging ? JointFace::Top : JointFace::Bottom;
}

}  // namespace

void chooseJointFaces(Model& model, FaceRule rule) {
  const double tolerance = samePlaceTolerance(model.tiles);
  const std::vector<Tile>& deployed = model.target ? *model.target : model.tiles;
  const std::optional<SheetFrame> frame = sheetFrame(model.tiles, tolerance);
  const bool planar = frame && isParallel(*frame, deployed, tolerance);
  for (Joint& joint : model.joints) {
    if (joint.kind != JointKind::Pivot) continue;
    joint.face = planar ? JointFace::Both : faceOf(joint, deployed, rule, tolerance);
  }
}

}  // namespace kirireel::model
