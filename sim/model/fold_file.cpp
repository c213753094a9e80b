#include "sim/model/fold_file.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "sim/base/error.h"
#include "sim/base/pending_file.h"
#include "sim/model/joint_checks.h"
#include "sim/model/shared_corners.h"
#include "sim/model/text_table.h"
#include "sim/model/tile_checks.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kJoints = "kirireel:joints";
constexpr const char* kPulled = "kirireel:pulled_tiles";

Json parsedFile(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw inputErrorAt({file}, "the file cannot be read; give a FOLD file");
  try {
    return Json::parse(stream);
  } catch (const nlohmann::json::exception& error) {
    const std::string text = error.what();
    throw inputErrorAt({file}, fmt::format("this is no JSON ({}); give a FOLD file",
                                           text.substr(text.rfind("] ") + 2)));
  }
}

/// One value of the file, with the words for what is wrong with it.
class FoldReader {
 public:
  explicit FoldReader(const fs::path& file) : file_(file), whole_(parsedFile(file)) {
    if (!whole_.is_object()) throw fault("the file holds no JSON object; give a FOLD file");
  }

  /// The corner numbers of the faces.
  CornerNumbers faces() const {
    const Json* faces = find(whole_, "faces_vertices");
    for (const Json& frame : frames()) {
      if (faces == nullptr) faces = find(frame, "faces_vertices");
    }
    if (faces == nullptr || !faces->is_array() || faces->empty()) {
      throw fault(
          "there are no faces_vertices; a sheet needs its faces: add them, or fold and save the "
          "pattern with a program that finds them");
    }
    CornerNumbers numbers;
    for (const Json& face : *faces) numbers.push_back(wholeNumbers(face, numbers.size()));
    return numbers;
  }

  /// The coordinates of all frames that have some.
  std::vector<std::vector<Vector3>> states() const {
    std::vector<std::vector<Vector3>> states;
    const auto append = [&](const Json& frame) {
      if (const Json* coordinates = find(frame, "vertices_coords")) {
        states.push_back(points(*coordinates));
      }
    };
    append(whole_);
    for (const Json& frame : frames()) append(frame);
    if (states.empty()) throw fault("there are no vertices_coords; add the vertices' coordinates");
    return states;
  }

  std::vector<Tile> tiles(const CornerNumbers& faces, const std::vector<Vector3>& points) const {
    std::vector<Tile> tiles;
    for (const std::vector<int>& face : faces) {
      Tile& tile = tiles.emplace_back();
      for (const int number : face) {
        if (number < 0 || number >= std::ssize(points)) {
          throw fault(
              fmt::format("face {} has the vertex {}, but there are vertices 0-{}; correct "
                          "it: FOLD counts from 0",
                          tiles.size() - 1, number, points.size() - 1));
        }
        tile.vertices.push_back(points[number]);
      }
    }
    return tiles;
  }

  /// Kirireel's own list of joints; null when there is none.
  const Json* ownJoints() const { return find(whole_, kJoints); }
  const Json* ownPulled() const { return find(whole_, kPulled); }

  std::vector<int> wholeNumbers(const Json& list, std::size_t index) const {
    std::vector<int> numbers;
    const bool isList = list.is_array();
    for (const Json& value : isList ? list : Json::array()) {
      if (value.is_number_integer()) numbers.push_back(value.get<int>());
    }
    if (isList && numbers.size() == list.size()) return numbers;
    throw fault(
        fmt::format("entry {} is no list of whole numbers; write vertex numbers, from 0", index));
  }

  InputError fault(const std::string& message) const { return inputErrorAt({file_}, message); }

 private:
  static const Json* find(const Json& object, const char* key) {
    const auto found = object.find(key);
    return found == object.end() ? nullptr : &*found;
  }

  std::vector<Json> frames() const {
    const Json* frames = find(whole_, "file_frames");
    if (frames == nullptr || !frames->is_array()) return {};
    return {frames->begin(), frames->end()};
  }

  std::vector<Vector3> points(const Json& coordinates) const {
    std::vector<Vector3> points;
    for (const Json& entry : coordinates) {
      Vector3& point = points.emplace_back(Vector3::Zero());
      const bool isPoint = entry.is_array() && (entry.size() == 2 || entry.size() == 3);
      for (std::size_t axis = 0; isPoint && axis < entry.size(); ++axis) {
        point[static_cast<int>(axis)] = entry[axis].is_number() ? entry[axis].get<double>() : NAN;
      }
      if (isPoint && point.allFinite() && point.cwiseAbs().maxCoeff() <= kMaxCoordinate) continue;
      throw fault(fmt::format("vertex {} is not two or three coordinates within {:g} m; correct it",
                              points.size() - 1, kMaxCoordinate));
    }
    return points;
  }

  fs::path file_;
  Json whole_;
};

/// Tiles with the places that checks name: a FOLD file has no lines, faces are counted instead.
TileTable tableOf(const fs::path& file, std::vector<Tile> tiles) {
  TileTable table;
  table.file = file;
  for (const Tile& tile : tiles) {
    table.sources.push_back({0, std::vector<int>(tile.vertices.size(), 0)});
  }
  table.tiles = std::move(tiles);
  return table;
}

std::vector<Joint> readOwnJoints(const FoldReader& reader, const TileTable& tiles) {
  JointTable table;
  table.file = tiles.file;
  std::vector<JointKind> kinds;
  for (const Json& entry : *reader.ownJoints()) {
    const std::vector<int> numbers = reader.wholeNumbers(entry, kinds.size());
    if (numbers.size() != 5 && numbers.size() != 6) {
      throw reader.fault(
          fmt::format("joint {} has {} numbers; write tile, vertex, tile, vertex, "
                      "face, and kind unless it is a pivot",
                      kinds.size(), numbers.size()));
    }
    JointRow& row = table.rows.emplace_back();
    std::copy_n(numbers.begin(), 5, row.values.begin());
    kinds.push_back(numbers.size() == 5 ? JointKind::Pivot : static_cast<JointKind>(numbers[5]));
  }
  std::vector<Joint> joints = checkedJoints(table, tiles);
  for (std::size_t k = 0; k < joints.size(); ++k) {
    Joint& joint = joints[k];
    if (kinds[k] == JointKind::Link) joint = makeLink(tiles.tiles, joint.a, joint.b);
    if (kinds[k] == JointKind::Fixed) {
      joint = makeFixedJoint(tiles.tiles, joint.a.tile, joint.b.tile);
    }
  }
  return joints;
}

Json coordinatesOf(const std::vector<Tile>& tiles, const CornerNumbers& numbers) {
  Json list = Json::array();
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    for (std::size_t k = 0; k < numbers[i].size(); ++k) {
      if (numbers[i][k] != std::ssize(list)) continue;
      const Vector3& vertex = tiles[i].vertices[k];
      list.push_back({vertex.x(), vertex.y(), vertex.z()});
    }
  }
  return list;
}

}  // namespace

Model readFold(const fs::path& file, std::vector<std::string>& warnings) {
  const FoldReader reader(file);
  const CornerNumbers faces = reader.faces();
  const std::vector<std::vector<Vector3>> states = reader.states();
  const TileTable start = tableOf(file, reader.tiles(faces, states.front()));
  checkTiles(start);
  checkOrientation(start, warnings);
  Model model;
  model.name = file.stem().string();
  model.tiles = start.tiles;
  model.joints =
      reader.ownJoints() != nullptr ? readOwnJoints(reader, start) : jointsOfSharedNumbers(faces);
  if (states.size() > 1) {
    const TileTable target = tableOf(file, reader.tiles(faces, states.back()));
    checkTarget(target, model, start, warnings);
    model.target = target.tiles;
  }
  if (reader.ownPulled() != nullptr) {
    model.pulledTiles = reader.wholeNumbers(*reader.ownPulled(), 0);
  }
  return model;
}

void writeFold(const Model& model, const fs::path& file) {
  const CornerNumbers numbers = sharedNumbers(model);
  Json json;
  json["file_spec"] = 1.1;
  json["file_creator"] = "Kirireel";
  json["file_classes"] = {model.target ? "animation" : "singleModel"};
  json["frame_title"] = "start";
  json["frame_classes"] = {"foldedForm"};
  json["vertices_coords"] = coordinatesOf(model.tiles, numbers);
  json["faces_vertices"] = numbers;
  if (model.target) {
    Json frame;
    frame["frame_title"] = "target";
    frame["frame_classes"] = {"foldedForm"};
    frame["frame_parent"] = 0;
    frame["frame_inherit"] = true;
    frame["vertices_coords"] = coordinatesOf(*model.target, numbers);
    json["file_frames"] = Json::array({frame});
  }
  json[kJoints] = Json::array();
  for (const Joint& joint : model.joints) {
    Json row = {joint.a.tile, joint.a.vertex, joint.b.tile, joint.b.vertex,
                static_cast<int>(joint.face)};
    if (joint.kind != JointKind::Pivot) row.push_back(static_cast<int>(joint.kind));
    json[kJoints].push_back(row);
  }
  if (model.pulledTiles) json[kPulled] = *model.pulledTiles;
  writeTextFile(file, json.dump() + "\n");
}

}  // namespace kirireel
