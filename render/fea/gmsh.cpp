#include "render/fea/gmsh.h"

#include <iterator>

#include <fmt/format.h>

namespace kirireel {
namespace {

/// The places of Gmsh's edge nodes in Abaqus's order.
constexpr std::array<int, 12> kHexahedronEdges = {8, 11, 16, 9, 17, 10, 18, 19, 12, 15, 13, 14};
constexpr std::array<int, 9> kWedgeEdges = {6, 8, 12, 7, 13, 14, 9, 11, 10};

/// What Gmsh calls an element: its type and its nodes in Gmsh's order.
struct GmshElement {
  int type = 0;
  std::vector<int> nodes;
};

GmshElement solid(const Element& element, bool quadratic) {
  GmshElement made;
  made.nodes.assign(element.nodes.begin(), element.nodes.begin() + 2 * element.sides);
  const bool isWedge = element.sides == 3;
  if (!quadratic) {
    made.type = isWedge ? 6 : 5;
    return made;
  }
  made.type = isWedge ? 18 : 17;
  const auto appendEdges = [&](const auto& places) {
    for (const int place : places) made.nodes.push_back(element.nodes[place]);
  };
  isWedge ? appendEdges(kWedgeEdges) : appendEdges(kHexahedronEdges);
  return made;
}

/// The bottom or the top of an element, seen from outside.
GmshElement faceOf(const Element& element, bool isTop, bool quadratic) {
  const int n = element.sides;
  GmshElement made;
  for (int k = 0; k < n; ++k) {
    made.nodes.push_back(element.nodes[isTop ? n + k : (n - k) % n]);
  }
  made.type = n == 3 ? 2 : 3;
  if (!quadratic) return made;
  made.type = n == 3 ? 9 : 16;
  for (int k = 0; k < n; ++k) {
    made.nodes.push_back(element.nodes[isTop ? 3 * n + k : 2 * n + (n - 1 - k)]);
  }
  return made;
}

/// Collects elements and the names of their groups. Each group is an entity of its own.
class GmshText {
 public:
  void beginGroup(int dimension, const std::string& name) {
    ++group_;
    fmt::format_to(std::back_inserter(names_), "{} {} \"{}\"\n", dimension, group_, name);
  }

  void add(const GmshElement& element) {
    ++elementCount_;
    fmt::format_to(std::back_inserter(elements_), "{} {} 2 {} {}", elementCount_, element.type,
                   group_, group_);
    for (const int node : element.nodes) {
      fmt::format_to(std::back_inserter(elements_), " {}", node + 1);
    }
    elements_ += '\n';
  }

  std::string text(const std::vector<Vector3>& nodes) const {
    std::string text = fmt::format(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n{}\n{}$EndPhysicalNames\n"
        "$Nodes\n{}\n",
        group_, names_, nodes.size());
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      fmt::format_to(std::back_inserter(text), "{} {} {} {}\n", k + 1, nodes[k].x(), nodes[k].y(),
                     nodes[k].z());
    }
    fmt::format_to(std::back_inserter(text), "$EndNodes\n$Elements\n{}\n{}$EndElements\n",
                   elementCount_, elements_);
    return text;
  }

 private:
  int group_ = 0;
  std::size_t elementCount_ = 0;
  std::string names_;
  std::string elements_;
};

void addTile(GmshText& text, const ElementMesh& mesh, std::size_t number) {
  const TileElements& tile = mesh.tiles[number];
  const bool quadratic = mesh.rule.quadratic;
  const std::string name = fmt::format("TILE_{:05}", number);
  text.beginGroup(3, name);
  for (int k = 0; k < tile.elementCount; ++k) {
    text.add(solid(mesh.elements[tile.firstElement + k], quadratic));
  }
  text.beginGroup(2, name + "_SBOT");
  for (int k = 0; k < tile.layerCount; ++k) {
    text.add(faceOf(mesh.elements[tile.firstElement + k], false, quadratic));
  }
  text.beginGroup(2, name + "_STOP");
  const int lastLayer = tile.firstElement + tile.elementCount - tile.layerCount;
  for (int k = 0; k < tile.layerCount; ++k) {
    text.add(faceOf(mesh.elements[lastLayer + k], true, quadratic));
  }
}

void addPoints(GmshText& text, const std::string& name, const std::vector<int>& nodes) {
  text.beginGroup(0, name);
  for (const int node : nodes) text.add({15, {node}});
}

}  // namespace

std::string gmshMesh(const ElementMesh& mesh) {
  GmshText text;
  for (std::size_t t = 0; t < mesh.tiles.size(); ++t) addTile(text, mesh, t);
  for (std::size_t j = 0; j < mesh.joints.size(); ++j) {
    addPoints(text, fmt::format("JOINT_{:05}_A", j), mesh.joints[j].a);
    addPoints(text, fmt::format("JOINT_{:05}_B", j), mesh.joints[j].b);
  }
  return text.text(mesh.nodes);
}

}  // namespace kirireel
