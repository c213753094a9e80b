#include "sim/model/joint_checks.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include <fmt/format.h>

namespace kirireel {
namespace {

// Corners nearer than this part of the model's size are taken as joined; what is left is rounding
// of the file. Largest met among exact designs: 2e-16 (stampfli24).
constexpr double kClosed = 1e-6;
// Corners further apart than this part of a tile are a wrong index. Largest met: 3.5e-4
// (cube2sphere_w3_h3).
constexpr double kTooFar = 0.05;

FileLocation locationOf(const JointTable& table, const JointRow& row, int entry) {
  return {table.file, row.line, row.columns[entry]};
}

/// Whether all numbers fit a file that counts tiles and vertices from 1.
bool countsFromOne(const JointTable& table, const TileTable& tiles) {
  const int tileCount = static_cast<int>(tiles.tiles.size());
  return std::all_of(table.rows.begin(), table.rows.end(), [&](const JointRow& row) {
    for (const int entry : {0, 2}) {
      const int tile = row.values[entry];
      const int vertex = row.values[entry + 1];
      if (tile < 1 || tile > tileCount || vertex < 1) return false;
      if (vertex > static_cast<int>(tiles.tiles[tile - 1].vertices.size())) return false;
    }
    return true;
  });
}

std::string howToMend(const JointTable& table, const TileTable& tiles, const std::string& usual) {
  if (!countsFromOne(table, tiles)) return usual;
  return "this file seems to count from 1: subtract 1 from all its tile and vertex numbers";
}

void checkTileNumber(const JointTable& table, const TileTable& tiles, const JointRow& row,
                     int entry) {
  const int count = static_cast<int>(tiles.tiles.size());
  const int tile = row.values[entry];
  if (tile >= 0 && tile < count) return;
  throw inputErrorAt(locationOf(table, row, entry),
                     fmt::format("{} has tiles 0-{}, not {}; {}", tiles.file.filename().string(),
                                 count - 1, tile, howToMend(table, tiles, "correct this column")));
}

void checkVertexNumber(const JointTable& table, const TileTable& tiles, const JointRow& row,
                       int entry) {
  const int tile = row.values[entry - 1];
  const int vertex = row.values[entry];
  const int count = static_cast<int>(tiles.tiles[tile].vertices.size());
  if (vertex >= 0 && vertex < count) return;
  const std::string usual =
      vertex < 0 ? "correct this column"
                 : "correct this column or add the vertex at " + tiles.shortName(tile);
  throw inputErrorAt(locationOf(table, row, entry),
                     fmt::format("tile {} has vertices 0-{}, not {}; {}", tile, count - 1, vertex,
                                 howToMend(table, tiles, usual)));
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
                                 row.values[0]));
}

Joint toJoint(const JointRow& row) {
  return {{row.values[0], row.values[1]},
          {row.values[2], row.values[3]},
          static_cast<JointFace>(row.values[4])};
}

/// Two rows repeat each other when they share a face at the same two corners, in either order.
void checkNotRepeated(const JointTable& table) {
  using CornerNumbers = std::pair<int, int>;
  // Line of the first row that holds these two corners on this face (1 or 2).
  std::map<std::tuple<CornerNumbers, CornerNumbers, int>, int> firstLine;
  for (const JointRow& row : table.rows) {
    CornerNumbers a{row.values[0], row.values[1]};
    CornerNumbers b{row.values[2], row.values[3]};
    if (b < a) std::swap(a, b);
    for (const int face : {1, 2}) {
      if ((row.values[4] & face) == 0) continue;
      const auto [entry, isNew] = firstLine.try_emplace({a, b, face}, row.line);
      if (isNew) continue;
      throw inputErrorAt({table.file, row.line},
                         fmt::format("vertex {} of tile {} and vertex {} of tile {} are joined on "
                                     "the {} face at line {} already; delete one of the two lines",
                                     a.second, a.first, b.second, b.first,
                                     face == 1 ? "bottom" : "top", entry->second));
    }
  }
}

double startGap(const Model& model, const Joint& joint) {
  const Vector3& a = model.tiles[joint.a.tile].vertices[joint.a.vertex];
  const Vector3& b = model.tiles[joint.b.tile].vertices[joint.b.vertex];
  return (a - b).norm();
}

}  // namespace

std::vector<Joint> checkedJoints(const JointTable& table, const TileTable& tiles) {
  std::vector<Joint> joints;
  joints.reserve(table.rows.size());
  for (const JointRow& row : table.rows) {
    for (const int entry : {0, 2}) {
      checkTileNumber(table, tiles, row, entry);
      checkVertexNumber(table, tiles, row, entry + 1);
    }
    checkFace(table, row);
    checkTwoTiles(table, row);
    joints.push_back(toJoint(row));
  }
  checkNotRepeated(table);
  return joints;
}

void checkClosed(const JointTable& table, const Model& model, const TileTable& tiles,
                 std::vector<std::string>& warnings) {
  const double allowed = kTooFar * tileSize(model);
  const double rounding = kClosed * modelSize(model);
  double worst = 0;
  int worstLine = 0;
  int open = 0;
  for (size_t i = 0; i < model.joints.size(); ++i) {
    const Joint& joint = model.joints[i];
    const double gap = startGap(model, joint);
    if (gap > allowed) {
      throw inputErrorAt(
          {table.file, table.rows[i].line},
          fmt::format("vertex {} of tile {} and vertex {} of tile {} are {:.3g} m "
                      "apart at the start, at most {:.3g} is allowed; correct this "
                      "joint or the vertices at {} and {}",
                      joint.a.vertex, joint.a.tile, joint.b.vertex, joint.b.tile, gap, allowed,
                      tiles.shortName(joint.a.tile), tiles.shortName(joint.b.tile)));
    }
    open += gap > rounding ? 1 : 0;
    if (gap <= worst) continue;
    worst = gap;
    worstLine = table.rows[i].line;
  }
  if (open == 0) return;
  warnings.push_back(
      fmt::format("{}: warning: {} joints are open at the start, this one most, by "
                  "{:.2g} m; the run pulls them together",
                  toString({table.file, worstLine}), open, worst));
}

}  // namespace kirireel
