// Checks of a list of joints, in the order of reading: existing numbers, valid faces, two different
// tiles, and finally the distance of their corners. Each message has the file's own line, column
// and numbers, which count from 0 or from 1.
#include "sim/formats/joint_checks.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "sim/base/words.h"
#include "sim/formats/repairs.h"
#include "sim/formats/text_table.h"
#include "sim/formats/written_digits.h"

namespace kirireel::formats {
namespace {

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

model::Joint toJoint(const JointRow& row) {
  return {{row.values[0], row.values[1]},
          {row.values[2], row.values[3]},
          static_cast<model::JointFace>(row.values[4]),
          model::JointKind::Pivot,
          Vector3::Zero(),
          false,
          row.neck};
}

}  // namespace

void requireKinds(const model::Model& model, const std::set<model::JointKind>& kinds,
                  const char* rule, const std::filesystem::path& file) {
  const int first = model.fileOrder.countsFrom;
  for (const model::Joint& joint : model.joints) {
    if (kinds.contains(joint.kind)) continue;
    throw InputError(fmt::format(
        "{}: error: {}, not the joint ({}) between tiles {} and {}. Convert to a .fold file",
        file.string(), rule, model::kindName(joint), first + joint.a.tile, first + joint.b.tile));
  }
}

double startGap(const model::Model& model, const model::Joint& joint) {
  const Vector3& a = model.tiles[joint.a.tile].vertices[joint.a.vertex];
  const Vector3& b = model.tiles[joint.b.tile].vertices[joint.b.vertex];
  return (a - b).norm();
}

double misfitOf(const model::Model& model) {
  const double tile = model::tileSize(model);
  const auto gapOf = [&](const std::vector<model::Tile>& tiles) {
    const double gap = model::largestJointGap(model.joints, tiles);
    return gap > model::kMaxMisfit * tile ? 0 : gap;
  };
  const double misfit = std::max(gapOf(model.tiles), model.target ? gapOf(*model.target) : 0);
  return misfit > model::kClosedShare * tile ? misfit : 0;
}

bool namesExistingCorners(const JointTable& table, const std::vector<model::Tile>& tiles,
                          int shift) {
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

void setNeck(int joint, const model::Neck& neck, const FileLocation& location, JointTable& table) {
  if (joint < 0 || joint >= std::ssize(table.rows)) {
    throw inputErrorAt(location, fmt::format("a neck names joint {}, but there are joints 0-{}; "
                                             "correct the number",
                                             joint, std::ssize(table.rows) - 1));
  }
  // Rejects NaN and impossible sizes.
  const bool isPossible = neck.width > neck.kerf / 2 && neck.kerf >= 0 &&
                          neck.length >= neck.kerf && neck.width <= kMaxCoordinate &&
                          neck.length <= kMaxCoordinate;
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

std::vector<model::Joint> checkedJoints(const JointTable& table, const TileTable& tiles) {
  std::vector<model::Joint> joints;
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

void checkClosed(const JointTable& table, model::Model& model, const TileTable& tiles,
                 std::vector<std::string>& warnings) {
  const double allowed = kMaxGap * model::tileSize(model);
  const double samePlace = samePlaceTolerance(model.tiles);
  RoundedCorners rounded(model);
  double worst = 0;
  int worstLine = 0;
  int open = 0;
  for (size_t i = 0; i < model.joints.size(); ++i) {
    const model::Joint& joint = model.joints[i];
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
  warnings.push_back(fmt::format(
      "{}: warning: {} open at the start, at most by {:.2g} here. The run "
      "closes joints",
      kirireel::toString({table.file, worstLine}), counted(open, "joint is", "joints are"), worst));
}

void noteNoJoints(const std::filesystem::path& file, model::Model& model,
                  std::vector<std::string>& warnings) {
  noteRepair({file.string(),
              "the file is empty",
              "the tiles are read as loose",
              "write the line \"# no joints\" if the tiles are loose",
              {}},
             model, warnings);
}

void dropRepeatedJoints(JointTable& table, model::Model& model,
                        std::vector<std::string>& warnings) {
  using CornerNumber = std::pair<int, int>;
  // Line of the first row that holds these two corners on this face (1 or 2).
  std::map<std::tuple<CornerNumber, CornerNumber, int>, int> firstLine;
  std::vector<JointRow> kept;
  model::Repair repair;
  int firstRepeated = 0;
  for (JointRow& row : table.rows) {
    CornerNumber a{row.values[0], row.values[1]};
    CornerNumber b{row.values[2], row.values[3]};
    // The order of the two ends has no effect.
    if (b < a) std::swap(a, b);
    const bool hasFaces =
        row.kind == model::JointKind::Pivot && row.values[4] >= 1 && row.values[4] <= 3;
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
  repair.found = fmt::format("{} listed again{}",
                             counted(repair.corners.size(), "joint is", "joints are"), earlier);
  repair.done = "repeated joints are removed, regardless of the order of their ends";
  repair.advice = "delete the repeated lines";
  noteRepair(std::move(repair), model, warnings);
}

// The shift applies to all four numbers of every row.
void repairBase(JointTable& table, const TileTable& tiles, model::Model& model,
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
  model::Repair repair;
  repair.place = table.file.string();
  repair.found = fmt::format("tiles and vertices count from {}, not from {}", other, defaultBase);
  repair.done = fmt::format("they are read as counted from {}", other);
  repair.advice = fmt::format("{} all tile and vertex numbers",
                              defaultBase > other ? "add 1 to" : "subtract 1 from");
  noteRepair(std::move(repair), model, warnings);
}

}  // namespace kirireel::formats
