/// Abaqus and CalculiX decks of bricks: their words, patches, springs, ties and contacts. Gmsh
/// meshes of the same elements.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "render/fea/element_mesh.h"
#include "sim/base/files.h"
#include "sim/base/geometry.h"
#include "sim/model/hinge.h"

namespace kirireel::fea {

// ------------------------------------------------------------------------------------------------
// The words that decks are made of, within the limits of their readers.

/// Which program's keywords a deck uses, where the two differ.
enum class Solver { Calculix, Abaqus };

/// Which named sets a deck has besides those of the whole sheet and its boundary.
enum class SetChoice {
  Usual,   ///< All up to 1,000 tiles, None above: readers look through all names for each name
  None,    ///< only the sets of the whole sheet and its boundary
  Joints,  ///< the nodes of each joint
  All,     ///< and of each tile its nodes, faces and surfaces
};

/// What tiles are made of; in SI units, for decks in any unit.
struct Material {
  double youngs = 1e9;    ///< Young's modulus, Pa, positive
  double poisson = 0.3;   ///< Poisson's ratio, above -1, below 0.5
  double density = 1000;  ///< kg/m^3, positive
};

/// The consistent units of a deck.
enum class DeckUnit {
  Model,               ///< metres, kilograms, seconds, newtons
  MillimetresNewtons,  ///< millimetres, tonnes, seconds, newtons: stress in MPa
};

/// The factors from SI quantities to those of a deck.
struct UnitScale {
  /// Deck units by metre: 1 or 1e3.
  double length = 1;
  /// Deck units by pascal: 1 or 1e-6. Forces keep their newtons.
  double stress = 1;
  /// Deck units by kg/m^3: 1 or 1e-12.
  double density = 1;
  /// For comments; it lives as long as the program.
  const char* words = "m, N, kg, s, Pa";
};

/// Which tiles a job moves as the trajectory did.
struct DriveChoice {
  /// How tiles are chosen.
  enum Kind {
    None,  ///< none: there is no such job
    All,   ///< every tile
    Edge,  ///< those at the two ends of the sheet's longest axis
    Some,  ///< those listed
  };
  Kind kind = None;        ///< how they are chosen
  std::vector<int> tiles;  ///< of Some, as the model's file numbers them
};

/// How decks are written.
struct DeckSettings {
  Solver solver = Solver::Calculix;   ///< whose keywords
  SetChoice sets = SetChoice::Usual;  ///< which sets of nodes and faces have names
  Material material;                  ///< of all tiles
  DeckUnit unit = DeckUnit::Model;    ///< of all its numbers
  DriveChoice drive;                  ///< of a second job, which follows the deployment
  bool buckling = false;              ///< a job that finds buckling loads
  bool stateMap = false;  ///< jobs that take the first state that is exported to the others
  bool periodic = false;  ///< a job that strains a sheet whose opposite ends are tied
  std::optional<double> contactFriction;  ///< of contact between flanks, from 0; absent: none
};

/// Where a deck comes from, for its header.
struct DeckOrigin {
  std::string model;     ///< the model's name
  std::string state;     ///< as it was asked for, such as "final"
  double time = 0;       ///< of the state, seconds
  double thickness = 0;  ///< of the bricks, metres
  double overlap = 0;    ///< the deepest of two bricks in this state, metres
  std::string writer;    ///< program and version
  std::string run;       ///< what identifies the run, one line
};

/// By what SI quantities are multiplied, and the words for a deck's header.
UnitScale unitScale(DeckUnit unit);

/// Whether bricks overlap by more than an analysis with contact can leave unsaid; metres. True
/// above 1e-4 of the thickness.
bool isOverlapToTell(double overlap, double thickness);

/// A number in at most 20 characters, which is all that CalculiX and Abaqus read of it: the
/// shortest text that reads back to the same double where it fits, else 14 digits. Zero for
/// magnitudes below 1e-90. The value must be finite: neither program reads "nan" or "inf".
std::string deckNumber(double value);

/// Appends numbers from 0 as numbers from 1, at most 16 a line. A count of 0 appends nothing, not
/// even a line break.
void appendNumbers(std::string& text, const int* numbers, std::size_t count);

/// Appends *NSET with these nodes, numbered from 0; nothing for an empty set.
void appendNodeSet(std::string& text, const std::string& name, const std::vector<int>& nodes);

/// Appends comment lines that say where a deck comes from, and warn of bricks that overlap. Names
/// are made printable and cut to 200 characters.
void appendOrigin(std::string& text, const DeckOrigin& origin, DeckUnit unit);

/// The card *HEADING with its one line of data, at most 80 characters.
std::string heading(const DeckOrigin& origin, const std::string& subject);

// ------------------------------------------------------------------------------------------------
// Abaqus and CalculiX decks of bricks.

/// The text of NAME_mesh.inp: nodes, elements (C3D20R; C3D20 in tiles that are one element wide;
/// C3D8I when linear; shells S8R or S4, plane elements CPS8R or CPS4), sets, surfaces and what
/// holds the joints together, but no material and no step.
///
/// Names count from 0 in the model's order, as those in other exports do: element sets TILE_00000,
/// NECK_00000 and EALL; node sets TILE_00000_N, _BOT, _TOP, JOINT_00000_A and _B, NJOINT, NALL and
/// those of boundarySets; surfaces TILE_00000_SBOT, _STOP, _SIDE and, on each edge of the tile,
/// _S0, _S1 and so on. With contact the surfaces of appendContactSurfaces; for periodic jobs the
/// control nodes NCONTROL, after all others. All is built in memory: about 70 bytes of text a node
/// and up to 170 an element. Throws what contactPairs and periodicity throw, where the settings ask
/// for these, and Interrupted when the user stops the program.
std::string meshDeck(const ElementMesh& mesh, const DeckSettings& settings,
                     const DeckOrigin& origin);

/// Shells that lie on one face, with the set that names them.
struct ShellOffset {
  const char* set;         ///< as the deck names it; it lives as long as the program
  double offset = 0;       ///< of OFFSET: from the middle to the nodes, in thicknesses
  std::vector<int> tiles;  ///< from 0
};

/// The shells by their offset; none where all lie in the middle. From the bottom to the top. The
/// mesh must be of shells.
std::vector<ShellOffset> shellOffsets(const ElementMesh& mesh);

/// What a deck names an element. The same word in CalculiX and Abaqus.
const char* elementType(const TileElements& tile, const ElementRule& rule);

// ------------------------------------------------------------------------------------------------
// Rigid patches at joints, and springs between them, as the decks of CalculiX and Abaqus have
// them.

/// The rigid patches of a mesh with the nodes that they turn about, numbered after the mesh's own.
/// In CalculiX the patches of a joint share one node, and the rotation of a patch that has a spring
/// is that of a further node (ROT NODE). In Abaqus a node governs one rigid body: each
/// patch has its own, and *MPC pins them together; the first of a joint is the one that may be
/// held.
class PatchDeck {
 public:
  /// The mesh must outlive this. Makes no node where the mesh has no patches.
  PatchDeck(const ElementMesh& mesh, Solver solver);

  /// The positions of the further nodes; none where the mesh has no patches.
  const std::vector<Vector3>& nodes() const { return nodes_; }

  /// How many of them have displacements; the rotations of others are displacements of theirs.
  std::size_t placedCount() const { return placed_; }

  /// Appends the patches' sets, the rigid bodies and their pins. Sets are PATCH_00000_0: cluster
  /// and patch, from 0.
  void appendBodies(std::string& text) const;

  /// Appends springs between patches, *ELEMENT and *SPRING, in this unit. Stiffness becomes N
  /// mm/rad in millimetres.
  void appendSprings(std::string& text, DeckUnit unit) const;

  /// Appends the moments by which springs that are not at rest pull in the mesh's state, as rows of
  /// *CLOAD; nothing where all are at rest.
  void appendMoments(std::string& text, DeckUnit unit) const;

 private:
  int addNode(std::size_t cluster);
  /// The node, from 0, whose displacement or rotation `axis()` is the turn of a patch about z.
  int turningNode(int cluster, int patch) const;
  int axis() const { return solver_ == Solver::Calculix ? 3 : 6; }

  const ElementMesh& mesh_;
  Solver solver_;
  std::vector<Vector3> nodes_;
  std::size_t placed_ = 0;
  /// By cluster and patch, from 0: in Abaqus the body's own node, in CalculiX its ROT NODE or -1.
  std::vector<std::vector<int>> own_;
};

// ------------------------------------------------------------------------------------------------
// Springs at the hinges of a deck.

/// Gives a mesh with rigid patches the springs that bricks in these poses have at hinges across
/// the plane z = const, shared evenly by the patches that join two tiles there. Springs at other
/// hinges, and in meshes without patches, are left out: returns how many. `springs` name bricks by
/// the tiles' numbers in the mesh; `poses` are those of the mesh. Angles in radians, stiffness in N
/// m/rad. Springs of stiffness 0 count as absent.
int addHingeSprings(ElementMesh& mesh, std::span<const model::HingeSpring> springs,
                    const Poses& poses);

// ------------------------------------------------------------------------------------------------
// The nodes at the ends of a sheet.

/// Nodes under a name.
struct NamedNodes {
  std::string name;        ///< as a deck writes it, in capitals
  std::vector<int> nodes;  ///< rising, from 0; reference nodes count on after the mesh's own
};

/// XMIN, XMAX, YMIN, YMAX, ZMIN and ZMAX: the nodes at the ends of the sheet (SheetEnds), or where
/// no edge is an end, those in the plane of the box round it, to 1e-6 of its size. ZMIN and ZMAX
/// are left out of flat sheets, whose faces they would be. Then BOXCORNERS, the nodes in two planes
/// across different axes (three where there is a ZMIN). Nodes that follow others are left out; the
/// reference nodes of rigid patches are in. A set may be empty. The order is that of this list. One
/// pass over the nodes; nothing is thrown.
std::vector<NamedNodes> boundarySets(const ElementMesh& mesh);

/// The axis of the sheet (SheetEnds) along which it is longest, among those with a MIN and a MAX. 0
/// for x, 1 for y, 2 for z. Of axes of equal extent the first.
int longestAxis(const ElementMesh& mesh);

/// A part of a load of 1 N that is spread evenly over an end.
struct NodeShare {
  int node = 0;      ///< from 0
  double share = 0;  ///< of the load; of all nodes 1 in sum
};

/// The consistent nodal forces of an even traction on the end `end` of boundarySets(), by rising
/// node: integrals of the shape functions over the faces (over lines for shells and plane
/// elements). Nodes that follow others count too. Where no edge is an end, equal shares of its
/// nodes.
std::vector<NodeShare> endShares(const ElementMesh& mesh, int end);

// ------------------------------------------------------------------------------------------------
// Sheets that repeat: nodes at opposite ends that move alike but for what control nodes say.

/// How a sheet is tied to its neighbours, which are copies of it.
struct Periodicity {
  std::array<Vector3, 2> periods;          ///< from cell to cell, metres
  Matrix3 axes = Matrix3::Identity();      ///< columns: the sheet's x, y and z in the world
  std::array<double, 2> period{};          ///< a rectangle of the cell's area, along x and y, metres
  std::vector<PeriodicTie> ties;           ///< by rising node
};

/// The ties of a mesh to copies of it. Only what joints hold across the border is tied
/// (findSheetLattice); slits stay open. The mesh of a sheet without joints is a plate: all nodes of
/// XMIN follow those of XMAX, which lie at the same place but for the period, and the same in y.
/// Throws InputError for shells, rigid patches, and sheets that do not repeat.
Periodicity periodicity(const ElementMesh& mesh);

/// The ties that pairs of nodes make: each node is its leader in another cell. Of all nodes that
/// are tied together the lowest leads.
std::vector<PeriodicTie> tiesBetween(const std::vector<PeriodicTie>& pairs);

/// Appends *EQUATION for each tie. The control nodes of x and y have the numbers `firstControl`,
/// from 0, and the next. Their displacements are along the sheet's axes: H e_x times the first
/// period and H e_y times the second, H being the mean displacement gradient. Two directions for
/// plane elements, three for solids.
void appendTies(std::string& text, const Periodicity& periodic, const ElementMesh& mesh,
                int firstControl);

/// The control nodes' positions, next to the sheet, metres.
std::vector<Vector3> controlPositions(const Periodicity& periodic, const ElementMesh& mesh);

// ------------------------------------------------------------------------------------------------
// Flanks of tiles that may touch, for analyses with contact.

/// Two flanks that face each other across the gap next to a joint.
struct ContactPair {
  std::vector<ElementFace> a;  ///< of one tile, all along the flank
  std::vector<ElementFace> b;  ///< of the other, all along the flank
};

/// For each joint the flanks on both sides of its corner, each pair once: what meets when the sheet
/// closes. Faces with nodes of joints are left out, whose displacements joints determine. Throws
/// InputError for meshes that have no such flanks: shells, plane elements, sheets with necks, and
/// elements so long that all faces touch a joint. Faces of a pair are in the order of the tile's
/// sides. The cost is that of a search through the corners of each joint's tiles, and sorting.
std::vector<ContactPair> contactPairs(const ElementMesh& mesh);

/// Appends the surfaces CONTACT_00000_A and _B of each pair. Nothing where there are no pairs.
/// Element numbers in the deck count from 1.
void appendContactSurfaces(std::string& text, const std::vector<ContactPair>& pairs);

/// Appends the interaction FLANKS and the pairs. With CalculiX contact is a penalty, E / t per
/// metre of overclosure and a hundredth of that where flanks stick; friction is Coulomb's
/// coefficient, from 0. Thickness in metres. They belong between the material and the first step.
void appendContactCards(std::string& text, std::size_t pairs, const DeckSettings& settings,
                        double thickness);

// ------------------------------------------------------------------------------------------------
// Gmsh meshes.

/// The text of a Gmsh 4.1 mesh with one physical group a kind: the volumes TILES (and NECKS), the
/// surfaces BOTTOM and TOP, the points JOINTS where joined tiles share nodes. Tile t is the entity
/// t + 1 of its volume, its faces the entities 3 t + 1 and 3 t + 2, and each node of a joint an
/// entity of its own. Each element is in it once. With SetChoice::All or Joints the nodes of
/// each joint have a group (JOINT_00000_A, _B) besides, with All each tile and its faces too
/// (TILE_00000, _SBOT, _STOP) and the surfaces SIDES (_SIDE, entity 3 t + 3). Gmsh reads thousands
/// of groups slowly. Coordinates in metres, to the last bit but at shut slits, where nodes that
/// would lie in one place stand apart (separatedNodes): no program welds them. Lengths stay
/// in `unit`, not in a deck's unit. All of the text is built in memory.
std::string gmshMesh(const ElementMesh& mesh, SetChoice sets = SetChoice::Usual,
                     const LengthUnit& unit = {});

// ------------------------------------------------------------------------------------------------
// Nodes in one place, drawn apart.

/// The positions of a mesh's nodes, metres, with those that lie in one place drawn apart: each 1e-7
/// of the sheet's size (the diagonal of its box) into the elements that it belongs to. Slits that
/// are shut have nodes in one place on both sides, to which programs that look for duplicate nodes
/// object, and which those that merge nodes would weld: Gmsh takes what differs by up to 2e-8 of
/// the size in each coordinate for one place. All other positions stay as they are. As many as the
/// mesh has. Where nodes still coincide after four passes they are left so.
std::vector<Vector3> separatedNodes(const ElementMesh& mesh);

}  // namespace kirireel::fea
