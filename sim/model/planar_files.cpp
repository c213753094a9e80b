#include "sim/model/planar_files.h"

#include <algorithm>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/model/joint_checks.h"
#include "sim/model/shared_corners.h"
#include "sim/model/text_table.h"
#include "sim/model/tile_checks.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;

const std::string kPlanarTilePurpose = "write one tile a line, \"x y\" for each vertex";
const std::string kPlanarJointPurpose = "write one joint a line, \"tile vertex tile vertex\", from 1";

TileTable readPlanarTiles(const fs::path& file) {
  TextTable text(file, kPlanarTilePurpose);
  TileTable table;
  table.file = file;
  TextLine line;
  while (text.next(line)) {
    if (line.fields.size() % 2 != 0 || line.fields.size() < 6) {
      throw inputErrorAt({file, line.number},
                         fmt::format("tile {} has {} numbers; write x and y for each of at least 3 "
                                     "vertices",
                                     table.tiles.size() + 1, line.fields.size()));
    }
    Tile& tile = table.tiles.emplace_back();
    TileSource& source = table.sources.emplace_back();
    source.line = line.number;
    for (std::size_t k = 0; k < line.fields.size(); k += 2) {
      const auto coordinate = [&](std::size_t field) {
        return parseCoordinate(line.fields[field], text.at(line, line.fields[field]));
      };
      tile.vertices.emplace_back(coordinate(k), coordinate(k + 1), 0);
      source.columns.push_back(line.fields[k].column);
    }
  }
  if (table.tiles.empty()) {
    throw inputErrorAt({file}, fmt::format("the file holds no tile; {}", kPlanarTilePurpose));
  }
  return table;
}

void requireBaseOne(const JointTable& table) {
  for (const JointRow& row : table.rows) {
    for (std::size_t entry = 0; entry < 4; ++entry) {
      if (row.values[entry] >= 0) continue;
      throw inputErrorAt({table.file, row.line, row.columns[entry]},
                         "tiles and vertices count from 1 here; this file seems to count from 0: "
                         "add 1 to all its numbers");
    }
  }
}

JointTable readPlanarJoints(const fs::path& file) {
  TextTable text(file, kPlanarJointPurpose);
  JointTable table;
  table.file = file;
  TextLine line;
  while (text.next(line)) {
    if (line.fields.size() != 4) {
      throw inputErrorAt({file, line.number}, fmt::format("{} numbers do not make a joint; {}",
                                                          line.fields.size(), kPlanarJointPurpose));
    }
    JointRow& row = table.rows.emplace_back();
    row.line = line.number;
    row.values[4] = static_cast<int>(JointFace::Both);
    for (std::size_t k = 0; k < 4; ++k) {
      const FileLocation place = text.at(line, line.fields[k]);
      const int number = parseWholeNumber(line.fields[k], place, "a tile or vertex number");
      row.values[k] = std::max(number, 0) - 1;
      row.columns[k] = line.fields[k].column;
    }
  }
  requireBaseOne(table);
  return table;
}

/// Runs all clockwise tiles, and the joints' vertices, the other way round.
void turnAnticlockwise(TileTable& tiles, JointTable& joints) {
  std::vector<bool> isTurned(tiles.tiles.size());
  for (std::size_t tile = 0; tile < tiles.tiles.size(); ++tile) {
    if (tileNormal(tiles.tiles[tile]).z() > 0) continue;
    isTurned[tile] = true;
    std::reverse(tiles.tiles[tile].vertices.begin(), tiles.tiles[tile].vertices.end());
    std::reverse(tiles.sources[tile].columns.begin(), tiles.sources[tile].columns.end());
  }
  for (JointRow& row : joints.rows) {
    for (const std::size_t entry : {0, 2}) {
      const int tile = row.values[entry];
      const int last = static_cast<int>(tiles.tiles[tile].vertices.size()) - 1;
      if (isTurned[tile]) row.values[entry + 1] = last - row.values[entry + 1];
    }
  }
}

fs::path constraintsBeside(const fs::path& vertices) {
  std::string name = vertices.filename().string();
  const std::string word = "vertices";
  name.replace(name.rfind(word), word.size(), "constraints");
  return vertices.parent_path() / name;
}

/// "penrose" of penrose_vertices.txt, the folder's name of vertices.txt.
std::string planarModelName(const fs::path& vertices) {
  const std::string stem = vertices.stem().string();
  const std::string before = stem.substr(0, stem.rfind("vertices"));
  if (before.empty()) return fs::absolute(vertices).parent_path().filename().string();
  return before.ends_with('_') ? before.substr(0, before.size() - 1) : before;
}

/// Only joints of model folders have a fifth number, their face.
bool namesFaces(const fs::path& constraints) {
  if (!fs::is_regular_file(constraints)) return false;
  TextTable text(constraints, kPlanarJointPurpose);
  TextLine line;
  return text.next(line) && line.fields.size() == 5;
}

bool holdsPairs(const fs::path& vertices) {
  TextTable text(vertices, kPlanarTilePurpose);
  TextLine line;
  bool onlyTriples = true;
  while (text.next(line)) {
    if (line.fields.size() % 2 != 0) return false;
    onlyTriples = onlyTriples && line.fields.size() % 3 == 0;
  }
  return !onlyTriples;
}

}  // namespace

bool holdsPlanarModel(const fs::path& vertices) {
  return holdsPairs(vertices) && !namesFaces(constraintsBeside(vertices));
}

Model readPlanarFiles(const fs::path& vertices, std::vector<std::string>& warnings) {
  TileTable tiles = readPlanarTiles(vertices);
  JointTable rows = readPlanarJoints(constraintsBeside(vertices));
  checkedJoints(rows, tiles);  // before numbers are changed, so that messages name those written
  turnAnticlockwise(tiles, rows);
  checkTiles(tiles);
  Model model;
  model.name = planarModelName(vertices);
  model.tiles = tiles.tiles;
  model.joints = checkedJoints(rows, tiles);
  const double tolerance = kSamePlace * modelSize(model);
  int links = 0;
  for (Joint& joint : model.joints) {
    const Joint link = makeLink(model.tiles, joint.a, joint.b);
    if (link.apart.norm() <= tolerance) continue;
    joint = link;
    ++links;
  }
  if (links > 0) {
    warnings.push_back(fmt::format("{}: note: {} joints stand apart and keep their distance",
                                   rows.file.string(), links));
  }
  return model;
}

}  // namespace kirireel
