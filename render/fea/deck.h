/// Writes Abaqus and CalculiX decks of bricks: keywords, patches, springs, ties and contacts. Also
/// writes Gmsh meshes of the same elements.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "render/fea/element_mesh.h"
#include "sim/base/files.h"
#include "sim/base/geometry.h"
#include "sim/brick/hinge.h"

namespace kirireel::fea {

// ------------------------------------------------------------------------------------------------
// Basic parts of decks, within the limits of the programs that read them.

/// The program whose keywords a deck uses, if the two differ.
enum class Solver { Calculix, Abaqus };

/// Named sets of a deck in addition to those of the whole sheet and its boundary.
enum class SetChoice {
  Auto,    ///< All up to 1,000 tiles, else None: programs search every name linearly
  None,    ///< only the sets of the whole sheet and its boundary
  Joints,  ///< the nodes of each joint
  All,     ///< the joints' sets, and the nodes, faces and surfaces of each tile
};

/// Material of the tiles, in SI units for decks in any unit.
struct Material {
  double youngs = 1e9;    ///< Young's modulus, Pa, > 0
  double poisson = 0.3;   ///< Poisson's ratio, (-1, 0.5)
  double density = 1000;  ///< kg/m^3, > 0
};

/// The consistent units of a deck.
enum class DeckUnit {
  Model,               ///< metres, kilograms, seconds, newtons
  MillimetresNewtons,  ///< millimetres, tonnes, seconds, newtons: stress in MPa
};

/// Factors from SI quantities to those of a deck.
struct UnitScale {
  /// Deck units per metre: 1 or 1e3.
  double length = 1;
  /// Deck units per pascal: 1 or 1e-6. Forces are always in newtons.
  double stress = 1;
  /// Deck units per kg/m^3: 1 or 1e-12.
  double density = 1;
  /// For comments; string literals.
  const char* words = "m, N, kg, s, Pa";
  const char* lengthName = "m";
  const char* stressName = "Pa";
};

/// Tiles that a job moves as in the trajectory.
struct DriveChoice {
  /// Selection of these tiles.
  enum Kind {
    None,  ///< no tile: no such job
    All,   ///< every tile
    Edge,  ///< tiles at both ends of the sheet's longest axis
    Some,  ///< the listed tiles
  };
  Kind kind = None;        ///< selection
  std::vector<int> tiles;  ///< for Some, with the numbers of the model's file
};

/// Options of decks.
struct DeckSettings {
  Solver solver = Solver::Calculix;       ///< program whose keywords the deck uses
  SetChoice sets = SetChoice::Auto;       ///< named sets of nodes and faces
  Material material;                      ///< of all tiles
  DeckUnit unit = DeckUnit::Model;        ///< of all numbers
  DriveChoice drive;                      ///< of a second job that follows the deployment
  bool buckling = false;                  ///< adds a job that computes buckling loads
  bool stateMap = false;                  ///< jobs that map the first exported state to the others
  bool periodic = false;                  ///< job that strains a sheet with opposite ends tied
  std::optional<double> contactFriction;  ///< between flanks, >= 0; absent: no contact
};

/// Origin of a deck, for its header.
struct DeckOrigin {
  std::string model;     ///< the model's name
  std::string state;     ///< as requested, such as "final"
  double time = 0;       ///< of the state, seconds
  double thickness = 0;  ///< of the bricks, metres
  double overlap = 0;    ///< deepest overlap of two bricks in this state, metres; tiles that are
                         ///< one part of the mesh do not count
  std::string writer;    ///< program name and version
  std::string run;       ///< identification of the run, one line
};

/// Factors from SI quantities to this unit, and its text for a deck's header.
UnitScale unitScale(DeckUnit unit);

/// Whether the overlap of bricks, metres, is large enough to be reported for a contact analysis.
/// The limit is 1e-4 of the thickness.
bool isReportableOverlap(double overlap, double thickness);

/// A number in at most 20 characters, the limit of CalculiX and Abaqus. The shortest text that
/// reads back as the same double if it fits, else 14 digits. Zero for magnitudes below 1e-90. The
/// value must be finite, since neither program reads "nan" or "inf".
std::string deckNumber(double value);

/// Appends zero-based numbers as one-based numbers, at most 16 per line. A count of 0 appends
/// nothing, not even a line break.
void appendNumbers(std::string& text, const int* numbers, std::size_t count);

/// Appends *NSET with these zero-based nodes; appends nothing for an empty set.
void appendNodeSet(std::string& text, const std::string& name, const std::vector<int>& nodes);

/// Appends comment lines with the deck's origin and a warning if bricks overlap. Names are made
/// printable and cut to 200 characters.
void appendOrigin(std::string& text, const DeckOrigin& origin, DeckUnit unit);

/// The card *HEADING with one line of data, at most 80 characters.
std::string heading(const DeckOrigin& origin, const std::string& subject);

// ------------------------------------------------------------------------------------------------
// Abaqus and CalculiX decks of bricks.

/// The text of NAME_mesh.inp: nodes, elements, sets, surfaces and the constraints of joints,
/// without material and steps. Elements are C3D20R (C3D20 in tiles one element wide), C3D8I if
/// linear, shells S8R or S4, plane elements CPS8R or CPS4.
///
/// Names are zero-based in the model's order, as in other exports: element sets TILE_00000,
/// NECK_00000 and EALL; node sets TILE_00000_N, _BOT, _TOP, JOINT_00000_A and _B, NJOINT, NALL and
/// those of boundarySets; surfaces TILE_00000_SBOT, _STOP, _SIDE and, on each edge of the tile,
/// _S0, _S1 and so on. Contact adds the surfaces of appendContactSurfaces. Periodic jobs add the
/// control nodes NCONTROL after all others. The text is built in memory: about 70 bytes per node
/// and up to 170 per element. Throws like contactPairs and periodicity if the settings request
/// them. Throws Interrupted if the user stops the program.
std::string meshDeck(const ElementMesh& mesh, const DeckSettings& settings,
                     const DeckOrigin& origin);

/// Shells whose nodes lie on one face, with the name of their set.
struct ShellOffset {
  const char* set;         ///< name in the deck; a string literal
  double offset = 0;       ///< value of OFFSET: from the middle to the nodes, in thicknesses
  std::vector<int> tiles;  ///< zero-based
};

/// The shells by their offset, from the bottom to the top. Empty if all nodes lie in the middle.
/// The mesh must consist of shells.
std::vector<ShellOffset> shellOffsets(const ElementMesh& mesh);

/// Element type in a deck, the same in CalculiX and Abaqus.
const char* elementType(const TileElements& tile, const ElementRule& rule);

// ------------------------------------------------------------------------------------------------
// Rigid patches at joints, and springs between them, in decks of CalculiX and Abaqus.

/// The rigid patches of a mesh with their reference nodes, numbered after the mesh's own nodes. In
/// CalculiX the patches of a joint share one node. A patch with a spring has a further node for its
/// rotation (ROT NODE). In Abaqus a node governs only one rigid body: each patch has its own, and
/// *MPC pins them together. Boundary conditions may use only the first node of a joint.
class PatchDeck {
 public:
  /// The mesh must outlive this object. Makes no nodes if the mesh has no patches.
  PatchDeck(const ElementMesh& mesh, Solver solver);

  /// The positions of the reference nodes; empty if the mesh has no patches.
  const std::vector<Vector3>& nodes() const { return nodes_; }

  /// Number of reference nodes with displacements. The displacements of others are rotations.
  std::size_t placedCount() const { return placed_; }

  /// Appends the patches' sets, the rigid bodies and their pins. Sets are PATCH_00000_0: cluster
  /// and patch, zero-based.
  void appendBodies(std::string& text) const;

  /// Appends springs between patches, *ORIENTATION, *ELEMENT and *SPRING, in this unit. Stiffness
  /// is in N mm/rad for millimetres.
  void appendSprings(std::string& text, DeckUnit unit) const;

  /// Appends the moments of springs that are not at rest in the mesh's state, as rows of *CLOAD.
  /// Appends nothing if all are at rest.
  void appendMoments(std::string& text, DeckUnit unit) const;

 private:
  int addNode(std::size_t cluster);
  /// The degree of freedom of a patch's own node that is its rotation about an axis, 0 to 2.
  Eigen::Index rotation(Eigen::Index axis) const {
    return axis + (solver_ == Solver::Calculix ? 1 : 4);
  }

  const ElementMesh& mesh_;
  Solver solver_;
  std::vector<Vector3> nodes_;
  std::size_t placed_ = 0;
  /// By cluster and patch, zero-based: in Abaqus the body's node, in CalculiX its ROT NODE or -1.
  std::vector<std::vector<int>> own_;
};

// ------------------------------------------------------------------------------------------------
// Springs at the hinges of a deck.

/// Whether a hinge's axis lies in its tiles. Its springs have no place in a deck, because the axis
/// rotates with the tiles.
bool isFold(const brick::Hinge& hinge, const std::vector<brick::Brick>& bricks);

/// Adds hinge springs of the bricks at these poses to a mesh with rigid patches. Only hinges across
/// their tiles count, in any plane. The patches that join two tiles share their spring equally.
/// Returns the number of other springs, which are left out, as are all in a mesh without patches.
/// `springs` identify `bricks` by the tiles' numbers in the mesh. `poses` are those of the mesh.
/// Angles in radians, stiffness in N m/rad. Springs with stiffness 0 count as absent.
int addHingeSprings(ElementMesh& mesh, const std::vector<brick::Brick>& bricks,
                    std::span<const brick::HingeSpring> springs, const Poses& poses);

// ------------------------------------------------------------------------------------------------
// The nodes at the ends of a sheet.

/// A named set of nodes.
struct NamedNodes {
  std::string name;        ///< name in the deck, in capitals
  std::vector<int> nodes;  ///< ascending, zero-based; reference nodes follow the mesh's own
};

/// XMIN, XMAX, YMIN, YMAX, ZMIN and ZMAX: the nodes at the ends of the sheet (SheetEnds). If no
/// edge is an end, the nodes in the plane of the bounding box, to 1e-6 of its size. Flat sheets
/// have no ZMIN and ZMAX, which would be their faces. BOXCORNERS follows: the nodes in two planes
/// across different axes (three with a ZMIN). Dependent nodes are left out, reference nodes of
/// rigid patches are included. A set may be empty. The order is that of this list. One pass over
/// the nodes, does not throw.
std::vector<NamedNodes> boundarySets(const ElementMesh& mesh);

/// Share of a node in a load of 1 N that is distributed evenly over an end.
struct NodeShare {
  int node = 0;      ///< zero-based
  double share = 0;  ///< fraction of the load; the sum over all nodes is 1
};

/// The consistent nodal forces of a uniform traction on the end `end` of boundarySets(), by
/// ascending node: integrals of the shape functions over the faces (over lines for shells and plane
/// elements). Dependent nodes are included. If no edge is an end, all its nodes have equal shares.
std::vector<NodeShare> endShares(const ElementMesh& mesh, int end);

// ------------------------------------------------------------------------------------------------
// Periodic sheets: nodes at opposite ends move equally, up to the motion of control nodes.

/// Ties of a sheet to its neighbours, which are copies of it.
struct Periodicity {
  std::array<Vector3, 2> periods;      ///< from cell to cell, metres
  Matrix3 axes = Matrix3::Identity();  ///< columns: the sheet's x, y and z in the world
  std::array<double, 2> period{};      ///< sides of a rectangle with the cell's area, metres
  std::vector<PeriodicTie> ties;       ///< by ascending node
};

/// The ties of a mesh to copies of it. Only connections by joints across the border are tied
/// (findSheetLattice); slits stay open. A sheet without joints is a plate: all nodes of XMIN follow
/// those of XMAX, at the same position up to the period, and the same in y. Throws InputError for
/// shells, rigid patches, and sheets that are not periodic.
Periodicity periodicity(const ElementMesh& mesh);

/// The ties from pairs of nodes: each node follows its leader in another cell. The leader is the
/// lowest node of all nodes tied together.
std::vector<PeriodicTie> tiesBetween(const std::vector<PeriodicTie>& pairs);

/// Appends *EQUATION for each tie. The control nodes of x and y have the zero-based numbers
/// `firstControl` and the next. Their displacements in the sheet's axes are H e_x times the first
/// period and H e_y times the second, with the mean displacement gradient H. Two directions for
/// plane elements, three for solids.
void appendTies(std::string& text, const Periodicity& periodic, const ElementMesh& mesh,
                int firstControl);

/// The control nodes' positions, next to the sheet, metres.
std::vector<Vector3> controlPositions(const Periodicity& periodic, const ElementMesh& mesh);

// ------------------------------------------------------------------------------------------------
// Flanks of tiles that may collide, for analyses with contact.

/// Two flanks that face each other across the gap or the slit at a joint.
struct ContactPair {
  std::vector<ElementFace> a;  ///< of the first tile, along the whole flank
  std::vector<ElementFace> b;  ///< of the second tile, along the whole flank
};

/// For each joint the flanks on both sides of its corner, each pair once: they collide when the
/// sheet closes. Faces with nodes of joints, or with nodes that a neck shares with its tiles, are
/// left out: joints determine these, and the ends of slits stay closed. Throws InputError for
/// meshes without such flanks: shells, plane elements, and elements so long that all faces touch a
/// joint. Faces of a pair have the order of the tile's sides. The cost is a search through the
/// corners of each joint's tiles and a sort.
std::vector<ContactPair> contactPairs(const ElementMesh& mesh);

/// Appends the surfaces CONTACT_00000_A and _B of each pair, or nothing without pairs. Element
/// numbers in the deck are one-based.
void appendContactSurfaces(std::string& text, const std::vector<ContactPair>& pairs);

/// Appends the interaction FLANKS and the pairs, between the material and the first step. In
/// CalculiX contact is a penalty of E / t per metre of overclosure, and a hundredth of that in
/// sticking. Friction is Coulomb's coefficient, >= 0. Thickness in metres.
void appendContactCards(std::string& text, std::size_t pairs, const DeckSettings& settings,
                        double thickness);

// ------------------------------------------------------------------------------------------------
// Gmsh meshes.

/// The text of a Gmsh 4.1 mesh with one physical group per kind: the volumes TILES (and NECKS), the
/// surfaces BOTTOM and TOP, the points JOINTS at which joined tiles share nodes. Tile t is the
/// entity t + 1 of its volume. Its faces are the entities 3 t + 1 and 3 t + 2, and each node of a
/// joint is an entity. Each element occurs once. SetChoice::All and Joints add a group for the
/// nodes of each joint (JOINT_00000_A, _B). All also adds each tile and its faces (TILE_00000,
/// _SBOT, _STOP) and the surfaces SIDES (_SIDE, entity 3 t + 3). Gmsh reads thousands of groups
/// slowly. Coordinates are bitwise exact except at closed slits, whose coinciding nodes are
/// separated (separatedNodes), so no program merges them. Coordinates are in `unit`, not in a
/// deck's unit. The text is built in memory.
std::string gmshMesh(const ElementMesh& mesh, SetChoice sets = SetChoice::Auto,
                     const LengthUnit& unit = {});

// ------------------------------------------------------------------------------------------------
// Separation of nodes at one position.

/// The positions of a mesh's nodes, metres. Coinciding nodes are moved by 1e-7 of the sheet's size
/// (diagonal of its bounding box) into their elements. Closed slits have coinciding nodes on both
/// sides. Programs report these as duplicates or merge them: Gmsh merges positions that differ by
/// up to 2e-8 of the size in each coordinate. All other positions stay unchanged. One position per
/// node. Nodes that still coincide after four passes stay so.
std::vector<Vector3> separatedNodes(const ElementMesh& mesh);

}  // namespace kirireel::fea
