// Selects a reader for a path, and completes the model in the same manner for all readers.
//
// The ending of a name decides, in upper or lower case. Two cases need the contents: vertices.txt
// can hold planar or spatial points, and a path can be a folder of either kind. After reading, the
// last digit of the coordinates is found for later tolerances, strict reading refuses repairs, and
// the target of another model replaces the model's own.
#include "sim/formats/read_model.h"

#include <algorithm>
#include <system_error>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/error.h"
#include "sim/base/file_kinds.h"
#include "sim/base/files.h"
#include "sim/base/words.h"
#include "sim/formats/drawing.h"
#include "sim/formats/joint_checks.h"
#include "sim/formats/model_formats.h"
#include "sim/formats/repairs.h"
#include "sim/formats/text_table.h"
#include "sim/formats/tile_checks.h"
#include "sim/formats/written_digits.h"

namespace kirireel::formats {
namespace {

namespace fs = std::filesystem;

/// Refuses another list of joints for a format that contains its joints.
void requireNoJointsFile(const fs::path& path, const ReadSettings& settings) {
  if (settings.jointsFile.empty()) return;
  throw inputErrorAt(
      {path},
      "this file contains its joints. Remove `joints_file`, or convert the model to a folder");
}

/// Refuses options that are for other formats.
void requireOwnOptions(const fs::path& path, const ReadSettings& settings) {
  const std::string ending = endingOf(path);
  const auto require = [&](bool isGiven, bool isOwn, const char* option, const char* formats) {
    if (!isGiven || isOwn) return;
    throw inputErrorAt({path}, fmt::format("{} is only for {}. Remove it", option, formats));
  };
  const bool isFold = ending == ".fold";
  const char* const kDrawings = "drawings (.svg, .dxf)";
  require(settings.frame.has_value(), isFold, "`frame`", ".fold files");
  require(settings.fold.has_value(), isFold, "`fold`", ".fold files");
  require(settings.joinCoplanar, ending == ".obj" || ending == ".ply", "`join_coplanar`",
          "OBJ and PLY meshes");
  require(!settings.cut.empty(), isDrawing(path), "`cut`", kDrawings);
  require(!settings.ignore.empty(), isDrawing(path), "`ignore`", kDrawings);
  require(settings.neckWidth > 0, isDrawing(path), "`widest_neck`", kDrawings);
  require(settings.areJointsInNecks, isDrawing(path), "`joint_at`", kDrawings);
}

// Selects the reader of a file by its ending.
model::Model readFile(const fs::path& path, const std::optional<fs::path>& target,
                      const ReadSettings& settings, std::vector<std::string>& warnings) {
  const std::string ending = endingOf(path);
  if (ending == ".txt" && isPlanarName(path)) {
    const fs::path vertices = planarVertices(path);
    // The files of a spatial folder have such names too.
    const bool isOfFolder = vertices.filename() == "vertices.txt" && !holdsPlanarModel(vertices);
    if (!isOfFolder) return readPlanarFiles(path, settings, warnings);
    const fs::path folder = vertices.has_parent_path() ? vertices.parent_path() : ".";
    ReadSettings own = settings;
    // If the user named a list of joints, use it with the other files of its folder.
    if (own.jointsFile.empty() && isJointList(path)) own.jointsFile = path;
    return readModelFolder(folder, own, warnings);
  }
  requireNoJointsFile(path, settings);
  if (ending == ".fold") return readFold(path, settings, warnings);
  if (ending == ".ply") return readPly(path, warnings, settings);
  if (isDrawing(path)) return readCutPattern(path, settings, warnings);
  if (ending == ".obj") {
    // A requested target replaces the sibling, so faults in the sibling do not matter.
    return readObjPair(path, target ? std::nullopt : deployedSibling(path), warnings, settings);
  }
  throw inputErrorAt(
      {path}, fmt::format("'{}' is not the ending of a model. Give {}", ending, kModelForms));
}

bool isPlanarFolder(const fs::path& folder) {
  const fs::path vertices = folder / "vertices.txt";
  return isFile(vertices) && holdsPlanarModel(vertices);
}

// Throws unless both models have the same tiles, with the same numbers of vertices.
void requireSameTiles(const model::Model& model, const model::Model& other, const fs::path& path) {
  const auto same = [](const model::Tile& a, const model::Tile& b) {
    return a.vertices.size() == b.vertices.size();
  };
  if (std::equal(model.tiles.begin(), model.tiles.end(), other.tiles.begin(), other.tiles.end(),
                 same)) {
    return;
  }
  throw inputErrorAt({path},
                     fmt::format("the target has {}, the model {}, with different numbers of "
                                 "vertices. Give the same tiles in the same order",
                                 counted(other.tiles.size(), "tile"), model.tiles.size()));
}

/// The start of another model in any format, with the model's order of vertices.
std::vector<model::Tile> startOf(const fs::path& path, const model::Model& model,
                                 bool joinCoplanar) {
  // The warnings about another model's start are not about this model.
  std::vector<std::string> ignored;
  ReadSettings settings;
  const std::string ending = endingOf(path);
  settings.joinCoplanar = joinCoplanar && (ending == ".obj" || ending == ".ply");
  settings.undeclaredUnit = model.unit;
  const model::Model other = readModel(path, std::nullopt, ignored, settings);
  requireSameTiles(model, other, path);
  // First to the order of the other model's file, which both models share, then to this model's
  // order.
  return model::inFileOrder(model::inFileOrder(other.tiles, other.fileOrder), model.fileOrder);
}

/// The file of a model's tiles.
fs::path tileFileOf(const fs::path& path) {
  if (!isFile(path)) return path / "vertices.txt";
  return endingOf(path) == ".txt" ? planarVertices(path) : path;
}

/// Readers return coordinates in the file's unit and the declared unit. Converts them to metres.
void applyUnit(model::Model& model, const fs::path& path, const ReadSettings& settings) {
  if (isDrawing(path)) return;  // a drawing has its own scale, see readCutPattern()
  // FOLD has a key for its unit, and no comments.
  if (endingOf(path) != ".fold") model.declaredUnit = unitInComments(tileFileOf(path));
  model.unit = settings.unit.value_or(model.declaredUnit.value_or(settings.undeclaredUnit));
  model::scaleLengths(model, model.declaredUnit.value_or(model.unit).metres);
}

}  // namespace

model::Model readModel(const fs::path& path, const std::optional<fs::path>& target,
                       std::vector<std::string>& warnings, const ReadSettings& settings) {
  requireOwnOptions(path, settings);
  model::Model model = isFile(path) ? readFile(path, target, settings, warnings)
                       : isPlanarFolder(path)
                           ? readPlanarFiles(path / "vertices.txt", settings, warnings)
                           : readModelFolder(path, settings, warnings);
  if (!isDrawing(path)) model.rounding = roundingOf(model.tiles);
  model.areCoplanarJoined = settings.joinCoplanar;
  applyUnit(model, path, settings);
  if (settings.strict) {
    refuseRepairs(model);
    if (!model.hullFault.empty()) throw InputError(model.hullFault);
  }
  if (target) {
    model.target = startOf(*target, model, settings.joinCoplanar);
    model.waypoints.clear();
    if (model.drawing) {
      model.drawing->givesTarget = false;
      for (model::Crease& crease : model.drawing->creases) crease.targetAngles.clear();
    }
  }
  model.rounding = std::max(model.rounding, misfitOf(model));
  return model;
}

std::vector<model::Tile> readTarget(const fs::path& path, const model::Model& model,
                                    std::vector<std::string>& warnings) {
  if (endingOf(path) == ".txt") {
    // Compared with the start in the file's unit.
    const double metres = unitInComments(path).value_or(model.unit).metres;
    model::Model inFile = model;
    model::scaleLengths(inFile, 1 / metres);
    inFile.target = readTargetFile(path, inFile, warnings);
    model::scaleLengths(inFile, metres);
    return *inFile.target;
  }
  return startOf(path, model, model.areCoplanarJoined);
}

void writeModel(const model::Model& inMetres, const fs::path& path) {
  const model::Model model = model::inUnit(inMetres, inMetres.unit);
  const std::string ending = endingOf(path);
  if (ending == ".fold") return writeFold(model, path);
  if (ending == ".obj") return writeObjPair(model, path);
  if (ending.empty()) return writeModelFolder(model, path);
  if (path.filename().string().ends_with("vertices.txt")) return writePlanarFiles(model, path);
  throw inputErrorAt(
      {path}, fmt::format("there is no format '{}'. Give an ending .fold or .obj, a name that ends "
                          "with vertices.txt for planar files, or no ending for a folder",
                          ending));
}

// ------------------------------------------------------------------------------------------------
// Reads and writes PyKirigami's folders.
//
// Files are read in the order of their dependence: tiles, joints, target, hull, pulled tiles. Each
// file is checked at once, so the first message names the file with the fault and not a
// consequence. Repairs (repairs.h) come before the checks that would otherwise fail. The reversal
// of clockwise tiles comes last, because it renumbers all corners.
//
// Numbers have the shortest digits that read back as the same double. Reading and writing a folder
// therefore keeps the model to the last bit.

namespace {

const std::string kTilePurpose = "write one tile per line, \"x y z\" for each vertex";
const std::string kJointPurpose =
    "write one joint per line, \"tileA vertexA tileB vertexB face\", or the line \"# no joints\" "
    "if the tiles are loose";
const std::string kPullPurpose =
    "list the numbers of the tiles to pull, or delete the file to pull all";

const std::string kHullPurpose =
    "write one corner of the sheet's outline per line, \"tile vertex\", in order, at least 3";

const std::string kNeckPurpose =
    "write one neck per line, \"joint width length kerf\". Joints are rows of constraints.txt, "
    "from 0";

void requireFolder(const fs::path& folder) {
  const std::string repair = "give a folder with vertices.txt and constraints.txt";
  if (!isPresent(folder)) {
    throw inputErrorAt({folder}, fmt::format("{}; {}", whyAbsent(folder, "folder"), repair));
  }
  if (!isFolder(folder)) {
    throw inputErrorAt({folder}, fmt::format("this is not a folder; {}", repair));
  }
}

/// Also correct for "data/heart/" and ".", whose own filename is empty.
std::string folderName(const fs::path& folder) {
  const fs::path whole = fs::absolute(folder).lexically_normal();
  return whole.has_filename() ? whole.filename().string() : whole.parent_path().filename().string();
}

// A line holds three numbers for each of at least three vertices.
void requireWholeVertices(const TextTable& text, const TextLine& line, size_t tile, size_t count) {
  // The message points at the first number of the incomplete vertex.
  const size_t left = count % 3;
  if (left != 0) {
    throw inputErrorAt(text.at(line, line.fields[count - left]),
                       fmt::format("tile {} has {} numbers, not three for each vertex; the vertex "
                                   "that starts here has only {}: complete it or delete it",
                                   tile, count, left));
  }
  if (count < 9) {
    throw inputErrorAt({text.file(), line.number},
                       fmt::format("tile {} has {} vertices; a tile has at least 3: add the "
                                   "missing ones or delete the line",
                                   tile, count / 3));
  }
}

/// Number of values without padding at the end: NaN, or repetitions of the last or first vertex.
/// Only the end is trimmed, because joints refer to vertex numbers.
std::size_t countWithoutPadding(const TextLine& line) {
  const auto at = [&](std::size_t k) { return line.fields[k].text; };
  const auto isSame = [&](std::size_t a, std::size_t b) {
    double first = 0, second = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const bool areNumbers = readNumber(at(a + axis), first) && readNumber(at(b + axis), second);
      if (!areNumbers || first != second) return false;
    }
    return true;
  };
  std::size_t count = line.fields.size();
  while (count >= 3 && isNan(at(count - 1)) && isNan(at(count - 2)) && isNan(at(count - 3))) {
    count -= 3;
  }
  while (count >= 6 && isSame(count - 3, count - 6)) count -= 3;
  while (count >= 6 && isSame(count - 3, 0)) count -= 3;
  return count;
}

// Tiles with the positions of their vertices in the file, for messages.
TileTable readTiles(const fs::path& file) {
  TextTable text(file, kTilePurpose);
  TileTable table;
  table.file = file;
  TextLine line;
  while (text.next(line)) {
    requireWholeVertices(text, line, table.tiles.size(), line.fields.size());
    const std::size_t count = countWithoutPadding(line);
    // If few vertices remain, a word that is not a number is the more likely mistake.
    for (std::size_t k = 0; count < line.fields.size() && k < count; ++k) {
      parseCoordinate(line.fields[k], text.at(line, line.fields[k]));
    }
    requireWholeVertices(text, line, table.tiles.size(), count);
    model::Tile& tile = table.tiles.emplace_back();
    TileSource& source = table.sources.emplace_back();
    source.line = line.number;
    for (size_t k = 0; k < count; k += 3) {
      const auto coordinate = [&](size_t axis) {
        const TextField& field = line.fields[k + axis];
        return parseCoordinate(field, text.at(line, field));
      };
      tile.vertices.push_back(Vector3{coordinate(0), coordinate(1), coordinate(2)});
      source.columns.push_back(line.fields[k].column);
    }
    if (count < line.fields.size())
      table.padded.push_back(static_cast<int>(table.tiles.size()) - 1);
  }
  if (table.tiles.empty()) {
    throw inputErrorAt({file}, fmt::format("the file has no tile; {}", kTilePurpose));
  }
  return table;
}

// Four or five whole numbers. Later checks test whether they exist, when the base is known.
JointRow readJointRow(const TextTable& text, const TextLine& line) {
  const size_t count = line.fields.size();
  if (count != 4 && count != 5) {
    throw inputErrorAt({text.file(), line.number},
                       fmt::format("a joint does not have {} numbers. Write \"tileA vertexA tileB "
                                   "vertexB\", and optionally a face (1 bottom, 2 top, 3 both)",
                                   count));
  }
  static const std::string kMeanings[] = {"a tile number", "a vertex number", "a tile number",
                                          "a vertex number", "a face"};
  JointRow row;
  row.line = line.number;
  row.values[4] = static_cast<int>(model::JointFace::Bottom);
  for (size_t k = 0; k < count; ++k) {
    const TextField& field = line.fields[k];
    row.values[k] = parseWholeNumber(field, text.at(line, field), kMeanings[k]);
    row.columns[k] = field.column;
  }
  return row;
}

JointTable readJointRows(const fs::path& file, model::Model& model,
                         std::vector<std::string>& warnings) {
  TextTable text(file, kJointPurpose);
  JointTable table;
  table.file = file;
  TextLine line;
  while (text.next(line)) table.rows.push_back(readJointRow(text, line));
  if (table.rows.empty() && !text.hasComment()) noteNoJoints(file, model, warnings);
  return table;
}

/// The necks of the joints of constraints.txt.
void readNecks(const fs::path& file, JointTable& joints) {
  TextTable text(file, kNeckPurpose);
  TextLine line;
  while (text.next(line)) {
    if (line.fields.size() != 4) {
      throw inputErrorAt({file, line.number}, fmt::format("a neck does not have {} numbers; {}",
                                                          line.fields.size(), kNeckPurpose));
    }
    const auto at = [&](std::size_t k) { return text.at(line, line.fields[k]); };
    const auto length = [&](std::size_t k) { return parseCoordinate(line.fields[k], at(k)); };
    const int joint = parseWholeNumber(line.fields[0], at(0), "a joint number");
    setNeck(joint, {length(1), length(2), length(3)}, {file, line.number}, joints);
  }
}

// Zero-based numbers, any number per line.
std::vector<int> readPulledTiles(const fs::path& file, int tileCount) {
  TextTable text(file, kPullPurpose);
  std::vector<int> pulled;
  TextLine line;
  while (text.next(line)) {
    for (const TextField& field : line.fields) {
      const int tile = parseWholeNumber(field, text.at(line, field), "a tile number");
      if (tile < 0 || tile >= tileCount) {
        throw inputErrorAt(text.at(line, field),
                           fmt::format("vertices.txt has tiles 0-{}, not {}; correct this number",
                                       tileCount - 1, tile));
      }
      pulled.push_back(tile);
    }
  }
  if (pulled.empty()) {
    throw inputErrorAt({file}, fmt::format("the file has no tile numbers; {}", kPullPurpose));
  }
  return pulled;
}

/// "tile vertex" pairs.
std::vector<model::Corner> readHull(const fs::path& file, const std::vector<model::Tile>& tiles) {
  TextTable text(file, kHullPurpose);
  std::vector<model::Corner> hull;
  TextLine line;
  while (text.next(line)) {
    if (line.fields.size() != 2) {
      throw inputErrorAt({file, line.number}, fmt::format("a corner does not have {} numbers; {}",
                                                          line.fields.size(), kHullPurpose));
    }
    const auto number = [&](std::size_t k, const char* meaning, std::size_t count) {
      const FileLocation where = text.at(line, line.fields[k]);
      const int value = parseWholeNumber(line.fields[k], where, meaning);
      if (value >= 0 && value < static_cast<int>(count)) return value;
      throw inputErrorAt(where, fmt::format("{} must be in [0, {}], not {}. Correct this column",
                                            meaning, count - 1, value));
    };
    const int tile = number(0, "a tile number", tiles.size());
    hull.push_back({tile, number(1, "a vertex number", tiles[tile].vertices.size())});
  }
  if (hull.size() >= 3) return hull;
  throw inputErrorAt({file},
                     fmt::format("{} corners enclose nothing; {}", hull.size(), kHullPurpose));
}

/// Requires a free path: models may be drawn by hand, so files are never overwritten or mixed.
void requireFree(const fs::path& file, const std::string& text) {
  std::error_code ignored;
  if (!fs::exists(fs::symlink_status(file, ignored))) return;
  // A file with the same contents is allowed. The same model can thus be written twice.
  if (isFile(file) && !text.empty() && readTextFile(file, "") == text) return;
  throw InputError(fmt::format(
      "{}: error: this file belongs to another model. Move it, or choose another folder",
      file.string()));
}

// Writes a comment if there are no joints, because an empty file would look like a mistake.
std::string jointText(const std::vector<model::Joint>& joints) {
  if (joints.empty()) return "# no joints\n";
  std::string text;
  for (const model::Joint& joint : joints) {
    text += fmt::format("{} {} {} {} {}\n", joint.a.tile, joint.a.vertex, joint.b.tile,
                        joint.b.vertex, static_cast<int>(joint.face));
  }
  return text;
}

/// Empty if no joint has a neck.
std::string neckText(const std::vector<model::Joint>& joints) {
  std::string text;
  for (std::size_t k = 0; k < joints.size(); ++k) {
    const model::Neck& neck = joints[k].neck;
    if (neck) text += fmt::format("{} {} {} {}\n", k, neck.width, neck.length, neck.kerf);
  }
  return text;
}

// An existing path as given has priority over one within the folder.
fs::path jointsFileOf(const fs::path& folder, const ReadSettings& settings) {
  if (settings.jointsFile.empty()) return folder / "constraints.txt";
  return namedFile(settings.jointsFile, folder);
}

}  // namespace

model::Model readModelFolder(const fs::path& folder, const ReadSettings& settings,
                             std::vector<std::string>& warnings) {
  requireFolder(folder);
  const TileTable tiles = readTiles(folder / "vertices.txt");
  checkTiles(tiles);
  model::Model model;
  model.name = folderName(folder);
  model.tiles = tiles.tiles;
  notePadding(tiles, model, warnings);

  JointTable joints = readJointRows(jointsFileOf(folder, settings), model, warnings);
  const bool hasOwnJoints = joints.file.lexically_normal().filename() == "constraints.txt";
  if (hasOwnJoints && isPresent(folder / "necks.txt")) readNecks(folder / "necks.txt", joints);
  repairBase(joints, tiles, model, warnings);
  dropRepeatedJoints(joints, model, warnings);
  model.joints = checkedJoints(joints, tiles);
  checkClosed(joints, model, tiles, warnings);

  if (isPresent(folder / "target.txt")) {
    const TileTable target = readTiles(folder / "target.txt");
    checkTargets({target}, model, tiles, warnings);
    model.target = target.tiles;
  }
  if (isPresent(folder / "hull.txt")) model.hull = readHull(folder / "hull.txt", model.tiles);
  if (isPresent(folder / "pull.txt")) {
    model.pulledTiles = readPulledTiles(folder / "pull.txt", static_cast<int>(model.tiles.size()));
  }
  turnClockwiseTiles(tiles, model, warnings);
  return model;
}

model::Model readModelFolder(const fs::path& folder, std::vector<std::string>& warnings) {
  return readModelFolder(folder, {}, warnings);
}

std::vector<model::Tile> readTargetFile(const fs::path& file, const model::Model& model,
                                        std::vector<std::string>& warnings) {
  const TileTable target = readTiles(file);
  const model::Model asInFile = model::inFileOrder(model);
  TileTable start{model.name, asInFile.tiles, {}};
  start.countsFrom = model.fileOrder.countsFrom;
  for (std::size_t i = 0; i < model.tiles.size(); ++i) {
    start.sources.push_back({static_cast<int>(i) + 1, {}});
  }
  checkTargets({target}, asInFile, start, warnings);
  return model::inFileOrder(target.tiles, model.fileOrder);
}

std::vector<model::Tile> readTileFile(const fs::path& file) {
  return readTiles(file).tiles;
}

std::string tilesText(const std::vector<model::Tile>& tiles, int dimensions) {
  std::string text;
  for (const model::Tile& tile : tiles) {
    const char* separator = "";
    for (const Vector3& vertex : tile.vertices) {
      // "{}" writes the shortest digits that read back as the same double.
      text +=
          fmt::format("{}{}", separator, fmt::join(vertex.data(), vertex.data() + dimensions, " "));
      separator = " ";
    }
    text += '\n';
  }
  return text;
}

std::string hullText(const std::vector<model::Corner>& hull) {
  std::string text;
  for (const model::Corner& corner : hull)
    text += fmt::format("{} {}\n", corner.tile, corner.vertex);
  return text;
}

void writeModelFolder(const model::Model& inOrder, const fs::path& folder) {
  const model::Model model = model::inFileOrder(inOrder);
  requireKinds(model, {model::JointKind::Pivot}, "constraints.txt supports only joints at corners",
               folder);
  // An empty text means that the file must not exist.
  const std::vector<std::pair<const char*, std::string>> files = {
      {"vertices.txt", unitLine(model.unit) + tilesText(model.tiles, 3)},
      {"constraints.txt", jointText(model.joints)},
      {"necks.txt", neckText(model.joints)},
      {"target.txt", model.target ? tilesText(*model.target, 3) : ""},
      {"pull.txt",
       model.pulledTiles ? fmt::format("{}\n", fmt::join(*model.pulledTiles, "\n")) : ""},
      {"hull.txt", model.hull ? hullText(*model.hull) : ""}};
  // Checks all files before writing the first one. A refusal then leaves nothing behind.
  for (const auto& [name, text] : files) requireFree(folder / name, text);
  makeFolder(folder);
  for (const auto& [name, text] : files) {
    if (!text.empty()) writeTextFile(folder / name, text);
  }
}

void writeTiles(const std::vector<model::Tile>& tiles, const fs::path& file,
                const LengthUnit& unit) {
  writeTextFile(file, unitLine(unit) + tilesText(tiles, 3));
}

}  // namespace kirireel::formats
