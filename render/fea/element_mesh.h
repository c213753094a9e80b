/// Bricks as solid elements, with the sets that a finite element program needs.
#pragma once

#include <array>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/brick/brick.h"
#include "sim/model/model.h"

namespace kirireel {

/// What holds the elements of joined bricks together.
enum class JointStyle {
  Shared,    ///< one node for all corners that meet
  Equation,  ///< a node each, tied by linear equations: gaps stay as they are
  Patch,     ///< a rigid patch round each corner, patches that meet turn about one reference node
};

/// How bricks become elements.
struct ElementRule {
  int perEdge = 2;         ///< elements along each edge of a tile, 1 to 64
  int through = 1;         ///< elements through the thickness, 1 to 64
  bool quadratic = false;  ///< 20 and 15 nodes an element instead of 8 and 6
  JointStyle joints = JointStyle::Shared;
  double patchRadius = 0;  ///< of JointStyle::Patch, metres, positive
};

/// A prism on a quadrilateral (8 or 20 nodes) or on a triangle (6 or 15). Nodes in the order of
/// Abaqus: bottom corners, top corners, then of quadratic ones the middles of the bottom edges, of
/// the top edges and of the upright edges.
struct Element {
  int sides = 4;                ///< 4 or 3
  std::array<int, 20> nodes{};  ///< numbers from 0
};

/// How many nodes an element of so many sides has.
int nodeCount(int sides, bool quadratic);

/// The elements and nodes of one brick. Nodes in rising order unless said otherwise.
struct TileElements {
  int firstElement = 0;  ///< elements of a tile follow each other
  int elementCount = 0;
  int layerCount = 0;                   ///< elements in one layer; the bottom layer comes first
  std::vector<int> nodes;               ///< all of them
  std::vector<int> bottom;              ///< on the bottom face
  std::vector<int> top;                 ///< on the top face
  std::vector<std::vector<int>> edges;  ///< of each corner, through the thickness, bottom first
};

/// The nodes of a joint on its two tiles, pair by pair: the bottom node, the top node, or all nodes
/// of the edge through the thickness.
struct JointNodes {
  std::vector<int> a;
  std::vector<int> b;
};

/// Corners of tiles that meet in joints, each given as a tile's node.
struct NodeCluster {
  std::vector<int> nodes;                 ///< rising, at least two
  std::vector<std::vector<int>> patches;  ///< of JointStyle::Patch: the nodes round each, rising
  double gap = 0;                         ///< largest distance between two of them, metres
};

/// A mesh of all bricks. Coordinates in metres, world axes.
struct ElementMesh {
  ElementRule rule;
  std::vector<Vector3> nodes;
  std::vector<Element> elements;
  std::vector<TileElements> tiles;    ///< one a brick
  std::vector<JointNodes> joints;     ///< one a joint
  std::vector<NodeCluster> clusters;  ///< in order of their first node; none are left when shared
  double largestGap = 0;              ///< between corners that meet, metres
};

/// Divides all bricks at the given poses. Four-sided tiles become grids of hexahedra, triangles and
/// other polygons (fanned round the centre of area) wedges. Corners of tiles lie where the bricks
/// have them, to the last bit; with JointStyle::Shared, where corners meet, at their mean.
///
/// Throws InputError for a rule out of range, too many elements, bricks too thin for such elements,
/// a tile that is not star-shaped round its centre, joints that would merge two corners of one
/// tile, and patches that are too small for the elements or so large that they overlap.
ElementMesh makeElementMesh(const std::vector<Brick>& bricks, const std::vector<Joint>& joints,
                            const Poses& poses, const ElementRule& rule);

}  // namespace kirireel
