// Which files beside each other make one planar model.
//
// Programs leave many files in one folder, told apart by their names alone. What a file holds is
// said by the last of the words "vertices", "constraints" and "hull" in its name, because a model
// may be called "hull" itself. The part of a name before "vertices" is the prefix of a model; every
// other file belongs to the model with the longest prefix that begins its name. Of several lists of
// joints the one is chosen that the user named, directly or by the hull that goes with it; else the
// one that is called as the vertices are; else the only one. Nothing is guessed beyond that:
// several lists without a usual name are refused with their names.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <regex>
#include <string_view>
#include <system_error>
#include <unordered_map>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/error.h"
#include "sim/base/files.h"
#include "sim/model/model_checks.h"
#include "sim/model/model_formats.h"
#include "sim/model/text_table.h"

namespace kirireel::model {
namespace {

namespace fs = std::filesystem;

constexpr const char* kVertices = "vertices";
constexpr const char* kConstraints = "constraints";
constexpr const char* kHull = "hull";

/// The word that says what a file holds; "" for another file. The words before it are of the
/// model's name, or name a variant.
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

/// The part of a name before one of the three words: "penrose_" of penrose_vertices.txt.
std::string prefixOf(const fs::path& vertices) {
  const std::string stem = vertices.stem().string();
  return stem.substr(0, stem.rfind(kVertices));
}

// All text files in the folder of this one, by name.
std::vector<fs::path> textFilesBeside(const fs::path& file) {
  const fs::path folder = file.has_parent_path() ? file.parent_path() : ".";
  std::vector<fs::path> files;
  // A folder that cannot be listed counts as empty: opening the named file gives a better message.
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    if (endingOf(entry.path()) != ".txt" || !entry.is_regular_file(ignored)) continue;
    files.push_back(file.parent_path() / entry.path().filename());
  }
  // The system lists files in any order.
  std::sort(files.begin(), files.end());
  return files;
}

/// Of the files of vertices the one whose prefix begins the name, the longest of them.
std::optional<fs::path> ownerOf(const fs::path& file, const std::vector<fs::path>& beside) {
  std::optional<fs::path> owner;
  for (const fs::path& vertices : beside) {
    if (wordOf(vertices) != kVertices) continue;
    if (!file.filename().string().starts_with(prefixOf(vertices))) continue;
    if (!owner || prefixOf(vertices).size() > prefixOf(*owner).size()) owner = vertices;
  }
  return owner;
}

/// The files of a model that hold what the word says.
std::vector<fs::path> partsOfModel(const fs::path& vertices, const std::string& word) {
  const std::vector<fs::path> beside = textFilesBeside(vertices);
  std::vector<fs::path> parts;
  for (const fs::path& file : beside) {
    if (wordOf(file) == word && ownerOf(file, beside) == vertices) parts.push_back(file);
  }
  return parts;
}

/// The same name with another word in place of one of the three.
fs::path withWord(const fs::path& file, const std::string& word, const std::string& other) {
  std::string name = file.filename().string();
  const std::size_t at = name.rfind(word);
  if (at != name.npos) name.replace(at, word.size(), other);
  return file.parent_path() / name;
}

bool contains(const std::vector<fs::path>& files, const fs::path& file) {
  return std::find(files.begin(), files.end(), file) != files.end();
}

/// The list that the user named: a path, or the name of one beside the vertices.
fs::path namedList(const fs::path& jointsFile, const fs::path& vertices) {
  const fs::path beside = vertices.parent_path() / jointsFile;
  return fs::exists(jointsFile) || !fs::exists(beside) ? jointsFile : beside;
}

// What the user named, else what goes with it, else the usual name, else the only one.
fs::path chosenList(const fs::path& named, const fs::path& vertices,
                    const std::vector<fs::path>& lists) {
  if (wordOf(named) == kConstraints) return named;
  if (wordOf(named) == kHull) {
    const fs::path partner = withWord(named, kHull, kConstraints);
    if (contains(lists, partner)) return partner;
  }
  const fs::path usual = withWord(vertices, kVertices, kConstraints);
  if (contains(lists, usual)) return usual;
  if (lists.size() == 1) return lists.front();
  if (lists.empty()) {
    throw inputErrorAt({vertices}, fmt::format("there is no list of joints beside it; write {}, or "
                                               "name one with --joints-file",
                                               usual.filename().string()));
  }
  throw inputErrorAt({vertices}, fmt::format("there are {} lists of joints beside it: {}; choose "
                                             "one with --joints-file",
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
  const std::optional<fs::path> owner = ownerOf(file, textFilesBeside(file));
  if (owner) return *owner;
  throw inputErrorAt({file},
                     "no file of vertices beside it has a name that begins like this one; "
                     "put NAME_vertices.txt there");
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
                                    : namedList(jointsFile, place.vertices);
  place.hull = chosenHull(named, place.joints, place.otherHulls);
  remove(place.otherJoints, place.joints);
  if (place.hull) remove(place.otherHulls, *place.hull);
  return place;
}

// ------------------------------------------------------------------------------------------------
// The planar text files of the quasicrystal kirigami simulator: vertices, constraints, hull.
//
// Two conventions of that program matter here. Tiles and vertices count from 1 in the lists of
// joints and from 0 in the hulls. And a joint holds its two vertices at the distance that they have
// at the start: 0 makes a pivot, anything else a rod (a link here). A model in the plane has no
// faces, so that pivots are on both faces of the bricks, which makes them hinges about the
// vertical.
//
// L. Liu, G. P. T. Choi, L. Mahadevan, Quasicrystal kirigami, Physical Review Research 4, 2022.

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
      rounded.add(joint, gap, kirireel::toString({rows.file, rows.rows[i].line}));
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
                  kirireel::toString({rows.file, firstLine}), rods, rods == 1 ? " holds" : "s hold",
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
  const int first = model.fileOrder.countsFrom;
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
                    file.string(), first + joint.a.tile, first + joint.b.tile));
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

// ------------------------------------------------------------------------------------------------
// From lines back to tiles.
//
// A cut pattern draws each side of a tile as a line in the sense in which the tile runs (its inside
// on the left), sides that two tiles share once, as slits. Beside each joint at m a neck of
// material stays: the two sides round the narrower gap end before m. A line on the layer of hinges
// leads from m to the middle between their ends, h; where the gap is open, a cut joins these ends.
//
// 1. *Necks* are taken out: cuts whose middle is the h of a hinge.
// 2. *Ends* that a hinge shortened go back to its m: those at its h, at the ends of its neck, or
//    ends of a single line that points at an m (where several hinges shortened one side).
// 3. *Tiles* are the cycles of directed sides. At a vertex the next side is the one that is met
//    first when turning clockwise from the way back: what lies between is the tile's own corner.
// 4. *Joints*: the corners at m whose sides bound the gap that the hinge's line lies in.
//
// Step 3 walks the faces of a planar straight-line graph, as in a doubly connected edge list (M. de
// Berg, O. Cheong, M. van Kreveld, M. Overmars, Computational Geometry, chapter 2). Cuts have a
// tile on one side only, so that they are walked in one direction; slits have one on both.
//
// Points are compared through a grid of cells, so that a pattern of n lines costs about O(n), but
// for ends that step 2 has to try with every neck. All tolerances are parts of the pattern's size:
// 1e-7 for points, ten times that where an end was computed from a neck, a hundred times that for
// directions that were written with few digits.

namespace {

namespace fs = std::filesystem;
using Vector2 = Eigen::Vector2d;

constexpr const char* kPatternPurpose = "give a cut pattern that `kirireel export` left";
// Points nearer than this part of the pattern's size are one.
constexpr double kSamePatternPoint = 1e-7;
// Sides that differ by less than this angle, radians, leave in one direction.
constexpr double kSamePatternDirection = 1e-6;
constexpr double kTurn = 2 * std::numbers::pi;

enum class LineLayer { Cuts, Slits, Hinges, Other };

// Other names are of layers that the pattern's readers may have added.
LineLayer layerNamed(std::string_view name) {
  return name == "cuts"     ? LineLayer::Cuts
         : name == "slits"  ? LineLayer::Slits
         : name == "hinges" ? LineLayer::Hinges
                            : LineLayer::Other;
}

struct DrawnLine {
  LineLayer layer = LineLayer::Cuts;
  Vector2 from = Vector2::Zero();
  Vector2 to = Vector2::Zero();
};

InputError patternFault(const fs::path& file, const std::string& what) {
  return inputErrorAt({file}, fmt::format("{}; {}", what, kPatternPurpose));
}

// A number of the file times `scale`, as metres.
double patternNumber(std::string_view text, const fs::path& file, double scale) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool isNumber = error == std::errc() && end == text.data() + text.size();
  if (isNumber && std::isfinite(value) && std::abs(scale * value) <= kMaxCoordinate) {
    return scale * value;
  }
  throw patternFault(
      file, fmt::format("'{}' is no coordinate within {:g} m", shown(text, 24), kMaxCoordinate));
}

std::vector<std::string_view> words(std::string_view text) {
  std::vector<std::string_view> found;
  constexpr std::string_view kBlank = " \t\r\n";
  std::size_t begin = text.find_first_not_of(kBlank);
  while (begin != text.npos) {
    const std::size_t end = std::min(text.find_first_of(kBlank, begin), text.size());
    found.push_back(text.substr(begin, end - begin));
    begin = text.find_first_not_of(kBlank, end);
  }
  return found;
}

/// The value of an attribute of a tag; none where it has no such attribute.
std::optional<std::string_view> attribute(std::string_view tag, const std::string& name) {
  // The blank before the name keeps "id" from matching within "data-id".
  const std::string key = " " + name + "=\"";
  const std::size_t at = tag.find(key);
  if (at == tag.npos) return std::nullopt;
  const std::string_view rest = tag.substr(at + key.size());
  const std::size_t end = rest.find('"');
  if (end == rest.npos) return std::nullopt;
  return rest.substr(0, end);
}

/// Groups named by their layer, in them paths "M x y L x y" in millimetres, y downwards.
std::vector<DrawnLine> svgLines(const std::string& text, const fs::path& file) {
  constexpr double kMillimetre = 1e-3;
  std::vector<DrawnLine> lines;
  LineLayer layer = LineLayer::Other;
  for (std::size_t at = text.find('<'); at != text.npos; at = text.find('<', at + 1)) {
    const std::size_t end = std::min(text.find('>', at), text.size());
    const std::string_view tag = std::string_view(text).substr(at, end - at);
    if (tag.starts_with("<g")) layer = layerNamed(attribute(tag, "id").value_or(""));
    if (tag.starts_with("</g")) layer = LineLayer::Other;
    if (!tag.starts_with("<path") || layer == LineLayer::Other) continue;
    const std::vector<std::string_view> parts = words(attribute(tag, "d").value_or(""));
    if (parts.size() != 6 || parts[0] != "M" || parts[3] != "L") {
      throw patternFault(file, "a path is no straight line \"M x y L x y\"");
    }
    const auto point = [&](std::size_t k) {
      return Vector2(patternNumber(parts[k], file, kMillimetre),
                     0.0 - patternNumber(parts[k + 1], file, kMillimetre));
    };
    lines.push_back({layer, point(1), point(4)});
  }
  return lines;
}

/// Entities LINE on layers, in the file's unit.
std::vector<DrawnLine> dxfLines(const std::string& text, const fs::path& file) {
  std::vector<DrawnLine> lines;
  std::map<int, std::string_view> entity;  // by group codes
  std::size_t at = 0;
  const auto nextLine = [&]() -> std::optional<std::string_view> {
    if (at >= text.size()) return std::nullopt;
    const std::size_t end = std::min(text.find('\n', at), text.size());
    std::string_view line = std::string_view(text).substr(at, end - at);
    at = end + 1;
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.remove_suffix(1);
    while (!line.empty() && line.front() == ' ') line.remove_prefix(1);
    return line;
  };
  const auto finish = [&] {
    if (!entity.contains(0) || entity[0] != "LINE") return;
    const LineLayer layer = layerNamed(entity.contains(8) ? entity[8] : "");
    if (layer == LineLayer::Other) return;
    std::array<double, 4> numbers{};
    constexpr std::array<int, 4> kCodes = {10, 20, 11, 21};
    for (std::size_t k = 0; k < 4; ++k) {
      if (!entity.contains(kCodes[k])) throw patternFault(file, "a LINE lacks an end");
      numbers[k] = patternNumber(entity[kCodes[k]], file, 1);
    }
    lines.push_back({layer, {numbers[0], numbers[1]}, {numbers[2], numbers[3]}});
  };
  while (const std::optional<std::string_view> code = nextLine()) {
    const std::optional<std::string_view> value = nextLine();
    int number = -1;
    const auto [end, error] = std::from_chars(code->data(), code->data() + code->size(), number);
    if (!value || error != std::errc() || end != code->data() + code->size()) {
      throw patternFault(file, "its lines are no pairs of group codes and values");
    }
    // Group code 0 begins the next entity, which ends the one before.
    if (number == 0) {
      finish();
      entity.clear();
    }
    entity[number] = *value;
  }
  finish();
  return lines;
}

/// What $INSUNITS says, with the group code 70; absent if there is none or it means no unit.
std::optional<LengthUnit> dxfUnit(const std::string& text) {
  static const std::regex pattern("\\$INSUNITS\\s+70\\s+(\\d+)");
  std::smatch match;
  if (!std::regex_search(text, match, pattern)) return std::nullopt;
  const std::string number = match[1];
  const auto found = std::ranges::find_if(lengthUnits(), [&](const LengthUnit& unit) {
    return unit.dxfNumber != 0 && std::to_string(unit.dxfNumber) == number;
  });
  return found == lengthUnits().end() ? std::nullopt : std::optional(*found);
}

/// Points of the plane, those within a tolerance as one, by number.
class PointNumbers {
 public:
  /// Cells are counted from `origin`, a point of the pattern, so that their numbers stay small.
  PointNumbers(double tolerance, const Vector2& origin) : tolerance_(tolerance), origin_(origin) {}

  /// The number of the known point there; none where there is none.
  std::optional<int> find(const Vector2& point) const {
    // Cells are as wide as the tolerance, so that a point within it is in this cell or in one
    // beside it.
    const auto [column, row] = cellOf(point);
    for (long x = column - 1; x <= column + 1; ++x) {
      for (long y = row - 1; y <= row + 1; ++y) {
        const auto cell = cells_.find(key(x, y));
        if (cell == cells_.end()) continue;
        for (const int number : cell->second) {
          if ((points_[number] - point).norm() <= tolerance_) return number;
        }
      }
    }
    return std::nullopt;
  }

  // The number of the point, which is a new one where none is near.
  int add(const Vector2& point) {
    if (const std::optional<int> known = find(point)) return *known;
    const auto [column, row] = cellOf(point);
    points_.push_back(point);
    cells_[key(column, row)].push_back(static_cast<int>(points_.size()) - 1);
    return static_cast<int>(points_.size()) - 1;
  }

  const Vector2& operator[](int number) const { return points_[number]; }
  int count() const { return static_cast<int>(points_.size()); }

 private:
  // Whole numbers of the cell that holds a point, counted from the origin of the grid.
  std::pair<long, long> cellOf(const Vector2& point) const {
    const Vector2 steps = (point - origin_) / tolerance_;
    return {std::lround(steps.x()), std::lround(steps.y())};
  }
  /// Cells that share a key by chance only cost time: points are compared themselves.
  static long key(long x, long y) {
    return static_cast<long>(static_cast<unsigned long>(x) * 1000003UL +
                             static_cast<unsigned long>(y));
  }

  double tolerance_;
  Vector2 origin_;
  std::vector<Vector2> points_;
  std::unordered_map<long, std::vector<int>> cells_;
};

double angleOf(const Vector2& direction) {
  return std::atan2(direction.y(), direction.x());
}

/// An angle in [-kSamePatternDirection, 2 pi - kSamePatternDirection).
double turnedBy(double angle) {
  double turn = std::fmod(angle, kTurn);
  if (turn < -kSamePatternDirection) turn += kTurn;
  return turn >= kTurn - kSamePatternDirection ? turn - kTurn : turn;
}

struct Neck {
  Vector2 joint;   ///< m
  Vector2 middle;  ///< h
};

/// A side of a tile from point to point, its tile on the left.
struct DirectedSide {
  int from = 0;
  int to = 0;
  int twin = -1;  ///< the same slit the other way; -1 of cuts
  int tile = -1;
  int vertex = -1;  ///< where it starts within its tile
};

class PatternReader {
 public:
  PatternReader(std::vector<DrawnLine> lines, const fs::path& file)
      : lines_(std::move(lines)),
        file_(file),
        tolerance_(kSamePatternPoint * sizeOf(lines_)),
        origin_(lines_.empty() ? Vector2(0, 0) : lines_.front().from),
        points_(tolerance_, origin_) {
    if (!(tolerance_ > 0)) throw patternFault(file_, "there are no lines of a sheet in it");
    takeNecks();
    restoreEnds();
    for (int k = 0; k < std::ssize(sides_); ++k) leaving_[sides_[k].from].push_back(k);
    for (int k = 0; k < std::ssize(sides_); ++k) {
      // The other sides of slits come last, so that tiles begin with lines of their own.
      if (!isReverse_[k] && sides_[k].tile < 0) traceTile(k);
    }
    for (int k = 0; k < std::ssize(sides_); ++k) {
      if (sides_[k].tile < 0) traceTile(k);
    }
  }

  // One tile for each cycle, in the order in which they were traced.
  std::vector<Tile> tiles() const {
    std::vector<Tile> tiles;
    for (const std::vector<int>& cycle : cycles_) {
      Tile& tile = tiles.emplace_back();
      for (const int side : cycle) {
        const Vector2& point = points_[sides_[side].from];
        tile.vertices.emplace_back(point.x(), point.y(), 0);
      }
    }
    return tiles;
  }

  // One joint for each hinge that was drawn.
  std::vector<Joint> joints() {
    std::vector<Joint> joints;
    for (const Neck& neck : necks_) joints.push_back(jointAt(neck));
    return joints;
  }

 private:
  // The diagonal of the box round all lines, metres.
  static double sizeOf(const std::vector<DrawnLine>& lines) {
    Eigen::AlignedBox2d box;
    for (const DrawnLine& line : lines) box.extend(line.from).extend(line.to);
    return box.isEmpty() ? 0 : box.diagonal().norm();
  }

  /// Steps 1: hinges, their necks, and which ends they shortened.
  void takeNecks() {
    PointNumbers middles(10 * tolerance_, origin_);
    for (const DrawnLine& line : lines_) {
      if (line.layer != LineLayer::Hinges) continue;
      necks_.push_back({line.from, line.to});
      const int middle = middles.add(line.to);
      if (middle < std::ssize(neckAt_)) continue;
      neckAt_.push_back(static_cast<int>(necks_.size()) - 1);
    }
    shortened_ = PointNumbers(10 * tolerance_, origin_);
    for (const int neck : neckAt_) addShortened(necks_[neck].middle, neck);
    std::erase_if(lines_, [&](const DrawnLine& line) {
      if (line.layer == LineLayer::Hinges) return true;
      if (line.layer != LineLayer::Cuts) return false;
      const auto middle = middles.find(0.5 * (line.from + line.to));
      if (!middle) return false;
      const int neck = neckAt_[*middle];
      const Vector2& joint = necks_[neck].joint;
      const double uneven = std::abs((line.from - joint).norm() - (line.to - joint).norm());
      if (uneven > 100 * tolerance_) return false;
      addShortened(line.from, neck);
      addShortened(line.to, neck);
      return true;
    });
  }

  // Notes that the hinge has shortened a side to this point. The first hinge there counts.
  void addShortened(const Vector2& point, int neck) {
    const int number = shortened_.add(point);
    if (number == std::ssize(shortenedBy_)) shortenedBy_.push_back(neck);
  }

  /// Whether a line from `other` through `end` leads on to the joint.
  bool pointsAt(const Vector2& joint, const Vector2& other, const Vector2& end) const {
    const Vector2 along = (end - other).normalized();
    const Vector2 rest = joint - end;
    const double ahead = rest.dot(along);
    return ahead > 0 && (rest - ahead * along).norm() <= 100 * tolerance_;
  }

  /// Step 2.
  void restoreEnds() {
    std::unordered_map<int, int> uses;
    PointNumbers ends(tolerance_, origin_);
    for (const DrawnLine& line : lines_) {
      ++uses[ends.add(line.from)];
      ++uses[ends.add(line.to)];
    }
    for (const Neck& neck : necks_) points_.add(neck.joint);
    for (const DrawnLine& line : lines_) {
      const auto wholeEnd = [&](const Vector2& end, const Vector2& other) {
        const std::optional<int> known = shortened_.find(end);
        if (known && pointsAt(necks_[shortenedBy_[*known]].joint, other, end)) {
          return necks_[shortenedBy_[*known]].joint;
        }
        const bool isLoose = uses[*ends.find(end)] == 1 && !points_.find(end);
        return isLoose ? jointAhead(end, other) : end;
      };
      const Vector2 from = wholeEnd(line.from, line.to);
      const Vector2 to = wholeEnd(line.to, line.from);
      addSide(points_.add(from), points_.add(to), line.layer == LineLayer::Slits);
    }
  }

  // The nearest joint in the direction in which a line ends.
  Vector2 jointAhead(const Vector2& end, const Vector2& other) const {
    const Neck* nearest = nullptr;
    for (const Neck& neck : necks_) {
      if (!pointsAt(neck.joint, other, end)) continue;
      if (!nearest || (neck.joint - end).norm() < (nearest->joint - end).norm()) nearest = &neck;
    }
    if (nearest) return nearest->joint;
    throw patternFault(file_, fmt::format("the line that ends at ({:.6g}, {:.6g}) m leads nowhere",
                                          end.x(), end.y()));
  }

  // A slit becomes two sides, one for each of its tiles; a cut has a tile on its left alone.
  void addSide(int from, int to, bool isSlit) {
    if (from == to) throw patternFault(file_, "a line has no length");
    const int number = static_cast<int>(sides_.size());
    sides_.push_back({from, to, isSlit ? number + 1 : -1, -1, -1});
    isReverse_.push_back(false);
    if (!isSlit) return;
    sides_.push_back({to, from, number, -1, -1});
    isReverse_.push_back(true);
  }

  /// Step 3.
  int nextSide(int side) const {
    const DirectedSide& incoming = sides_[side];
    const Vector2& here = points_[incoming.to];
    const double back = angleOf(points_[incoming.from] - here);
    int best = -1;
    double least = 2 * kTurn;
    const auto found = leaving_.find(incoming.to);
    if (found == leaving_.end()) return -1;
    for (const int candidate : found->second) {
      // The way back along the same slit would turn round at its end.
      if (candidate == incoming.twin) continue;
      double corner = turnedBy(back - angleOf(points_[sides_[candidate].to] - here));
      // A side that leaves along the way back closes a corner of a full turn: it is the last
      // choice.
      if (corner <= kSamePatternDirection) corner += kTurn;
      if (corner >= least) continue;
      least = corner;
      best = candidate;
    }
    return best;
  }

  // Walks from side to side until the first one comes again.
  void traceTile(int first) {
    std::vector<int> cycle;
    int side = first;
    do {
      sides_[side].tile = static_cast<int>(cycles_.size());
      sides_[side].vertex = static_cast<int>(cycle.size());
      cycle.push_back(side);
      side = nextSide(side);
      // Either the line ends, or another tile has taken this side, or the walk has grown beyond any
      // tile.
      const bool isStray =
          side < 0 || (sides_[side].tile >= 0 && side != first) || cycle.size() > kMostTileVertices;
      if (isStray) {
        const Vector2& where = points_[sides_[cycle.back()].to];
        throw patternFault(file_, fmt::format("the lines round ({:.6g}, {:.6g}) m do not close to "
                                              "tiles",
                                              where.x(), where.y()));
      }
    } while (side != first);
    cycles_.push_back(std::move(cycle));
  }

  /// Step 4.
  Joint jointAt(const Neck& neck) {
    const int place = *points_.find(neck.joint);
    const double towards = angleOf(neck.middle - neck.joint);
    std::optional<Corner> before, after;
    double leastBefore = 2 * kTurn, leastAfter = 2 * kTurn;
    for (const int side : leaving_[place]) {
      const DirectedSide& leaving = sides_[side];
      const Corner corner{leaving.tile, leaving.vertex};
      // The angle from the hinge's line to this side, anticlockwise; the tile is on its left.
      const double gapAfter = turnedBy(angleOf(points_[leaving.to] - points_[place]) - towards);
      // The side that arrives here in the same tile bounds its corner on the other side.
      const std::vector<int>& cycle = cycles_[leaving.tile];
      const int last = cycle[(leaving.vertex + cycle.size() - 1) % cycle.size()];
      const double gapBefore =
          turnedBy(towards - angleOf(points_[sides_[last].from] - points_[place]));
      if (gapAfter < leastAfter) {
        leastAfter = gapAfter;
        after = corner;
      }
      if (gapBefore < leastBefore) {
        leastBefore = gapBefore;
        before = corner;
      }
    }
    if (!before || !after || before->tile == after->tile) {
      throw patternFault(file_, fmt::format("the hinge at ({:.6g}, {:.6g}) m joins no two tiles",
                                            neck.joint.x(), neck.joint.y()));
    }
    return {*before, *after, JointFace::Both};
  }

  std::vector<DrawnLine> lines_;
  const fs::path& file_;
  double tolerance_;  // metres
  Vector2 origin_;
  std::vector<Neck> necks_;
  std::vector<int> neckAt_;  // by the numbers of their middles
  PointNumbers shortened_{1, {0, 0}};
  std::vector<int> shortenedBy_;
  PointNumbers points_;  // of the sheet
  std::vector<DirectedSide> sides_;
  std::vector<bool> isReverse_;
  std::unordered_map<int, std::vector<int>> leaving_;  // sides by the point that they start at
  std::vector<std::vector<int>> cycles_;
};

// A ray along x crosses the outline an odd number of times.
bool isWithin(const Tile& tile, const Vector3& point) {
  bool isInside = false;
  for (std::size_t k = 0; k < tile.vertices.size(); ++k) {
    const Vector3& a = tile.vertices[k];
    const Vector3& b = tile.vertices[(k + 1) % tile.vertices.size()];
    if ((a.y() > point.y()) == (b.y() > point.y())) continue;
    const double x = a.x() + (point.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
    isInside = isInside != (point.x() < x);
  }
  return isInside;
}

/// In a flat sheet, lines that close within a tile are the outline of a hole.
void refuseHoles(const std::vector<Tile>& tiles, double tolerance, const fs::path& file) {
  struct ViewPlace {
    int tile = 0;
    Eigen::AlignedBox2d box;
  };
  std::vector<ViewPlace> places;  // from the left
  for (int i = 0; i < std::ssize(tiles); ++i) {
    ViewPlace& place = places.emplace_back();
    place.tile = i;
    for (const Vector3& vertex : tiles[i].vertices) place.box.extend(vertex.head<2>());
  }
  std::ranges::stable_sort(places, {}, [](const ViewPlace& place) { return place.box.min().x(); });
  const Vector2 margin = Vector2::Constant(tolerance);
  for (auto inner = places.begin(); inner != places.end(); ++inner) {
    const Eigen::AlignedBox2d wide(inner->box.min() - margin, inner->box.max() + margin);
    const std::vector<Vector3>& outline = tiles[inner->tile].vertices;
    for (auto outer = places.begin(); outer != inner; ++outer) {
      const Tile& around = tiles[outer->tile];
      const bool isHole =
          outer->box.contains(wide) && std::ranges::all_of(outline, [&](const Vector3& vertex) {
            return isWithin(around, vertex);
          });
      if (!isHole) continue;
      throw inputErrorAt({file},
                         fmt::format("the lines round ({:.6g}, {:.6g}) m cut a hole into a tile; "
                                     "tiles have none: leave the hole out, or divide the tile into "
                                     "tiles without holes, hinged to each other",
                                     outline[0].x(), outline[0].y()));
    }
  }
}

// Tiles of a drawing have no line of their own in the file.
TileTable patternTable(const fs::path& file, const std::vector<Tile>& tiles) {
  TileTable table;
  table.file = file;
  table.tiles = tiles;
  for (const Tile& tile : tiles) {
    table.sources.push_back({0, std::vector<int>(tile.vertices.size(), 0)});
  }
  return table;
}

}  // namespace

Model readCutPattern(const fs::path& file, std::vector<std::string>& warnings) {
  const std::string text = readTextFile(file, kPatternPurpose);
  const bool isSvg = endingOf(file) == ".svg";
  PatternReader reader(isSvg ? svgLines(text, file) : dxfLines(text, file), file);
  Model model;
  model.name = file.stem().string();
  model.tiles = reader.tiles();
  if (model.tiles.empty()) throw patternFault(file, "there are no tiles in it");
  const TileTable table = patternTable(file, model.tiles);
  checkTiles(table);
  refuseHoles(model.tiles, kSamePatternPoint * modelSize(model), file);
  model.joints = reader.joints();
  // An SVG is read in metres already.
  model.declaredUnit = isSvg ? LengthUnit{} : dxfUnit(text);
  turnClockwiseTiles(table, model, warnings);
  return model;
}

}  // namespace kirireel::model
