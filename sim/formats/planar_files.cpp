// Selects the files in one folder that belong to one planar model.
//
// Programs leave many files in one folder and distinguish them by name. The last of the words
// "vertices", "constraints" and "hull" in a name gives the content, because the model itself can be
// called "hull". The name before "vertices" is the prefix of a model. Every other file belongs to
// the model with the longest matching prefix. Of several lists of joints, the program takes the one
// that the user named directly or by its hull. Otherwise it takes the list with the name of the
// vertices, and otherwise the only list. It does not guess further: several lists without a default
// name are an error that lists them.
#include <algorithm>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <system_error>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/error.h"
#include "sim/base/file_kinds.h"
#include "sim/base/files.h"
#include "sim/base/words.h"
#include "sim/formats/joint_checks.h"
#include "sim/formats/model_formats.h"
#include "sim/formats/read_settings.h"
#include "sim/formats/repairs.h"
#include "sim/formats/text_table.h"
#include "sim/formats/tile_checks.h"
#include "sim/formats/written_digits.h"
#include "sim/model/sheet_frame.h"

namespace kirireel::formats {
namespace {

namespace fs = std::filesystem;

constexpr const char* kVertices = "vertices";
constexpr const char* kConstraints = "constraints";
constexpr const char* kHull = "hull";

/// The word for the content of a file; "" for other files. Words before it belong to the name of
/// the model or of a variant.
std::string wordOf(const fs::path& file) {
  if (endingOf(file) != ".txt") return "";
  const std::string stem = file.stem().string();
  std::string word;
  std::size_t last = 0;
  for (const char* candidate : {kVertices, kConstraints, kHull}) {
    const std::size_t at = stem.rfind(candidate);
    if (at == stem.npos || (!word.empty() && at < last)) continue;
    word = candidate;
    last = at;
  }
  // NAME_hull_tiles.txt lists tiles, not corners.
  const bool listsTiles = word == kHull && stem.find("tiles", last) != stem.npos;
  return listsTiles ? "" : word;
}

/// The part of a name before one of the three words, such as "penrose_" of penrose_vertices.txt.
std::string prefixOf(const fs::path& vertices) {
  const std::string stem = vertices.stem().string();
  return stem.substr(0, stem.rfind(kVertices));
}

// All text files in the folder of this file, by name.
std::vector<fs::path> textFilesNextTo(const fs::path& file) {
  const fs::path folder = file.has_parent_path() ? file.parent_path() : ".";
  std::vector<fs::path> files;
  // A folder that cannot be listed counts as empty: opening the named file gives a better message.
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    if (endingOf(entry.path()) != ".txt" || !entry.is_regular_file(ignored)) continue;
    files.push_back(file.parent_path() / entry.path().filename());
  }
  // The system lists files in arbitrary order.
  std::sort(files.begin(), files.end());
  return files;
}

/// The file of vertices whose prefix matches the name; the longest prefix of several.
std::optional<fs::path> ownerOf(const fs::path& file, const std::vector<fs::path>& siblings) {
  std::optional<fs::path> owner;
  for (const fs::path& vertices : siblings) {
    if (wordOf(vertices) != kVertices) continue;
    if (!file.filename().string().starts_with(prefixOf(vertices))) continue;
    if (!owner || prefixOf(vertices).size() > prefixOf(*owner).size()) owner = vertices;
  }
  return owner;
}

/// The files of a model with this content.
std::vector<fs::path> partsOfModel(const fs::path& vertices, const std::string& word) {
  const std::vector<fs::path> siblings = textFilesNextTo(vertices);
  std::vector<fs::path> parts;
  for (const fs::path& file : siblings) {
    if (wordOf(file) == word && ownerOf(file, siblings) == vertices) parts.push_back(file);
  }
  return parts;
}

/// The same name with one of the three words replaced.
fs::path withWord(const fs::path& file, const std::string& word, const std::string& other) {
  std::string name = file.filename().string();
  const std::size_t at = name.rfind(word);
  if (at != name.npos) name.replace(at, word.size(), other);
  return file.parent_path() / name;
}

bool contains(const std::vector<fs::path>& files, const fs::path& file) {
  return std::find(files.begin(), files.end(), file) != files.end();
}

// The list that the user named, else the list that belongs to the named hull, else the list with
// the default name, else the only list.
fs::path chosenList(const fs::path& named, const fs::path& vertices,
                    const std::vector<fs::path>& lists) {
  if (wordOf(named) == kConstraints) return named;
  if (wordOf(named) == kHull) {
    const fs::path partner = withWord(named, kHull, kConstraints);
    if (contains(lists, partner)) return partner;
  }
  const fs::path matching = withWord(vertices, kVertices, kConstraints);
  if (contains(lists, matching)) return matching;
  if (lists.size() == 1) return lists.front();
  if (lists.empty()) {
    throw inputErrorAt(
        {vertices},
        fmt::format("there is no list of joints next to it. Write {}, or set `joints_file`",
                    matching.filename().string()));
  }
  throw inputErrorAt(
      {vertices},
      fmt::format("there are {} lists of joints next to it: {}. Select one with `joints_file`",
                  lists.size(), fileNames(lists)));
}

std::optional<fs::path> chosenHull(const fs::path& named, const fs::path& joints,
                                   const std::vector<fs::path>& hulls) {
  if (wordOf(named) == kHull) return named;
  const fs::path partner = withWord(joints, kConstraints, kHull);
  if (contains(hulls, partner)) return partner;
  if (hulls.size() == 1) return hulls.front();
  return std::nullopt;
}

void remove(std::vector<fs::path>& files, const fs::path& file) {
  std::erase(files, file);
}

}  // namespace

std::string fileNames(const std::vector<fs::path>& files) {
  std::vector<std::string> names;
  for (const fs::path& file : files) names.push_back(file.filename().string());
  return fmt::format("{}", fmt::join(names, ", "));
}

bool isPlanarName(const fs::path& file) {
  return !wordOf(file).empty();
}

bool isJointList(const fs::path& file) {
  return wordOf(file) == kConstraints;
}

fs::path planarVertices(const fs::path& file) {
  if (wordOf(file) == kVertices) return file;
  const std::optional<fs::path> owner = ownerOf(file, textFilesNextTo(file));
  if (owner) return *owner;
  throw inputErrorAt(
      {file},
      "there is no file of vertices with the same beginning of its name. Add NAME_vertices.txt");
}

std::vector<fs::path> jointLists(const fs::path& vertices) {
  return partsOfModel(vertices, kConstraints);
}

PlanarPlace planarPlace(const fs::path& named, const fs::path& jointsFile) {
  PlanarPlace place;
  place.vertices = planarVertices(named);
  place.otherJoints = jointLists(place.vertices);
  place.otherHulls = partsOfModel(place.vertices, kHull);
  place.joints = jointsFile.empty() ? chosenList(named, place.vertices, place.otherJoints)
                                    : namedFile(jointsFile, place.vertices.parent_path());
  place.hull = chosenHull(named, place.joints, place.otherHulls);
  remove(place.otherJoints, place.joints);
  if (place.hull) remove(place.otherHulls, *place.hull);
  return place;
}

// ------------------------------------------------------------------------------------------------
// Planar text files of the quasicrystal kirigami simulator: vertices, constraints, hull.
//
// That program has two conventions. Tiles and vertices count from 1 in lists of joints and from 0
// in hulls. A joint keeps its two vertices at their start distance: 0 is a pivot, any other value a
// rod (here a link). Planar models have no faces, so pivots are on both faces of the bricks. Such a
// pair of pivots is a hinge with a vertical axis.
//
// L. Liu, G. P. T. Choi, L. Mahadevan, Quasicrystal kirigami, Physical Review Research 4, 2022.

namespace {

const std::string kPlanarTilePurpose = "write one tile per line, \"x y\" for each vertex";
const std::string kPlanarJointPurpose =
    "write one joint per line, \"tile vertex tile vertex\", from 1";
const std::string kInSpace =
    "Put files with x, y and z, and joints with a face, into a folder as vertices.txt and "
    "constraints.txt";
const std::string kPlanarHullPurpose =
    "write one corner of the sheet's outline per line, \"tile vertex\", from 0, at least 3";

// Pairs of numbers, at height 0.
TileTable readPlanarTiles(const fs::path& file) {
  TextTable text(file, kPlanarTilePurpose);
  TileTable table;
  table.file = file;
  table.countsFrom = 1;
  TextLine line;
  std::set<std::string> heights;  // of all vertices, if the numbers are x, y and z
  bool areTriples = true;
  while (text.next(line)) {
    if (line.fields.size() % 2 != 0 || line.fields.size() < 6) {
      throw inputErrorAt({file, line.number},
                         fmt::format("tile {} has {} numbers; write x and y for each of at least 3 "
                                     "vertices. {}",
                                     table.tiles.size() + 1, line.fields.size(), kInSpace));
    }
    areTriples = areTriples && line.fields.size() >= 9 && line.fields.size() % 3 == 0;
    for (std::size_t k = 2; k < line.fields.size(); k += 3) {
      heights.emplace(line.fields[k].text);
    }
    model::Tile& tile = table.tiles.emplace_back();
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
    throw inputErrorAt({file}, fmt::format("the file has no tile; {}", kPlanarTilePurpose));
  }
  if (areTriples && heights.size() == 1) {
    throw inputErrorAt({file}, fmt::format("every third number is {}: vertices have x, y and z. {}",
                                           *heights.begin(), kInSpace));
  }
  return table;
}

/// The number minus 1, without overflow of int.
int fromOne(int number) {
  return std::max(number, std::numeric_limits<int>::min() + 2) - 1;
}

// Zero-based rows for either base of the file.
JointTable readPlanarJoints(const fs::path& file, model::Model& model,
                            std::vector<std::string>& warnings) {
  TextTable text(file, kPlanarJointPurpose);
  JointTable table;
  table.file = file;
  table.countsFrom = 1;
  TextLine line;
  while (text.next(line)) {
    if (line.fields.size() != 4) {
      throw inputErrorAt({file, line.number},
                         fmt::format("a joint does not have {} numbers; {}. {}", line.fields.size(),
                                     kPlanarJointPurpose, kInSpace));
    }
    JointRow& row = table.rows.emplace_back();
    row.line = line.number;
    row.values[4] = static_cast<int>(model::JointFace::Both);
    for (std::size_t k = 0; k < 4; ++k) {
      const FileLocation place = text.at(line, line.fields[k]);
      row.values[k] = fromOne(parseWholeNumber(line.fields[k], place, "a tile or vertex number"));
      row.columns[k] = line.fields[k].column;
    }
  }
  if (table.rows.empty() && !text.hasComment()) noteNoJoints(file, model, warnings);
  return table;
}

/// Corners of the outline, one "tile vertex" per line. They are zero-based, or one-based if some
/// would otherwise not exist.
std::vector<model::Corner> readPlanarHull(const fs::path& file,
                                          const std::vector<model::Tile>& tiles) {
  TextTable text(file, kPlanarHullPurpose);
  JointTable table;  // rows of two equal corners, for the same checks
  TextLine line;
  while (text.next(line)) {
    if (line.fields.size() != 2) {
      throw inputErrorAt({file, line.number}, fmt::format("a corner does not have {} numbers; {}",
                                                          line.fields.size(), kPlanarHullPurpose));
    }
    JointRow& row = table.rows.emplace_back();
    for (std::size_t k = 0; k < 4; ++k) {
      const TextField& field = line.fields[k % 2];
      row.values[k] = parseWholeNumber(field, text.at(line, field), "a tile or vertex number");
    }
  }
  // The default base of a hull is 0. A vertex number equal to the number of vertices shows base 1.
  const int shift = namesExistingCorners(table, tiles, 0) ? 0 : -1;
  if (!namesExistingCorners(table, tiles, shift) || table.rows.size() < 3) {
    throw inputErrorAt({file}, fmt::format("its {} rows name missing corners, or too few; {}",
                                           table.rows.size(), kPlanarHullPurpose));
  }
  std::vector<model::Corner> hull;
  for (const JointRow& row : table.rows) {
    hull.push_back({row.values[0] + shift, row.values[1] + shift});
  }
  return hull;
}

/// Reads a hull next to the model. An error in it affects only runs that need the hull, because the
/// user did not request it.
std::optional<std::vector<model::Corner>> hullBeside(const PlanarPlace& place, model::Model& model,
                                                     std::vector<std::string>& warnings) {
  if (!place.hull) {
    if (!place.otherHulls.empty()) {
      warnings.push_back(
          fmt::format("{}: note: none of the hulls next to it ({}) has the name of these joints. "
                      "The convex outline is used",
                      place.joints.string(), fileNames(place.otherHulls)));
    }
    return std::nullopt;
  }
  try {
    return readPlanarHull(*place.hull, model.tiles);
  } catch (const InputError& error) {
    model.hullFault = error.what();
    warnings.push_back(fmt::format("{}. This hull is ignored", error.what()));
    return std::nullopt;
  }
}

/// The file of another part of the same model.
fs::path partFile(const fs::path& vertices, const std::string& part) {
  const std::string word = "vertices";
  std::string name = vertices.filename().string();
  name.replace(name.rfind(word), word.size(), part);
  return vertices.parent_path() / name;
}

/// "penrose" for penrose_vertices.txt, the folder's name for vertices.txt.
std::string planarModelName(const fs::path& vertices) {
  const std::string stem = vertices.stem().string();
  const std::string before = stem.substr(0, stem.rfind("vertices"));
  if (before.empty())
    return fs::absolute(vertices).lexically_normal().parent_path().filename().string();
  return before.ends_with('_') ? before.substr(0, before.size() - 1) : before;
}

/// Whether joints have a fifth number, the face, as only in model folders.
bool namesFaces(const fs::path& constraints) {
  TextTable text(constraints, kPlanarJointPurpose);
  TextLine line;
  return text.next(line) && line.fields.size() == 5;
}

/// Whether the numbers on each line can be pairs, and not also triples.
bool holdsPairs(const fs::path& vertices) {
  TextTable text(vertices, kPlanarTilePurpose);
  TextLine line;
  bool onlyTriples = true;
  while (text.next(line)) {
    const std::size_t count = line.fields.size();
    // A triangle is the smallest tile: six planar coordinates.
    if (count % 2 != 0 || count < 6) return false;
    // Six numbers are three planar vertices. Two spatial vertices would not be a tile.
    onlyTriples = onlyTriples && count % 3 == 0 && count != 6;
  }
  return !onlyTriples;
}

/// Joints whose corners are apart become rods. Gaps from rounding are noted as repairs.
void makeRods(const JointTable& rows, model::Model& model, std::vector<std::string>& warnings) {
  const double samePlace = samePlaceTolerance(model.tiles);
  RoundedCorners rounded(model);
  double shortest = std::numeric_limits<double>::max(), longest = 0;
  int rods = 0, firstLine = 0;
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    model::Joint& joint = model.joints[i];
    const double gap = startGap(model, joint);
    // The corners are one point within the precision of the file's digits: a pivot.
    if (gap <= samePlace) {
      rounded.add(joint, gap, kirireel::toString({rows.file, rows.rows[i].line}));
      continue;
    }
    joint = model::makeLink(model.tiles, joint.a, joint.b);
    shortest = std::min(shortest, gap);
    longest = std::max(longest, gap);
    if (rods++ == 0) firstLine = rows.rows[i].line;
  }
  rounded.note(model, warnings);
  if (rods == 0) return;
  const bool oneLength = longest - shortest <= samePlace;
  const std::string length = oneLength ? fmt::format("{:.4g}", longest)
                                       : fmt::format("{:.4g} to {:.4g}", shortest, longest);
  warnings.push_back(fmt::format("{}: note: {} of constant length, {} (corners clearly apart)",
                                 kirireel::toString({rows.file, firstLine}),
                                 counted(rods, "joint is a rod", "joints are rods"), length));
}

std::string planarJointText(const std::vector<model::Joint>& joints) {
  if (joints.empty()) return "# no joints\n";
  std::string text;
  for (const model::Joint& joint : joints) {
    text += fmt::format("{} {} {} {}\n", joint.a.tile + 1, joint.a.vertex + 1, joint.b.tile + 1,
                        joint.b.vertex + 1);
  }
  return text;
}

/// Planar files cannot hold heights or tiles that move as one. Returns the sheet's plane.
model::SheetFrame requirePlanar(const model::Model& model, const fs::path& file) {
  const std::optional<model::SheetFrame> frame = model::sheetFrame(model);
  if (!frame) {
    throw InputError(fmt::format(
        "{}: error: planar files have only x and y, but the start is not flat. Convert to a folder",
        file.string()));
  }
  // The reader makes links of joints whose corners are apart.
  requireKinds(model, {model::JointKind::Pivot, model::JointKind::Link},
               "planar files support only joints at corners", file);
  return *frame;
}

}  // namespace

void writePlanarFiles(const model::Model& inOrder, const fs::path& vertices) {
  const model::SheetFrame frame = requirePlanar(inOrder, vertices);
  const model::Model model = model::inFileOrder(inOrder);
  writeTextFile(vertices, unitLine(model.unit) + tilesText(model::toFrame(frame, model.tiles), 2));
  writeTextFile(partFile(vertices, "constraints"), planarJointText(model.joints));
  if (model.hull) writeTextFile(partFile(vertices, "hull"), hullText(*model.hull));
}

bool holdsPlanarModel(const fs::path& vertices) {
  if (!holdsPairs(vertices)) return false;
  const std::vector<fs::path> lists = jointLists(vertices);
  return std::none_of(lists.begin(), lists.end(), namesFaces);
}

model::Model readPlanarFiles(const fs::path& named, const ReadSettings& settings,
                             std::vector<std::string>& warnings) {
  const PlanarPlace place = planarPlace(named, settings.jointsFile);
  const TileTable tiles = readPlanarTiles(place.vertices);
  checkTiles(tiles);
  model::Model model;
  model.name = planarModelName(place.vertices);
  model.tiles = tiles.tiles;
  model.fileOrder.countsFrom = 1;
  JointTable rows = readPlanarJoints(place.joints, model, warnings);
  repairBase(rows, tiles, model, warnings);
  dropRepeatedJoints(rows, model, warnings);
  model.joints = checkedJoints(rows, tiles);
  makeRods(rows, model, warnings);
  if (settings.jointsFile.empty() && !place.otherJoints.empty()) {
    warnings.push_back(
        fmt::format("{}: note: these joints are used. Next to them are {} (see `joints_file`)",
                    place.joints.string(), fileNames(place.otherJoints)));
  }
  model.hull = hullBeside(place, model, warnings);
  turnClockwiseTiles(tiles, model, warnings);
  return model;
}

}  // namespace kirireel::formats
