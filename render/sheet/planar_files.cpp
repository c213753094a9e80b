// OBJ as PyKirigami writes it: "v x y z" for every corner of every tile, an empty line, "f 1 2 3 4"
// for every tile, numbers from 1.
//
// FOLD (E. D. Demaine, J. S. Ku, R. J. Lang, "A New File Standard to Represent Folded Structures",
// 2016; github.com/edemaine/fold) is JSON:
//
//     file_spec, file_creator, file_classes, file_title
//     vertices_coords   [[x, y, z], ...]     faces_vertices   [[v, v, ...], ...]
//     edges_vertices    [[v, v], ...]        edges_assignment ["B" or "F", ...]
//     file_frames       [{frame_parent: 0, frame_inherit: true, vertices_coords}, ...]
//
// FOLD has vertices that faces share, and our tiles share corners only where joints say so;
// union-find over the joints gives the shared vertices. Joints of the top face are left out, since
// the sheet of the bottoms is what is written.
#include "render/sheet/planar_files.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <numeric>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace kirireel {
namespace {

using Json = nlohmann::ordered_json;

template <typename... Arguments>
void append(std::string& text, fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  fmt::format_to(std::back_inserter(text), format, std::forward<Arguments>(arguments)...);
}

/// Which vertices of tiles are one vertex of the sheet.
struct SharedVertices {
  std::vector<std::vector<int>> faces;  ///< the sheet's vertices round each tile
  int count = 0;
};

/// Numbers are in order of first appearance.
SharedVertices shareVertices(const Model& model) {
  std::vector<int> firstOf;
  int corners = 0;
  for (const Tile& tile : model.tiles) {
    firstOf.push_back(corners);
    corners += static_cast<int>(tile.vertices.size());
  }
  std::vector<int> parent(corners);
  std::iota(parent.begin(), parent.end(), 0);
  const auto lowest = [&](int corner) {
    while (parent[corner] != corner) corner = parent[corner] = parent[parent[corner]];
    return corner;
  };
  for (const Joint& joint : model.joints) {
    if (joint.face == JointFace::Top || joint.kind != JointKind::Pivot) continue;
    const int a = lowest(firstOf[joint.a.tile] + joint.a.vertex);
    const int b = lowest(firstOf[joint.b.tile] + joint.b.vertex);
    parent[std::max(a, b)] = std::min(a, b);
  }
  SharedVertices shared;
  std::vector<int> number(corners, -1);
  for (std::size_t t = 0; t < model.tiles.size(); ++t) {
    std::vector<int>& face = shared.faces.emplace_back();
    for (std::size_t k = 0; k < model.tiles[t].vertices.size(); ++k) {
      const int corner = lowest(firstOf[t] + static_cast<int>(k));
      if (number[corner] < 0) number[corner] = shared.count++;
      face.push_back(number[corner]);
    }
  }
  return shared;
}

/// Corners that a joint leaves apart are written at their mean.
Json coordinates(const SharedVertices& shared, const std::vector<Tile>& tiles) {
  std::vector<Vector3> sums(shared.count, Vector3::Zero());
  std::vector<int> uses(shared.count);
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    for (std::size_t k = 0; k < tiles[t].vertices.size(); ++k) {
      sums[shared.faces[t][k]] += tiles[t].vertices[k];
      ++uses[shared.faces[t][k]];
    }
  }
  Json rows = Json::array();
  for (int v = 0; v < shared.count; ++v) {
    const Vector3 mean = sums[v] / uses[v];
    rows.push_back({mean.x(), mean.y(), mean.z()});
  }
  return rows;
}

/// Sorted by their vertices.
void addEdges(const SharedVertices& shared, Json& fold) {
  std::map<std::pair<int, int>, int> facesAt;
  for (const std::vector<int>& face : shared.faces) {
    for (std::size_t k = 0; k < face.size(); ++k) {
      ++facesAt[std::minmax(face[k], face[(k + 1) % face.size()])];
    }
  }
  Json edges = Json::array();
  Json assignment = Json::array();
  for (const auto& [edge, faces] : facesAt) {
    edges.push_back({edge.first, edge.second});
    assignment.push_back(faces == 1 ? "B" : "F");
  }
  fold["edges_vertices"] = std::move(edges);
  fold["edges_assignment"] = std::move(assignment);
}

Json jointRows(const std::vector<Joint>& joints) {
  Json rows = Json::array();
  for (const Joint& joint : joints) {
    rows.push_back(
        {joint.a.tile, joint.a.vertex, joint.b.tile, joint.b.vertex, static_cast<int>(joint.face)});
  }
  return rows;
}

std::string frameTitle(double time) {
  return fmt::format("t = {} s", time);
}

}  // namespace

std::string planarObjText(const std::vector<Tile>& tiles) {
  std::size_t vertices = 0;
  for (const Tile& tile : tiles) vertices += tile.vertices.size();
  std::string text = fmt::format("# {} vertices {} faces\n", vertices, tiles.size());
  for (const Tile& tile : tiles) {
    for (const Vector3& v : tile.vertices) append(text, "v {} {} {}\n", v.x(), v.y(), v.z());
  }
  text += "\n";
  std::size_t next = 1;
  for (const Tile& tile : tiles) {
    text += "f";
    for (std::size_t k = 0; k < tile.vertices.size(); ++k) append(text, " {}", next++);
    text += "\n";
  }
  return text;
}

std::string foldText(const Model& model, const std::vector<SheetState>& states) {
  const SharedVertices shared = shareVertices(model);
  Json fold = {{"file_spec", 1.2},
               {"file_creator", "Kirireel"},
               {"file_classes", {"animation"}},
               {"file_title", model.name},
               {"frame_title", frameTitle(states[0].time)},
               {"frame_attributes", {"3D"}},
               {"frame_unit", "m"},
               {"vertices_coords", coordinates(shared, states[0].tiles)},
               {"faces_vertices", shared.faces}};
  addEdges(shared, fold);
  fold["kirireel:joints"] = jointRows(model.joints);
  Json frames = Json::array();
  for (std::size_t k = 1; k < states.size(); ++k) {
    frames.push_back({{"frame_title", frameTitle(states[k].time)},
                      {"frame_parent", 0},
                      {"frame_inherit", true},
                      {"vertices_coords", coordinates(shared, states[k].tiles)}});
  }
  fold["file_frames"] = std::move(frames);
  // The model's name may hold bytes that are not UTF-8.
  return fold.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace kirireel
