// Round a corner where tile A is joined to tile B, anticlockwise, lie A's outgoing edge, A, its
// incoming edge, a gap, B's outgoing edge, B, its incoming edge, a gap. So A's incoming flank faces
// B's outgoing one, and B's incoming flank A's outgoing one.
//
// Only these pairs are declared. General contact of all flanks would find others too, but CalculiX
// has pairs alone. Contact between tiles that no joint connects is left to the user of the deck.
//
// Pressure follows from the depth of penetration c (metres). In CalculiX it is linear, p = k c with
// k = E / t: E is Young's modulus (Pa), t the thickness (m). So tiles that overlap by a share e of
// their thickness press by e E, as much as the tile itself would at that strain, and contact is
// about as stiff as the tile behind it. A stiffer k converges worse, a softer one lets tiles sink
// in. Friction sticks along a slope of 0.01 k until it slides at mu p (CalculiX manual, *SURFACE
// BEHAVIOR and *FRICTION). Abaqus has "hard" contact without a stiffness to choose.
#include "render/fea/contact_pairs.h"

#include <algorithm>
#include <set>
#include <tuple>

#include "sim/base/error.h"

namespace kirireel {
namespace {

/// A tile's edge, from its corner `edge` to the next.
using TileEdge = std::pair<int, int>;

/// The corner of a tile that a node belongs to. `edges` has one list a corner. The number of
/// corners where none holds the node.
int cornerOf(const TileElements& tile, int node) {
  const auto holds = [node](const std::vector<int>& edge) {
    return std::ranges::find(edge, node) != edge.end();
  };
  return static_cast<int>(std::ranges::find_if(tile.edges, holds) - tile.edges.begin());
}

/// The pairs of edges that face each other across a gap, each once and sorted, so that decks do not
/// depend on the order of joints: the two joints of a fold or two joints on both faces of one
/// corner name the same gap.
std::set<std::pair<TileEdge, TileEdge>> facingEdges(const ElementMesh& mesh) {
  std::set<std::pair<TileEdge, TileEdge>> pairs;
  for (const JointNodes& joint : mesh.joints) {
    const TileElements &a = mesh.tiles[joint.tileA], &b = mesh.tiles[joint.tileB];
    const int cornerA = cornerOf(a, joint.a[0]), cornerB = cornerOf(b, joint.b[0]);
    const int countA = static_cast<int>(a.edges.size()), countB = static_cast<int>(b.edges.size());
    // Edge k leads from corner k to the next, so the incoming edge of corner c is c - 1.
    const TileEdge intoA(joint.tileA, (cornerA + countA - 1) % countA),
        outOfA(joint.tileA, cornerA);
    const TileEdge intoB(joint.tileB, (cornerB + countB - 1) % countB),
        outOfB(joint.tileB, cornerB);
    pairs.insert(std::minmax(intoA, outOfB));
    pairs.insert(std::minmax(intoB, outOfA));
  }
  return pairs;
}

/// Nodes whose displacements joints determine.
std::vector<bool> nodesOfJoints(const ElementMesh& mesh) {
  std::vector<bool> isTaken = followers(mesh);
  for (const JointNodes& joint : mesh.joints) {
    for (const auto* nodes : {&joint.a, &joint.b}) {
      for (const int node : *nodes) isTaken[node] = true;
    }
  }
  return isTaken;
}

/// The faces along a tile's edge none of whose four corners a joint takes: a contact constraint at
/// a node that *EQUATION or a rigid body determines already would ask for too much of it.
std::vector<ElementFace> freeFaces(const ElementMesh& mesh, const TileEdge& edge,
                                   const std::vector<bool>& isTaken) {
  std::vector<ElementFace> faces;
  for (const ElementFace& face : mesh.tiles[edge.first].sides) {
    const std::array<int, 20>& nodes = mesh.elements[face.element].nodes;
    const int next = (face.side + 1) % 4;
    const bool touchesJoint = isTaken[nodes[face.side]] || isTaken[nodes[next]] ||
                              isTaken[nodes[face.side + 4]] || isTaken[nodes[next + 4]];
    if (face.tileEdge == edge.second && !touchesJoint) faces.push_back(face);
  }
  return faces;
}

}  // namespace

std::vector<ContactPair> contactPairs(const ElementMesh& mesh) {
  if (mesh.rule.family != ElementFamily::Solid || mesh.rule.joints == JointStyle::Neck) {
    throw InputError(
        "error: contact is between the flanks of solid tiles; leave out --deck-contacts, or "
        "--shells and --joints neck");
  }
  const std::vector<bool> isTaken = nodesOfJoints(mesh);
  std::vector<ContactPair> pairs;
  for (const auto& [first, second] : facingEdges(mesh)) {
    ContactPair pair{freeFaces(mesh, first, isTaken), freeFaces(mesh, second, isTaken)};
    if (!pair.a.empty() && !pair.b.empty()) pairs.push_back(std::move(pair));
  }
  // An edge of one or two elements has a joint's node on each of them.
  if (pairs.empty() && !mesh.joints.empty()) {
    throw InputError(
        "error: all faces of the tiles' flanks touch a joint, so none is left for contact; use at "
        "least 3 elements per edge");
  }
  return pairs;
}

void appendContactSurfaces(std::string& text, const std::vector<ContactPair>& pairs) {
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    for (const auto& [faces, ending] : {std::pair{&pairs[k].a, "A"}, {&pairs[k].b, "B"}}) {
      append(text, "*SURFACE, NAME=CONTACT_{:05}_{}, TYPE=ELEMENT\n", k, ending);
      for (const ElementFace& face : *faces) {
        // Faces 1 and 2 of a hexahedron are its bottom and top; 3 to 6 follow its bottom corners.
        append(text, "{}, S{}\n", face.element + 1, face.side + 3);
      }
    }
  }
}

void appendContactCards(std::string& text, std::size_t pairs, const DeckSettings& settings,
                        double thickness) {
  const UnitScale scale = unitScale(settings.unit);
  // k = E / t in the deck's units, pressure by length.
  const double slope = scale.stress * settings.material.youngs / (scale.length * thickness);
  const double friction = settings.contactFriction.value_or(0);
  text += "*SURFACE INTERACTION, NAME=FLANKS\n";
  if (settings.solver == Solver::Calculix) {
    append(text, "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n{}\n", deckNumber(slope));
    if (friction > 0) {
      append(text, "*FRICTION\n{}, {}\n", deckNumber(friction), deckNumber(0.01 * slope));
    }
  } else {
    text += "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=HARD\n";
    if (friction > 0) append(text, "*FRICTION\n{}\n", deckNumber(friction));
  }
  for (std::size_t k = 0; k < pairs; ++k) {
    append(text,
           "*CONTACT PAIR, INTERACTION=FLANKS, TYPE=SURFACE TO SURFACE\n"
           "CONTACT_{0:05}_A, CONTACT_{0:05}_B\n",
           k);
  }
}

}  // namespace kirireel
