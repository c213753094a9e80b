// Pairs of OBJ files as inverse design programs leave them: one file for the contracted and one for
// the deployed sheet, with the same faces.
//
// OBJ knows vertices, faces and comments. Joints are vertex numbers that faces share, on the
// bottom. What that cannot say (the face of a joint, joints whose corners differ by rounding,
// pulled tiles) stands in comments that other programs pass over: "# joint A a B b FACE" and "#
// pull TILE", numbered from 0. A file with such comments is read by them alone, so that writing and
// reading give the same model. G. P. T. Choi, L. H. Dudte, L. Mahadevan, Programming shape using
// kirigami tessellations, Nature Materials 18, 2019, is where such pairs come from.
#include "sim/model/obj_pair.h"

#include <algorithm>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/base/pending_file.h"
#include "sim/model/joint_checks.h"
#include "sim/model/mending.h"
#include "sim/model/shared_corners.h"
#include "sim/model/text_table.h"
#include "sim/model/tile_checks.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;

const std::string kPurpose = "give a Wavefront OBJ file with one face a tile";

/// One OBJ file.
struct ObjSheet {
  TileTable tiles;
  CornerNumbers numbers;
  JointTable joints;        ///< of the comments
  std::vector<int> pulled;  ///< of the comments
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
      const std::string_view word = line.fields[0].text;
      // All other statements of the format describe looks.
      if (word == "v") readVertex(line);
      if (word == "f") readFace(line);
      if (word == "#") readComment(line);
    }
    if (sheet_.tiles.tiles.empty()) {
      throw inputErrorAt({text_.file()}, fmt::format("the file holds no face; {}", kPurpose));
    }
    requirePulledTiles();
    return std::move(sheet_);
  }

 private:
  FileLocation at(const TextLine& line, std::size_t field) const {
    return text_.at(line, line.fields[field]);
  }

  // The first three numbers, metres.
  void readVertex(const TextLine& line) {
    // Numbers beyond the third (a weight, colours) are passed over.
    if (line.fields.size() < 4) {
      throw inputErrorAt({text_.file(), line.number},
                         fmt::format("a vertex has x, y and z, not {} numbers; complete it",
                                     line.fields.size() - 1));
    }
    Vector3& vertex = vertices_.emplace_back();
    for (int axis = 0; axis < 3; ++axis) {
      vertex[axis] = parseCoordinate(line.fields[axis + 1], at(line, axis + 1));
    }
  }

  /// The vertex number of "7", "7/1", "7//" or, counted from the end, "-1"; from 0.
  int vertexNumber(const TextLine& line, std::size_t field) const {
    TextField number = line.fields[field];
    number.text = number.text.substr(0, number.text.find('/'));
    const int count = static_cast<int>(vertices_.size());
    const int value = parseWholeNumber(number, at(line, field), "a vertex number");
    // Negative numbers count backwards from the last vertex so far.
    const int fromZero = value < 0 ? count + value : value - 1;
    if (fromZero >= 0 && fromZero < count) return fromZero;
    throw inputErrorAt(at(line, field),
                       fmt::format("there are vertices 1-{} so far, not {}; {}", count, value,
                                   value == 0 ? "OBJ counts from 1: add 1 to all vertex numbers"
                                              : "correct this number"));
  }

  // A face takes vertices that stand before it, as OBJ has it.
  void readFace(const TextLine& line) {
    const std::size_t tile = sheet_.tiles.tiles.size();
    if (line.fields.size() < 4) {
      throw inputErrorAt({text_.file(), line.number},
                         fmt::format("face {} has {} vertices; a tile has at least 3: complete it "
                                     "or delete the line",
                                     tile, line.fields.size() - 1));
    }
    Tile& polygon = sheet_.tiles.tiles.emplace_back();
    TileSource& source = sheet_.tiles.sources.emplace_back();
    std::vector<int>& numbers = sheet_.numbers.emplace_back();
    source.line = line.number;
    for (std::size_t k = 1; k < line.fields.size(); ++k) {
      numbers.push_back(vertexNumber(line, k));
      polygon.vertices.push_back(vertices_[numbers.back()]);
      source.columns.push_back(line.fields[k].column);
    }
  }

  // The two comments that this program writes; all others are passed over.
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

  /// Comments may stand before the faces that they name.
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
  ObjSheet sheet_;
};

void requireSameFaces(const ObjSheet& start, const ObjSheet& target) {
  // Where each face has vertices of its own, their numbers say nothing about joints, and the
  // programs that write such files number them as they like.
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

/// NAME_contracted and NAME are the same model.
std::string modelName(const fs::path& file) {
  const std::string stem = file.stem().string();
  const std::string ending = "_contracted";
  return stem.ends_with(ending) ? stem.substr(0, stem.size() - ending.size()) : stem;
}

fs::path deployedName(const fs::path& contracted) {
  return contracted.parent_path() / (modelName(contracted) + "_deployed.obj");
}

// All vertices first, then a face for each tile.
std::string objText(const std::vector<Tile>& tiles, const CornerNumbers& numbers) {
  int count = 0;
  std::string vertices, faces;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
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
  const fs::path sibling = deployedName(contracted);
  if (sibling == contracted || !fs::exists(sibling)) return std::nullopt;
  return sibling;
}

Model readObjPair(const fs::path& start, const std::optional<fs::path>& target,
                  std::vector<std::string>& warnings) {
  ObjSheet sheet = ObjReader(start).read();
  checkTiles(sheet.tiles);
  Model model;
  model.name = modelName(start);
  model.tiles = sheet.tiles.tiles;
  std::vector<const std::vector<Tile>*> states = {&model.tiles};
  if (target) {
    const ObjSheet deployed = ObjReader(*target).read();
    // Shapes are compared before numbers: a target of other tiles is the likelier mistake.
    checkTarget(deployed.tiles, model, sheet.tiles, warnings);
    requireSameFaces(sheet, deployed);
    model.target = deployed.tiles.tiles;
    states.push_back(&*model.target);
  }
  if (!sheet.joints.rows.empty()) {
    dropRepeatedJoints(sheet.joints, model, warnings);
    model.joints = checkedJoints(sheet.joints, sheet.tiles);
    checkClosed(sheet.joints, model, sheet.tiles, warnings);
  } else {
    model.joints = jointsOfMesh(sheet.numbers, states, start);
  }
  if (!sheet.pulled.empty()) model.pulledTiles = sheet.pulled;
  turnClockwiseTiles(sheet.tiles, model, warnings);
  return model;
}

void writeObjPair(const Model& inOrder, const fs::path& file) {
  const Model model = inFileOrder(inOrder);
  std::string comments;
  for (const Joint& joint : model.joints) {
    if (joint.kind != JointKind::Pivot) {
      throw InputError(
          fmt::format("{}: error: OBJ holds joints at shared vertices, not the link between tiles "
                      "{} and {}; convert to a .fold file",
                      file.string(), joint.a.tile, joint.b.tile));
    }
    comments += fmt::format("# joint {} {} {} {} {}\n", joint.a.tile, joint.a.vertex, joint.b.tile,
                            joint.b.vertex, static_cast<int>(joint.face));
  }
  for (const int tile : model.pulledTiles.value_or(std::vector<int>())) {
    comments += fmt::format("# pull {}\n", tile);
  }
  const CornerNumbers numbers = sharedNumbers(model);
  writeTextFile(file, objText(model.tiles, numbers) + comments);
  if (model.target) writeTextFile(deployedName(file), objText(*model.target, numbers));
}

}  // namespace kirireel
