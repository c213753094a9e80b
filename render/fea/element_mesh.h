/// Bricks as finite elements, with the sets for finite element programs.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "render/fea/periodic.h"
#include "render/writers/flat_sheet.h"
#include "sim/base/geometry.h"
#include "sim/brick/brick.h"
#include "sim/brick/stiffness.h"
#include "sim/model/model.h"

namespace kirireel::fea {

/// Connection between the elements of joined bricks.
enum class JointStyle {
  Shared,    ///< one node for all coinciding corners
  Equation,  ///< one node per tile, tied by linear equations: gaps stay
  Patch,     ///< a rigid patch around each corner; joined patches rotate about a reference node
  Neck,      ///< necks of material: the flat cut sheet in one piece (makeNeckMesh)
};

/// Element type of a sheet.
enum class ElementFamily {
  Solid,  ///< C3D20R or C3D8I
  Shell,  ///< S8R or S4: in the middle of the thickness, or on the face with the tile's joints
  Plane,  ///< plane stress, CPS8R or CPS4, only with necks
};

/// Rule for dividing bricks into elements. Errors of the defaults (up to 468 squares): 1.1% for a
/// clamped plate 50 times as wide as thick, 1.7% for a cantilever 20 times as long as thick.
struct ElementRule {
  int perEdge = 0;  ///< elements along each edge of a tile, 1 to 64; 0: defaultPerEdge, more if
                    ///< joint patches need them
  int through = 2;  ///< elements through the thickness, 1 to 64
  bool quadratic = true;                   ///< 20 nodes per element, else 8
  JointStyle joints = JointStyle::Shared;  ///< connection of tiles at their joints
  double patchRadius = 0;  ///< of JointStyle::Patch, metres; 0: a quarter of the shortest edge
  double size = 0;         ///< maximum length of elements along edges, metres; 0: `perEdge`
  ElementFamily family = ElementFamily::Solid;  ///< solids, shells or plane elements
  writers::NeckShape neck;                      ///< of JointStyle::Neck, see writers::shapeAt()
  int countsFrom = 0;  ///< number of the first tile in messages, as in the model's file
  LengthUnit unit;     ///< of lengths in messages, as in the model's file
};

/// The coarsest elements, 8 nodes each, sufficient for tiles without strain. Joints, family and
/// radius stay unchanged.
ElementRule coarsest(ElementRule rule);

/// A prism on a quadrilateral, or only the quadrilateral. Node order of Abaqus: bottom corners, top
/// corners. Quadratic ones continue with the middles of the bottom edges, top edges and upright
/// edges. Shells and plane elements have the corners, then the middles.
struct Element {
  std::array<int, 20> nodes{};  ///< zero-based; the first nodeCount are used
};

/// Number of nodes of an element: 20 or 8, for shells and plane elements 8 or 4.
int nodeCount(const ElementRule& rule);

/// A face of an element.
struct ElementFace {
  int element = 0;   ///< number, zero-based
  int side = 0;      ///< from its bottom corner `side` to the next, 0 to 3
  int tileEdge = 0;  ///< edge of the tile that contains the face; -1: none, as at necks
};

/// The elements and nodes of one brick. Nodes are in ascending order unless stated otherwise.
struct TileElements {
  int firstElement = 0;                 ///< elements of a tile are consecutive
  int elementCount = 0;                 ///< number of elements
  int layerCount = 0;                   ///< elements per layer; the bottom layer is first
  bool isRow = false;                   ///< one element wide
  double level = 0.5;                   ///< of shells: position of nodes in the thickness, 0 to 1
  std::vector<int> nodes;               ///< all nodes
  std::vector<int> bottom;              ///< on the bottom face
  std::vector<int> top;                 ///< on the top face
  std::vector<std::vector<int>> edges;  ///< per corner, through the thickness, bottom first
  std::vector<ElementFace> sides;       ///< all side faces, sorted by tile edge
};

/// The nodes of a corner that a joint on this face holds. The edge is one of TileElements::edges.
std::vector<int> heldNodes(const std::vector<int>& edge, model::JointFace face);

/// The nodes of a joint on its two tiles, pair by pair: the bottom node, the top node, or all nodes
/// of the edge through the thickness. Shells have one node.
struct JointNodes {
  int tileA = 0;         ///< number, zero-based
  int tileB = 0;         ///< number, zero-based
  bool isHinge = false;  ///< through the thickness: tiles rotate only about its line
  std::vector<int> a;    ///< nodes of tile A, zero-based
  std::vector<int> b;    ///< nodes of tile B at the same positions
};

/// Corners of tiles at a common joint, each as a tile's node.
struct NodeCluster {
  std::vector<int> nodes;                 ///< ascending, at least two
  std::vector<std::vector<int>> patches;  ///< of JointStyle::Patch: nodes of each patch, ascending
  double gap = 0;                         ///< largest distance between two nodes, metres
};

/// A torsional spring between the rigid patches of two tiles.
struct PatchSpring {
  int cluster = 0;                  ///< index into ElementMesh::clusters
  int patchA = 0;                   ///< index into the cluster's patches
  int patchB = 0;                   ///< the same for the other tile
  double stiffness = 0;             ///< N m/rad
  double moment = 0;                ///< on B in the mesh's state, opposite on A; N m
  Vector3 axis = Vector3::UnitZ();  ///< unit, world axes
};

/// A node that follows a node in another cell of a periodic sheet, see deck.h.
struct PeriodicTie {
  int node = 0;                ///< dependent node
  int leader = 0;              ///< node that it follows
  std::array<int, 2> times{};  ///< cell offset from leader to node, in periods
};

/// Two tiles that a fixed joint makes one part of the mesh: they share the nodes of an edge.
struct JoinedTiles {
  int tileA = 0;  ///< number, zero-based
  int tileB = 0;  ///< number, zero-based
};

/// A tile and its edge from the vertex of this number to the next, zero-based.
using TileEdge = std::pair<int, int>;

/// Two edges that face each other across a gap or a slit.
using FacingEdges = std::pair<TileEdge, TileEdge>;

/// The edges next to a joint of these corners, on both sides of it. `sidesA` and `sidesB` are the
/// numbers of edges of the two tiles.
std::array<FacingEdges, 2> edgesBesideJoint(const model::Corner& a, int sidesA,
                                            const model::Corner& b, int sidesB);

/// The neck at a joint of JointStyle::Neck.
struct MeshNeck {
  std::array<FacingEdges, 2> slits;          ///< on both sides of it
  std::array<brick::NeckCorner, 2> corners;  ///< of both tiles
  writers::NeckShape shape;                  ///< result of writers::shapeAt()
};

/// The ends of a sheet in its own axes, where a test machine would grip it.
struct SheetEnds {
  Matrix3 axes = Matrix3::Identity();  ///< columns: unit vectors along the sheet's x, y and z
  bool isFlat = false;                 ///< all bottoms lie in one plane, across z
  int longest = 0;                     ///< axis of the largest extent that has ends: 0 x, 1 y, 2 z
  /// XMIN, XMAX, YMIN, YMAX, ZMIN, ZMAX: faces of elements; empty if no edge is an end.
  std::array<std::vector<ElementFace>, 6> faces;
};

/// A mesh of all bricks. Coordinates in metres, world axes; of plane elements in the sheet's plane.
struct ElementMesh {
  ElementRule rule;                          ///< a patch radius of 0 is replaced by its value
  std::vector<Vector3> nodes;                ///< positions, in the order of their numbers
  std::vector<Element> elements;             ///< ordered by tile
  std::vector<TileElements> tiles;           ///< one per brick
  std::vector<TileElements> necks;           ///< of JointStyle::Neck: necks with a non-zero area
  std::vector<MeshNeck> neckShapes;          ///< of JointStyle::Neck, one per joint
  std::vector<JointNodes> joints;            ///< one per pivot
  std::vector<JoinedTiles> joined;           ///< one per fixed joint
  std::vector<NodeCluster> clusters;         ///< ordered by first node; empty if shared
  std::vector<PatchSpring> springs;          ///< of JointStyle::Patch, see deck.h
  std::vector<PeriodicTie> ties;             ///< of a job on a periodic sheet
  double largestGap = 0;                     ///< between corners of one joint, metres
  SheetEnds ends;                            ///< from findEndEdges()
  Quaternion turn = Quaternion::Identity();  ///< from the world to the axes of the nodes
  std::optional<SheetLattice> lattice;       ///< of makePeriodicNeckMesh(), which also sets `ties`
};

/// Throws InputError for counts and sizes that are out of range or contradict each other.
/// Independent of bricks. Ranges: perEdge [0, 64], through [1, 64], lengths >= 0; NaN is refused.
void requireValidRule(const ElementRule& rule);

/// Default number of elements along an edge, if the sheet is not too large.
inline constexpr int kDefaultPerEdge = 8;

/// Default number of elements along edges: 8, or as many as keep the sheet below 60,000 elements,
/// but >= 2. The rule's other fields (through, joints, patchRadius) are used. It divides no brick
/// and makes up to seven passes over them.
int defaultPerEdge(const std::vector<brick::Brick>& bricks, const ElementRule& rule);

/// Whether the default number of elements along edges is below 8. Messages report this to the user.
bool isCoarsened(const std::vector<brick::Brick>& bricks, const ElementRule& rule);

/// Divides all bricks at the given poses. Four-sided tiles become grids. Triangles and other
/// polygons (as fans around the centroid) become three grids per triangle. All elements are built
/// on quadrilaterals, because triangular prisms bend badly. Corners of tiles are bitwise equal to
/// the bricks' corners. With JointStyle::Shared, joined corners are at their mean.
///
/// Shells lie in the middle of tiles whose joints go through the thickness, and share nodes there,
/// since such tiles rotate only in their plane. If all joints of a tile lie on one face, so do its
/// shells, offset by half a thickness (S8R and S4 with OFFSET). Shells with a common node would
/// bend as one, so these have separate nodes, and their clusters are tied by equations. Elements
/// are shorter towards the edges of four-sided tiles, see neck_sheet.cpp.
///
/// Throws InputError for a rule out of range, too many elements, bricks too thin for the elements,
/// a tile that is not star-shaped around its centre, joints that would merge two corners of one
/// tile, patches that are too small for the elements or overlap, and shells of tiles with joints on
/// different faces. Node numbers follow the tiles in the model's order. The same bricks give the
/// same mesh on every machine. Memory is 80 bytes per element and 24 per node, plus the tiles'
/// lists of nodes.
ElementMesh makeElementMesh(const std::vector<brick::Brick>& bricks,
                            const std::vector<model::Joint>& joints, const Poses& poses,
                            const ElementRule& rule);

/// The nodes of a face: for solids the corners, then the middles of its sides; for shells and plane
/// elements the two ends, then the middle.
std::vector<int> faceNodes(const ElementMesh& mesh, const ElementFace& face);

/// The smallest angle between two sides of an element's bottom, degrees.
double smallestElementAngle(const ElementMesh& mesh);

/// Whether there are clusters tied by *EQUATION: all remaining ones without patches.
bool hasEquations(const ElementMesh& mesh);

/// For each node of the mesh whether it is dependent and may not be constrained otherwise. With
/// *EQUATION all but the first of a cluster are dependent, in rigid patches all, in ties the tied
/// nodes. Reference and control nodes have no entry.
std::vector<bool> followers(const ElementMesh& mesh);

/// For each node of the mesh whether it belongs to a joint, or to two parts: tiles share nodes with
/// necks or with each other.
std::vector<bool> jointNodesOf(const ElementMesh& mesh);

/// The rotation centre of a cluster's patches, numbered after all other nodes, zero-based.
/// `cluster` is zero-based, and the mesh has JointStyle::Patch.
int referenceNode(const ElementMesh& mesh, std::size_t cluster);

/// Position of that node: the mean of the cluster's corners.
Vector3 referencePosition(const ElementMesh& mesh, std::size_t cluster);

// ------------------------------------------------------------------------------------------------
// Division of a tile into quadrilaterals, on which a brick's elements are built.

/// A point of a tile as a weighted mean of vertices; base n of an n-gon is the tile's centre.
struct FootprintPoint {
  std::array<int, 4> bases{};       ///< vertices, or n for the centre
  std::array<double, 4> weights{};  ///< sum 1, 0 if unused

  /// Position of the point, given the n vertices followed by the centre.
  Vector3 at(const std::vector<Vector3>& verticesAndCentre) const;
};

/// A side of a cell that lies on an edge of the tile.
struct FootprintSide {
  int cell = 0;      ///< index into Footprint::cells
  int side = 0;      ///< of the cell: from its point `side` to the next
  int tileEdge = 0;  ///< from vertex `tileEdge` to the next
};

/// Points and quadrilaterals of a tile.
struct Footprint {
  std::vector<FootprintPoint> points;     ///< zero-based
  std::vector<int> corners;               ///< the point at each vertex of the tile
  std::vector<std::array<int, 4>> cells;  ///< points, anticlockwise
  std::vector<std::array<int, 2>> edges;  ///< of the cells, unique, the lower point first
  std::vector<FootprintSide> sides;       ///< sorted by tile edge
  bool isRow = false;  ///< one cell wide: needs full integration against zero-energy modes
};

/// A four-sided tile as a grid of quadrilaterals: `first` along the edges 0 and 2, `second` along
/// the edges 1 and 3, each >= 1. The points of an edge are equidistant. If graded, they are denser
/// towards its ends: (1 - cos(pi k / n)) / 2. Gives `first` x `second` cells and
/// (first + 1) x (second + 1) points.
Footprint gridFootprint(int first, int second, bool isGraded = false);

/// A tile with any number of sides as triangles: a triangle stays whole, others are fans around the
/// centre. Each triangle is cut through the middles of its sides into three quadrilaterals, and
/// these into grids of halfPerEdge x halfPerEdge. Each edge of the tile then has 2 halfPerEdge
/// cells. `sides` >= 3, halfPerEdge >= 1. Gives 3 halfPerEdge^2 cells for a triangle, `sides` times
/// as many for others.
Footprint fanFootprint(int sides, int halfPerEdge);

/// A tile as these anticlockwise triangles of its vertices, each divided like those of a fan. The
/// number `sides` is its centre. The triangles must cover the tile without overlap and share whole
/// sides.
Footprint triangleFootprint(const std::vector<std::array<int, 3>>& triangles, int sides,
                            int halfPerEdge);

/// Whether a convex or star-shaped tile should be divided as a grid: it has four vertices, and no
/// corner is so straight or sharp that a quadrilateral there degenerates. The sine of every turn is
/// at least 0.05 (3 degrees). `normal` is a unit vector towards the side from which vertices are
/// anticlockwise.
bool takesGrid(const std::vector<Vector3>& vertices, const Vector3& normal);

/// The edges of quadrilaterals, unique and sorted, the lower point first.
std::vector<std::array<int, 2>> edgesOf(const std::vector<std::array<int, 4>>& cells);

// ------------------------------------------------------------------------------------------------
// Prisms on quadrilaterals, layer by layer.

/// Builds the elements of a mesh's rule on quadrilaterals: solids between levels of points, shells
/// and plane elements on a single level.
class PrismLayers {
 public:
  /// Number of levels of points for the rule: 1 for shells and plane elements, `through` + 1 for
  /// linear solids, 2 `through` + 1 for quadratic solids, which have an additional level halfway up
  /// each layer.
  static int levelCount(const ElementRule& rule);

  /// Adds the nodes. `levels` holds the points that cells refer to, bottom first, metres. Each
  /// level has the same number of points. The mesh must outlive this object.
  PrismLayers(ElementMesh& mesh, std::vector<std::array<int, 4>> cells,
              const std::vector<std::vector<Vector3>>& levels);

  /// Adds the elements on some cells, layer by layer. `sides` are those of these cells, numbered
  /// from `firstCell`. The returned tile's `edges` are empty. The cost is a sort of the tile's
  /// nodes.
  TileElements append(std::size_t firstCell, std::size_t cellCount,
                      const std::vector<FootprintSide>& sides);

  /// The nodes at a point, bottom first.
  std::vector<int> nodesAt(int point) const;

  /// The nodes in the middle of the side between two points, bottom first; empty if linear. The
  /// side must exist.
  std::vector<int> nodesBetween(int a, int b) const;

 private:
  int step() const { return mesh_.rule.quadratic ? 2 : 1; }
  std::size_t edgeNumber(int a, int b) const;
  Element elementOn(const std::array<int, 4>& cell, int level) const;

  ElementMesh& mesh_;
  std::vector<std::array<int, 4>> cells_;
  std::vector<std::array<int, 2>> edges_;
  std::vector<std::vector<int>> pointNode_;  ///< by level and point
  std::vector<std::vector<int>> edgeNode_;   ///< by level and edge
};

// ------------------------------------------------------------------------------------------------
// Corners of tiles at common joints: search, merge, and rigid patches.

/// The smallest distance between two points, infinite for fewer than two. Compares all pairs.
double smallestDistance(const std::vector<Vector3>& points);

/// The nodes of each pivot, in their order. Fixed joints are left out (joinTiles). Throws
/// InputError for a link, which no deck can hold. `countsFrom`: the first joint's number in
/// messages.
std::vector<JointNodes> jointNodes(const std::vector<model::Joint>& joints,
                                   const std::vector<TileElements>& tiles, int countsFrom);

/// Merges tiles with fixed joints to one part: the nodes of their common edges become one node at
/// their mean, and the faces there are no longer sides. Both tiles must have the same nodes along
/// such an edge. Throws InputError for a fixed joint between tiles without a common edge.
void joinTiles(ElementMesh& mesh, const std::vector<model::Joint>& joints);

/// The nodes that the mesh's joints connect, before any merging. Throws InputError if two of them
/// belong to one tile. Ordered by lowest node; patches are empty.
std::vector<NodeCluster> findClusters(const ElementMesh& mesh);

/// Merges each cluster to one node at the mean of its corners, and renumbers the nodes without
/// gaps. Clusters of shells on one face stay, since these must not share nodes. All other positions
/// stay bitwise equal.
void mergeClusters(ElementMesh& mesh);

/// Gives each node of each cluster its patch. Throws InputError if two patches overlap or a patch
/// has fewer than three nodes. The message recommends `minPerEdge` elements along each edge.
void spreadPatches(ElementMesh& mesh, int minPerEdge);

// ------------------------------------------------------------------------------------------------
// A flat sheet with necks of material at its joints, in one piece, as finite elements.

/// Two lines of an outline with corresponding nodes: a line, and its copy moved by periods.
struct TwinLines {
  std::array<int, 2> line{};  ///< point numbers in the outline
  std::array<int, 2> twin{};  ///< the corresponding points of the copy
  std::array<int, 2> cell{};  ///< offset from the copy to the line, in periods
};

/// The outline as a Gmsh geometry: one surface per tile and neck, quadrilaterals of the rule's
/// size, smaller at the necks. A finer rule refines both. The text is in Gmsh's own language
/// (.geo), lengths in metres. `tileSize` is the mean length of tiles' edges, metres.
std::string neckGeometry(const writers::NeckOutline& outline, const ElementRule& rule,
                         double tileSize, const std::vector<TwinLines>& twins = {});

/// The outline of a model's start with necks (writers::neckOutline). Also throws InputError for
/// necks narrower than a millionth of the sheet's size, whose elements Gmsh cannot place.
writers::NeckOutline meshableOutline(const model::Model& model, const writers::NeckShape& shape);

/// The start of a planar model as one sheet with the rule's necks and this thickness in metres:
/// solids, shells in the middle of the thickness, or plane elements in the plane z = 0. Tiles and
/// necks share nodes at their common boundary; the two sides of a slit share none. Requires an
/// installed Gmsh.
///
/// Throws like meshableOutline, requireValidRule and meshedByGmsh. The mesh has no joints and no
/// clusters.
ElementMesh makeNeckMesh(const model::Model& model, double thickness, const ElementRule& rule);

/// The same as one cell of an infinite sheet (findSheetLattice). Necks that its border cuts are
/// part of it, each once. Their nodes have ties to those of the tile at their other end. Also
/// throws like findSheetLattice.
ElementMesh makePeriodicNeckMesh(const model::Model& model, double thickness,
                                 const ElementRule& rule);

}  // namespace kirireel::fea
