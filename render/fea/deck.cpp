// Writes a sheet as an input deck: cards that begin with `*`, lines of data, and comments that
// begin with `**`. The order is:
//
//     **                       origin, units, warnings
//     *NODE, NSET=NALL         number, x, y, z; number from 1
//     *ELEMENT, TYPE=, ELSET=  number and nodes, a block for each tile and neck
//     *ELSET, ELSET=EALL       all elements
//     *NSET, *SURFACE          per tile, per joint, boundary, reference and control nodes
//     *EQUATION                ties of coinciding corners, three per dependent node
//     *RIGID BODY, *MPC        patches and their pins, if any
//     *ELEMENT, *SPRING        springs between patches
//
// If the keywords of CalculiX and Abaqus differ, settings.solver decides (CalculiX User's Manual
// and Abaqus Keywords Reference Guide, cards by name). The deck respects limits of both: 16 numbers
// per line, 20 characters per number, 256 per line.
//
// Nodes in a hexahedron: 1 to 4 around the bottom, anticlockwise seen from the top, 5 to 8 above
// them, 9 to 12 in the middles of the bottom edges, 13 to 16 of the top edges, 17 to 20 of the
// upright edges. element_mesh.h has the same order. Faces: S1 bottom, S2 top, S3 to S6 from corner
// 1-2 on.
//
// Element types: C3D20R bends without shear locking and has only 8 integration points. Its weakness
// are zero-energy modes, which a single row of elements does not suppress. Such tiles use C3D20
// with 27 points. Linear elements have incompatible modes (C3D8I), without which thin plates would
// lock.
#include "render/fea/deck.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>

#include "sim/base/error.h"
#include "sim/base/interruption.h"
#include "sim/brick/stiffness.h"

namespace kirireel::fea {
namespace {

/// Larger sheets have sets only on request. A tile has at least nine sets, and programs search all
/// names for each name: the reading time is quadratic in the number of sets.
constexpr std::size_t kMaxTilesWithSets = 1000;

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

/// "0.1 m" for a header, in the unit of the deck.
std::string deckLength(double metres, const UnitScale& scale) {
  return fmt::format("{} {}", deckNumber(metres * scale.length), scale.lengthName);
}

/// "0.1 m" or "0.1 to 0.2 m": the range of one length over all necks.
std::string neckLengths(const ElementMesh& mesh, double writers::NeckShape::*length,
                        const UnitScale& scale) {
  std::vector<double> all;
  for (const MeshNeck& neck : mesh.neckShapes) all.push_back(neck.shape.*length);
  if (all.empty()) all.push_back(writers::shapeAt({}, mesh.rule.neck).*length);
  const auto [least, most] = std::ranges::minmax(all);
  // Lengths from a drawing have noise in their last digits.
  const std::string from = fmt::format("{:.6g}", least * scale.length);
  const std::string to = fmt::format("{:.6g} {}", most * scale.length, scale.lengthName);
  return to.starts_with(from + " ") ? to : from + " to " + to;
}

/// Appends the equivalent hinge stiffness of the necks, a check of the order of magnitude: E
/// modulus, t thickness, w width and L length of the necks, see sim/brick/stiffness.h.
void appendNeckStiffness(std::string& text, const ElementMesh& mesh, const DeckSettings& settings,
                         double thickness) {
  std::vector<double> found;
  double length = 0;
  for (const auto& [slits, corners, shape] : mesh.neckShapes) {
    found.push_back(brick::neckStiffness(settings.material.youngs, thickness, shape.width,
                                         shape.length, corners));
    length = std::max(length, shape.length);
  }
  if (found.empty()) return;
  const auto [least, most] = std::ranges::minmax(found);
  const UnitScale scale = unitScale(settings.unit);
  const std::string stiffest =
      most > 1.0001 * least ? fmt::format(" to {:.4g}", most * scale.length) : "";
  appendText(
      text,
      "** In the sheet's plane a neck next to a closed slit is a rotational spring of {:.4g}{} N "
      "{}/rad\n** with E = {} {}: {}.\n",
      least * scale.length, stiffest, scale.lengthName,
      deckNumber(settings.material.youngs * scale.stress), scale.stressName,
      length > 0 ? "a beam's E t w^3 / (12 L), less what its two tiles give at its ends"
                 : "what its two tiles give, as their corners' angles are");
}

/// The header has what the numbers do not show: units, the kind of joints, and two mistakes that
/// programs do not report (mechanisms, and forces on single nodes).
void appendHeader(std::string& text, const ElementMesh& mesh, const DeckSettings& settings,
                  const DeckOrigin& origin) {
  const UnitScale scale = unitScale(settings.unit);
  text += "** A sheet of tiles as finite elements. No material and no step.\n";
  appendOrigin(text, origin, settings.unit);
  appendText(text,
             "** {} tiles, {} nodes, {} elements, {}.\n"
             "** Keywords of {}. Joints: {}.\n",
             mesh.tiles.size(), mesh.nodes.size(), mesh.elements.size(),
             mesh.rule.quadratic ? "quadratic" : "linear",
             settings.solver == Solver::Abaqus ? "Abaqus" : "CalculiX", jointWord(mesh));
  appendText(text, "** Smallest angle between two sides of an element: {:.3g} degrees.\n",
             smallestElementAngle(mesh));
  if (mesh.rule.countsFrom != 0) {
    appendText(text, "** Sets count from 0: TILE_00000 is tile {} of the model's file.\n",
               mesh.rule.countsFrom);
  }
  text +=
      "** Closed slits have nodes in one place on both sides: never merge duplicate "
      "nodes.\n";
  if (mesh.rule.joints == JointStyle::Neck) {
    // Sheets with necks have no ideal hinges, so the warnings below do not apply.
    appendText(
        text,
        "** The flat start as it is cut, in one piece: necks {} wide and {} long, fillets of "
        "{},\n** kerf {}.\n",
        neckLengths(mesh, &writers::NeckShape::width, scale),
        neckLengths(mesh, &writers::NeckShape::length, scale),
        deckLength(mesh.rule.neck.radius, scale),
        neckLengths(mesh, &writers::NeckShape::kerf, scale));
    appendNeckStiffness(text, mesh, settings, origin.thickness);
    return;
  }
  appendText(
      text,
      "** Largest gap between corners that a joint holds together: {}.\n"
      "** WARNING: joints are ideal hinges, so the sheet is a mechanism. A linear static step "
      "that\n"
      "** holds too little of it ends without a warning and with meaningless displacements.\n",
      deckLength(mesh.largestGap, scale));
  if (mesh.rule.joints == JointStyle::Patch) {
    appendText(text, "** Patches have a radius of {}.\n", deckLength(mesh.rule.patchRadius, scale));
    if (mesh.springs.empty()) return;
    appendText(text,
               "** {} torsional springs connect patches. They rest in this state; jobs add the "
               "moments\n** that the run's springs have in it.\n",
               mesh.springs.size());
    return;
  }
  text +=
      "** WARNING: forces through a single node depend on the mesh: finer elements make a softer\n"
      "** joint, without limit. Use rigid patches of a fixed radius where its stiffness matters.\n";
}

/// All nodes in one block, those of rigid patches last: some programs read only one block.
void appendNodes(std::string& text, const std::vector<Vector3>& nodes, DeckUnit unit) {
  const double scale = unitScale(unit).length;
  text += "*NODE, NSET=NALL\n";
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const Vector3 at = scale * nodes[k];
    appendText(text, "{}, {}, {}, {}\n", k + 1, deckNumber(at.x()), deckNumber(at.y()),
               deckNumber(at.z()));
  }
}

/// The numbers of one element. A row that is too long for one line continues on the next.
void appendElement(std::string& text, const ElementMesh& mesh, int number) {
  constexpr std::size_t kNumbersInLine = 16;
  // The element's own number and up to 20 nodes, zero-based; appendNumbers adds 1.
  std::array<int, 21> row{number};
  std::ranges::copy(mesh.elements[number].nodes, row.begin() + 1);
  const std::size_t count = nodeCount(mesh.rule) + 1;
  if (count <= kNumbersInLine) return appendNumbers(text, row.data(), count);
  appendNumbers(text, row.data(), kNumbersInLine);
  // A data line that ends in a comma continues, so the line break is written again after it.
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
  appendText(text, "*ELEMENT, TYPE={}, ELSET={}\n", elementType(tile, mesh.rule), name);
  for (int k = 0; k < tile.elementCount; ++k) appendElement(text, mesh, tile.firstElement + k);
}

/// One set for each occurring offset: *SHELL SECTION needs a set, and OFFSET belongs to the
/// section.
void appendOffsetSets(std::string& text, const ElementMesh& mesh) {
  for (const ShellOffset& shells : shellOffsets(mesh)) {
    appendText(text, "*ELSET, ELSET={}\n", shells.set);
    std::vector<int> elements;
    for (const int tile : shells.tiles) {
      const TileElements& own = mesh.tiles[tile];
      for (int k = 0; k < own.elementCount; ++k) elements.push_back(own.firstElement + k);
    }
    appendNumbers(text, elements.data(), elements.size());
  }
}

/// All elements of one type in one block without a set for the block.
void appendAllElements(std::string& text, const ElementMesh& mesh) {
  std::string last;
  for (const auto& [name, tile] : partsOf(mesh)) {
    const std::string type = elementType(*tile, mesh.rule);
    if (type != last) appendText(text, "*ELEMENT, TYPE={}\n", type);
    last = type;
    for (int k = 0; k < tile->elementCount; ++k) appendElement(text, mesh, tile->firstElement + k);
  }
}

/// Faces 1 and 2 of a prism are bottom and top, 3 to 6 its sides.
void appendSurfaces(std::string& text, const TileElements& tile, const std::string& name) {
  appendText(text, "*SURFACE, NAME={}_SBOT, TYPE=ELEMENT\n", name);
  for (int k = 0; k < tile.layerCount; ++k) appendText(text, "{}, S1\n", tile.firstElement + k + 1);
  appendText(text, "*SURFACE, NAME={}_STOP, TYPE=ELEMENT\n", name);
  // Elements of a tile are numbered by layers, the bottom layer first.
  const int lastLayer = tile.firstElement + tile.elementCount - tile.layerCount;
  for (int k = 0; k < tile.layerCount; ++k) appendText(text, "{}, S2\n", lastLayer + k + 1);
  appendText(text, "*SURFACE, NAME={}_SIDE, TYPE=ELEMENT\n", name);
  for (const ElementFace& face : tile.sides) {
    appendText(text, "{}, S{}\n", face.element + 1, face.side + 3);
  }
  // Sides are sorted by tile edge, so a new surface begins at each change of the edge. Necks have
  // no edges (-1) and belong only to _SIDE.
  int edge = -1;
  for (const ElementFace& face : tile.sides) {
    if (face.tileEdge < 0) continue;
    if (face.tileEdge != edge) {
      appendText(text, "*SURFACE, NAME={}_S{}, TYPE=ELEMENT\n", name, face.tileEdge);
    }
    edge = face.tileEdge;
    appendText(text, "{}, S{}\n", face.element + 1, face.side + 3);
  }
}

/// Shells and plane elements have one face, so they need no BOT, TOP and surfaces.
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

/// Ascending, without duplicates for nodes of several joints.
std::vector<int> allJointNodes(const ElementMesh& mesh) {
  std::vector<int> nodes;
  for (const JointNodes& joint : mesh.joints) {
    std::ranges::copy(joint.a, std::back_inserter(nodes));
    std::ranges::copy(joint.b, std::back_inserter(nodes));
  }
  std::ranges::sort(nodes);
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

/// u_k - u_0 = 0 for x, y and z (1, 2, 3). In both programs the first term is the dependent one. It
/// must not be dependent twice, so all nodes of a cluster follow the lowest.
void appendEquations(std::string& text, const ElementMesh& mesh) {
  for (const NodeCluster& cluster : mesh.clusters) {
    for (std::size_t k = 1; k < cluster.nodes.size(); ++k) {
      for (int axis = 1; axis <= 3; ++axis) {
        appendText(text, "*EQUATION\n2\n{0}, {2}, 1., {1}, {2}, -1.\n", cluster.nodes[k] + 1,
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
  if (choice != SetChoice::Auto) return choice;
  return tiles <= kMaxTilesWithSets ? SetChoice::All : SetChoice::None;
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
  // OFFSET=0 is the default, so one section for EALL is sufficient.
  const bool isSingleLayer = groups.size() == 1 && groups[0].offset == 0;
  return isSingleLayer ? std::vector<ShellOffset>() : groups;
}

const char* elementType(const TileElements& tile, const ElementRule& rule) {
  if (rule.family == ElementFamily::Shell) return rule.quadratic ? "S8R" : "S4";
  if (rule.family == ElementFamily::Plane) return rule.quadratic ? "CPS8R" : "CPS4";
  if (!rule.quadratic) return "C3D8I";
  // A single row of elements with reduced integration has zero-energy bending modes.
  return tile.isRow ? "C3D20" : "C3D20R";
}

std::string meshDeck(const ElementMesh& mesh, const DeckSettings& settings,
                     const DeckOrigin& origin) {
  // The numbers are: the mesh's nodes, those of patches, control nodes. The sets below need this
  // order.
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
  appendText(text, "*ELSET, ELSET=EALL, GENERATE\n1, {}, 1\n", mesh.elements.size());
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

// ------------------------------------------------------------------------------------------------
// Common text of all decks: numbers, lists, and lines about the origin.
//
// Numbers. CalculiX reads 20 characters of a field and ignores the rest without a message:
// 1.2345678901234567e-05 (22 characters) loses its exponent. The shortest decimal that reads back
// as the same double usually fits. A sign, a point, 14 digits and an exponent of four characters
// always fit. Exponents with three digits would need one more, so magnitudes below 1e-90 become
// zero.
//
// Units. A deck has no units, and the user must keep them consistent. With lengths in mm and forces
// in N, stress is N/mm^2 = MPa (1 Pa = 1e-6 MPa). Mass is in tonnes, because 1 N = 1 t mm/s^2.
// Density is therefore 1 kg/m^3 = 1e-3 t / 1e9 mm^3 = 1e-12 t/mm^3.

namespace {

constexpr std::size_t kLongestNumber = 20;  ///< characters that CalculiX reads of a number
constexpr std::size_t kLongestLine = 200;   ///< Abaqus and CalculiX read 256 characters
/// Abaqus keeps the first 80 characters of a heading.
constexpr std::size_t kLongestHeading = 80;
constexpr int kNumbersInLine = 16;  ///< limit per line in CalculiX and Abaqus
/// Smaller coordinates are rounding errors. Their exponents would need a third digit.
constexpr double kSmallest = 1e-90;
/// As a fraction of the thickness. Contact tolerates smaller overlaps.
constexpr double kMinReportedOverlap = 1e-4;

/// One line of printable characters for any name. Line breaks and other control characters would
/// end the comment and begin a card.
std::string oneLine(std::string text, std::size_t longest) {
  for (char& letter : text) {
    if (static_cast<unsigned char>(letter) < ' ') letter = ' ';
  }
  if (text.size() > longest) text.resize(longest);
  return text;
}

}  // namespace

UnitScale unitScale(DeckUnit unit) {
  if (unit == DeckUnit::Model) return {};
  return {1e3, 1e-6, 1e-12, "mm, N, t, s, MPa", "mm", "MPa"};
}

bool isReportableOverlap(double overlap, double thickness) {
  return overlap > kMinReportedOverlap * thickness;
}

std::string deckNumber(double value) {
  if (std::abs(value) < kSmallest) return "0.";
  std::string exact = fmt::format("{}", value);
  // Every number has a point: CalculiX refuses 2500 as a stiffness. Versions of fmt differ in
  // "{:#}".
  if (exact.find('.') == std::string::npos)
    exact.insert(std::min(exact.find('e'), exact.size()), ".0");
  return exact.size() <= kLongestNumber ? exact : fmt::format("{:#.14g}", value);
}

void appendNumbers(std::string& text, const int* numbers, std::size_t count) {
  for (std::size_t k = 0; k < count; ++k) {
    const bool endsLine = (k + 1) % kNumbersInLine == 0 || k + 1 == count;
    // Decks are one-based, meshes here zero-based.
    appendText(text, "{}{}", numbers[k] + 1, endsLine ? "\n" : ", ");
  }
}

void appendNodeSet(std::string& text, const std::string& name, const std::vector<int>& nodes) {
  if (nodes.empty()) return;
  appendText(text, "*NSET, NSET={}\n", name);
  appendNumbers(text, nodes.data(), nodes.size());
}

void appendOrigin(std::string& text, const DeckOrigin& origin, DeckUnit unit) {
  appendText(
      text, "** {}\n",
      oneLine(fmt::format("Model {}, state {}, at {} s.", origin.model, origin.state, origin.time),
              kLongestLine));
  const UnitScale scale = unitScale(unit);
  appendText(text, "** Written by {}. Units: {}; bricks {} thick.\n", origin.writer, scale.words,
             deckLength(origin.thickness, scale));
  appendText(text, "** {}\n", oneLine("Run: " + origin.run, kLongestLine));
  appendText(text, "** Deepest overlap of two bricks in this state: {}.\n",
             deckLength(origin.overlap, scale));
  if (!isReportableOverlap(origin.overlap, origin.thickness)) return;
  appendText(
      text,
      "** WARNING: bricks overlap by {:.2g} of their thickness: with contact between tiles,\n"
      "** an analysis starts overclosed. A run with --contacts keeps bricks apart.\n",
      origin.overlap / origin.thickness);
}

std::string heading(const DeckOrigin& origin, const std::string& subject) {
  const std::string line =
      fmt::format("{}, state {}, {}, {}", origin.model, origin.state, subject, origin.writer);
  return "*HEADING\n" + oneLine(line, kLongestHeading) + "\n";
}

// ------------------------------------------------------------------------------------------------
// The same mechanics in both programs. Let a cluster have the patches 0 to m - 1. Each is a set of
// nodes that moves as a rigid body, u = u_ref + R (x - x_ref) - (x - x_ref).
//
// CalculiX: *RIGID BODY, NSET=, REF NODE=, ROT NODE=. Patches with the same REF NODE share
// its displacement and have independent rotations. A ROT NODE is needed if springs or
// moments act on a rotation. Its displacements 1 to 3 are the rotation about x, y and z in
// radians.
//
// Abaqus: *RIGID BODY, PIN NSET=, REF NODE=. A reference node has the displacements 1 to 3 and the
// rotations 4 to 6 of its one body. *MPC PIN equates the displacements of two nodes: the bodies
// share a point and rotate freely.
//
// A spring is SPRING2 between one degree of freedom of each of two nodes. Rotations are 1 to 3 of
// ROT NODEs in CalculiX, 4 to 6 of reference nodes in Abaqus. An axis that is not along x, y or z
// is the first of an *ORIENTATION. The deck's moment is force times length: 1 N m is 1e3 N mm.

PatchDeck::PatchDeck(const ElementMesh& mesh, Solver solver) : mesh_(mesh), solver_(solver) {
  if (mesh.rule.joints != JointStyle::Patch) return;
  // The shared nodes come first, one per cluster, as referenceNode() requires.
  for (std::size_t c = 0; c < mesh.clusters.size(); ++c) addNode(c);
  for (std::size_t c = 0; c < mesh.clusters.size(); ++c) {
    own_.emplace_back(mesh.clusters[c].patches.size(), -1);
    if (solver == Solver::Calculix) continue;
    // In Abaqus the shared node is the first patch's own.
    own_[c][0] = referenceNode(mesh, c);
    for (std::size_t k = 1; k < own_[c].size(); ++k) own_[c][k] = addNode(c);
  }
  // ROT NODEs come after all nodes with a position, which users may constrain.
  placed_ = nodes_.size();
  if (solver == Solver::Abaqus) return;
  for (const PatchSpring& spring : mesh.springs) {
    for (const int patch : {spring.patchA, spring.patchB}) {
      int& own = own_[spring.cluster][patch];
      // Only patches with springs need one.
      if (own < 0) own = addNode(spring.cluster);
    }
  }
}

int PatchDeck::addNode(std::size_t cluster) {
  nodes_.push_back(referencePosition(mesh_, cluster));
  return static_cast<int>(mesh_.nodes.size() + nodes_.size()) - 1;
}

void PatchDeck::appendBodies(std::string& text) const {
  std::string pins;
  for (std::size_t c = 0; c < own_.size(); ++c) {
    const int shared = referenceNode(mesh_, c) + 1;
    for (std::size_t k = 0; k < own_[c].size(); ++k) {
      const std::string name = fmt::format("PATCH_{:05}_{}", c, k);
      appendNodeSet(text, name, mesh_.clusters[c].patches[k]);
      const int own = own_[c][k] + 1;
      if (solver_ == Solver::Abaqus) {
        appendText(text, "*RIGID BODY, PIN NSET={}, REF NODE={}\n", name, own);
        // The first node of PIN is the dependent one. Boundary conditions must use the shared node.
        if (own != shared) appendText(pins, "PIN, {}, {}\n", own, shared);
      } else {
        appendText(text, "*RIGID BODY, NSET={}, REF NODE={}", name, shared);
        own > 0 ? appendText(text, ", ROT NODE={}\n", own) : appendText(text, "\n");
      }
    }
  }
  if (!pins.empty()) text += "*MPC\n" + pins;
}

void PatchDeck::appendSprings(std::string& text, DeckUnit unit) const {
  const UnitScale scale = unitScale(unit);
  // Stress times volume is a moment: 1e-6 * 1e9 = 1e3 N mm per N m.
  const double moment = scale.stress * scale.length * scale.length * scale.length;
  // Springs are elements too, numbered after those of the mesh.
  std::size_t number = mesh_.elements.size();
  for (std::size_t k = 0; k < mesh_.springs.size(); ++k) {
    const PatchSpring& spring = mesh_.springs[k];
    Eigen::Index along = 0;
    std::string orientation;
    spring.axis.cwiseAbs().maxCoeff(&along);
    if ((spring.axis.array() != 0).count() > 1) {
      along = 0;
      orientation = fmt::format(", ORIENTATION=AXIS_{:05}", k);
      const Vector3 across = spring.axis.unitOrthogonal();
      appendText(text, "*ORIENTATION, NAME=AXIS_{:05}\n{}, {}, {}, {}, {}, {}\n", k,
                 deckNumber(spring.axis.x()), deckNumber(spring.axis.y()),
                 deckNumber(spring.axis.z()), deckNumber(across.x()), deckNumber(across.y()),
                 deckNumber(across.z()));
    }
    appendText(text,
               "*ELEMENT, TYPE=SPRING2, ELSET=SPRING_{0:05}\n{1}, {2}, {3}\n"
               "*SPRING, ELSET=SPRING_{0:05}{4}\n{5}, {5}\n{6}\n",
               k, ++number, own_[spring.cluster][spring.patchA] + 1,
               own_[spring.cluster][spring.patchB] + 1, orientation, rotation(along),
               deckNumber(moment * spring.stiffness));
  }
}

void PatchDeck::appendMoments(std::string& text, DeckUnit unit) const {
  const UnitScale scale = unitScale(unit);
  const double unitMoment = scale.stress * scale.length * scale.length * scale.length;
  for (const PatchSpring& spring : mesh_.springs) {
    // Equal and opposite moments on the two patches.
    if (spring.moment == 0) continue;
    for (const auto& [patch, moment] :
         {std::pair{spring.patchA, -spring.moment}, {spring.patchB, spring.moment}}) {
      for (int axis = 0; axis < 3; ++axis) {
        if (spring.axis[axis] == 0) continue;
        appendText(text, "{}, {}, {}\n", own_[spring.cluster][patch] + 1, rotation(axis),
                   deckNumber(unitMoment * moment * spring.axis[axis]));
      }
    }
  }
}

// ------------------------------------------------------------------------------------------------
// Rigid patches have rotations, solid elements have none. A spring connects the rotations of two
// tiles' patches about the hinge's axis in the mesh's state. It is linear in the angle from that
// state, for any angle as long as the axis keeps its direction. Its moment in that state is a load:
//
//     moment = k (rest - angle) = k (rest - angle of the state) - k (turn since the state).
//
// k is the stiffness (N m/rad), "rest" the angle without moment and "angle" the hinge's angle
// in the run (rad). The first term is a constant moment (*CLOAD). The second is the spring element
// of the deck, which is at rest in the mesh's state. Neither program needs a pre-stressed spring.
//
// A hinge through the thickness has a patch on the bottom and on the top of each of its tiles. They
// share the stiffness equally.

namespace {

/// The patch of a cluster that lies on a tile, or -1.
int patchOn(const ElementMesh& mesh, const NodeCluster& cluster, int tile) {
  for (std::size_t k = 0; k < cluster.patches.size(); ++k) {
    if (std::ranges::binary_search(mesh.tiles[tile].nodes, cluster.nodes[k])) {
      return static_cast<int>(k);
    }
  }
  return -1;
}

/// The locations of a spring between two tiles, without its stiffness. Searches all clusters for
/// each spring: the cost is the number of clusters times the number of springs.
std::vector<PatchSpring> placesBetween(const ElementMesh& mesh, int tileA, int tileB) {
  std::vector<PatchSpring> places;
  for (std::size_t c = 0; c < mesh.clusters.size(); ++c) {
    const int patchA = patchOn(mesh, mesh.clusters[c], tileA);
    const int patchB = patchOn(mesh, mesh.clusters[c], tileB);
    if (patchA >= 0 && patchB >= 0) places.push_back({static_cast<int>(c), patchA, patchB});
  }
  return places;
}

}  // namespace

bool isFold(const brick::Hinge& hinge, const std::vector<brick::Brick>& bricks) {
  // Axes lie in a tile or across it.
  return std::abs(bricks[hinge.brickA].normal.dot(hinge.axis)) < 0.5;
}

int addHingeSprings(ElementMesh& mesh, const std::vector<brick::Brick>& bricks,
                    std::span<const brick::HingeSpring> springs, const Poses& poses) {
  constexpr double kNoComponent = 1e-9;
  const std::vector<double> moments = brick::hingeMoments(springs, poses);
  int left = 0;
  for (std::size_t k = 0; k < springs.size(); ++k) {
    const brick::HingeSpring& spring = springs[k];
    if (spring.stiffness == 0) continue;
    // Rounding must not add components to an axis along x, y or z.
    Vector3 axis = poses[spring.hinge.brickA].rotation * spring.hinge.axis;
    axis = (axis.array().abs() < kNoComponent).select(0, axis).normalized();
    std::vector<PatchSpring> places;
    if (!isFold(spring.hinge, bricks)) {
      places = placesBetween(mesh, spring.hinge.brickA, spring.hinge.brickB);
    }
    // The caller reports the springs that are left out.
    if (places.empty()) ++left;
    const double share = 1.0 / static_cast<double>(std::max<std::size_t>(places.size(), 1));
    for (PatchSpring& place : places) {
      place.stiffness = share * spring.stiffness;
      place.moment = share * moments[k];
      place.axis = axis;
      mesh.springs.push_back(place);
    }
  }
  return left;
}

// ------------------------------------------------------------------------------------------------
// Finds the nodes that a user is likely to constrain or load: those at the ends of the sheet.
//
// Ends are faces of elements (SheetEnds). If no edge is an end, the plane of the bounding box in
// the sheet's axes is used. With the box's corners lo and hi, its diagonal s (all metres) and a
// node's coordinate x along an axis, the node is
//
//     in MIN if x - lo <= 1e-6 s,    in MAX if hi - x <= 1e-6 s.
//
// A dependent node (by *EQUATION, a rigid patch or a tie) is left out: CalculiX and Abaqus refuse
// prescribed displacements there. Reference nodes of patches replace the nodes of their patches.
//
// For a uniform traction on an end, a node gets the integral of its shape function over the faces,
// divided by their area. On a rectangle of 8 nodes that is -1/12 at corners and 1/3 at middles, of
// 4 nodes 1/4. On a line of 3 nodes it is 1/6 at the ends and 2/3 at the middle, of 2 nodes 1/2.

namespace {

/// Between the rounding of poses and the length of the shortest elements.
constexpr double kSamePlane = 1e-6;  ///< of the sheet's size
/// By axis, MIN before MAX: plane k is across axis k / 2.
constexpr const char* kPlanes[] = {"XMIN", "XMAX", "YMIN", "YMAX", "ZMIN", "ZMAX"};

/// In the sheet's axes. Empty (its minimum above its maximum) if there are no nodes.
Eigen::AlignedBox3d boxOf(const ElementMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vector3& node : mesh.nodes) box.extend(mesh.ends.axes.transpose() * node);
  return box;
}

/// The area of a face with these nodes; the length for shells and plane elements.
double faceSize(const ElementMesh& mesh, const std::vector<int>& nodes) {
  const auto at = [&](std::size_t k) { return mesh.nodes[nodes[k]]; };
  if (mesh.rule.family != ElementFamily::Solid) return (at(1) - at(0)).norm();
  return 0.5 * (at(2) - at(0)).cross(at(3) - at(1)).norm();
}

/// The integral of the shape function of node `place` in faceNodes(), divided by the face's size.
double shapeIntegral(const ElementMesh& mesh, std::size_t place) {
  const bool isQuadratic = mesh.rule.quadratic;
  if (mesh.rule.family != ElementFamily::Solid) {
    if (!isQuadratic) return 0.5;
    return place < 2 ? 1.0 / 6 : 2.0 / 3;
  }
  if (!isQuadratic) return 0.25;
  return place < 4 ? -1.0 / 12 : 1.0 / 3;
}

/// For each node of the mesh whether it is at an end.
std::vector<bool> isAtEnd(const ElementMesh& mesh, int end, const Eigen::AlignedBox3d& box) {
  std::vector<bool> found(mesh.nodes.size());
  if (!mesh.ends.faces[end].empty()) {
    for (const ElementFace& face : mesh.ends.faces[end]) {
      for (const int node : faceNodes(mesh, face)) found[node] = true;
    }
    return found;
  }
  const double tolerance = kSamePlane * box.sizes().norm();
  const int axis = end / 2;
  for (std::size_t k = 0; k < mesh.nodes.size(); ++k) {
    const double x = mesh.ends.axes.col(axis).dot(mesh.nodes[k]);
    found[k] = (end % 2 == 0 ? x - box.min()[axis] : box.max()[axis] - x) <= tolerance;
  }
  return found;
}

/// Number of axes across which the point lies in a plane of the box.
int planesAt(const Vector3& point, const Eigen::AlignedBox3d& box, int axes) {
  const double tolerance = kSamePlane * box.sizes().norm();
  int count = 0;
  for (int axis = 0; axis < axes; ++axis) {
    const double inside = std::min(point[axis] - box.min()[axis], box.max()[axis] - point[axis]);
    count += inside <= tolerance ? 1 : 0;
  }
  return count;
}

}  // namespace

std::vector<NamedNodes> boundarySets(const ElementMesh& mesh) {
  const Eigen::AlignedBox3d box = boxOf(mesh);
  // In a flat sheet ZMIN and ZMAX would contain every node of the two faces, so they are left out.
  const int axes = mesh.ends.isFlat ? 2 : 3;
  const std::vector<bool> follows = followers(mesh);
  const bool hasReferences = mesh.rule.joints == JointStyle::Patch;
  std::vector<NamedNodes> sets(2 * axes + 1);
  for (int k = 0; k < 2 * axes; ++k) {
    sets[k].name = kPlanes[k];
    const std::vector<bool> isThere = isAtEnd(mesh, k, box);
    for (int node = 0; node < static_cast<int>(mesh.nodes.size()); ++node) {
      if (isThere[node] && !follows[node]) sets[k].nodes.push_back(node);
    }
    for (std::size_t c = 0; c < mesh.clusters.size() && hasReferences; ++c) {
      const std::vector<int>& corners = mesh.clusters[c].nodes;
      if (std::ranges::any_of(corners, [&](int node) { return isThere[node]; })) {
        sets[k].nodes.push_back(referenceNode(mesh, c));
      }
    }
  }
  sets.back().name = "BOXCORNERS";
  const auto addCorner = [&](int node, const Vector3& position) {
    const Vector3 inSheet = mesh.ends.axes.transpose() * position;
    if (planesAt(inSheet, box, axes) == axes) sets.back().nodes.push_back(node);
  };
  for (std::size_t k = 0; k < mesh.nodes.size(); ++k) {
    if (!follows[k]) addCorner(static_cast<int>(k), mesh.nodes[k]);
  }
  for (std::size_t c = 0; c < mesh.clusters.size() && hasReferences; ++c) {
    addCorner(referenceNode(mesh, c), referencePosition(mesh, c));
  }
  return sets;
}

std::vector<NodeShare> endShares(const ElementMesh& mesh, int end) {
  std::map<int, double> sizes;
  double whole = 0;
  for (const ElementFace& face : mesh.ends.faces[end]) {
    const std::vector<int> nodes = faceNodes(mesh, face);
    const double size = faceSize(mesh, nodes);
    whole += size;
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      sizes[nodes[k]] += size * shapeIntegral(mesh, k);
    }
  }
  if (sizes.empty()) {
    const std::vector<bool> isThere = isAtEnd(mesh, end, boxOf(mesh));
    for (std::size_t k = 0; k < isThere.size(); ++k) {
      if (!isThere[k]) continue;
      sizes[static_cast<int>(k)] = 1;
      ++whole;
    }
  }
  std::vector<NodeShare> shares;
  for (const auto& [node, size] : sizes) shares.push_back({node, size / whole});
  return shares;
}

// ------------------------------------------------------------------------------------------------
// A node b lies in a cell that is n P_1 + m P_2 away from the cell of its leader a. Its motion is
// that of a plus the contribution of the mean displacement gradient H,
// u_b = u_a + H (n P_1 + m P_2). H has two control nodes, c_x = H e_x L_x and c_y = H e_y L_y, with
// displacements in the sheet's axes:
//
//     u_b = u_a + R ((p_x / L_x) c_x + (p_y / L_y) c_y),   p = R^T (n P_1 + m P_2).
//
// R has the sheet's axes as columns. A dependent node is never a leader, which programs would
// refuse. The reaction at a control node is the force on a side of the cell (compare S. Li, A.
// Wongsto, Unit cells for micromechanical analyses of particle-reinforced composites, Mech. Mater.
// 36, 2004).

namespace {

/// Corners with smaller gaps after a run still count as partners.
constexpr double kSameNodePlace = 1e-5;  ///< of the sheet's size, the accuracy of symmetry after a
                                         ///< run

/// The pairs of nodes at both ends; absent if some have no partner. Compares all nodes of one end
/// with all nodes of the other. Their numbers are small.
std::optional<std::vector<std::pair<int, int>>> partners(const ElementMesh& mesh, int axis,
                                                         const std::vector<int>& low,
                                                         const std::vector<int>& high) {
  const double tolerance = kSameNodePlace * boxOf(mesh).sizes().norm();
  const Vector3 along = mesh.ends.axes.col(axis);
  if (low.empty() || low.size() != high.size()) return std::nullopt;
  std::vector<std::pair<int, int>> pairs;
  std::vector<bool> isTaken(high.size());
  for (const int node : low) {
    std::size_t found = 0;
    for (; found < high.size(); ++found) {
      Vector3 offset = mesh.nodes[high[found]] - mesh.nodes[node];
      // Only across the axis: along it the distance is a period.
      offset -= along.dot(offset) * along;
      if (!isTaken[found] && offset.norm() <= tolerance) break;
    }
    if (found == high.size()) return std::nullopt;
    isTaken[found] = true;
    pairs.emplace_back(node, high[found]);
  }
  return pairs;
}

/// A sheet without joints: all nodes of its ends are tied.
Periodicity plateTies(const ElementMesh& mesh) {
  const std::vector<NamedNodes> ends = boundarySets(mesh);
  const Eigen::AlignedBox3d box = boxOf(mesh);
  Periodicity periodic;
  periodic.axes = mesh.ends.axes;
  std::vector<PeriodicTie> pairs;
  for (const int axis : {0, 1}) {
    const auto found = partners(mesh, axis, ends[2 * axis].nodes, ends[2 * axis + 1].nodes);
    if (!found) {
      throw InputError(
          fmt::format("error: --periodic ties opposite ends of a sheet, but in this state {} has "
                      "other nodes than {}; choose a state or a number of tiles in which the sheet "
                      "repeats",
                      ends[2 * axis].name, ends[2 * axis + 1].name));
    }
    periodic.period[axis] = box.sizes()[axis];
    periodic.periods[axis] = box.sizes()[axis] * mesh.ends.axes.col(axis);
    for (const auto& [low, high] : *found) {
      PeriodicTie& pair = pairs.emplace_back(PeriodicTie{high, low, {}});
      pair.times[axis] = 1;
    }
  }
  periodic.ties = tiesBetween(pairs);
  return periodic;
}

/// The corner of a tile that contains a node. `edges` has one list per corner. Returns the number
/// of corners if none contains it.
int cornerOf(const TileElements& tile, int node) {
  const auto holds = [node](const std::vector<int>& edge) {
    return std::ranges::find(edge, node) != edge.end();
  };
  return static_cast<int>(std::ranges::find_if(tile.edges, holds) - tile.edges.begin());
}

model::JointFace faceOf(const JointNodes& joint, const TileElements& tile) {
  if (joint.isHinge) return model::JointFace::Both;
  const std::vector<int>& edge = tile.edges[cornerOf(tile, joint.a[0])];
  return joint.a[0] == edge.front() ? model::JointFace::Bottom : model::JointFace::Top;
}

/// A sheet of hinged tiles: the corners that joints hold across the border are tied.
Periodicity hingeTies(const ElementMesh& mesh) {
  std::vector<std::vector<Vector3>> tiles;
  for (const TileElements& tile : mesh.tiles) {
    std::vector<Vector3>& corners = tiles.emplace_back();
    for (const std::vector<int>& edge : tile.edges) corners.push_back(mesh.nodes[edge.front()]);
  }
  std::vector<model::Joint> joints;
  for (const JointNodes& joint : mesh.joints) {
    const TileElements &a = mesh.tiles[joint.tileA], &b = mesh.tiles[joint.tileB];
    model::Joint& own = joints.emplace_back();
    own.a = {joint.tileA, cornerOf(a, joint.a[0])};
    own.b = {joint.tileB, cornerOf(b, joint.b[0])};
    own.face = faceOf(joint, a);
  }
  const SheetLattice lattice = findSheetLattice(tiles, joints, mesh.rule.countsFrom);
  // With *EQUATION the first node of a cluster is already the leader of the others.
  std::map<int, int> firstOf;
  for (const NodeCluster& cluster : mesh.clusters) {
    for (const int node : cluster.nodes) firstOf[node] = cluster.nodes[0];
  }
  const auto leading = [&](int node) {
    const auto found = firstOf.find(node);
    return found == firstOf.end() ? node : found->second;
  };
  std::vector<PeriodicTie> pairs;
  for (const BorderJoint& border : lattice.joints) {
    const auto nodesOf = [&](const model::Corner& corner) {
      return heldNodes(mesh.tiles[corner.tile].edges[corner.vertex], border.joint.face);
    };
    const std::vector<int> a = nodesOf(border.joint.a), b = nodesOf(border.joint.b);
    // Corner a coincides with corner b in the other cell.
    for (std::size_t k = 0; k < a.size(); ++k) {
      pairs.push_back({leading(a[k]), leading(b[k]), border.cell});
    }
  }
  return {lattice.periods, lattice.axes, lattice.lengths, tiesBetween(pairs)};
}

}  // namespace

std::vector<PeriodicTie> tiesBetween(const std::vector<PeriodicTie>& pairs) {
  // Trees of nodes: each node except roots has a parent and the cell offset from the parent.
  std::map<int, PeriodicTie> trees;
  const auto rootOf = [&trees](int node) {
    PeriodicTie tie{node, node, {}};
    for (auto found = trees.find(node); found != trees.end(); found = trees.find(tie.leader)) {
      for (const int axis : {0, 1}) tie.times[axis] += found->second.times[axis];
      tie.leader = found->second.leader;
    }
    return tie;
  };
  for (const PeriodicTie& pair : pairs) {
    const PeriodicTie node = rootOf(pair.node), leader = rootOf(pair.leader);
    if (node.leader == leader.leader) continue;
    // root(node) + times(node) = node = leader + pair = root(leader) + times(leader) + pair.
    PeriodicTie tie{node.leader, leader.leader, {}};
    for (const int axis : {0, 1}) {
      tie.times[axis] = leader.times[axis] + pair.times[axis] - node.times[axis];
    }
    if (tie.node < tie.leader) {
      std::swap(tie.node, tie.leader);
      for (int& times : tie.times) times = -times;
    }
    trees[tie.node] = tie;
  }
  std::vector<PeriodicTie> ties;
  for (const auto& [node, tie] : trees) ties.push_back(rootOf(node));
  return ties;
}

Periodicity periodicity(const ElementMesh& mesh) {
  if (mesh.rule.family == ElementFamily::Shell) {
    throw InputError(
        "error: --periodic ties the displacements of solids and plane elements; remove --shells");
  }
  if (mesh.rule.joints == JointStyle::Patch) {
    throw InputError(
        "error: --periodic ties the corners of tiles, which rigid patches surround; choose other "
        "--joints");
  }
  if (mesh.lattice) {
    return {mesh.lattice->periods, mesh.lattice->axes, mesh.lattice->lengths, mesh.ties};
  }
  return mesh.joints.empty() ? plateTies(mesh) : hingeTies(mesh);
}

void appendTies(std::string& text, const Periodicity& periodic, const ElementMesh& mesh,
                int firstControl) {
  constexpr double kRounding = 1e-12;
  const int directions = mesh.rule.family == ElementFamily::Plane ? 2 : 3;
  for (const PeriodicTie& tie : periodic.ties) {
    const Vector3 offset = periodic.axes.transpose() * (tie.times[0] * periodic.periods[0] +
                                                        tie.times[1] * periodic.periods[1]);
    for (int direction = 0; direction < directions; ++direction) {
      // The dependent node first; four terms per line.
      std::string terms;
      int count = 0;
      const auto append = [&](int node, int along, double factor) {
        const char* before = count == 0 ? "" : count % 4 == 0 ? ",\n" : ", ";
        appendText(terms, "{}{}, {}, {}", before, node + 1, along + 1, deckNumber(factor));
        ++count;
      };
      append(tie.node, direction, 1);
      append(tie.leader, direction, -1);
      for (const int control : {0, 1}) {
        for (int along = 0; along < directions; ++along) {
          const double factor =
              -offset[control] / periodic.period[control] * periodic.axes(direction, along);
          if (std::abs(factor) > kRounding) append(firstControl + control, along, factor);
        }
      }
      appendText(text, "*EQUATION\n{}\n{}\n", count, terms);
    }
  }
}

std::vector<Vector3> controlPositions(const Periodicity& periodic, const ElementMesh& mesh) {
  const Eigen::AlignedBox3d box = boxOf(mesh);
  std::vector<Vector3> positions;
  for (const int axis : {0, 1}) {
    Vector3 position = box.center();
    // A tenth of the period outside the sheet, for visibility in viewers. The position has no
    // effect on any equation.
    position[axis] = box.max()[axis] + 0.1 * periodic.period[axis];
    positions.emplace_back(mesh.ends.axes * position);
    if (mesh.rule.family == ElementFamily::Plane) positions.back().z() = 0;
  }
  return positions;
}

// ------------------------------------------------------------------------------------------------
// Flanks next to a joint or a neck face each other (edgesBesideJoint). The deck declares only these
// pairs. General contact of all flanks would find more, but CalculiX supports only pairs. The user
// of the deck can add contact between tiles without a common joint.
//
// Pressure depends on the penetration c (metres). In CalculiX it is linear, p = k c with k = E / t,
// Young's modulus E (Pa) and thickness t (m). An overlap of the fraction e of the thickness causes
// the pressure e E, as in a tile at that strain. Contact is then about as stiff as the tile behind
// it. A stiffer k converges worse, a softer one allows deeper penetration. Friction sticks along a
// slope of 0.01 k until it slides at mu p (CalculiX manual, *SURFACE BEHAVIOR and *FRICTION).
// Abaqus has "hard" contact without a stiffness parameter.

namespace {

/// The pairs of edges that face each other across a gap, unique and sorted. Decks then do not
/// depend on the order of joints: the two joints of a fold, or two joints on both faces of one
/// corner, give the same gap.
std::set<FacingEdges> facingEdges(const ElementMesh& mesh) {
  std::set<FacingEdges> pairs;
  for (const JointNodes& joint : mesh.joints) {
    const TileElements &a = mesh.tiles[joint.tileA], &b = mesh.tiles[joint.tileB];
    const auto both =
        edgesBesideJoint({joint.tileA, cornerOf(a, joint.a[0])}, static_cast<int>(a.edges.size()),
                         {joint.tileB, cornerOf(b, joint.b[0])}, static_cast<int>(b.edges.size()));
    pairs.insert(both.begin(), both.end());
  }
  for (const MeshNeck& neck : mesh.neckShapes) {
    pairs.insert(neck.slits.begin(), neck.slits.end());
  }
  return pairs;
}

/// The faces along a tile's edge without the given nodes. A contact constraint at a node that
/// *EQUATION or a rigid body already determines would be overconstrained. A node that two parts
/// share cannot part from itself.
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
  if (mesh.rule.family != ElementFamily::Solid) {
    throw InputError(
        "error: contact is between the flanks of solid tiles; remove --deck-contacts, or --shells "
        "and --plane-stress");
  }
  std::vector<bool> isTaken = jointNodesOf(mesh);
  const std::vector<bool> isFollower = followers(mesh);
  for (std::size_t k = 0; k < isTaken.size(); ++k) isTaken[k] = isTaken[k] || isFollower[k];
  std::vector<ContactPair> pairs;
  for (const auto& [first, second] : facingEdges(mesh)) {
    ContactPair pair{freeFaces(mesh, first, isTaken), freeFaces(mesh, second, isTaken)};
    if (!pair.a.empty() && !pair.b.empty()) pairs.push_back(std::move(pair));
  }
  // An edge of one or two elements has a joint's node on each of them.
  if (pairs.empty() && !(mesh.joints.empty() && mesh.neckShapes.empty())) {
    throw InputError(
        "error: all faces of the tiles' flanks touch a joint, so none is left for contact; use at "
        "least 3 elements per edge");
  }
  return pairs;
}

void appendContactSurfaces(std::string& text, const std::vector<ContactPair>& pairs) {
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    for (const auto& [faces, ending] : {std::pair{&pairs[k].a, "A"}, {&pairs[k].b, "B"}}) {
      appendText(text, "*SURFACE, NAME=CONTACT_{:05}_{}, TYPE=ELEMENT\n", k, ending);
      for (const ElementFace& face : *faces) {
        // Faces 1 and 2 of a hexahedron are its bottom and top; 3 to 6 follow its bottom corners.
        appendText(text, "{}, S{}\n", face.element + 1, face.side + 3);
      }
    }
  }
}

void appendContactCards(std::string& text, std::size_t pairs, const DeckSettings& settings,
                        double thickness) {
  const UnitScale scale = unitScale(settings.unit);
  // k = E / t in the deck's units, pressure per length.
  const double slope = scale.stress * settings.material.youngs / (scale.length * thickness);
  const double friction = settings.contactFriction.value_or(0);
  text += "*SURFACE INTERACTION, NAME=FLANKS\n";
  if (settings.solver == Solver::Calculix) {
    appendText(text, "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n{}\n", deckNumber(slope));
    if (friction > 0) {
      appendText(text, "*FRICTION\n{}, {}\n", deckNumber(friction), deckNumber(0.01 * slope));
    }
  } else {
    text += "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=HARD\n";
    if (friction > 0) appendText(text, "*FRICTION\n{}\n", deckNumber(friction));
  }
  for (std::size_t k = 0; k < pairs; ++k) {
    appendText(text,
               "*CONTACT PAIR, INTERACTION=FLANKS, TYPE=SURFACE TO SURFACE\n"
               "CONTACT_{0:05}_A, CONTACT_{0:05}_B\n",
               k);
  }
}

}  // namespace kirireel::fea
