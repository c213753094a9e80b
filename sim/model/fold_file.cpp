// FOLD as the origami programs write it, and Kirireel's own keys in it.
//
// Reading goes through the file in four steps.
// 1. Faces: faces_vertices of the file, or of the first frame that has them.
// 2. States: vertices_coords of the file and of each frame that has some. The first is the start,
//    the last the target.
// 3. Joints: the key kirireel:joints, where there is one ([tile, vertex, tile, vertex, face, kind]
//    for each; kind 0 pivot, 1 link, 2 fixed, absent for 0), else the edges (model_formats.h).
// 4. With one state, the target of a flat sheet is that state folded by its edges_foldAngle. With
//    any number of them, springs at folds rest at these angles.
//
// Writing merges corners into one vertex only where they agree to the last bit in both states, so
// that reading gives the same doubles back. Joints of corners that differ by rounding survive
// through kirireel:joints. nlohmann's ordered_json keeps the order of keys, so that the same model
// gives the same bytes.
//
// The library throws where types do not fit; every access below is checked first, so that messages
// speak of faces and edges.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "sim/base/error.h"
#include "sim/base/files.h"
#include "sim/model/model_checks.h"
#include "sim/model/model_formats.h"
#include "sim/model/text_table.h"

namespace kirireel::model {
namespace {

namespace fs = std::filesystem;
constexpr const char* kJoints = "kirireel:joints";
constexpr const char* kPulled = "kirireel:pulled_tiles";

// The whole file as JSON; its syntax errors as ours.
Json parsedFile(const fs::path& file) {
  try {
    return parseJson(readTextFile(file, "give a FOLD file"));
  } catch (const Json::exception& error) {
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
  // in model_checks.cpp. More means that the angles do not close round a loop.
  constexpr double kTornFold = 0.05;  // of a tile
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
  if (worst > kTornFold * tileSize(model)) {
    warnings.push_back(
        fmt::format("{}: warning: folded by its edges_foldAngle, joints would open by "
                    "{:.2g} m; there is no target, and springs at folds rest at these angles",
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
  model.foldAngles = foldAnglesOf(faces, creases, model, file);
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
  addCreases(creasesOf(numbers, inOrder), json);
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
  writeTextFile(file, jsonText(json) + "\n");
}

// ------------------------------------------------------------------------------------------------
// Joints from edges, and edges from joints.
//
// 1. *Joints.* All corners at one vertex are one, unless a cut edge ends there. Then the corners
//    are parted into groups that the vertex's other edges hold together (two faces with a common
//    uncut edge are in one group), and each group is a chain of joints of its own.
// 2. *Folding.* A face is placed by an isometry T of the flat sheet. Across an edge with the fold
//    angle a (radians) its neighbour is placed by
//   T' = T P R(-a, e) P^-1
// where P moves the origin to a point of the edge, and R(-a, e) turns by -a about the edge's
// direction e, with the first face on its left seen from above. A positive angle so lifts the
// neighbour, on the right of e, to the upper side: a valley. The faces are walked outwards from one
// face of each piece. Loops of edges are not checked here: where angles do not fit each other, the
// joints of the last edge in a loop stand open, and the caller measures that.
// 3. *Angles* of a folded state: a = -atan2((n x n') . e, n . n'), n and n' the unit normals of
//    both faces; atan2 keeps its digits near 0 and near 180 degrees, where an arc cosine would lose
//    half of them.
//
// The format: E. D. Demaine, J. S. Ku, R. J. Lang, A new file standard to represent folded
// structures, Fall Workshop on Computational Geometry, 2016.

namespace {

using Ends = std::pair<int, int>;  // vertex numbers, the smaller first

// Below this angle, degrees, an edge is flat.
constexpr double kFlatEdge = 1e-6;

/// A side of a face: corner k and the next.
struct FaceSide {
  int face = 0;
  int corner = 0;
};

// A std::map keeps the edges in the order of their vertex numbers, so that results do not depend on
// addresses or hashes.
std::map<Ends, std::vector<FaceSide>> sidesByEnds(const CornerNumbers& faces) {
  std::map<Ends, std::vector<FaceSide>> sides;
  for (int face = 0; face < std::ssize(faces); ++face) {
    const int count = static_cast<int>(faces[face].size());
    for (int k = 0; k < count; ++k) {
      sides[std::minmax(faces[face][k], faces[face][(k + 1) % count])].push_back({face, k});
    }
  }
  return sides;
}

const Vector3& startOf(const std::vector<Tile>& tiles, const FaceSide& side) {
  return tiles[side.face].vertices[side.corner];
}

const Vector3& endOf(const std::vector<Tile>& tiles, const FaceSide& side) {
  const std::vector<Vector3>& vertices = tiles[side.face].vertices;
  return vertices[(side.corner + 1) % vertices.size()];
}

using FacePairs = std::vector<std::pair<int, int>>;

/// Which faces uncut edges hold together.
struct HeldFaces {
  std::map<int, FacePairs> atVertex;    ///< hinged at this vertex, by an edge that ends there
  std::set<std::pair<int, int>> fixed;  ///< joined to one piece, the smaller number first
};

// Goes through all edges that two faces or more share and no cut parts.
HeldFaces heldFaces(const CornerNumbers& faces, const std::map<Ends, char>& assignments) {
  HeldFaces held;
  for (const auto& [ends, sides] : sidesByEnds(faces)) {
    const auto found = assignments.find(ends);
    const char assignment = found == assignments.end() ? 'U' : found->second;
    // An edge of three faces or more holds each with the next.
    for (std::size_t k = 1; k < sides.size() && assignment != 'C'; ++k) {
      const std::pair<int, int> two = std::minmax(sides[k - 1].face, sides[k].face);
      held.atVertex[ends.first].push_back(two);
      held.atVertex[ends.second].push_back(two);
      if (assignment == 'J' && two.first != two.second) held.fixed.insert(two);
    }
  }
  return held;
}

// Corners of the faces at each vertex, by rising face.
std::map<int, std::vector<Corner>> cornersByVertex(const CornerNumbers& faces) {
  std::map<int, std::vector<Corner>> corners;
  for (int face = 0; face < std::ssize(faces); ++face) {
    for (int k = 0; k < std::ssize(faces[face]); ++k) corners[faces[face][k]].push_back({face, k});
  }
  return corners;
}

/// Corners at one vertex in groups that its uncut edges hold together, by their faces.
std::vector<std::vector<Corner>> groupsAt(const std::vector<Corner>& corners,
                                          const FacePairs& held) {
  std::vector<std::size_t> group(corners.size());
  std::iota(group.begin(), group.end(), 0);
  const auto placeOf = [&](int face) {
    return static_cast<std::size_t>(
        std::find_if(corners.begin(), corners.end(),
                     [face](const Corner& corner) { return corner.tile == face; }) -
        corners.begin());
  };
  for (const auto& [a, b] : held) {
    const std::size_t kept = group[placeOf(a)], lost = group[placeOf(b)];
    // A vertex has few corners, so that renaming a group is cheaper than a tree of sets.
    std::replace(group.begin(), group.end(), lost, kept);
  }
  std::map<std::size_t, std::vector<Corner>> groups;
  for (std::size_t k = 0; k < corners.size(); ++k) groups[group[k]].push_back(corners[k]);
  std::vector<std::vector<Corner>> result;
  for (auto& [number, members] : groups) result.push_back(std::move(members));
  return result;
}

}  // namespace

// Joints come by rising vertex number, and fixed joints after them.
std::vector<Joint> jointsOfCreases(const CornerNumbers& faces, const std::vector<Crease>& creases,
                                   const std::vector<Tile>& tiles) {
  std::map<Ends, char> assignments;
  std::set<int> cutAt;  // vertices
  for (const Crease& crease : creases) {
    assignments[std::minmax(crease.from, crease.to)] = crease.assignment;
    if (crease.assignment == 'C') cutAt.insert({crease.from, crease.to});
  }
  const HeldFaces held = heldFaces(faces, assignments);
  std::vector<Joint> joints;
  for (const auto& [vertex, corners] : cornersByVertex(faces)) {
    const auto pairs = held.atVertex.find(vertex);
    const bool isCut = cutAt.contains(vertex);
    const auto groups =
        !isCut ? std::vector<std::vector<Corner>>{corners}
               : groupsAt(corners, pairs == held.atVertex.end() ? FacePairs{} : pairs->second);
    for (const std::vector<Corner>& group : groups) {
      for (std::size_t k = 1; k < group.size(); ++k) {
        const std::pair<int, int> two = std::minmax(group[k - 1].tile, group[k].tile);
        // A joint within one tile says nothing, and one within a rigid piece is held by the fixed
        // joint.
        if (two.first == two.second || held.fixed.contains(two)) continue;
        joints.push_back({group[k - 1], group[k], JointFace::Bottom});
      }
    }
  }
  for (const auto& [a, b] : held.fixed) joints.push_back(makeFixedJoint(tiles, a, b));
  return joints;
}

// Depth first from the lowest face of each piece; a face is placed by the first edge that reaches
// it.
std::optional<std::vector<Tile>> foldedTiles(const CornerNumbers& faces,
                                             const std::vector<Crease>& creases,
                                             const std::vector<Tile>& tiles) {
  std::map<Ends, double> angles;
  bool folds = false;
  for (const Crease& crease : creases) {
    // These have one face at each side, so that nothing turns about them.
    if (crease.assignment == 'C' || crease.assignment == 'B') continue;
    const double angle = crease.foldAngle.value_or(0);
    angles[std::minmax(crease.from, crease.to)] = angle;
    folds = folds || std::abs(angle) > kFlatEdge;
  }
  if (!folds) return std::nullopt;
  const auto sides = sidesByEnds(faces);
  std::vector<std::optional<Eigen::Isometry3d>> placed(faces.size());
  for (std::size_t root = 0; root < faces.size(); ++root) {
    if (placed[root]) continue;
    placed[root] = Eigen::Isometry3d::Identity();
    std::vector<int> waiting = {static_cast<int>(root)};
    while (!waiting.empty()) {
      const int face = waiting.back();
      waiting.pop_back();
      const int count = static_cast<int>(faces[face].size());
      for (int k = 0; k < count; ++k) {
        const Ends ends = std::minmax(faces[face][k], faces[face][(k + 1) % count]);
        const auto angle = angles.find(ends);
        if (angle == angles.end()) continue;
        for (const FaceSide& other : sides.at(ends)) {
          // Each face is placed once, by the first path that reaches it.
          if (placed[other.face]) continue;
          const FaceSide own{face, k};
          // Along the edge with this face on the left, seen from above.
          const double sense = tileNormal(tiles[face]).z() > 0 ? 1 : -1;
          const Vector3 along = sense * (endOf(tiles, own) - startOf(tiles, own)).normalized();
          const Vector3& hinge = startOf(tiles, own);
          Eigen::Isometry3d turn = Eigen::Isometry3d::Identity();
          turn.translate(hinge);
          turn.rotate(Eigen::AngleAxisd(-angle->second * kDegree, along));
          turn.translate(-hinge);
          placed[other.face] = *placed[face] * turn;
          waiting.push_back(other.face);
        }
      }
    }
  }
  std::vector<Tile> folded = tiles;
  for (std::size_t face = 0; face < faces.size(); ++face) {
    for (Vector3& vertex : folded[face].vertices) vertex = *placed[face] * vertex;
  }
  return folded;
}

namespace {

/// 1 where a file's angle counts seen from the upper side of a tile, else -1: those of a flat sheet
/// count seen from above.
double fileSign(const Model& model, bool isFlat, int tile) {
  return isFlat && tileNormal(model.tiles[tile]).z() < 0 ? -1 : 1;
}

void foldBy(double degrees, Crease& crease) {
  crease.foldAngle = std::abs(degrees) > kFlatEdge ? degrees : 0;
  crease.assignment = *crease.foldAngle > 0 ? 'V' : *crease.foldAngle < 0 ? 'M' : 'F';
}

}  // namespace

std::map<std::pair<int, int>, double> foldAnglesOf(const CornerNumbers& faces,
                                                   const std::vector<Crease>& creases,
                                                   const Model& model, const fs::path& file) {
  const auto sides = sidesByEnds(faces);
  const bool isFlat = liesFlat(model.tiles, 1e-9 * modelSize(model));
  std::map<std::pair<int, int>, double> angles;
  for (const Crease& crease : creases) {
    const auto both = sides.find(std::minmax(crease.from, crease.to));
    const bool folds = std::string_view("BCJ").find(crease.assignment) == std::string_view::npos;
    if (!crease.foldAngle || !folds || both == sides.end() || both->second.size() != 2) continue;
    const FaceSide &first = both->second[0], &second = both->second[1];
    if (first.face == second.face) continue;
    const double angle = fileSign(model, isFlat, first.face) * *crease.foldAngle * kDegree;
    const auto [known, isNew] = angles.try_emplace({first.face, second.face}, angle);
    if (!isNew && std::abs(known->second - angle) > kFlatEdge * kDegree) {
      throw inputErrorAt(
          {file}, fmt::format("edges_foldAngle has the angles {:g} and {:g} for two "
                              "edges of the faces {} and {}, which turn about one "
                              "line; correct one of the two",
                              known->second / kDegree, angle / kDegree, first.face, second.face));
    }
    // Faces of one sense, which flat ones have, run along their edge in opposite directions.
    const bool isAlike =
        isFlat || faces[first.face][first.corner] != faces[second.face][second.corner];
    angles.try_emplace({second.face, first.face}, isAlike ? angle : -angle);
  }
  return angles;
}

std::vector<Crease> creasesOf(const CornerNumbers& faces, const std::vector<Tile>& state) {
  std::vector<Crease> creases;
  for (const auto& [ends, both] : sidesByEnds(faces)) {
    Crease& crease = creases.emplace_back(Crease{ends.first, ends.second, 'B', {}});
    // A boundary edge has no angle.
    if (both.size() == 1) continue;
    const FaceSide &first = both[0], &second = both[1];
    const Vector3 along = (endOf(state, first) - startOf(state, first)).normalized();
    const Vector3 normal = tileNormal(state[first.face]);
    // Faces of one sense run along their common edge in opposite directions.
    const bool isAlike = faces[first.face][first.corner] != faces[second.face][second.corner];
    const Vector3 other = (isAlike ? 1 : -1) * tileNormal(state[second.face]);
    const double angle = -std::atan2(normal.cross(other).dot(along), normal.dot(other)) / kDegree;
    foldBy(angle, crease);
  }
  return creases;
}

// The edges come in the order of sidesByEnds(), as there. Tiles that were turned round have the
// angles of the sheet as it lies now.
std::vector<Crease> creasesOf(const CornerNumbers& faces, const Model& inOrder) {
  const Model model = inFileOrder(inOrder);
  const bool isFlat = liesFlat(model.tiles, 1e-9 * modelSize(model));
  std::vector<Crease> creases =
      creasesOf(faces, model.target && isFlat ? *model.target : model.tiles);
  auto crease = creases.begin();
  for (const auto& [ends, both] : sidesByEnds(faces)) {
    Crease& own = *crease++;
    if (both.size() != 2) continue;
    const auto found = inOrder.foldAngles.find({both[0].face, both[1].face});
    if (found == inOrder.foldAngles.end()) continue;
    foldBy(fileSign(inOrder, isFlat, both[0].face) * found->second / kDegree, own);
  }
  return creases;
}

}  // namespace kirireel::model
