/// Bricks as finite elements, with the sets that a finite element program needs.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "render/fea/periodic.h"
#include "render/writers/flat_sheet.h"
#include "sim/base/geometry.h"
#include "sim/model/brick.h"
#include "sim/model/model.h"
#include "sim/model/stiffness.h"

namespace kirireel::fea {

/// What holds the elements of joined bricks together.
enum class JointStyle {
  Shared,    ///< one node for all corners that meet
  Equation,  ///< a node each, tied by linear equations: gaps stay as they are
  Patch,     ///< a rigid patch round each corner, patches that meet turn about one reference node
  Neck,      ///< necks of material: the flat sheet as it is cut, in one piece (makeNeckMesh)
};

/// What kind of elements a sheet consists of.
enum class ElementFamily {
  Solid,  ///< C3D20R or C3D8I
  Shell,  ///< S8R or S4: in the middle of the thickness, or on the face that a tile's joints lie on
  Plane,  ///< plane stress, CPS8R or CPS4, only of necks
};

/// How bricks become elements. The defaults bend as plates do, in sheets of up to 468 squares: a
/// clamped plate 50 times as wide as thick to 1.1%, a cantilever 20 times as long as thick to 1.7%.
struct ElementRule {
  int perEdge = 0;        ///< elements along each edge of a tile, 1 to 64; 0 for usualPerEdge, and
                          ///< more where joint patches need them
  int through = 2;        ///< elements through the thickness, 1 to 64
  bool quadratic = true;  ///< 20 nodes an element instead of 8
  JointStyle joints = JointStyle::Shared;  ///< how tiles hold together at their joints
  double patchRadius = 0;  ///< of JointStyle::Patch, metres; 0 for a quarter of the shortest edge
  double size = 0;         ///< the longest that elements are along edges, metres; 0 for `perEdge`
  ElementFamily family = ElementFamily::Solid;  ///< solids, shells or plane elements
  writers::NeckShape neck;                      ///< of JointStyle::Neck, see writers::shapeAt()
  int countsFrom = 0;  ///< the first tile's number in messages: as the model's file counts
};

/// The fewest elements that tiles can consist of, 8 nodes each: enough where nothing strains them.
/// Joints, family and radius stay as they are.
ElementRule coarsest(ElementRule rule);

/// A prism on a quadrilateral, or only the quadrilateral. Nodes in the order of Abaqus: bottom
/// corners, top corners, then of quadratic ones the middles of the bottom edges, of the top edges
/// and of the upright edges; of shells and plane elements the corners, then the middles.
struct Element {
  std::array<int, 20> nodes{};  ///< numbers from 0; the first nodeCount of them
};

/// How many nodes an element has: 20 or 8, of shells and plane elements 8 or 4.
int nodeCount(const ElementRule& rule);

/// A face of an element.
struct ElementFace {
  int element = 0;   ///< its number, from 0
  int side = 0;      ///< from its bottom corner `side` to the next, 0 to 3
  int tileEdge = 0;  ///< the tile's edge that it lies on
};

/// The elements and nodes of one brick. Nodes in rising order unless said otherwise.
struct TileElements {
  int firstElement = 0;                 ///< elements of a tile follow each other
  int elementCount = 0;                 ///< how many there are
  int layerCount = 0;                   ///< elements in one layer; the bottom layer comes first
  bool isRow = false;                   ///< one element wide
  double level = 0.5;                   ///< of shells: where nodes lie in the thickness, 0 to 1
  std::vector<int> nodes;               ///< all of them
  std::vector<int> bottom;              ///< on the bottom face
  std::vector<int> top;                 ///< on the top face
  std::vector<std::vector<int>> edges;  ///< of each corner, through the thickness, bottom first
  std::vector<ElementFace> sides;       ///< the faces all round, by tile edge
};

/// The nodes of a joint on its two tiles, pair by pair: the bottom node, the top node, or all nodes
/// of the edge through the thickness; of shells the one node there is.
struct JointNodes {
  int tileA = 0;         ///< its number, from 0
  int tileB = 0;         ///< its number, from 0
  bool isHinge = false;  ///< it goes through the thickness: tiles turn only about its line
  std::vector<int> a;    ///< of tile A, nodes from 0
  std::vector<int> b;    ///< of tile B, each that of the same place
};

/// Corners of tiles that meet in joints, each given as a tile's node.
struct NodeCluster {
  std::vector<int> nodes;                 ///< rising, at least two
  std::vector<std::vector<int>> patches;  ///< of JointStyle::Patch: the nodes round each, rising
  double gap = 0;                         ///< largest distance between two of them, metres
};

/// A torsional spring between the rigid patches of two tiles, about z.
struct PatchSpring {
  int cluster = 0;       ///< the joint, as a number of ElementMesh::clusters
  int patchA = 0;        ///< of the cluster's patches
  int patchB = 0;        ///< that of the other tile
  double stiffness = 0;  ///< N m/rad
  double moment = 0;     ///< on B in the mesh's state, and on A in reverse; N m
};

/// A node that follows another one in the next cell of a sheet that repeats, see deck.h.
struct PeriodicTie {
  int node = 0;                ///< that follows
  int leader = 0;              ///< that it follows
  std::array<int, 2> times{};  ///< from the leader to the node, in periods
};

/// Two tiles that a fixed joint makes one part of the mesh: they share the nodes of an edge.
struct JoinedTiles {
  int tileA = 0;  ///< its number, from 0
  int tileB = 0;  ///< its number, from 0
};

/// The neck at a joint of JointStyle::Neck.
struct MeshNeck {
  std::array<model::NeckCorner, 2> corners;  ///< of both tiles
  writers::NeckShape shape;                  ///< as writers::shapeAt() has it
};

/// The ends of a sheet, in its own axes: what a person would hold.
struct SheetEnds {
  Matrix3 axes = Matrix3::Identity();  ///< columns: unit vectors along the sheet's x, y and z
  bool isFlat = false;                 ///< all bottoms lie in one plane z = const
  /// XMIN, XMAX, YMIN, YMAX, ZMIN, ZMAX: faces of elements; empty where no edge is an end.
  std::array<std::vector<ElementFace>, 6> faces;
};

/// A mesh of all bricks. Coordinates in metres, world axes.
struct ElementMesh {
  ElementRule rule;                     ///< a patch radius of 0 replaced by the one in use
  std::vector<Vector3> nodes;           ///< places, in the order of their numbers
  std::vector<Element> elements;        ///< tile by tile
  std::vector<TileElements> tiles;      ///< one a brick
  std::vector<TileElements> necks;      ///< of JointStyle::Neck: those with an area of their own
  std::vector<MeshNeck> neckShapes;     ///< of JointStyle::Neck, one a joint
  std::vector<JointNodes> joints;       ///< one a pivot
  std::vector<JoinedTiles> joined;      ///< one a fixed joint
  std::vector<NodeCluster> clusters;    ///< in order of their first node; none are left when shared
  std::vector<PatchSpring> springs;     ///< of JointStyle::Patch, see deck.h
  std::vector<PeriodicTie> ties;        ///< of a job on a sheet that repeats
  double largestGap = 0;                ///< between corners that meet, metres
  SheetEnds ends;                       ///< by findEndEdges()
  std::optional<SheetLattice> lattice;  ///< of makePeriodicNeckMesh(), which has `ties` too
};

/// Throws InputError for numbers of elements and sizes that are out of range or contradict each
/// other, for any bricks. Ranges: perEdge [0, 64], through [1, 64], lengths >= 0; NaN is refused.
void requireValidRule(const ElementRule& rule);

/// Elements along an edge when nobody chose and there are not too many of them.
inline constexpr int kUsualPerEdge = 8;

/// How many elements lie along edges when nobody chose: 8, or as many as keep the sheet below
/// 60,000 elements, at least 2. The rule's other numbers (through, joints, patchRadius) count as
/// they are. Divides no brick, so it costs up to seven passes over them.
int usualPerEdge(const std::vector<model::Brick>& bricks, const ElementRule& rule);

/// Whether nobody chose how many elements lie along edges, and they are fewer than 8. Messages tell
/// the user so.
bool isCoarsened(const std::vector<model::Brick>& bricks, const ElementRule& rule);

/// Divides all bricks at the given poses. Four-sided tiles become grids, triangles and other
/// polygons (fanned round the centre of area) three grids per triangle; all elements are built on
/// quadrilaterals, because wedges bend badly. Corners of tiles lie where the bricks have them, to
/// the last bit; with JointStyle::Shared, where corners meet, at their mean.
///
/// Shells lie in the middle of tiles whose joints go through the thickness and share nodes there,
/// since such tiles turn only in their plane. If all joints of a tile lie on one face, so do
/// its shells, offset by half a thickness (S8R and S4 with OFFSET), and as shells that share a node
/// would bend as one, each has its own: clusters stay, to be tied by equations. Elements are
/// shorter towards the edges of four-sided tiles, see neck_sheet.cpp.
///
/// Throws InputError for a rule out of range, too many elements, bricks too thin for such elements,
/// a tile that is not star-shaped round its centre, joints that would merge two corners of one
/// tile, patches that are too small for the elements or so large that they overlap, and shells of
/// tiles with joints on different faces. Node numbers are those of the tiles in the model's order;
/// the same bricks give the same mesh on every machine. Memory is 80 bytes an element, 24 a node,
/// and the tiles' lists of nodes besides.
ElementMesh makeElementMesh(const std::vector<model::Brick>& bricks,
                            const std::vector<model::Joint>& joints, const Poses& poses,
                            const ElementRule& rule);

/// The nodes of a face: of solids the corners, then the middles of its sides; of shells and plane
/// elements the two ends, then the middle.
std::vector<int> faceNodes(const ElementMesh& mesh, const ElementFace& face);

/// The smallest angle between two sides of an element's bottom, degrees.
double smallestElementAngle(const ElementMesh& mesh);

/// Whether clusters are tied by *EQUATION: all that are left and have no patches.
bool hasEquations(const ElementMesh& mesh);

/// For each node whether it follows others; nothing else may hold it. With *EQUATION all but the
/// first of a cluster follow, in rigid patches all, and in ties those that are tied. One entry per
/// node of the mesh; reference and control nodes have none.
std::vector<bool> followers(const ElementMesh& mesh);

/// The node that the patches of a cluster turn about, numbered after all others. From 0. `cluster`
/// counts from 0 and the mesh has JointStyle::Patch.
int referenceNode(const ElementMesh& mesh, std::size_t cluster);

/// Where that node is: the mean of the cluster's corners.
Vector3 referencePosition(const ElementMesh& mesh, std::size_t cluster);

// ------------------------------------------------------------------------------------------------
// How a tile is divided into quadrilaterals; a brick's elements are built on these.

/// A point of a tile as a mean of its vertices; number n of an n-gon is the tile's centre.
struct FootprintPoint {
  std::array<int, 4> bases{};       ///< vertices, or n for the centre
  std::array<double, 4> weights{};  ///< sum 1, unused ones 0

  /// Where the point lies, given the n vertices and, after them, the centre.
  Vector3 at(const std::vector<Vector3>& verticesAndCentre) const;
};

/// A side of a cell that lies on an edge of the tile.
struct FootprintSide {
  int cell = 0;      ///< its number in Footprint::cells
  int side = 0;      ///< of the cell: from its point `side` to the next
  int tileEdge = 0;  ///< from vertex `tileEdge` to the next
};

/// Points, and the quadrilaterals between them.
struct Footprint {
  std::vector<FootprintPoint> points;     ///< numbered from 0
  std::vector<int> corners;               ///< the point at each vertex of the tile
  std::vector<std::array<int, 4>> cells;  ///< points, anticlockwise
  std::vector<std::array<int, 2>> edges;  ///< of the cells, each once, the lower point first
  std::vector<FootprintSide> sides;       ///< by tile edge
  bool isRow = false;  ///< one cell wide: nothing but full integration holds its shape
};

/// A four-sided tile as a grid of quadrilaterals: `first` along the edges 0 and 2, `second` along
/// the edges 1 and 3, each at least 1. The points of an edge lie at equal shares of it, or, graded,
/// at (1 - cos(pi k / n)) / 2, closer to its ends. `first` x `second` cells, (first + 1) x (second
/// + 1) points.
Footprint gridFootprint(int first, int second, bool isGraded = false);

/// A tile of any number of sides as triangles (a triangle as it is, others fanned round the
/// centre), each cut through the middles of its sides into three quadrilaterals, and these into
/// grids of halfPerEdge x halfPerEdge: 2 halfPerEdge cells along each edge of the tile. `sides` is
/// at least 3, halfPerEdge at least 1. 3 halfPerEdge^2 cells for a triangle, `sides` times as many
/// for others.
Footprint fanFootprint(int sides, int halfPerEdge);

/// A concave tile as these triangles of its vertices, anticlockwise, each divided as those of a
/// fan. The triangles must cover the tile without overlap and share whole sides.
Footprint triangleFootprint(const std::vector<std::array<int, 3>>& triangles, int sides,
                            int halfPerEdge);

/// Whether a convex or star-shaped tile is better divided as a grid: it has four vertices, and none
/// of its corners is so straight or so sharp that a quadrilateral there would have no shape. Sine
/// of every turn at least 0.05, which is 3 degrees. `normal` is a unit vector to the side from
/// which vertices run anticlockwise.
bool takesGrid(const std::vector<Vector3>& vertices, const Vector3& normal);

/// The edges of quadrilaterals, each once, the lower point first, sorted.
std::vector<std::array<int, 2>> edgesOf(const std::vector<std::array<int, 4>>& cells);

// ------------------------------------------------------------------------------------------------
// Prisms on quadrilaterals, layer by layer.

/// Lays the elements of a mesh's rule on quadrilaterals: solids between levels of points, shells
/// and plane elements on a single level.
class PrismLayers {
 public:
  /// How many levels of points the rule asks for; quadratic solids have one halfway up each layer.
  /// 1 for shells and plane elements, `through` + 1 for linear solids, 2 `through` + 1 for
  /// quadratic.
  static int levelCount(const ElementRule& rule);

  /// Adds the nodes. `levels` holds the points that cells refer to, bottom first, metres. The mesh
  /// must outlive this. Each level has the same number of points; `cells` index them.
  PrismLayers(ElementMesh& mesh, std::vector<std::array<int, 4>> cells,
              const std::vector<std::vector<Vector3>>& levels);

  /// Adds the elements on some cells, one layer after the other. `sides` are those of these cells,
  /// numbered from `firstCell`. The returned tile's `edges` are empty. Costs a sort of the tile's
  /// nodes.
  TileElements append(std::size_t firstCell, std::size_t cellCount,
                      const std::vector<FootprintSide>& sides);

  /// The nodes at a point, bottom first.
  std::vector<int> nodesAt(int point) const;

  /// The nodes in the middle of the side between two points, bottom first; none when linear. There
  /// must be such a side.
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
// Corners of tiles that meet in joints: found, merged, or given rigid patches.

/// The least distance between two of the points, infinite for less than two. Compares all pairs.
double leastDistance(const std::vector<Vector3>& points);

/// The nodes of each pivot, in their order. Fixed joints are left out (joinTiles). Throws
/// InputError for a joint that no deck can hold, a link. `countsFrom`: the first joint's number in
/// messages.
std::vector<JointNodes> jointNodes(const std::vector<model::Joint>& joints,
                                   const std::vector<TileElements>& tiles, int countsFrom);

/// Makes tiles that fixed joints hold one part: the nodes of the edges that two tiles share become
/// one, at their mean, and the faces there are no longer sides. Both tiles must have the same nodes
/// along such an edge. Throws InputError for a fixed joint between tiles that share no edge.
void joinTiles(ElementMesh& mesh, const std::vector<model::Joint>& joints);

/// The nodes that the mesh's joints bring together, before any are merged. Throws InputError when
/// two of them belong to one tile. In order of their lowest node; patches are empty.
std::vector<NodeCluster> findClusters(const ElementMesh& mesh);

/// Makes one node of each cluster, at the mean of its corners, and numbers the nodes again without
/// gaps. What is left are clusters of shells on one face, which must not share nodes. Positions of
/// all other nodes keep their last bit.
void mergeClusters(ElementMesh& mesh);

/// Gives each node of each cluster its patch. Throws InputError when a patch holds fewer than three
/// nodes (`leastPerEdge` elements along each edge would do, it says) or two of them overlap.
void spreadPatches(ElementMesh& mesh, int leastPerEdge);

// ------------------------------------------------------------------------------------------------
// A flat sheet with necks of material at its joints, in one piece, as finite elements.

/// Two lines of an outline that get the same nodes: from a point to another, and the same moved.
struct TwinLines {
  std::array<int, 2> line{};  ///< points of the outline
  std::array<int, 2> twin{};  ///< the same points of its twin
  std::array<int, 2> cell{};  ///< from the twin to the line, in periods
};

/// The outline as a Gmsh geometry: one surface a tile and a neck, quadrilaterals of the rule's
/// size, small at the necks: the finer the rule, the finer both. The text is in Gmsh's own language
/// (.geo), lengths in metres. `tileSize` is the mean length of tiles' edges, metres.
std::string neckGeometry(const writers::NeckOutline& outline, const ElementRule& rule,
                         double tileSize, const std::vector<TwinLines>& twins = {});

/// The start of a planar model as one sheet with the rule's necks, of this thickness in metres:
/// solids, shells in the middle of the thickness, or plane elements in the plane z = 0. Tiles and
/// necks share nodes where they meet; the two sides of a slit share none. Meshed by Gmsh, which
/// must be installed.
///
/// Throws what neckOutline, requireValidRule and meshedByGmsh throw. The mesh has no joints and no
/// clusters.
ElementMesh makeNeckMesh(const model::Model& model, double thickness, const ElementRule& rule);

/// The same as one cell of an infinite sheet (findSheetLattice): the necks that its border cuts are
/// part of it, each once, and their nodes have ties to those of the tile that they lead to. Throws
/// what findSheetLattice throws besides.
ElementMesh makePeriodicNeckMesh(const model::Model& model, double thickness,
                                 const ElementRule& rule);

}  // namespace kirireel::fea
