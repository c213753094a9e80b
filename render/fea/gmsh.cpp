// Writes the ASCII format MSH 4.1 (Gmsh reference manual, "MSH file format"). The order of sections
// is:
//
//     $MeshFormat      4.1 0 8: version, 0 for ASCII, 8 bytes a real
//     $PhysicalNames   count; then dimension, number, "name" of each group
//     $Entities        counts of points, curves, surfaces, volumes; then each with its place or
//                      box, its groups, and the entities that bound it (none are named here)
//     $Nodes           blocks, nodes, smallest and largest number; by block: dimension, entity, 0,
//                      count, then the numbers, then the positions
//     $Elements        blocks, elements, smallest and largest number; by block: dimension, entity,
//                      kind, count, then number and nodes of each
//
// An element belongs to an entity and an entity to groups. An element therefore occurs once in the
// file and not once per group, unlike in the older format 2.2. A node is in one block only: the
// first that contains it, points of joints before parts.
//
// There are few groups by default, because Gmsh reads thousands of them slowly.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "render/fea/deck.h"

namespace kirireel::fea {
namespace {

// Gmsh's element type numbers.
constexpr int kPoint = 15;
/// Types 3 and 16 have 4 and 8 nodes, 5 and 17 have 8 and 20.
constexpr int kQuadrilateral[] = {3, 16};  ///< linear, quadratic
constexpr int kHexahedron[] = {5, 17};
constexpr int kLine[] = {1, 8};

/// Positions of Gmsh's hexahedron edge nodes in Abaqus's order. Gmsh orders edges by their lower
/// corner: 0-1, 0-3, 0-4, 1-2, 1-5, 2-3, 2-6, 3-7, 4-5, 4-7, 5-6, 6-7. Abaqus has those of the
/// bottom (8 to 11), of the top (12 to 15), the upright ones (16 to 19).
constexpr std::array<int, 12> kHexahedronEdges = {8, 11, 16, 9, 17, 10, 18, 19, 12, 15, 13, 14};

/// An element's nodes in Gmsh's order.
std::vector<int> solid(const Element& element, bool quadratic) {
  std::vector<int> nodes(element.nodes.begin(), element.nodes.begin() + 8);
  if (!quadratic) return nodes;
  for (const int place : kHexahedronEdges) nodes.push_back(element.nodes[place]);
  return nodes;
}

/// The nodes of a face, seen from outside: corners, then the middles of its edges. Eight-node
/// quadrilaterals have the same order in both programs.
std::vector<int> face(const Element& element, const std::array<int, 8>& places, bool quadratic) {
  std::vector<int> nodes;
  for (int k = 0; k < (quadratic ? 8 : 4); ++k) nodes.push_back(element.nodes[places[k]]);
  return nodes;
}

constexpr std::array<int, 8> kBottomFace = {0, 3, 2, 1, 11, 10, 9, 8};
constexpr std::array<int, 8> kTopFace = {4, 5, 6, 7, 12, 13, 14, 15};

/// `side` is 0 to 3. Order of middles: bottom edge, upright edge of the next corner, top edge,
/// upright edge of this corner.
std::array<int, 8> sideFace(int side) {
  const int next = (side + 1) % 4;
  return {side, next, next + 4, side + 4, 8 + side, 16 + next, 12 + side, 16 + side};
}

/// Elements of one kind that belong to one entity.
struct Block {
  int dimension = 0;
  int entity = 0;
  int kind = 0;
  std::vector<std::vector<int>> elements;  ///< their nodes, zero-based
};

/// A named group with its number, counted per dimension.
struct Group {
  int dimension = 0;
  int number = 0;
  std::string name;
};

/// Sides of a part with the same name.
struct SideEntity {
  int part = 0;
  std::vector<int> groups;
};

/// Collects groups, entities and elements, and writes them section by section.
class GmshText {
 public:
  GmshText(const ElementMesh& mesh, SetChoice sets, const LengthUnit& unit)
      : mesh_(mesh), sets_(sets), unit_(unit), positions_(separatedNodes(mesh)) {
    for (Vector3& position : positions_) position = inUnit(position, unit);
    // Entities are numbered tiles first, then necks.
    for (const TileElements& tile : mesh.tiles) parts_.push_back(&tile);
    for (const TileElements& neck : mesh.necks) parts_.push_back(&neck);
    addGroup(bodyDimension(), "TILES");
    if (!mesh.necks.empty()) addGroup(bodyDimension(), "NECKS");
    if (isSolid()) {
      for (const char* name : {"BOTTOM", "TOP"}) addGroup(2, name);
      if (sets == SetChoice::All) addGroup(2, "SIDES");
    }
    const bool areNamed = sets == SetChoice::All || sets == SetChoice::Joints;
    if (!mesh.joints.empty() && (areNamed || mesh.rule.joints == JointStyle::Shared)) {
      addGroup(0, "JOINTS");
      addJoints();
    }
    for (std::size_t k = 0; k < parts_.size(); ++k) addPart(k);
    if (mesh.rule.joints == JointStyle::Neck) addNamedSides();
  }

  std::string text() const {
    std::string text = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
    appendText(text, "$Comments\nunit {}\n$EndComments\n", unit_.name);
    appendText(text, "$PhysicalNames\n{}\n", groups_.size());
    for (const Group& group : groups_) {
      appendText(text, "{} {} \"{}\"\n", group.dimension, group.number, group.name);
    }
    text += "$EndPhysicalNames\n";
    appendEntities(text);
    appendNodes(text);
    appendElements(text);
    return text;
  }

 private:
  int addGroup(int dimension, const std::string& name) {
    groups_.push_back({dimension, ++groupsOf_[dimension], name});
    return groups_.back().number;
  }

  /// One entity per node of joints, independent of the number of joints that share it.
  void addJoints() {
    for (std::size_t j = 0; j < mesh_.joints.size(); ++j) {
      for (const auto& [nodes, ending] :
           {std::pair{&mesh_.joints[j].a, "A"}, {&mesh_.joints[j].b, "B"}}) {
        const bool isNamed = sets_ == SetChoice::All || sets_ == SetChoice::Joints;
        const int group = isNamed ? addGroup(0, fmt::format("JOINT_{:05}_{}", j, ending)) : 0;
        for (const int node : *nodes) {
          std::vector<int>& groups = pointGroups_[node];
          // Group 1 of dimension 0 is JOINTS, which was added first.
          if (groups.empty()) groups.push_back(1);
          if (isNamed) groups.push_back(group);
        }
      }
    }
    int entity = 0;
    for (const auto& [node, groups] : pointGroups_) {
      blocks_.push_back({0, ++entity, kPoint, {{node}}});
    }
  }

  bool isSolid() const { return mesh_.rule.family == ElementFamily::Solid; }
  int bodyDimension() const { return isSolid() ? 3 : 2; }

  /// Bodies of solids are volumes, those of shells and plane elements surfaces.
  void addPart(std::size_t number) {
    const TileElements& part = *parts_[number];
    const bool quadratic = mesh_.rule.quadratic;
    const int k = static_cast<int>(number);
    Block body{bodyDimension(), k + 1, (isSolid() ? kHexahedron : kQuadrilateral)[quadratic], {}};
    for (int e = part.firstElement; e < part.firstElement + part.elementCount; ++e) {
      const std::array<int, 20>& nodes = mesh_.elements[e].nodes;
      body.elements.push_back(
          isSolid() ? solid(mesh_.elements[e], quadratic)
                    : std::vector<int>(nodes.begin(), nodes.begin() + nodeCount(mesh_.rule)));
    }
    if (isSolid()) addFaces(part, k);
    blocks_.push_back(std::move(body));
    namePart(number);
  }

  /// The sides of a sheet with necks: XMIN to YMAX, and SLITS for all others. One entity per part
  /// and name, after the other surfaces. Shells and plane elements have curves.
  void addNamedSides() {
    std::map<std::pair<int, int>, std::size_t> nameOf;  // of element and side
    for (std::size_t end = 0; end < 4; ++end) {
      for (const ElementFace& face : mesh_.ends.faces[end]) {
        nameOf[{face.element, face.side}] = end;
      }
    }
    constexpr const char* kNames[] = {"XMIN", "XMAX", "YMIN", "YMAX", "SLITS"};
    const int dimension = bodyDimension() - 1;
    std::array<int, 5> groups{};
    int entity = isSolid() ? 3 * static_cast<int>(parts_.size()) : 0;
    for (std::size_t k = 0; k < parts_.size(); ++k) {
      std::array<std::vector<std::vector<int>>, 5> elements;
      for (const ElementFace& side : parts_[k]->sides) {
        const auto found = nameOf.find({side.element, side.side});
        elements[found == nameOf.end() ? 4 : found->second].push_back(sideElement(side));
      }
      for (std::size_t name = 0; name < elements.size(); ++name) {
        if (elements[name].empty()) continue;
        if (groups[name] == 0) groups[name] = addGroup(dimension, kNames[name]);
        SideEntity& side = sideEntities_.emplace_back();
        side.part = static_cast<int>(k);
        side.groups = {groups[name]};
        if (isSolid() && sets_ == SetChoice::All) {
          side.groups.push_back(3);  // SIDES
          side.groups.push_back(surfaceGroups_[3 * k + 2]);
        }
        blocks_.push_back({dimension, ++entity,
                           (isSolid() ? kQuadrilateral : kLine)[mesh_.rule.quadratic],
                           std::move(elements[name])});
      }
    }
  }

  /// A side of an element as a separate element.
  std::vector<int> sideElement(const ElementFace& side) const {
    const Element& element = mesh_.elements[side.element];
    if (isSolid()) return face(element, sideFace(side.side), mesh_.rule.quadratic);
    std::vector<int> nodes = {element.nodes[side.side], element.nodes[(side.side + 1) % 4]};
    if (mesh_.rule.quadratic) nodes.push_back(element.nodes[4 + side.side]);
    return nodes;
  }

  /// Surfaces 3 k + 1, 3 k + 2 and 3 k + 3 are the bottom, top and sides of part k.
  void addFaces(const TileElements& part, int number) {
    const bool quadratic = mesh_.rule.quadratic;
    Block faces[3];
    for (int k = 0; k < 3; ++k) faces[k] = {2, 3 * number + k + 1, kQuadrilateral[quadratic], {}};
    const int lastLayer = part.firstElement + part.elementCount - part.layerCount;
    for (int k = 0; k < part.layerCount; ++k) {
      faces[0].elements.push_back(
          face(mesh_.elements[part.firstElement + k], kBottomFace, quadratic));
      faces[1].elements.push_back(face(mesh_.elements[lastLayer + k], kTopFace, quadratic));
    }
    for (const ElementFace& side : part.sides) {
      faces[2].elements.push_back(
          face(mesh_.elements[side.element], sideFace(side.side), quadratic));
    }
    for (Block& block : faces) {
      // No program can show a surface without elements.
      const bool isSide = &block == &faces[2];
      const bool hasSides = sets_ == SetChoice::All && mesh_.rule.joints != JointStyle::Neck;
      if (isSide && (!hasSides || block.elements.empty())) continue;
      blocks_.push_back(std::move(block));
    }
  }

  void namePart(std::size_t number) {
    if (sets_ != SetChoice::All) return;
    const std::size_t tiles = mesh_.tiles.size();
    const std::string name = number < tiles ? fmt::format("TILE_{:05}", number)
                                            : fmt::format("NECK_{:05}", number - tiles);
    bodyGroups_.push_back(addGroup(bodyDimension(), name));
    if (!isSolid()) return;
    for (const char* ending : {"_SBOT", "_STOP", "_SIDE"}) {
      surfaceGroups_.push_back(addGroup(2, name + ending));
    }
  }

  /// Points have a position, all others the bounding box of their part. No curves.
  void appendEntities(std::string& text) const {
    const int parts = static_cast<int>(parts_.size());
    const int sides = static_cast<int>(sideEntities_.size());
    appendText(text, "$Entities\n{} {} {} {}\n", pointGroups_.size(), isSolid() ? 0 : sides,
               isSolid() ? 3 * parts + sides : parts, isSolid() ? parts : 0);
    int entity = 0;
    for (const auto& [node, groups] : pointGroups_) {
      const Vector3& at = positions_[node];
      appendText(text, "{} {} {} {} {}", ++entity, at.x(), at.y(), at.z(), groups.size());
      for (const int group : groups) appendText(text, " {}", group);
      text += '\n';
    }
    const auto appendSides = [&](int first) {
      for (int k = 0; k < sides; ++k) {
        const SideEntity& side = sideEntities_[k];
        appendBox(text, first + k + 1, side.part);
        appendText(text, "{}", side.groups.size());
        for (const int group : side.groups) appendText(text, " {}", group);
        text += " 0\n";
      }
    };
    // The group of kind 1 + k % 3: BOTTOM, TOP, SIDES.
    if (isSolid()) {
      for (int k = 0; k < 3 * parts; ++k) appendEntity(text, k, k / 3, 1 + k % 3, surfaceGroups_);
      appendSides(3 * parts);
    } else {
      appendSides(0);
    }
    const int tiles = static_cast<int>(mesh_.tiles.size());
    for (int k = 0; k < parts; ++k) appendEntity(text, k, k, k < tiles ? 1 : 2, bodyGroups_);
    text += "$EndEntities\n";
  }

  /// One entity with its box, its kind's group and, if it has one, a group of its own.
  void appendEntity(std::string& text, int number, int part, int kind,
                    const std::vector<int>& own) const {
    appendBox(text, number + 1, part);
    own.empty() ? appendText(text, "1 {} 0\n", kind)
                : appendText(text, "2 {} {} 0\n", kind, own[number]);
  }

  /// An entity's one-based number and the bounding box of its part.
  void appendBox(std::string& text, int number, int part) const {
    Eigen::AlignedBox3d box;
    for (const int node : parts_[part]->nodes) box.extend(positions_[node]);
    appendText(text, "{} {} {} {} {} {} {} ", number, box.min().x(), box.min().y(), box.min().z(),
               box.max().x(), box.max().y(), box.max().z());
  }

  void appendNodes(std::string& text) const {
    std::vector<bool> isWritten(mesh_.nodes.size());
    // Nodes keep the mesh's numbers, one-based, in any block.
    appendText(text, "$Nodes\n{0} {1} 1 {1}\n", pointGroups_.size() + parts_.size(),
               mesh_.nodes.size());
    const auto appendBlock = [&](int dimension, int entity, const std::vector<int>& nodes) {
      appendText(text, "{} {} 0 {}\n", dimension, entity, nodes.size());
      for (const int node : nodes) appendText(text, "{}\n", node + 1);
      for (const int node : nodes) {
        const Vector3& at = positions_[node];
        appendText(text, "{} {} {}\n", at.x(), at.y(), at.z());
        isWritten[node] = true;
      }
    };
    int entity = 0;
    for (const auto& [node, groups] : pointGroups_) appendBlock(0, ++entity, {node});
    for (std::size_t k = 0; k < parts_.size(); ++k) {
      std::vector<int> own;
      std::ranges::copy_if(parts_[k]->nodes, std::back_inserter(own),
                           [&](int node) { return !isWritten[node]; });
      appendBlock(bodyDimension(), static_cast<int>(k) + 1, own);
    }
    text += "$EndNodes\n";
  }

  void appendElements(std::string& text) const {
    std::size_t count = 0;
    for (const Block& block : blocks_) count += block.elements.size();
    appendText(text, "$Elements\n{0} {1} 1 {1}\n", blocks_.size(), count);
    std::size_t number = 0;
    for (const Block& block : blocks_) {
      appendText(text, "{} {} {} {}\n", block.dimension, block.entity, block.kind,
                 block.elements.size());
      for (const std::vector<int>& nodes : block.elements) {
        appendText(text, "{}", ++number);
        for (const int node : nodes) appendText(text, " {}", node + 1);
        text += '\n';
      }
    }
    text += "$EndElements\n";
  }

  const ElementMesh& mesh_;
  SetChoice sets_;
  LengthUnit unit_;
  std::vector<Vector3> positions_;          ///< of the nodes
  std::vector<const TileElements*> parts_;  ///< tiles, then necks
  std::vector<Group> groups_;
  std::array<int, 4> groupsOf_{};                ///< by dimension
  std::map<int, std::vector<int>> pointGroups_;  ///< by node
  std::vector<int> surfaceGroups_;               ///< of individual faces, in order of entities
  std::vector<int> bodyGroups_;                  ///< of individual tiles and necks
  std::vector<SideEntity> sideEntities_;         ///< of sheets with necks
  std::vector<Block> blocks_;
};

}  // namespace

std::string gmshMesh(const ElementMesh& mesh, SetChoice sets, const LengthUnit& unit) {
  return GmshText(mesh, sets, unit).text();
}

// ------------------------------------------------------------------------------------------------
// Nodes are sorted by their projections on a direction that no grid has. Only neighbours in that
// order need to be compared. If tiles overlap, two nodes may move equally: then one of them is
// moved again.
//
// Let s be the diagonal of the nodes' bounding box. Two nodes coincide if they are less than
// 4e-8 s apart. Such a node moves by 1e-7 s towards the mean of its elements' middles within the
// plane of its tile. It stays on the tile's face. The two sides of a slit move in opposite
// directions.
//
// For nodes at a distance d, projections on (1, sqrt 2, sqrt 3) / sqrt 6 differ by at most d. A
// node is therefore compared with those whose projections are within 4e-8 s. In a grid, nodes of a
// row or column have different projections, so such a list is short: n log n in total.

namespace {

// Fractions of the sheet's size. kOnePlace is less than two moves, to prevent new coincidences.
constexpr double kMove = 1e-7;
constexpr double kOnePlace = 4e-8;

double sizeOf(const std::vector<Vector3>& nodes) {
  return nodes.empty() ? 0 : boundingBox(nodes).sizes().norm();
}

/// For each node whether another coincides with it; `onlyLater`: an earlier one.
std::vector<bool> isAmongOthers(const std::vector<Vector3>& nodes, double tolerance,
                                bool onlyLater) {
  const Vector3 direction = Vector3(1, std::sqrt(2.0), std::sqrt(3.0)) / std::sqrt(6.0);
  std::vector<double> along(nodes.size());
  for (std::size_t k = 0; k < nodes.size(); ++k) along[k] = direction.dot(nodes[k]);
  std::vector<int> order(nodes.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](int node) { return std::pair(along[node], node); });
  std::vector<bool> found(nodes.size());
  for (std::size_t a = 0; a < order.size(); ++a) {
    for (std::size_t b = a + 1; b < order.size(); ++b) {
      if (along[order[b]] - along[order[a]] > tolerance) break;
      if ((nodes[order[a]] - nodes[order[b]]).norm() > tolerance) continue;
      found[std::max(order[a], order[b])] = true;
      if (!onlyLater) found[std::min(order[a], order[b])] = true;
    }
  }
  return found;
}

/// The middle of four corners of an element.
Vector3 middleOf(const ElementMesh& mesh, const Element& element, int first) {
  Vector3 sum = Vector3::Zero();
  for (int k = first; k < first + 4; ++k) sum += mesh.nodes[element.nodes[k]];
  return sum / 4;
}

/// The direction from a node into an element, in the plane of its tile.
Vector3 inwards(const ElementMesh& mesh, const Element& element, int node) {
  const Vector3 bottom = middleOf(mesh, element, 0);
  Vector3 direction = bottom - mesh.nodes[node];
  if (mesh.rule.family == ElementFamily::Solid) {
    // Remove the component along the thickness.
    const Vector3 up = (middleOf(mesh, element, 4) - bottom).normalized();
    direction -= up.dot(direction) * up;
  }
  return direction.normalized();
}

}  // namespace

std::vector<Vector3> separatedNodes(const ElementMesh& mesh) {
  constexpr int kPasses = 4;
  const double size = sizeOf(mesh.nodes);
  std::vector<Vector3> nodes = mesh.nodes;
  for (int pass = 0; pass < kPasses; ++pass) {
    // From the second pass on, only the later of two nodes moves, since both together would
    // coincide again.
    const std::vector<bool> moves = isAmongOthers(nodes, kOnePlace * size, pass > 0);
    if (std::ranges::find(moves, true) == moves.end()) break;
    std::vector<Vector3> directions(nodes.size(), Vector3::Zero());
    for (const Element& element : mesh.elements) {
      for (int k = 0; k < nodeCount(mesh.rule); ++k) {
        const int node = element.nodes[k];
        if (moves[node]) directions[node] += inwards(mesh, element, node);
      }
    }
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      if (moves[k]) nodes[k] += kMove * size * directions[k].normalized();
    }
  }
  return nodes;
}

}  // namespace kirireel::fea
