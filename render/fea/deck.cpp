// Writes a sheet as an input deck: cards that begin with `*`, lines of data, comments that begin
// with `**`. In this order:
//
//     **                       where it comes from, its units, warnings
//     *NODE, NSET=NALL         number, x, y, z; number from 1
//     *ELEMENT, TYPE=, ELSET=  number and nodes, a block for each tile and neck
//     *ELSET, ELSET=EALL       all elements
//     *NSET, *SURFACE          by tile, by joint, the boundary, reference and control nodes
//     *EQUATION                what ties corners that meet, three a node that follows
//     *RIGID BODY, *MPC        patches and their pins, in meshes that have them
//     *ELEMENT, *SPRING        springs between patches
//
// Where the keywords of CalculiX and Abaqus differ, settings.solver decides (CalculiX User's Manual
// and Abaqus Keywords Reference Guide, the cards by name). Limits that both share are kept: 16
// numbers a line, 20 characters a number, 256 a line.
//
// Nodes in a hexahedron: 1 to 4 round the bottom, anticlockwise seen from the top, 5 to 8 above
// them, 9 to 12 in the middles of the bottom edges, 13 to 16 of the top edges, 17 to 20 of the
// upright ones. That is the order in which element_mesh.h has them already. Faces: S1 bottom, S2
// top, S3 to S6 from corner 1-2 on.
//
// Elements by choice: C3D20R bends without shear locking and costs 8 integration points. Its
// weakness are modes that cost no energy, which a row of elements does not suppress; such tiles
// take C3D20 with 27 points. Linear elements have incompatible modes (C3D8I), without which thin
// plates would lock.
#include "render/fea/deck.h"

#include <algorithm>
#include <iterator>

#include "render/fea/boundary_sets.h"
#include "render/fea/contact_pairs.h"
#include "render/fea/patch_deck.h"
#include "render/fea/periodic.h"
#include "sim/base/interruption.h"
#include "sim/model/neck_stiffness.h"

namespace kirireel {
namespace {

/// Above this number of tiles, sets are left out unless they are asked for. A tile has at least
/// nine sets, and readers look through all names for each name, so that reading them costs the
/// square of their number.
constexpr std::size_t kMostTilesWithSets = 1000;

const char* jointWord(const ElementMesh& mesh) {
  switch (mesh.rule.joints) {
    case JointStyle::Shared:
      if (hasEquations(mesh)) return "*EQUATION of displacements where they lie on one face";
      return "shared nodes, each at the mean of its corners";
    case JointStyle::Equation:
      return "*EQUATION, the lowest node leads; corners keep their gaps";
    case JointStyle::Neck:
      return "necks of material";
    case JointStyle::Patch:
      break;
  }
  return "rigid patches that turn about shared reference nodes";
}

/// What a hinge's spring would be in place of a neck. So that a user can check the order of
/// magnitude: E (Pa), t thickness, w width and L length of the neck (m), see
/// sim/model/neck_stiffness.h.
void appendNeckStiffness(std::string& text, const NeckShape& neck, const DeckSettings& settings,
                         double thickness) {
  append(text,
         "** In the sheet's plane a neck beside a shut slit is a rotational spring of {:.4g} N "
         "m/rad\n** with E = {} Pa: a beam's E t w^3 / (12 L), less what the tiles give at its "
         "ends.\n",
         neckStiffness(settings.material.youngs, thickness, neck.width,
                       std::max(neck.length, neck.kerf)),
         deckNumber(settings.material.youngs));
}

/// The header says what cannot be seen in the numbers: units, what joints are, and the two mistakes
/// that programs do not report (mechanisms, and forces through single nodes).
void appendHeader(std::string& text, const ElementMesh& mesh, const DeckSettings& settings,
                  const DeckOrigin& origin) {
  text += "** A sheet of tiles as finite elements. No material and no step.\n";
  appendOrigin(text, origin, settings.unit);
  append(text,
         "** {} tiles, {} nodes, {} elements, {}.\n"
         "** Keywords of {}. Joints: {}.\n",
         mesh.tiles.size(), mesh.nodes.size(), mesh.elements.size(),
         mesh.rule.quadratic ? "quadratic" : "linear",
         settings.solver == Solver::Abaqus ? "Abaqus" : "CalculiX", jointWord(mesh));
  if (mesh.rule.countsFrom != 0) {
    append(text, "** Sets count from 0: TILE_00000 is tile {} of the model's file.\n",
           mesh.rule.countsFrom);
  }
  text +=
      "** Slits that are shut have nodes in one place on both sides: never merge duplicate "
      "nodes.\n";
  if (mesh.rule.joints == JointStyle::Neck) {
    // Sheets with necks have no ideal hinges, so the warnings below do not concern them.
    const NeckShape& neck = mesh.rule.neck;
    append(
        text,
        "** The flat start as it is cut, in one piece: necks {} m wide and {} m long, fillets of "
        "{} m,\n** kerf {} m.\n",
        deckNumber(neck.width), deckNumber(std::max(neck.length, neck.kerf)),
        deckNumber(neck.radius), deckNumber(neck.kerf));
    appendNeckStiffness(text, neck, settings, origin.thickness);
    return;
  }
  append(text,
         "** Largest gap between corners that a joint holds together: {} m.\n"
         "** WARNING: joints are ideal hinges, so the sheet is a mechanism. A linear static step "
         "that\n"
         "** holds too little of it ends without a warning and with meaningless displacements.\n",
         deckNumber(mesh.largestGap));
  if (mesh.rule.joints == JointStyle::Patch) {
    append(text, "** Patches have a radius of {} m.\n", deckNumber(mesh.rule.patchRadius));
    if (mesh.springs.empty()) return;
    append(text,
           "** {} torsional springs stand between patches. They rest in this state; jobs add the "
           "moments\n** that the run's springs have in it.\n",
           mesh.springs.size());
    return;
  }
  text +=
      "** WARNING: forces through a single node depend on the mesh: finer elements make a softer\n"
      "** joint, without limit. Use rigid patches of a fixed radius where its stiffness matters.\n";
}

/// All nodes in one block, those of rigid patches last: some readers know one block alone.
void appendNodes(std::string& text, const std::vector<Vector3>& nodes, DeckUnit unit) {
  const double scale = unitScale(unit).length;
  text += "*NODE, NSET=NALL\n";
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const Vector3 at = scale * nodes[k];
    append(text, "{}, {}, {}, {}\n", k + 1, deckNumber(at.x()), deckNumber(at.y()),
           deckNumber(at.z()));
  }
}

/// The numbers of one element; a row too long for one line goes on in the next.
void appendElement(std::string& text, const ElementMesh& mesh, int number) {
  constexpr std::size_t kNumbersInLine = 16;
  // The element's own number, then up to 20 nodes, all from 0; appendNumbers adds the 1.
  std::array<int, 21> row{number};
  std::ranges::copy(mesh.elements[number].nodes, row.begin() + 1);
  const std::size_t count = nodeCount(mesh.rule) + 1;
  if (count <= kNumbersInLine) return appendNumbers(text, row.data(), count);
  appendNumbers(text, row.data(), kNumbersInLine);
  // A line of data that ends in a comma continues; the line break behind it is written anew.
  text.back() = ',';
  text += '\n';
  appendNumbers(text, row.data() + kNumbersInLine, count - kNumbersInLine);
}

/// The tiles, then the necks between them, by name.
std::vector<std::pair<std::string, const TileElements*>> partsOf(const ElementMesh& mesh) {
  std::vector<std::pair<std::string, const TileElements*>> parts;
  for (const auto& [word, tiles] : {std::pair{"TILE", &mesh.tiles}, {"NECK", &mesh.necks}}) {
    for (std::size_t k = 0; k < tiles->size(); ++k) {
      parts.emplace_back(fmt::format("{}_{:05}", word, k), &(*tiles)[k]);
    }
  }
  return parts;
}

void appendPart(std::string& text, const ElementMesh& mesh, const std::string& name,
                const TileElements& tile) {
  checkInterruption();
  append(text, "*ELEMENT, TYPE={}, ELSET={}\n", elementType(tile, mesh.rule), name);
  for (int k = 0; k < tile.elementCount; ++k) appendElement(text, mesh, tile.firstElement + k);
}

/// One set for each offset that occurs: *SHELL SECTION takes a set, and OFFSET belongs to the
/// section.
void appendOffsetSets(std::string& text, const ElementMesh& mesh) {
  for (const ShellOffset& shells : shellOffsets(mesh)) {
    append(text, "*ELSET, ELSET={}\n", shells.set);
    std::vector<int> elements;
    for (const int tile : shells.tiles) {
      const TileElements& own = mesh.tiles[tile];
      for (int k = 0; k < own.elementCount; ++k) elements.push_back(own.firstElement + k);
    }
    appendNumbers(text, elements.data(), elements.size());
  }
}

/// All elements of one type in one block without a set of their own.
void appendAllElements(std::string& text, const ElementMesh& mesh) {
  std::string last;
  for (const auto& [name, tile] : partsOf(mesh)) {
    const std::string type = elementType(*tile, mesh.rule);
    if (type != last) append(text, "*ELEMENT, TYPE={}\n", type);
    last = type;
    for (int k = 0; k < tile->elementCount; ++k) appendElement(text, mesh, tile->firstElement + k);
  }
}

/// Faces 1 and 2 of a prism are its bottom and its top, 3 to 6 its sides.
void appendSurfaces(std::string& text, const TileElements& tile, const std::string& name) {
  append(text, "*SURFACE, NAME={}_SBOT, TYPE=ELEMENT\n", name);
  for (int k = 0; k < tile.layerCount; ++k) append(text, "{}, S1\n", tile.firstElement + k + 1);
  append(text, "*SURFACE, NAME={}_STOP, TYPE=ELEMENT\n", name);
  // Elements of a tile are numbered layer by layer, the bottom layer first.
  const int lastLayer = tile.firstElement + tile.elementCount - tile.layerCount;
  for (int k = 0; k < tile.layerCount; ++k) append(text, "{}, S2\n", lastLayer + k + 1);
  append(text, "*SURFACE, NAME={}_SIDE, TYPE=ELEMENT\n", name);
  for (const ElementFace& face : tile.sides) {
    append(text, "{}, S{}\n", face.element + 1, face.side + 3);
  }
  // Sides come sorted by tile edge, so a new surface begins where the edge changes. Necks have no
  // edges (-1) and take part in _SIDE alone.
  int edge = -1;
  for (const ElementFace& face : tile.sides) {
    if (face.tileEdge < 0) continue;
    if (face.tileEdge != edge) {
      append(text, "*SURFACE, NAME={}_S{}, TYPE=ELEMENT\n", name, face.tileEdge);
    }
    edge = face.tileEdge;
    append(text, "{}, S{}\n", face.element + 1, face.side + 3);
  }
}

/// Shells and plane elements have one face; BOT, TOP and surfaces would say nothing.
void appendTileSets(std::string& text, const ElementMesh& mesh) {
  for (const auto& [name, tile] : partsOf(mesh)) {
    appendNodeSet(text, name + "_N", tile->nodes);
    if (mesh.rule.family != ElementFamily::Solid) continue;
    appendNodeSet(text, name + "_BOT", tile->bottom);
    appendNodeSet(text, name + "_TOP", tile->top);
    appendSurfaces(text, *tile, name);
  }
}

void appendJointSets(std::string& text, const ElementMesh& mesh) {
  for (std::size_t j = 0; j < mesh.joints.size(); ++j) {
    appendNodeSet(text, fmt::format("JOINT_{:05}_A", j), mesh.joints[j].a);
    appendNodeSet(text, fmt::format("JOINT_{:05}_B", j), mesh.joints[j].b);
  }
}

/// Each once and rising; a node that several joints share would be named as often.
std::vector<int> allJointNodes(const ElementMesh& mesh) {
  std::vector<int> nodes;
  for (const JointNodes& joint : mesh.joints) {
    std::ranges::copy(joint.a, std::back_inserter(nodes));
    std::ranges::copy(joint.b, std::back_inserter(nodes));
  }
  std::ranges::sort(nodes);
  const auto repeated = std::ranges::unique(nodes);
  nodes.erase(repeated.begin(), repeated.end());
  return nodes;
}

/// u_k - u_0 = 0 for x, y and z (1, 2, 3). The first term is the dependent one, in both programs;
/// it must not be dependent twice, so all nodes of a cluster follow its lowest.
void appendEquations(std::string& text, const ElementMesh& mesh) {
  for (const NodeCluster& cluster : mesh.clusters) {
    for (std::size_t k = 1; k < cluster.nodes.size(); ++k) {
      for (int axis = 1; axis <= 3; ++axis) {
        append(text, "*EQUATION\n2\n{0}, {2}, 1., {1}, {2}, -1.\n", cluster.nodes[k] + 1,
               cluster.nodes[0] + 1, axis);
      }
    }
  }
}

std::vector<int> countedFrom(std::size_t first, std::size_t count) {
  std::vector<int> numbers;
  for (std::size_t k = 0; k < count; ++k) numbers.push_back(static_cast<int>(first + k));
  return numbers;
}

SetChoice chosenSets(SetChoice choice, std::size_t tiles) {
  if (choice != SetChoice::Usual) return choice;
  return tiles <= kMostTilesWithSets ? SetChoice::All : SetChoice::None;
}

}  // namespace

std::vector<ShellOffset> shellOffsets(const ElementMesh& mesh) {
  std::vector<ShellOffset> groups;
  // Levels are exactly 0, 0.5 or 1: shellLevels in element_mesh.cpp chooses among these.
  for (const auto& [level, set] :
       {std::pair{0.0, "SHELLS_BOTTOM"}, {0.5, "SHELLS_MIDDLE"}, {1.0, "SHELLS_TOP"}}) {
    ShellOffset group{set, level - 0.5, {}};
    for (std::size_t t = 0; t < mesh.tiles.size(); ++t) {
      if (mesh.tiles[t].level == level) group.tiles.push_back(static_cast<int>(t));
    }
    if (!group.tiles.empty()) groups.push_back(std::move(group));
  }
  // OFFSET=0 is the default: then one section for EALL does.
  const bool isAlone = groups.size() == 1 && groups[0].offset == 0;
  return isAlone ? std::vector<ShellOffset>() : groups;
}

const char* elementType(const TileElements& tile, const ElementRule& rule) {
  if (rule.family == ElementFamily::Shell) return rule.quadratic ? "S8R" : "S4";
  if (rule.family == ElementFamily::Plane) return rule.quadratic ? "CPS8R" : "CPS4";
  if (!rule.quadratic) return "C3D8I";
  // A row of elements with reduced integration bends at no cost.
  return tile.isRow ? "C3D20" : "C3D20R";
}

std::string meshDeck(const ElementMesh& mesh, const DeckSettings& settings,
                     const DeckOrigin& origin) {
  // Numbers: the mesh's nodes, then those of patches, then control nodes. Sets below rely on it.
  const PatchDeck patches(mesh, settings.solver);
  std::vector<Vector3> nodes = mesh.nodes;
  nodes.insert(nodes.end(), patches.nodes().begin(), patches.nodes().end());
  const std::size_t firstControl = nodes.size();
  if (settings.periodic)
    std::ranges::copy(controlPositions(periodicity(mesh), mesh), std::back_inserter(nodes));
  const SetChoice sets = chosenSets(settings.sets, mesh.tiles.size());

  std::string text;
  appendHeader(text, mesh, settings, origin);
  appendNodes(text, nodes, settings.unit);
  if (sets == SetChoice::None) {
    appendAllElements(text, mesh);
  } else {
    for (const auto& [name, tile] : partsOf(mesh)) appendPart(text, mesh, name, *tile);
  }
  append(text, "*ELSET, ELSET=EALL, GENERATE\n1, {}, 1\n", mesh.elements.size());
  if (sets == SetChoice::All) appendTileSets(text, mesh);
  if (sets != SetChoice::None) appendJointSets(text, mesh);
  appendNodeSet(text, "NJOINT", allJointNodes(mesh));
  for (const NamedNodes& set : boundarySets(mesh)) appendNodeSet(text, set.name, set.nodes);
  appendNodeSet(text, "NREFERENCE", countedFrom(mesh.nodes.size(), patches.placedCount()));
  appendNodeSet(text, "NCONTROL", countedFrom(firstControl, nodes.size() - firstControl));
  if (mesh.rule.family == ElementFamily::Shell) appendOffsetSets(text, mesh);
  if (settings.contactFriction) appendContactSurfaces(text, contactPairs(mesh));
  if (hasEquations(mesh)) appendEquations(text, mesh);
  patches.appendBodies(text);
  patches.appendSprings(text, settings.unit);
  return text;
}

}  // namespace kirireel
