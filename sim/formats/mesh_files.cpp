// Pairs of OBJ files from inverse design programs: one file for the contracted sheet and one for
// the deployed sheet, with the same faces.
//
// OBJ has vertices, faces and comments. Vertex numbers that faces share become joints on the bottom
// face. Other information (the face of a joint, joints whose corners differ by rounding, pulled
// tiles) is in comments that other programs ignore: "# joint A a B b FACE" and "# pull TILE",
// zero-based. If a file has such comments, they replace the shared numbers, and writing and reading
// give the same model. Such pairs come from G. P. T. Choi, L. H. Dudte, L. Mahadevan, Programming
// shape using kirigami tessellations, Nature Materials 18, 2019.
#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <set>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/base/file_kinds.h"
#include "sim/base/files.h"
#include "sim/formats/drawing.h"
#include "sim/formats/faces.h"
#include "sim/formats/joint_checks.h"
#include "sim/formats/model_formats.h"
#include "sim/formats/read_settings.h"
#include "sim/formats/shared_corners.h"
#include "sim/formats/text_table.h"
#include "sim/formats/tile_checks.h"

namespace kirireel::formats {
namespace {

namespace fs = std::filesystem;

const std::string kPurpose = "give a Wavefront OBJ file with one face per tile";

/// Removes padding from a face of a mesh: entries without a vertex (-1), repeated vertices, and
/// corners that coincide with their neighbour. Returns the remaining entries.
std::vector<int> unpaddedCorners(const std::vector<int>& numbers,
                                 const std::vector<Vector3>& points) {
  std::vector<int> entries;
  for (int k = 0; k < std::ssize(numbers); ++k) {
    if (numbers[k] >= 0) entries.push_back(k);
  }
  std::vector<int> kept;
  for (const int k : entries) {
    const auto isSame = [&](int other) {
      return numbers[k] == numbers[other] || points[numbers[k]] == points[numbers[other]];
    };
    if (kept.empty() || !isSame(kept.back())) kept.push_back(k);
  }
  // The last corner can repeat the first to close the polygon.
  while (kept.size() > 1 && points[numbers[kept.back()]] == points[numbers[kept.front()]]) {
    kept.pop_back();
  }
  return kept;
}

/// One state of a mesh. In each tile the first corner with a number defines its position.
std::vector<model::Tile> tilesBy(const CornerNumbers& outlines, const CornerNumbers& numbers,
                                 const std::vector<model::Tile>& faces) {
  std::map<int, Vector3> places;
  for (std::size_t face = 0; face < faces.size(); ++face) {
    for (std::size_t k = 0; k < numbers[face].size(); ++k) {
      places.emplace(numbers[face][k], faces[face].vertices[k]);
    }
  }
  std::vector<model::Tile> tiles;
  for (const std::vector<int>& outline : outlines) {
    model::Tile& tile = tiles.emplace_back();
    for (const int number : outline) tile.vertices.push_back(places.at(number));
  }
  return tiles;
}

/// Completes the tiles and joints of a mesh whose states are in the model. Faces are kept, or
/// coplanar faces are joined. Returns the tile of each face. Suggests joining if the faces appear
/// to be triangles of larger tiles.
std::vector<int> completeMesh(const CornerNumbers& ownNumbers, TileTable& table,
                              model::Model& model, const ReadSettings& settings,
                              std::vector<std::string>& warnings) {
  std::vector<const std::vector<model::Tile>*> states = {&model.tiles};
  if (model.target) states.push_back(&*model.target);
  CornerNumbers numbers = meshNumbers(ownNumbers, states, table.file);
  JoinedFaces joined = joinFaces(numbers, coplanarFaces(numbers, states));
  const std::size_t count = joined.tiles.size();
  if (!settings.joinCoplanar) {
    model.joints = jointsOfSharedNumbers(numbers);
    const bool areTriangles =
        std::ranges::all_of(joined.tileOf, [&, face = std::size_t{0}](int tile) mutable {
          return joined.tiles[tile].size() == numbers[face].size() || numbers[face++].size() == 3;
        });
    if (count > 1 && count < numbers.size() && areTriangles) {
      warnings.push_back(
          fmt::format("{}: warning: {} faces are probably {} tiles cut to triangles. "
                      "`join_coplanar` joins coplanar faces with a common edge",
                      table.file.string(), numbers.size(), count));
    }
    return joined.tileOf;
  }
  model.tiles = tilesBy(joined.tiles, numbers, model.tiles);
  if (model.target) model.target = tilesBy(joined.tiles, numbers, *model.target);
  std::vector<TileSource> sources(count);
  for (std::size_t face = numbers.size(); face-- > 0;) {
    const auto tile = static_cast<std::size_t>(joined.tileOf[face]);
    sources[tile] = {table.sources[face].line, std::vector<int>(joined.tiles[tile].size(), 0)};
    if (!model.tileNames.empty()) model.tileNames[tile] = model.tileNames[face];
  }
  if (!model.tileNames.empty()) model.tileNames.resize(count);
  table.tiles = model.tiles;
  table.sources = std::move(sources);
  checkTiles(table);
  model.joints = jointsOfSharedNumbers(joined.tiles);
  return joined.tileOf;
}

/// One OBJ file.
struct ObjSheet {
  TileTable tiles;
  CornerNumbers numbers;
  JointTable joints;                   ///< from the comments
  std::vector<int> pulled;             ///< from the comments
  std::vector<std::string> names;      ///< of each face, by its group and material
  std::map<std::string, int> ignored;  ///< counts of statements that are not read, by keyword
};

/// Reads one file statement by statement.
class ObjReader {
 public:
  explicit ObjReader(const fs::path& file) : text_(file, kPurpose, TextTable::Comments::Keep) {
    sheet_.tiles.file = sheet_.joints.file = file;
  }

  ObjSheet read() {
    TextLine line;
    while (text_.next(line)) {
      const std::string word = lowerCase(line.fields[0].text);
      if (word == "v") {
        readVertex(line);
      } else if (word == "f" || word == "fo") {  // fo: a face in the oldest files
        readFace(line);
      } else if (word.starts_with('#')) {
        readComment(line);
      } else if (word == "g" || word == "o") {
        group_ = wordsOf(line);
      } else if (word == "usemtl") {
        material_ = wordsOf(line);
      } else if (std::ranges::find(kLooks, word) == std::end(kLooks)) {
        ++sheet_.ignored[shown(word, 24)];
      }
    }
    if (sheet_.tiles.tiles.empty()) {
      throw inputErrorAt({text_.file()}, fmt::format("the file has no face; {}", kPurpose));
    }
    requirePulledTiles();
    return std::move(sheet_);
  }

 private:
  FileLocation at(const TextLine& line, std::size_t field) const {
    return text_.at(line, line.fields[field]);
  }

  /// Statements about appearance.
  static constexpr std::string_view kLooks[] = {
      "vt",    "vn",  "s",        "mtllib",   "mg",         "usemap",   "maplib",
      "bevel", "lod", "c_interp", "d_interp", "shadow_obj", "trace_obj"};

  // The first three numbers, metres. NaN is padding, which no tile may use.
  void readVertex(const TextLine& line) {
    // Further numbers (a weight, colours) are ignored.
    if (line.fields.size() < 4) {
      throw inputErrorAt({text_.file(), line.number},
                         fmt::format("a vertex has x, y and z, not {} numbers; complete it",
                                     line.fields.size() - 1));
    }
    Vector3& vertex = vertices_.emplace_back();
    const auto isMissing = [&](int axis) { return isNan(line.fields[axis + 1].text); };
    if (isMissing(0) && isMissing(1) && isMissing(2)) {
      vertex.setConstant(NAN);
      return;
    }
    for (int axis = 0; axis < 3; ++axis) {
      vertex[axis] = parseCoordinate(line.fields[axis + 1], at(line, axis + 1));
    }
  }

  /// The zero-based vertex number of "7", "7/1", "7//" or, counted from the end, "-1". -1: padding.
  int vertexNumber(const TextLine& line, std::size_t field) const {
    TextField number = line.fields[field];
    number.text = number.text.substr(0, number.text.find('/'));
    if (isNan(number.text)) return -1;
    const int count = static_cast<int>(vertices_.size());
    const int value = parseWholeNumber(number, at(line, field), "a vertex number");
    // Negative numbers count backwards from the last vertex so far.
    const int fromZero = value < 0 ? count + value : value - 1;
    if (fromZero >= 0 && fromZero < count) return vertices_[fromZero].allFinite() ? fromZero : -1;
    throw inputErrorAt(
        at(line, field),
        fmt::format("there are {} before this line, not {}; {}",
                    count == 0 ? "no vertices (v)" : fmt::format("only vertices 1-{}", count),
                    value,
                    value == 0  ? "OBJ counts from 1: add 1 to all vertex numbers"
                    : value > 0 ? "correct this number, or move the face below its vertices"
                                : "correct this number"));
  }

  // As in OBJ, a face can only use vertices before it in the file.
  void readFace(const TextLine& line) {
    const std::size_t tile = sheet_.tiles.tiles.size();
    std::vector<int> entries;
    for (std::size_t k = 1; k < line.fields.size(); ++k) entries.push_back(vertexNumber(line, k));
    const std::vector<int> kept = unpaddedCorners(entries, vertices_);
    if (kept.size() < 3) {
      throw inputErrorAt({text_.file(), line.number},
                         fmt::format("face {} has {} vertices; a tile has at least 3: complete it "
                                     "or delete the line",
                                     tile, kept.size()));
    }
    if (kept.size() < entries.size()) sheet_.tiles.padded.push_back(static_cast<int>(tile));
    model::Tile& polygon = sheet_.tiles.tiles.emplace_back();
    TileSource& source = sheet_.tiles.sources.emplace_back();
    std::vector<int>& numbers = sheet_.numbers.emplace_back();
    source.line = line.number;
    const bool hasBoth = !group_.empty() && !material_.empty();
    sheet_.names.push_back(group_ + (hasBoth ? " " : "") + material_);
    for (const int k : kept) {
      numbers.push_back(entries[k]);
      polygon.vertices.push_back(vertices_[entries[k]]);
      source.columns.push_back(line.fields[k + 1].column);
    }
  }

  /// The text after the first word; "" if there is none.
  static std::string wordsOf(const TextLine& line) {
    std::string text;
    for (std::size_t k = 1; k < line.fields.size(); ++k) {
      if (k > 1) text += ' ';
      text += line.fields[k].text;
    }
    return text;
  }

  // Reads the two kinds of comments that this program writes; ignores others.
  void readComment(const TextLine& line) {
    const bool isJoint = line.fields.size() == 7 && line.fields[1].text == "joint";
    if (isJoint) {
      JointRow& row = sheet_.joints.rows.emplace_back();
      row.line = line.number;
      for (std::size_t k = 0; k < 5; ++k) {
        row.values[k] = parseWholeNumber(line.fields[k + 2], at(line, k + 2), "a whole number");
        row.columns[k] = line.fields[k + 2].column;
      }
    }
    const bool isPull = line.fields.size() == 3 && line.fields[1].text == "pull";
    if (isPull) {
      sheet_.pulled.push_back(parseWholeNumber(line.fields[2], at(line, 2), "a tile number"));
      pulledPlaces_.push_back(at(line, 2));
    }
  }

  /// Checks this last because comments may precede the faces that they name.
  void requirePulledTiles() const {
    const int count = static_cast<int>(sheet_.tiles.tiles.size());
    for (std::size_t k = 0; k < sheet_.pulled.size(); ++k) {
      const int tile = sheet_.pulled[k];
      if (tile >= 0 && tile < count) continue;
      throw inputErrorAt(
          pulledPlaces_[k],
          fmt::format("there are faces 0-{}, not {}; correct this number", count - 1, tile));
    }
  }

  TextTable text_;
  std::vector<Vector3> vertices_;
  std::vector<FileLocation> pulledPlaces_;
  std::string group_, material_;  ///< of the next face
  ObjSheet sheet_;
};

bool sharesNumbers(const CornerNumbers& numbers) {
  std::set<int> seen;
  return std::ranges::any_of(numbers, [&](const std::vector<int>& tile) {
    return std::ranges::any_of(tile, [&](int number) { return !seen.insert(number).second; });
  });
}

void requireSameFaces(const ObjSheet& start, const ObjSheet& target) {
  // If each face has its own vertices, their numbers contain no joints. Programs that write such
  // files number them arbitrarily.
  if (!sharesNumbers(start.numbers)) return;
  const std::size_t common = std::min(start.numbers.size(), target.numbers.size());
  for (std::size_t i = 0; i < common; ++i) {
    if (start.numbers[i] == target.numbers[i]) continue;
    const int tile = static_cast<int>(i);
    throw inputErrorAt(target.tiles.at(tile),
                       fmt::format("face {} has other vertex numbers than at {}; write the same "
                                   "faces in the same order in both files",
                                   tile, start.tiles.shortName(tile)));
  }
}

void warnOfIgnored(const std::map<std::string, int>& ignored, const fs::path& file,
                   std::vector<std::string>& warnings) {
  if (ignored.empty()) return;
  std::vector<std::string> words;
  for (const auto& [word, count] : ignored) words.push_back(fmt::format("{} ({})", word, count));
  warnings.push_back(
      fmt::format("{}: warning: ignored statements: {}", file.string(), listed(words, 30)));
}

/// NAME_contracted and NAME are the same model.
std::string modelName(const fs::path& file) {
  const std::string stem = file.stem().string();
  const std::string ending = "_contracted";
  return stem.ends_with(ending) ? stem.substr(0, stem.size() - ending.size()) : stem;
}

/// `ending` is for example ".obj".
fs::path deployedName(const fs::path& contracted, const fs::path& ending) {
  return contracted.parent_path() / (modelName(contracted) + "_deployed" + ending.string());
}

// All vertices first, then a face for each tile.
std::string objText(const std::vector<model::Tile>& tiles, const CornerNumbers& numbers,
                    const std::vector<std::string>& names) {
  int count = 0;
  std::string vertices, faces, name;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    if (!names.empty() && names[i] != name) faces += fmt::format("g {}\n", name = names[i]);
    faces += "f";
    for (std::size_t k = 0; k < numbers[i].size(); ++k) {
      // Numbers rise in the order of their first corners.
      if (numbers[i][k] == count) {
        const Vector3& vertex = tiles[i].vertices[k];
        vertices += fmt::format("v {} {} {}\n", vertex.x(), vertex.y(), vertex.z());
        ++count;
      }
      faces += fmt::format(" {}", numbers[i][k] + 1);
    }
    faces += '\n';
  }
  return vertices + faces;
}

}  // namespace

std::optional<fs::path> deployedSibling(const fs::path& contracted) {
  // Tries the contracted file's own spelling of the ending first.
  for (const fs::path& ending : {contracted.extension(), fs::path(".obj"), fs::path(".OBJ")}) {
    const fs::path sibling = deployedName(contracted, ending);
    if (sibling != contracted && isPresent(sibling)) return sibling;
  }
  return std::nullopt;
}

model::Model readObjPair(const fs::path& start, const std::optional<fs::path>& target,
                         std::vector<std::string>& warnings, const ReadSettings& settings) {
  ObjSheet sheet = ObjReader(start).read();
  checkTiles(sheet.tiles);
  model::Model model;
  model.name = modelName(start);
  model.tiles = sheet.tiles.tiles;
  const auto hasName = [](const std::string& name) { return !name.empty(); };
  if (std::ranges::any_of(sheet.names, hasName)) model.tileNames = sheet.names;
  notePadding(sheet.tiles, model, warnings);
  warnOfIgnored(sheet.ignored, start, warnings);
  if (target) {
    const ObjSheet deployed = ObjReader(*target).read();
    // Compares shapes before numbers, since a target with other tiles is the more likely mistake.
    checkTargets({deployed.tiles}, model, sheet.tiles, warnings);
    requireSameFaces(sheet, deployed);
    model.target = deployed.tiles.tiles;
  }
  if (!sheet.joints.rows.empty()) {
    if (settings.joinCoplanar) {
      throw inputErrorAt({start, sheet.joints.rows.front().line},
                         "this comment names a joint of two faces, but `join_coplanar` changes "
                         "faces. Remove `join_coplanar` or these comments");
    }
    dropRepeatedJoints(sheet.joints, model, warnings);
    model.joints = checkedJoints(sheet.joints, sheet.tiles);
    checkClosed(sheet.joints, model, sheet.tiles, warnings);
  } else {
    const std::vector<int> tileOf =
        completeMesh(sheet.numbers, sheet.tiles, model, settings, warnings);
    if (settings.joinCoplanar) {
      for (int& tile : sheet.pulled) tile = tileOf[tile];
    }
  }
  if (!sheet.pulled.empty()) model.pulledTiles = sheet.pulled;
  turnClockwiseTiles(sheet.tiles, model, warnings);
  return model;
}

void writeObjPair(const model::Model& inOrder, const fs::path& file) {
  const model::Model model = model::inFileOrder(inOrder);
  std::string comments;
  requireKinds(model, {model::JointKind::Pivot}, "OBJ supports only joints at shared vertices",
               file);
  for (const model::Joint& joint : model.joints) {
    comments += fmt::format("# joint {} {} {} {} {}\n", joint.a.tile, joint.a.vertex, joint.b.tile,
                            joint.b.vertex, static_cast<int>(joint.face));
  }
  for (const int tile : model.pulledTiles.value_or(std::vector<int>())) {
    comments += fmt::format("# pull {}\n", tile);
  }
  const CornerNumbers numbers = sharedNumbers(model);
  const std::string unit = unitLine(model.unit);
  writeTextFile(file, unit + objText(model.tiles, numbers, model.tileNames) + comments);
  if (!model.target) return;
  writeTextFile(deployedName(file, file.extension()),
                unit + objText(*model.target, numbers, model.tileNames));
}

// ------------------------------------------------------------------------------------------------
// PLY meshes, in the three encodings of the format.
//
// A file has a text header and data. The header lists elements (their count and the properties of
// each). The data are the elements' values in sequence, as words (ASCII) or as bytes with the
// widths in the header. Only vertices (x, y, z) and faces (vertex_indices or vertex_index) are
// kept. Everything else is also read, because only its width shows where the next value begins.
//
// Shifts combine the bytes, so the machine's byte order does not matter. Counts in the header are
// not trusted: no memory is reserved for them, a list may not be longer than the file, and reading
// past the end is an error. G. Turk, The PLY polygon file format, 1994.

namespace {

const std::string kPlyPurpose = "give a PLY mesh with one face per tile";

/// A number's type: its width in bytes and their interpretation.
struct PlyType {
  int width = 4;
  enum class NumberKind { Signed, Unsigned, Real } kind = NumberKind::Real;
};

struct PlyProperty {
  std::string_view name;
  PlyType type;  ///< of the number, or of a list's entries
  bool isList = false;
  PlyType count;  ///< of a list's length
};

struct PlyElement {
  std::string_view name;
  long count = 0;
  std::vector<PlyProperty> properties;
};

enum class PlyFormat { Ascii, LittleEndian, BigEndian };

/// Reads header and data from one text.
class PlyReader {
 public:
  explicit PlyReader(const fs::path& file) : file_(file), text_(readTextFile(file, kPlyPurpose)) {
    readHeader();
    for (const PlyElement& element : elements_) readElement(element);
    if (!word().empty()) {
      throw faultHere(fmt::format(
          "there is more data than the header counts ({}). Correct the counts", describeCounts()));
    }
    if (faces_.empty()) throw fault("the file has no face");
  }

  /// The faces without padding, as tiles, and their vertex numbers.
  TileTable tiles(CornerNumbers& outlines) const {
    TileTable table;
    table.file = file_;
    for (const std::vector<int>& face : faces_) {
      const std::size_t tile = table.tiles.size();
      for (const int number : face) {
        if (number < -1 || number >= std::ssize(points_)) {
          throw fault(
              fmt::format("face {} has the vertex {}, but there are vertices 0-{}: PLY "
                          "counts from 0",
                          tile, number, points_.size() - 1));
        }
      }
      std::vector<int> numbers = face;
      for (int& number : numbers) {
        if (number >= 0 && !points_[number].allFinite()) number = -1;
      }
      const std::vector<int> kept = unpaddedCorners(numbers, points_);
      if (kept.size() < 3) {
        throw fault(
            fmt::format("face {} has {} vertices, a tile has at least 3", tile, kept.size()));
      }
      if (kept.size() < face.size()) table.padded.push_back(static_cast<int>(tile));
      table.sources.push_back({0, std::vector<int>(kept.size(), 0)});
      std::vector<int>& outline = outlines.emplace_back();
      model::Tile& polygon = table.tiles.emplace_back();
      for (const int k : kept) {
        outline.push_back(numbers[k]);
        polygon.vertices.push_back(points_[numbers[k]]);
      }
    }
    return table;
  }

 private:
  /// `line`: of the fault; 0 if it concerns the whole file.
  InputError fault(const std::string& what, int line = 0) const {
    return inputErrorAt({file_, line}, fmt::format("{}; {}", what, kPlyPurpose));
  }

  /// A fault in the word that was read last, with its line. Binary data has no lines.
  InputError faultHere(const std::string& what) const {
    const bool hasLines = !isInData_ || format_ == PlyFormat::Ascii;
    const auto end = text_.begin() + static_cast<std::ptrdiff_t>(at_);
    return fault(what, hasLines ? 1 + static_cast<int>(std::count(text_.begin(), end, '\n')) : 0);
  }

  std::string describeCounts() const {
    std::vector<std::string> counts;
    for (const PlyElement& element : elements_) {
      counts.push_back(fmt::format("{} {}", shown(element.name, 24), element.count));
    }
    return listed(counts);
  }

  /// The next word of the header or of ASCII data; empty at the end.
  std::string_view word() {
    constexpr std::string_view kBlank = " \t\r\n";
    const std::size_t begin = std::min(text_.find_first_not_of(kBlank, at_), text_.size());
    const std::size_t end = std::min(text_.find_first_of(kBlank, begin), text_.size());
    at_ = end;
    return std::string_view(text_).substr(begin, end - begin);
  }

  /// Moves behind the end of the line: a line feed, a carriage return, or both.
  void skipLine() {
    at_ = std::min(text_.find_first_of("\r\n", at_), text_.size());
    if (text_.compare(at_, 2, "\r\n") == 0) ++at_;
    at_ = std::min(at_ + 1, text_.size());
  }

  // The two spellings of each type that are in use.
  PlyType typeNamed(std::string_view name) const {
    using NumberKind = PlyType::NumberKind;
    static constexpr std::pair<std::string_view, PlyType> kTypes[] = {
        {"char", {1, NumberKind::Signed}},     {"int8", {1, NumberKind::Signed}},
        {"uchar", {1, NumberKind::Unsigned}},  {"uint8", {1, NumberKind::Unsigned}},
        {"short", {2, NumberKind::Signed}},    {"int16", {2, NumberKind::Signed}},
        {"ushort", {2, NumberKind::Unsigned}}, {"uint16", {2, NumberKind::Unsigned}},
        {"int", {4, NumberKind::Signed}},      {"int32", {4, NumberKind::Signed}},
        {"uint", {4, NumberKind::Unsigned}},   {"uint32", {4, NumberKind::Unsigned}},
        {"float", {4, NumberKind::Real}},      {"float32", {4, NumberKind::Real}},
        {"double", {8, NumberKind::Real}},     {"float64", {8, NumberKind::Real}}};
    for (const auto& [known, type] : kTypes) {
      if (known == name) return type;
    }
    throw faultHere(fmt::format("there is no type '{}'", shown(name, 24)));
  }

  // Keys come in any order. Unknown keys (comment, obj_info) are ignored up to the end of their
  // line.
  void readHeader() {
    if (text_.starts_with("\xEF\xBB\xBF")) at_ = 3;
    if (word() != "ply") throw faultHere("the file does not begin with \"ply\"");
    bool hasFormat = false;
    for (;;) {
      const std::string_view key = word();
      if (key.empty()) throw fault("the header has no end");
      if (key == "end_header") break;
      if (key == "format") {
        const std::string_view name = word();
        hasFormat = true;
        if (name == "ascii")
          format_ = PlyFormat::Ascii;
        else if (name == "binary_little_endian")
          format_ = PlyFormat::LittleEndian;
        else if (name == "binary_big_endian")
          format_ = PlyFormat::BigEndian;
        else
          throw faultHere(fmt::format("there is no format '{}'", shown(name, 24)));
      } else if (key == "element") {
        PlyElement& element = elements_.emplace_back();
        element.name = word();
        const std::string_view count = word();
        const auto [end, error] =
            std::from_chars(count.data(), count.data() + count.size(), element.count);
        if (error != std::errc() || end != count.data() + count.size() || element.count < 0) {
          throw faultHere(fmt::format("an element cannot be there '{}' times", shown(count, 24)));
        }
      } else if (key == "property") {
        // A list has more words than a plain property. readProperty() reads exactly what it needs,
        // and the next key follows.
        readProperty();
        continue;
      }
      skipLine();
    }
    skipLine();
    if (!hasFormat) throw fault("the header has no format");
    if (std::ranges::find(elements_, "face", &PlyElement::name) == elements_.end()) {
      throw fault("the header has no element face");
    }
    isInData_ = true;
  }

  void readProperty() {
    if (elements_.empty()) throw faultHere("a property is before its element");
    PlyProperty property;
    std::string_view type = word();
    property.isList = type == "list";
    if (property.isList) {
      property.count = typeNamed(word());
      type = word();
    }
    property.type = typeNamed(type);
    property.name = word();
    elements_.back().properties.push_back(property);
  }

  // The next number of the data, in the format of the file.
  double number(const PlyType& type) {
    if (format_ == PlyFormat::Ascii) {
      const std::string_view text = word();
      double value = 0;
      if (readNumber(text, value)) return value;
      if (text.empty()) throw fault("the file ends early");
      throw faultHere(fmt::format("'{}' is not a number", shown(text, 24)));
    }
    const auto width = static_cast<std::size_t>(type.width);
    if (text_.size() - at_ < width) throw fault("the file ends early");
    std::uint64_t bits = 0;
    for (std::size_t k = 0; k < width; ++k) {
      // The most significant byte first.
      const std::size_t place = format_ == PlyFormat::LittleEndian ? width - 1 - k : k;
      bits = bits << 8 | static_cast<unsigned char>(text_[at_ + place]);
    }
    at_ += width;
    if (type.kind == PlyType::NumberKind::Unsigned) return static_cast<double>(bits);
    if (type.kind == PlyType::NumberKind::Real) {
      return width == 8 ? std::bit_cast<double>(bits)
                        : std::bit_cast<float>(static_cast<std::uint32_t>(bits));
    }
    // Shifting up and arithmetically down copies the sign bit of a narrow number to the upper bits.
    const int unused = 64 - 8 * type.width;
    return static_cast<double>(static_cast<std::int64_t>(bits << unused) >> unused);
  }

  /// A whole number that fits an int.
  int wholeNumber(const PlyType& type, const char* what) {
    const double value = number(type);
    if (value == std::floor(value) && std::abs(value) <= std::numeric_limits<int>::max()) {
      return static_cast<int>(value);
    }
    throw faultHere(fmt::format("{:g} is no {}", value, what));
  }

  // A length and as many entries. Whole numbers are vertex numbers.
  std::vector<int> list(const PlyProperty& property) {
    const int count = wholeNumber(property.count, "length of a list");
    if (count < 0 || count > std::ssize(text_)) {
      throw faultHere(fmt::format("a list cannot be {} long", count));
    }
    std::vector<int> numbers;
    for (int k = 0; k < count; ++k) {
      // Skip real numbers, since a vertex number is whole.
      numbers.push_back(property.type.kind == PlyType::NumberKind::Real
                            ? (static_cast<void>(number(property.type)), 0)
                            : wholeNumber(property.type, "vertex number"));
    }
    return numbers;
  }

  // Reads every property of every entry, because only this shows where the next one begins.
  void readElement(const PlyElement& element) {
    const bool areVertices = element.name == "vertex", areFaces = element.name == "face";
    // An element without properties takes no bytes for any count.
    const long count = element.properties.empty() ? 0 : element.count;
    for (long k = 0; k < count; ++k) {
      Vector3 point = Vector3::Zero();
      bool isPolygon = false;
      std::vector<int> corners;
      for (const PlyProperty& property : element.properties) {
        if (property.isList) {
          std::vector<int> entries = list(property);
          if (property.name != "vertex_indices" && property.name != "vertex_index") continue;
          corners = std::move(entries);
          isPolygon = true;
          continue;
        }
        const double value = number(property.type);
        const int axis = property.name == "x" ? 0 : property.name == "y" ? 1 : 2;
        if (axis < 2 || property.name == "z") point[axis] = value;
      }
      if (areVertices) addPoint(point);
      if (areFaces && isPolygon) faces_.push_back(std::move(corners));
    }
  }

  void addPoint(const Vector3& point) {
    const bool isPadding = point.array().isNaN().all();
    const bool isWithin = point.allFinite() && point.cwiseAbs().maxCoeff() <= kMaxCoordinate;
    if (!isWithin && !isPadding) {
      throw faultHere(fmt::format("vertex {} is not within {:g}", points_.size(), kMaxCoordinate));
    }
    points_.push_back(point);
  }

  fs::path file_;
  std::string text_;
  std::size_t at_ = 0;
  bool isInData_ = false;  ///< behind the header
  PlyFormat format_ = PlyFormat::Ascii;
  std::vector<PlyElement> elements_;
  std::vector<Vector3> points_;
  CornerNumbers faces_;
};

}  // namespace

model::Model readPly(const fs::path& file, std::vector<std::string>& warnings,
                     const ReadSettings& settings) {
  const PlyReader reader(file);
  model::Model model;
  model.name = file.stem().string();
  CornerNumbers numbers;
  TileTable table = reader.tiles(numbers);
  checkTiles(table);
  model.tiles = table.tiles;
  notePadding(table, model, warnings);
  completeMesh(numbers, table, model, settings, warnings);
  turnClockwiseTiles(table, model, warnings);
  return model;
}

}  // namespace kirireel::formats
