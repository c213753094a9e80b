// FOLD as the origami programs write it, and Kirireel's own keys in it.
//
// Reading goes through the file in four steps.
// 1. Faces: faces_vertices of the file, or of the first frame that has them.
// 2. States: vertices_coords of the file and of each frame that has some. The first is the start,
//    the last the target.
// 3. Joints: the key kirireel:joints, where there is one ([tile, vertex, tile, vertex, face, kind]
//    for each; kind 0 pivot, 1 link, 2 fixed, absent for 0), else the edges (creases.h).
// 4. With one state, the target of a flat sheet is that state folded by its edges_foldAngle.
//
// Writing merges corners into one vertex only where they agree to the last bit in both states, so
// that reading gives the same doubles back. Joints of corners that differ by rounding survive
// through kirireel:joints. nlohmann's ordered_json keeps the order of keys, so that the same model
// gives the same bytes.
//
// The library throws where types do not fit; every access below is checked first, so that messages
// speak of faces and edges.
#include "sim/model/fold_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "sim/base/error.h"
#include "sim/base/input_file.h"
#include "sim/base/pending_file.h"
#include "sim/base/spelling.h"
#include "sim/model/creases.h"
#include "sim/model/joint_checks.h"
#include "sim/model/mending.h"
#include "sim/model/shared_corners.h"
#include "sim/model/text_table.h"
#include "sim/model/tile_checks.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kJoints = "kirireel:joints";
constexpr const char* kPulled = "kirireel:pulled_tiles";

// The whole file as JSON; its syntax errors as ours.
Json parsedFile(const fs::path& file) {
  try {
    return Json::parse(readTextFile(file, "give a FOLD file"));
  } catch (const nlohmann::json::exception& error) {
    // The library's texts begin with "[json.exception.parse_error.101] ", which helps nobody.
    const std::string_view text = error.what();
    const std::string_view reason = text.substr(text.find("] ") + 2);  // after its number
    throw inputErrorAt({file},
                       fmt::format("this is no JSON ({}); give a FOLD file", shown(reason, 160)));
  }
}

// Numbers such as 1e99 or 2^40 are valid JSON; a cast would wrap them to a vertex that exists.
bool fitsInt(const Json& value) {
  if (!value.is_number_integer()) return false;
  if (value.is_number_unsigned()) {
    return value.get<std::uint64_t>() <= std::uint64_t{std::numeric_limits<int>::max()};
  }
  return value.get<std::int64_t>() >= std::numeric_limits<int>::min();
}

/// One value of the file, with the words for what is wrong with it.
class FoldReader {
 public:
  explicit FoldReader(const fs::path& file) : file_(file), whole_(parsedFile(file)) {
    if (!whole_.is_object()) throw fault("the file holds no JSON object; give a FOLD file");
  }

  /// The corner numbers of the faces.
  CornerNumbers faces() const {
    // Frames inherit the faces in most files; some programs write them into the frames instead.
    const Json* faces = find(whole_, "faces_vertices");
    for (const Json* frame : frames()) {
      if (faces == nullptr) faces = find(*frame, "faces_vertices");
    }
    if (faces == nullptr || !faces->is_array() || faces->empty()) {
      throw fault(
          "there are no faces_vertices; a sheet needs its faces: add them, or fold and save the "
          "pattern with a program that finds them");
    }
    CornerNumbers numbers;
    for (const Json& face : *faces) {
      numbers.push_back(wholeNumbers(face, numbers.size()));
      if (numbers.back().size() >= 3) continue;
      throw fault(
          fmt::format("face {} has {} vertices; a tile has at least 3: complete it or "
                      "delete it",
                      numbers.size() - 1, numbers.back().size()));
    }
    return numbers;
  }

  /// The coordinates of all frames that have some.
  std::vector<std::vector<Vector3>> states() const {
    std::vector<std::vector<Vector3>> states;
    const auto append = [&](const Json& frame) {
      const Json* coordinates = find(frame, "vertices_coords");
      if (coordinates != nullptr && !coordinates->empty()) states.push_back(points(*coordinates));
    };
    append(whole_);
    for (const Json* frame : frames()) append(*frame);
    if (states.empty()) throw fault("there are no vertices_coords; add the vertices' coordinates");
    return states;
  }

  // The faces with coordinates of one state. Throws where a face names a vertex that is not there.
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

  /// Joints come of faces that share corners, but a file whose edges are broken may be broken
  /// elsewhere. `vertexCount`: of frames that have no coordinates of their own.
  void requireSoundEdges(std::size_t vertexCount) const {
    requireSoundEdges(whole_, vertexCount);
    for (const Json* frame : frames()) requireSoundEdges(*frame, vertexCount);
  }

  /// The edges of the first frame that has some, which requireSoundEdges has found to be sound.
  std::vector<Crease> creases() const {
    std::vector<const Json*> all = frames();
    all.insert(all.begin(), &whole_);
    for (const Json* frame : all) {
      const Json* edges = find(*frame, "edges_vertices");
      if (edges == nullptr) continue;
      const Json* assignment = find(*frame, "edges_assignment");
      const Json* angles = find(*frame, "edges_foldAngle");
      std::vector<Crease> creases;
      for (std::size_t k = 0; k < edges->size(); ++k) {
        Crease& crease = creases.emplace_back();
        crease.from = (*edges)[k][0].get<int>();
        crease.to = (*edges)[k][1].get<int>();
        if (assignment != nullptr) crease.assignment = letterOf((*assignment)[k]);
        const bool hasAngle = angles != nullptr && (*angles)[k].is_number();
        if (hasAngle) crease.foldAngle = (*angles)[k].get<double>();
      }
      return creases;
    }
    return {};
  }

  /// Kirireel's own list of joints; null when there is none.
  const Json* ownJoints() const { return find(whole_, kJoints); }

  /// Kirireel's own list of pulled tiles, of so many; none when all are.
  std::optional<std::vector<int>> pulledTiles(std::size_t tileCount) const {
    const Json* list = find(whole_, kPulled);
    if (list == nullptr) return std::nullopt;
    std::vector<int> pulled = wholeNumbers(*list, 0);
    for (const int tile : pulled) {
      if (tile >= 0 && tile < static_cast<int>(tileCount)) continue;
      throw fault(fmt::format("{} names tile {}, but there are tiles 0-{}; correct it", kPulled,
                              tile, tileCount - 1));
    }
    return pulled;
  }

  // A list of numbers that fit an int. `index` names the entry in the message.
  std::vector<int> wholeNumbers(const Json& list, std::size_t index) const {
    std::vector<int> numbers;
    for (const Json& value : list) {
      if (fitsInt(value)) numbers.push_back(value.get<int>());
    }
    // A value that is no whole number makes the counts differ.
    if (list.is_array() && numbers.size() == list.size()) return numbers;
    throw fault(
        fmt::format("entry {} is no list of whole numbers; write vertex numbers, from 0", index));
  }

  InputError fault(const std::string& message) const { return inputErrorAt({file_}, message); }

 private:
  // The value of a key; null where the object has none.
  static const Json* find(const Json& object, const char* key) {
    const auto found = object.find(key);
    return found == object.end() ? nullptr : &*found;
  }

  // The frames beyond the file's own, in order.
  std::vector<const Json*> frames() const {
    std::vector<const Json*> found;
    const Json* frames = find(whole_, "file_frames");
    if (frames == nullptr) return found;
    if (!frames->is_array()) throw fault("file_frames is no list of frames; correct or delete it");
    for (const Json& frame : *frames) {
      if (!frame.is_object()) {
        throw fault(fmt::format("entry {} of file_frames is no JSON object; correct or delete it",
                                found.size()));
      }
      found.push_back(&frame);
    }
    return found;
  }

  // Edges name two vertices each, and have as many letters and angles as there are edges.
  void requireSoundEdges(const Json& frame, std::size_t vertexCount) const {
    const Json* coordinates = find(frame, "vertices_coords");
    // A frame without coordinates of its own inherits those of the file.
    if (coordinates != nullptr && !coordinates->empty()) vertexCount = coordinates->size();
    const Json* edges = find(frame, "edges_vertices");
    if (edges == nullptr) return;
    if (!edges->is_array()) throw fault("edges_vertices is no list of edges; correct or delete it");
    std::size_t number = 0;
    for (const Json& edge : *edges) {
      const std::vector<int> ends = wholeNumbers(edge, number);
      const auto exists = [&](int end) {
        return end >= 0 && static_cast<std::size_t>(end) < vertexCount;
      };
      if (ends.size() != 2 || !std::ranges::all_of(ends, exists)) {
        throw fault(
            fmt::format("edge {} does not join two of the vertices 0-{}; correct it, or "
                        "delete edges_vertices",
                        number, vertexCount - 1));
      }
      ++number;
    }
    requireSoundAssignment(frame, edges->size());
    requireSoundAngles(frame, edges->size());
  }

  void requireSoundAssignment(const Json& frame, std::size_t count) const {
    const Json* assignment = find(frame, "edges_assignment");
    if (assignment == nullptr) return;
    if (!assignment->is_array() || assignment->size() != count) {
      throw fault(
          fmt::format("edges_assignment is no list of {} letters, one for each edge; correct "
                      "or delete it",
                      count));
    }
    for (std::size_t k = 0; k < count; ++k) {
      if (letterOf((*assignment)[k]) != 0) continue;
      throw fault(
          fmt::format("edge {} has an assignment that FOLD does not know; write one of B, "
                      "M, V, F, U, C, J",
                      k));
    }
  }

  void requireSoundAngles(const Json& frame, std::size_t count) const {
    const Json* angles = find(frame, "edges_foldAngle");
    if (angles == nullptr) return;
    if (!angles->is_array() || angles->size() != count) {
      throw fault(
          fmt::format("edges_foldAngle is no list of {} angles, one for each edge; correct "
                      "or delete it",
                      count));
    }
    for (std::size_t k = 0; k < count; ++k) {
      const Json& angle = (*angles)[k];
      // FOLD writes null for edges whose angle is unknown, boundaries among them.
      if (angle.is_null() || (angle.is_number() && std::abs(angle.get<double>()) <= 180)) continue;
      throw fault(
          fmt::format("edge {} has a fold angle that is no number of degrees from -180 to "
                      "180, nor null; correct it",
                      k));
    }
  }

  /// The letter of an assignment as a capital; 0 where it is none.
  static char letterOf(const Json& value) {
    if (!value.is_string() || value.get_ref<const std::string&>().size() != 1) return 0;
    const char letter =
        static_cast<char>(std::toupper(static_cast<unsigned char>(value.get<std::string>()[0])));
    return std::string_view("BMVFUCJ").find(letter) == std::string_view::npos ? '\0' : letter;
  }

  // Coordinates of all vertices, metres; z is 0 where it is not given.
  std::vector<Vector3> points(const Json& coordinates) const {
    std::vector<Vector3> points;
    for (const Json& entry : coordinates) {
      Vector3& point = points.emplace_back(Vector3::Zero());
      // Two coordinates are a planar pattern at z = 0.
      const bool isPoint = entry.is_array() && (entry.size() == 2 || entry.size() == 3);
      for (std::size_t axis = 0; isPoint && axis < entry.size(); ++axis) {
        // NaN for what is no number, so that one test below refuses it.
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

/// A joint of another kind than the pivot that it was read as.
Joint ofKind(JointKind kind, const Joint& joint, const FoldReader& reader,
             const std::vector<Tile>& tiles) {
  // The corners of a fixed joint carry no meaning; makeFixedJoint() names those of the model.
  if (kind == JointKind::Fixed) return makeFixedJoint(tiles, joint.a.tile, joint.b.tile);
  if (kind != JointKind::Link) return joint;
  const Joint link = makeLink(tiles, joint.a, joint.b);
  if (link.apart.norm() > 0) return link;
  throw reader.fault(
      fmt::format("the link between tiles {} and {} has no length; leave its kind out to "
                  "join their corners",
                  joint.a.tile, joint.b.tile));
}

std::vector<Joint> readOwnJoints(const FoldReader& reader, const TileTable& tiles, Model& model,
                                 std::vector<std::string>& warnings) {
  JointTable table;
  table.file = tiles.file;
  for (const Json& entry : *reader.ownJoints()) {
    const std::vector<int> numbers = reader.wholeNumbers(entry, table.rows.size());
    if (numbers.size() != 5 && numbers.size() != 6) {
      throw reader.fault(
          fmt::format("joint {} has {} numbers; write tile, vertex, tile, vertex, "
                      "face, and kind unless it is a pivot",
                      table.rows.size(), numbers.size()));
    }
    JointRow& row = table.rows.emplace_back();
    std::copy_n(numbers.begin(), 5, row.values.begin());
    const int kind = numbers.size() == 5 ? 0 : numbers[5];
    if (kind < 0 || kind > 2) {
      throw reader.fault(
          fmt::format("joint {} has the kind {}; write 0 (pivot), 1 (link) or 2 (fixed)",
                      table.rows.size() - 1, kind));
    }
    row.kind = static_cast<JointKind>(kind);
  }
  dropRepeatedJoints(table, model, warnings);
  std::vector<Joint> joints = checkedJoints(table, tiles);
  for (std::size_t k = 0; k < joints.size(); ++k) {
    joints[k] = ofKind(table.rows[k].kind, joints[k], reader, tiles.tiles);
  }
  return joints;
}

/// A flat sheet whose creases have angles goes where they fold it.
void foldAlong(const std::vector<Crease>& creases, const CornerNumbers& faces, Model& model,
               const fs::path& file, std::vector<std::string>& warnings) {
  // The largest opening between joints that a target may have: the same part of a tile as kTooFar
  // in joint_checks.cpp. More means that the angles do not close round a loop.
  constexpr double kTorn = 0.05;  // of a tile
  if (!liesFlat(model.tiles, 1e-9 * modelSize(model))) return;
  std::optional<std::vector<Tile>> folded = foldedTiles(faces, creases, model.tiles);
  if (!folded) return;
  double worst = 0;
  for (const Joint& joint : model.joints) {
    if (joint.kind != JointKind::Pivot) continue;
    const Vector3& a = (*folded)[joint.a.tile].vertices[joint.a.vertex];
    const Vector3& b = (*folded)[joint.b.tile].vertices[joint.b.vertex];
    worst = std::max(worst, (a - b).norm());
  }
  if (worst > kTorn * tileSize(model)) {
    warnings.push_back(
        fmt::format("{}: warning: folded by its edges_foldAngle, joints would open by "
                    "{:.2g} m; the angles are left out, and there is no target",
                    file.string(), worst));
    return;
  }
  model.target = std::move(folded);
}

// Coordinates by vertex number, each from its first corner.
Json coordinatesOf(const std::vector<Tile>& tiles, const CornerNumbers& numbers) {
  Json list = Json::array();
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    for (std::size_t k = 0; k < numbers[i].size(); ++k) {
      // Numbers rise in the order of their first corners, so that a corner with the next number is
      // the first one of its vertex.
      if (numbers[i][k] != std::ssize(list)) continue;
      const Vector3& vertex = tiles[i].vertices[k];
      list.push_back({vertex.x(), vertex.y(), vertex.z()});
    }
  }
  return list;
}

// Three lists of one length: ends, letters, angles in degrees.
void addCreases(const std::vector<Crease>& creases, Json& json) {
  Json edges = Json::array(), assignment = Json::array(), angles = Json::array();
  for (const Crease& crease : creases) {
    edges.push_back({crease.from, crease.to});
    assignment.push_back(std::string(1, crease.assignment));
    angles.push_back(crease.foldAngle ? Json(*crease.foldAngle) : Json());
  }
  json["edges_vertices"] = std::move(edges);
  json["edges_assignment"] = std::move(assignment);
  json["edges_foldAngle"] = std::move(angles);
}

}  // namespace

Model readFold(const fs::path& file, std::vector<std::string>& warnings) {
  const FoldReader reader(file);
  const CornerNumbers faces = reader.faces();
  const std::vector<std::vector<Vector3>> states = reader.states();
  reader.requireSoundEdges(states.front().size());
  const std::vector<Crease> creases = reader.creases();
  const TileTable start = tableOf(file, reader.tiles(faces, states.front()));
  checkTiles(start);
  Model model;
  model.name = file.stem().string();
  model.tiles = start.tiles;
  model.joints = reader.ownJoints() != nullptr ? readOwnJoints(reader, start, model, warnings)
                                               : jointsOfCreases(faces, creases, start.tiles);
  if (states.size() > 1) {
    const TileTable target = tableOf(file, reader.tiles(faces, states.back()));
    checkTarget(target, model, start, warnings);
    model.target = target.tiles;
  }
  if (states.size() == 1) foldAlong(creases, faces, model, file, warnings);
  model.pulledTiles = reader.pulledTiles(model.tiles.size());
  turnClockwiseTiles(start, model, warnings);
  return model;
}

void writeFold(const Model& inOrder, const fs::path& file) {
  const Model model = inFileOrder(inOrder);
  const CornerNumbers numbers = sharedNumbers(model);
  Json json;
  json["file_spec"] = 1.2;
  json["file_creator"] = "Kirireel";
  json["file_classes"] = {model.target ? "animation" : "singleModel"};
  json["frame_title"] = "start";
  // A flat start is a crease pattern, and its edges carry the angles of the target. Otherwise they
  // carry those of the start itself.
  const bool isFlat = liesFlat(model.tiles, 1e-9 * modelSize(model));
  json["frame_classes"] = {isFlat ? "creasePattern" : "foldedForm"};
  json["vertices_coords"] = coordinatesOf(model.tiles, numbers);
  json["faces_vertices"] = numbers;
  addCreases(creasesOf(numbers, model.target && isFlat ? *model.target : model.tiles), json);
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
