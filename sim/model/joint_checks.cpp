// Checks of a list of joints, in the order in which a reader runs them: numbers that exist, then
// faces, then a joint of two tiles, and, once the joints are made, the distance of their corners.
// Each message names the file's own line, column and numbers, which count from 0 or from 1.
#include "sim/model/joint_checks.h"

#include <algorithm>

#include <fmt/format.h>

#include "sim/model/mending.h"
#include "sim/model/rounding.h"

namespace kirireel {
namespace {

// Corners further apart than this part of a tile are a wrong index. Largest met: 3.5e-4
// (cube2sphere_w3_h3).
constexpr double kTooFar = 0.05;

FileLocation locationOf(const JointTable& table, const JointRow& row, int entry) {
  return {table.file, row.line, row.columns[entry]};
}

// Entry 0 or 2 of the row.
void checkTileNumber(const JointTable& table, const TileTable& tiles, const JointRow& row,
                     int entry) {
  const int count = static_cast<int>(tiles.tiles.size());
  const int tile = row.values[entry];
  if (tile >= 0 && tile < count) return;
  throw inputErrorAt(
      locationOf(table, row, entry),
      fmt::format("{} has tiles {}-{}, not {}; correct this column", tiles.file.filename().string(),
                  table.countsFrom, table.countsFrom + count - 1, table.countsFrom + tile));
}

// Entry 1 or 3, of the tile in the entry before it.
void checkVertexNumber(const JointTable& table, const TileTable& tiles, const JointRow& row,
                       int entry) {
  const int tile = row.values[entry - 1];
  const int vertex = row.values[entry];
  const int count = static_cast<int>(tiles.tiles[tile].vertices.size());
  if (vertex >= 0 && vertex < count) return;
  // A vertex number above the last may also mean that the tile lacks a vertex.
  const std::string usual =
      vertex < 0 ? "correct this column"
                 : "correct this column or add the vertex at " + tiles.shortName(tile);
  throw inputErrorAt(locationOf(table, row, entry),
                     fmt::format("tile {} has vertices {}-{}, not {}; {}", table.countsFrom + tile,
                                 table.countsFrom, table.countsFrom + count - 1,
                                 table.countsFrom + vertex, usual));
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
          static_cast<JointFace>(row.values[4])};
}

}  // namespace

double startGap(const Model& model, const Joint& joint) {
  const Vector3& a = model.tiles[joint.a.tile].vertices[joint.a.vertex];
  const Vector3& b = model.tiles[joint.b.tile].vertices[joint.b.vertex];
  return (a - b).norm();
}

bool namesWhatIsThere(const JointTable& table, const std::vector<Tile>& tiles, int shift) {
  return std::all_of(table.rows.begin(), table.rows.end(), [&](const JointRow& row) {
    // Entries 0 and 2 are tiles, the ones after them vertices. Everything is shifted alike, since a
    // file counts both from 0 or both from 1.
    for (const int entry : {0, 2}) {
      const int tile = row.values[entry] + shift;
      const int vertex = row.values[entry + 1] + shift;
      if (tile < 0 || tile >= std::ssize(tiles) || vertex < 0) return false;
      if (vertex >= std::ssize(tiles[tile].vertices)) return false;
    }
    return true;
  });
}

std::vector<Joint> checkedJoints(const JointTable& table, const TileTable& tiles) {
  std::vector<Joint> joints;
  joints.reserve(table.rows.size());
  for (const JointRow& row : table.rows) {
    for (const int entry : {0, 2}) {
      // The tile goes first: without it there is no count of vertices to compare with.
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
    // A wrong number joins corners that are nowhere near each other.
    if (gap > allowed) {
      throw inputErrorAt(
          {table.file, table.rows[i].line},
          fmt::format("vertex {} of tile {} and vertex {} of tile {} are {:.3g} m "
                      "apart at the start, at most {:.3g} is allowed; correct this "
                      "joint or the vertices at {} and {}",
                      table.countsFrom + joint.a.vertex, table.countsFrom + joint.a.tile,
                      table.countsFrom + joint.b.vertex, table.countsFrom + joint.b.tile, gap,
                      allowed, tiles.shortName(joint.a.tile), tiles.shortName(joint.b.tile)));
    }
    // The digits of the file explain the gap: the corners are one.
    if (gap <= samePlace) {
      rounded.add(joint, gap, toString({table.file, table.rows[i].line}));
      continue;
    }
    // Everything between is an opening that the first steps of a run close.
    ++open;
    if (gap <= worst) continue;
    worst = gap;
    worstLine = table.rows[i].line;
  }
  rounded.note(model, warnings);
  if (open == 0) return;
  warnings.push_back(
      fmt::format("{}: warning: {} joints are open at the start, this one most, by "
                  "{:.2g} m; the run pulls them together",
                  toString({table.file, worstLine}), open, worst));
}

}  // namespace kirireel
