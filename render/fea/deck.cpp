#include "render/fea/deck.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include <fmt/format.h>

namespace kirireel {
namespace {

constexpr std::size_t kLongestNumber = 20;  ///< characters that CalculiX reads of a number
constexpr int kNumbersInLine = 16;          ///< that CalculiX and Abaqus read of a line
/// Smaller coordinates are rounding; their exponents would take a third digit.
constexpr double kSmallest = 1e-90;

template <typename... Arguments>
void append(std::string& text, fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  fmt::format_to(std::back_inserter(text), format, std::forward<Arguments>(arguments)...);
}

/// Numbers from 0 become numbers from 1.
void appendNumbers(std::string& text, const int* numbers, std::size_t count) {
  for (std::size_t k = 0; k < count; ++k) {
    const bool endsLine = (k + 1) % kNumbersInLine == 0 || k + 1 == count;
    append(text, "{}{}", numbers[k] + 1, endsLine ? "\n" : ", ");
  }
}

void appendNodeSet(std::string& text, const std::string& name, const std::vector<int>& nodes) {
  append(text, "*NSET, NSET={}\n", name);
  appendNumbers(text, nodes.data(), nodes.size());
}

const char* elementType(int sides, bool quadratic) {
  if (sides == 4) return quadratic ? "C3D20" : "C3D8";
  return quadratic ? "C3D15" : "C3D6";
}

const char* jointWord(JointStyle style) {
  switch (style) {
    case JointStyle::Shared:
      return "shared nodes, each at the mean of its corners";
    case JointStyle::Equation:
      return "*EQUATION, the lowest node leads; corners keep their gaps";
    case JointStyle::Patch:
      break;
  }
  return "rigid patches that turn about shared reference nodes";
}

void appendHeader(std::string& text, const ElementMesh& mesh, const std::string& title) {
  append(text,
         "** {}\n"
         "** Written by Kirireel. Lengths in the model's unit, unscaled. No material and no step.\n"
         "** {} tiles, {} nodes, {} elements; four-sided tiles are grids, others fans of wedges.\n"
         "** Joints: {}.\n"
         "** Largest gap between corners that a joint holds together: {}.\n"
         "** WARNING: joints are ideal hinges, so the sheet is a mechanism. A linear static step "
         "that\n"
         "** holds too little of it ends without a warning and with meaningless displacements.\n",
         title, mesh.tiles.size(), mesh.nodes.size(), mesh.elements.size(),
         jointWord(mesh.rule.joints), deckNumber(mesh.largestGap));
  if (mesh.rule.joints != JointStyle::Patch) {
    text +=
        "** WARNING: forces through a single node depend on the mesh: finer elements make a "
        "softer\n"
        "** joint, without limit. Use rigid patches of a fixed radius where its stiffness "
        "matters.\n";
  }
  if (!mesh.rule.quadratic) {
    text += "** Linear elements are too stiff in bending; use quadratic ones where bricks bend.\n";
  }
}

void appendNode(std::string& text, std::size_t number, const Vector3& at) {
  append(text, "{}, {}, {}, {}\n", number, deckNumber(at.x()), deckNumber(at.y()),
         deckNumber(at.z()));
}

void appendNodes(std::string& text, const ElementMesh& mesh) {
  text += "*NODE, NSET=NALL\n";
  for (std::size_t k = 0; k < mesh.nodes.size(); ++k) appendNode(text, k + 1, mesh.nodes[k]);
}

void appendElements(std::string& text, const ElementMesh& mesh, std::size_t tileNumber) {
  const TileElements& tile = mesh.tiles[tileNumber];
  const int sides = mesh.elements[tile.firstElement].sides;
  append(text, "*ELEMENT, TYPE={}, ELSET=TILE_{:05}\n", elementType(sides, mesh.rule.quadratic),
         tileNumber);
  for (int k = tile.firstElement; k < tile.firstElement + tile.elementCount; ++k) {
    std::array<int, 21> row{k};
    std::ranges::copy(mesh.elements[k].nodes, row.begin() + 1);
    const std::size_t count = nodeCount(sides, mesh.rule.quadratic) + 1;
    if (count <= kNumbersInLine) {
      appendNumbers(text, row.data(), count);
      continue;
    }
    appendNumbers(text, row.data(), kNumbersInLine);
    text.back() = ',';  // the row goes on
    text += '\n';
    appendNumbers(text, row.data() + kNumbersInLine, count - kNumbersInLine);
  }
}

/// Face 1 of a prism is its bottom, face 2 its top.
void appendSurfaces(std::string& text, const TileElements& tile, std::size_t number) {
  append(text, "*SURFACE, NAME=TILE_{:05}_SBOT, TYPE=ELEMENT\n", number);
  for (int k = 0; k < tile.layerCount; ++k) append(text, "{}, S1\n", tile.firstElement + k + 1);
  append(text, "*SURFACE, NAME=TILE_{:05}_STOP, TYPE=ELEMENT\n", number);
  const int lastLayer = tile.firstElement + tile.elementCount - tile.layerCount;
  for (int k = 0; k < tile.layerCount; ++k) append(text, "{}, S2\n", lastLayer + k + 1);
}

void appendTileSets(std::string& text, const ElementMesh& mesh) {
  for (std::size_t t = 0; t < mesh.tiles.size(); ++t) {
    const TileElements& tile = mesh.tiles[t];
    appendNodeSet(text, fmt::format("TILE_{:05}_N", t), tile.nodes);
    appendNodeSet(text, fmt::format("TILE_{:05}_BOT", t), tile.bottom);
    appendNodeSet(text, fmt::format("TILE_{:05}_TOP", t), tile.top);
    appendSurfaces(text, tile, t);
  }
}

std::vector<int> sortedOnce(std::vector<int> nodes) {
  std::ranges::sort(nodes);
  const auto repeated = std::ranges::unique(nodes);
  nodes.erase(repeated.begin(), repeated.end());
  return nodes;
}

void appendJointSets(std::string& text, const ElementMesh& mesh) {
  std::vector<int> all;
  for (std::size_t j = 0; j < mesh.joints.size(); ++j) {
    const JointNodes& joint = mesh.joints[j];
    appendNodeSet(text, fmt::format("JOINT_{:05}_A", j), joint.a);
    appendNodeSet(text, fmt::format("JOINT_{:05}_B", j), joint.b);
    std::ranges::copy(joint.a, std::back_inserter(all));
    std::ranges::copy(joint.b, std::back_inserter(all));
  }
  if (!all.empty()) appendNodeSet(text, "NJOINT", sortedOnce(std::move(all)));
}

/// The node that the patches of a cluster turn about, numbered after all others.
int referenceNode(const ElementMesh& mesh, std::size_t cluster) {
  return static_cast<int>(mesh.nodes.size() + cluster);
}

/// For each node whether it follows others, so that nothing else may hold it.
std::vector<bool> followers(const ElementMesh& mesh) {
  std::vector<bool> follows(mesh.nodes.size());
  for (const NodeCluster& cluster : mesh.clusters) {
    if (mesh.rule.joints == JointStyle::Equation) {
      for (std::size_t k = 1; k < cluster.nodes.size(); ++k) follows[cluster.nodes[k]] = true;
    }
    for (const std::vector<int>& patch : cluster.patches) {
      for (const int node : patch) follows[node] = true;
    }
  }
  return follows;
}

/// The bottom corners of all tiles, or what they follow.
std::vector<int> nodesToHold(const ElementMesh& mesh) {
  const std::vector<bool> follows = followers(mesh);
  std::vector<int> nodes;
  for (const TileElements& tile : mesh.tiles) {
    for (const std::vector<int>& edge : tile.edges) {
      if (!follows[edge.front()]) nodes.push_back(edge.front());
    }
  }
  if (mesh.rule.joints == JointStyle::Patch) {
    for (std::size_t c = 0; c < mesh.clusters.size(); ++c) nodes.push_back(referenceNode(mesh, c));
  }
  return sortedOnce(std::move(nodes));
}

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

void appendPatches(std::string& text, const ElementMesh& mesh) {
  if (mesh.clusters.empty()) return;
  text += "*NODE, NSET=NREFERENCE\n";
  for (std::size_t c = 0; c < mesh.clusters.size(); ++c) {
    Vector3 sum = Vector3::Zero();
    for (const int node : mesh.clusters[c].nodes) sum += mesh.nodes[node];
    appendNode(text, referenceNode(mesh, c) + 1,
               sum / static_cast<double>(mesh.clusters[c].nodes.size()));
  }
  for (std::size_t c = 0; c < mesh.clusters.size(); ++c) {
    for (std::size_t k = 0; k < mesh.clusters[c].patches.size(); ++k) {
      const std::string name = fmt::format("PATCH_{:05}_{}", c, k);
      appendNodeSet(text, name, mesh.clusters[c].patches[k]);
      append(text, "*RIGID BODY, NSET={}, REF NODE={}\n", name, referenceNode(mesh, c) + 1);
    }
  }
}

}  // namespace

std::string deckNumber(double value) {
  if (std::abs(value) < kSmallest) return "0.";
  const std::string exact = fmt::format("{}", value);
  return exact.size() <= kLongestNumber ? exact : fmt::format("{:.14g}", value);
}

std::string meshDeck(const ElementMesh& mesh, const std::string& title) {
  std::string text;
  appendHeader(text, mesh, title);
  appendNodes(text, mesh);
  for (std::size_t t = 0; t < mesh.tiles.size(); ++t) appendElements(text, mesh, t);
  append(text, "*ELSET, ELSET=EALL, GENERATE\n1, {}, 1\n", mesh.elements.size());
  appendTileSets(text, mesh);
  appendJointSets(text, mesh);
  if (mesh.rule.joints == JointStyle::Equation) appendEquations(text, mesh);
  if (mesh.rule.joints == JointStyle::Patch) appendPatches(text, mesh);
  appendNodeSet(text, "NHOLD", nodesToHold(mesh));
  return text;
}

std::string jobDeck(const ElementMesh& mesh, const std::string& meshFile) {
  std::string text(
      "** A job to start from: every tile rests on its corners and bends under its own weight.\n"
      "** Replace material, boundary and load by yours; units must fit the mesh's unit of length.\n"
      "** WARNING: joints are ideal hinges. Holding less than NHOLD may leave a mechanism, on "
      "which\n"
      "** a linear static step gives huge displacements and no warning; check the largest |U|.\n");
  if (mesh.rule.joints == JointStyle::Equation) {
    text +=
        "** WARNING: nodes that follow in *EQUATION cannot be held: clamping TILE_00000_N works "
        "for\n"
        "** the tile whose joints all lead, not for others. NHOLD holds leading nodes alone.\n";
  }
  if (mesh.rule.joints == JointStyle::Patch) {
    text += "** WARNING: nodes of rigid patches cannot be held; hold their reference nodes.\n";
  }
  append(text,
         "*INCLUDE, INPUT={}\n"
         "*MATERIAL, NAME=SHEET\n"
         "*ELASTIC\n"
         "1.e9, 0.3\n"
         "*DENSITY\n"
         "1000.\n"
         "*SOLID SECTION, ELSET=EALL, MATERIAL=SHEET\n"
         "*BOUNDARY\n"
         "NHOLD, 1, 3\n"
         "*STEP\n"
         "*STATIC\n"
         "*DLOAD\n"
         "EALL, GRAV, 9.81, 0., 0., -1.\n"
         "*NODE FILE\n"
         "U\n"
         "*EL FILE\n"
         "S\n"
         "*END STEP\n",
         meshFile);
  return text;
}

}  // namespace kirireel
