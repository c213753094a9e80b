// The planar text files of the quasicrystal kirigami simulator: vertices, constraints, hull.
//
// Two conventions of that program matter here. Tiles and vertices count from 1 in the lists of
// joints and from 0 in the hulls. And a joint holds its two vertices at the distance that they have
// at the start: 0 makes a pivot, anything else a rod (a link here). A model in the plane has no
// faces, so that pivots are on both faces of the bricks, which makes them hinges about the
// vertical.
//
// L. Liu, G. P. T. Choi, L. Mahadevan, Quasicrystal kirigami, Physical Review Research 4, 2022.
#include "sim/model/planar_files.h"

#include <algorithm>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/base/pending_file.h"
#include "sim/model/joint_checks.h"
#include "sim/model/planar_siblings.h"
#include "sim/model/rounding.h"
#include "sim/model/text_table.h"
#include "sim/model/tile_checks.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;

const std::string kPlanarTilePurpose = "write one tile a line, \"x y\" for each vertex";
const std::string kPlanarJointPurpose =
    "write one joint a line, \"tile vertex tile vertex\", from 1";
const std::string kPlanarHullPurpose =
    "write one corner of the sheet's outside a line, \"tile vertex\", from 0, at least 3";

// Pairs of numbers, at height 0.
TileTable readPlanarTiles(const fs::path& file) {
  TextTable text(file, kPlanarTilePurpose);
  TileTable table;
  table.file = file;
  table.countsFrom = 1;
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
      tile.vertices.push_back(Vector3{coordinate(k), coordinate(k + 1), 0});
      source.columns.push_back(line.fields[k].column);
    }
  }
  if (table.tiles.empty()) {
    throw inputErrorAt({file}, fmt::format("the file holds no tile; {}", kPlanarTilePurpose));
  }
  return table;
}

/// The number in a field, less 1, as far as an int holds that.
int fromOne(int number) {
  return std::max(number, std::numeric_limits<int>::min() + 2) - 1;
}

// Rows with numbers from 0, whatever the file counts from.
JointTable readPlanarJoints(const fs::path& file, Model& model,
                            std::vector<std::string>& warnings) {
  TextTable text(file, kPlanarJointPurpose);
  JointTable table;
  table.file = file;
  table.countsFrom = 1;
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
      row.values[k] = fromOne(parseWholeNumber(line.fields[k], place, "a tile or vertex number"));
      row.columns[k] = line.fields[k].column;
    }
  }
  if (table.rows.empty() && !text.hasComment()) noteNoJoints(file, model, warnings);
  return table;
}

/// Corners of the outline: "tile vertex" a line. They count from 0, or from 1 where they name
/// corners that are not there else.
std::vector<Corner> readPlanarHull(const fs::path& file, const std::vector<Tile>& tiles) {
  TextTable text(file, kPlanarHullPurpose);
  JointTable table;  // rows of two equal corners, for the same checks
  TextLine line;
  while (text.next(line)) {
    if (line.fields.size() != 2) {
      throw inputErrorAt({file, line.number}, fmt::format("{} numbers do not make a corner; {}",
                                                          line.fields.size(), kPlanarHullPurpose));
    }
    JointRow& row = table.rows.emplace_back();
    for (std::size_t k = 0; k < 4; ++k) {
      const TextField& field = line.fields[k % 2];
      row.values[k] = parseWholeNumber(field, text.at(line, field), "a tile or vertex number");
    }
  }
  // The hull's own base is 0; a row with a vertex number equal to the count of vertices shows the
  // other.
  const int shift = namesWhatIsThere(table, tiles, 0) ? 0 : -1;
  if (!namesWhatIsThere(table, tiles, shift) || table.rows.size() < 3) {
    throw inputErrorAt({file}, fmt::format("its {} rows name corners that are not there, or too "
                                           "few; {}",
                                           table.rows.size(), kPlanarHullPurpose));
  }
  std::vector<Corner> hull;
  for (const JointRow& row : table.rows) {
    hull.push_back({row.values[0] + shift, row.values[1] + shift});
  }
  return hull;
}

/// A hull that lies beside the model was not asked for: what is wrong with it refuses nothing but
/// the runs that need it.
std::optional<std::vector<Corner>> hullBeside(const PlanarPlace& place, Model& model,
                                              std::vector<std::string>& warnings) {
  if (!place.hull) {
    if (!place.otherHulls.empty()) {
      warnings.push_back(
          fmt::format("{}: note: none of the hulls beside it ({}) has the name of "
                      "these joints; the convex outline stands for it",
                      place.joints.string(), fileNames(place.otherHulls)));
    }
    return std::nullopt;
  }
  try {
    return readPlanarHull(*place.hull, model.tiles);
  } catch (const InputError& error) {
    model.hullFault = error.what();
    warnings.push_back(fmt::format("{}; this hull is left out", error.what()));
    return std::nullopt;
  }
}

/// The file of another part of the model.
fs::path beside(const fs::path& vertices, const std::string& part) {
  const std::string word = "vertices";
  std::string name = vertices.filename().string();
  name.replace(name.rfind(word), word.size(), part);
  return vertices.parent_path() / name;
}

/// "penrose" of penrose_vertices.txt, the folder's name of vertices.txt.
std::string planarModelName(const fs::path& vertices) {
  const std::string stem = vertices.stem().string();
  const std::string before = stem.substr(0, stem.rfind("vertices"));
  if (before.empty())
    return fs::absolute(vertices).lexically_normal().parent_path().filename().string();
  return before.ends_with('_') ? before.substr(0, before.size() - 1) : before;
}

/// Only joints of model folders have a fifth number, their face.
bool namesFaces(const fs::path& constraints) {
  TextTable text(constraints, kPlanarJointPurpose);
  TextLine line;
  return text.next(line) && line.fields.size() == 5;
}

/// Numbers on a line: whether they can be pairs alone, or triples too.
bool holdsPairs(const fs::path& vertices) {
  TextTable text(vertices, kPlanarTilePurpose);
  TextLine line;
  bool onlyTriples = true;
  while (text.next(line)) {
    const std::size_t count = line.fields.size();
    // A triangle is the least tile: six numbers in the plane.
    if (count % 2 != 0 || count < 6) return false;
    // Six numbers are three vertices in the plane: two in space would not make a tile.
    onlyTriples = onlyTriples && count % 3 == 0 && count != 6;
  }
  return !onlyTriples;
}

/// Joints that hold corners apart become rods; those that rounding holds apart are noted.
void makeRods(const JointTable& rows, Model& model, std::vector<std::string>& warnings) {
  const double samePlace = samePlaceTolerance(model.tiles);
  RoundedCorners rounded(model);
  double shortest = std::numeric_limits<double>::max(), longest = 0;
  int rods = 0, firstLine = 0;
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    Joint& joint = model.joints[i];
    const double gap = startGap(model, joint);
    // The corners are one, as far as the digits of the file can tell: a pivot.
    if (gap <= samePlace) {
      rounded.add(joint, gap, toString({rows.file, rows.rows[i].line}));
      continue;
    }
    joint = makeLink(model.tiles, joint.a, joint.b);
    shortest = std::min(shortest, gap);
    longest = std::max(longest, gap);
    if (rods++ == 0) firstLine = rows.rows[i].line;
  }
  rounded.note(model, warnings);
  if (rods == 0) return;
  const bool oneLength = longest - shortest <= samePlace;
  const std::string length = oneLength ? fmt::format("{:.4g} m", longest)
                                       : fmt::format("{:.4g} to {:.4g} m", shortest, longest);
  warnings.push_back(
      fmt::format("{}: note: {} joint{} corners clearly apart: {} {} long, which "
                  "{} this distance",
                  toString({rows.file, firstLine}), rods, rods == 1 ? " holds" : "s hold",
                  rods == 1 ? "a rod" : "rods", length, rods == 1 ? "keeps" : "keep"));
}

std::string planarTileText(const std::vector<Tile>& tiles) {
  std::string text;
  for (const Tile& tile : tiles) {
    const char* separator = "";
    for (const Vector3& vertex : tile.vertices) {
      text += fmt::format("{}{} {}", separator, vertex.x(), vertex.y());
      separator = " ";
    }
    text += '\n';
  }
  return text;
}

std::string planarJointText(const std::vector<Joint>& joints) {
  if (joints.empty()) return "# no joints\n";
  std::string text;
  for (const Joint& joint : joints) {
    text += fmt::format("{} {} {} {}\n", joint.a.tile + 1, joint.a.vertex + 1, joint.b.tile + 1,
                        joint.b.vertex + 1);
  }
  return text;
}

/// Planar files have no place for heights, nor for tiles that move as one.
void requirePlanar(const Model& model, const fs::path& file) {
  if (!liesFlat(model.tiles, 1e-9 * modelSize(model))) {
    throw InputError(
        fmt::format("{}: error: planar files hold x and y alone, and the start does "
                    "not lie in a horizontal plane; convert to a folder",
                    file.string()));
  }
  for (const Joint& joint : model.joints) {
    if (joint.kind != JointKind::Fixed) continue;
    throw InputError(
        fmt::format("{}: error: planar files hold corners that stay together, not the "
                    "fixed tiles {} and {}; convert to a .fold file",
                    file.string(), joint.a.tile, joint.b.tile));
  }
}

}  // namespace

void writePlanarFiles(const Model& inOrder, const fs::path& vertices) {
  requirePlanar(inOrder, vertices);
  const Model model = inFileOrder(inOrder);
  writeTextFile(vertices, planarTileText(model.tiles));
  writeTextFile(beside(vertices, "constraints"), planarJointText(model.joints));
  if (!model.hull) return;
  std::string hull;
  for (const Corner& corner : *model.hull) {
    hull += fmt::format("{} {}\n", corner.tile, corner.vertex);
  }
  writeTextFile(beside(vertices, "hull"), hull);
}

bool holdsPlanarModel(const fs::path& vertices) {
  if (!holdsPairs(vertices)) return false;
  const std::vector<fs::path> lists = jointLists(vertices);
  return std::none_of(lists.begin(), lists.end(), namesFaces);
}

Model readPlanarFiles(const fs::path& named, const ReadSettings& settings,
                      std::vector<std::string>& warnings) {
  const PlanarPlace place = planarPlace(named, settings.jointsFile);
  const TileTable tiles = readPlanarTiles(place.vertices);
  checkTiles(tiles);
  Model model;
  model.name = planarModelName(place.vertices);
  model.tiles = tiles.tiles;
  model.fileOrder.countsFrom = 1;
  JointTable rows = readPlanarJoints(place.joints, model, warnings);
  mendBase(rows, tiles, model, warnings);
  dropRepeatedJoints(rows, model, warnings);
  model.joints = checkedJoints(rows, tiles);
  makeRods(rows, model, warnings);
  if (settings.jointsFile.empty() && !place.otherJoints.empty()) {
    warnings.push_back(
        fmt::format("{}: note: these joints were taken; beside them are {} (see "
                    "--joints-file)",
                    place.joints.string(), fileNames(place.otherJoints)));
  }
  model.hull = hullBeside(place, model, warnings);
  turnClockwiseTiles(tiles, model, warnings);
  return model;
}

}  // namespace kirireel
