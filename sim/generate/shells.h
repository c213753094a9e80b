/// Sheets that deploy to curved surfaces, and the common parts of their designs.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/generate/constrained_fit.h"
#include "sim/generate/lattice.h"
#include "sim/generate/lattice_designs.h"
#include "sim/model/model.h"

namespace kirireel::generate {

// ------------------------------------------------------------------------------------------------
// Sheets of quads that deploy to curved surfaces. Lengths in metres, angles in radians.
//
// Each function throws InputError if no such sheet was found, which occurs for shapes far from the
// defaults.

/// A rectangular tube that becomes slimmer and longer: columns x rows rectangles wrapped around a
/// regular prism with as many sides as columns.
struct CylinderShape {
  int columns = 6;    ///< even, >= 4
  int rows = 6;       ///< >= 1
  double length = 2;  ///< of a tile around the tube at the start, > 0
  double width = 1;   ///< of a tile along the tube at the start, > 0
};
/// Such a model, its start and its target.
model::Model makeCylinder(const CylinderShape& shape);

/// A flat square that becomes a cap on a sphere.
struct CapShape {
  int size = 8;                           ///< columns and rows, even
  double radius = 3.4641016151377544;     ///< of the sphere
  double halfAngle = 0.7853981633974483;  ///< between the sphere's pole and the sides' middles
};
/// Such a model, its start and its target.
model::Model makeSphericalCap(const CapShape& shape);

/// A cube of six square sheets that becomes a sphere: six caps, joined at tips that coincide in
/// both states. The shape's angle is not used; it is pi / 4.
model::Model makeCubeToSphere(const CapShape& shape);

/// A flat strip that becomes a twisted band.
struct BandShape {
  int columns = 12;             ///< along the strip, even
  int rows = 2;                 ///< across, even
  int halfTwists = 1;           ///< >= 0
  double radius = 3;            ///< of the band's middle line
  double angle = 1.2217304764;  ///< approximate opening angle of neighbours
};
/// Such a model, its start and its target.
model::Model makeMoebiusBand(const BandShape& shape);

/// A cap of a sphere that becomes a saddle z = curvature (x^2 - y^2), closed in both states.
struct SaddleShape {
  int columns = 10;        ///< even
  int rows = 10;           ///< even
  double radius = 6.9;     ///< of the sphere
  double curvature = 0.4;  ///< of the saddle, 1/m
  double width = 6;        ///< of the sheet's longer side before lifting
};
/// Such a model, its start and its target.
model::Model makeSphereToSaddle(const SaddleShape& shape);

// ------------------------------------------------------------------------------------------------
// Two congruent states of one sheet of quads, as unknowns of a fit.

/// Shared nodes of a sheet's corners. Joints are shared nodes, so they are closed exactly.
struct NodeMap {
  std::vector<std::vector<int>> nodeOf;  ///< [tile][corner], zero-based
  int nodeCount = 0;                     ///< number of different nodes
};

/// The nodes of the open sheet: joined corners share a node.
NodeMap openNodes(const Lattice& lattice);

/// The nodes of the sheet closed at the start (theta = 0): a grid of columns + 1 by rows + 1.
NodeMap nodesClosedAtStart(const Lattice& lattice);

/// The nodes of the sheet closed again after all tiles have rotated (theta = pi).
NodeMap nodesClosedAtEnd(const Lattice& lattice);

/// A point whose coordinates are unknowns.
struct UnknownPoint {
  Vector3 value = Vector3::Zero();  ///< current coordinates, metres
  int first = 0;                    ///< index of the unknown x; y and z follow
  int dimension = 3;                ///< 2 for a point in the plane z = 0
};

/// The nodes of one state as unknowns.
struct StateUnknowns {
  NodeMap nodes;      ///< shared nodes of corners
  int dimension = 3;  ///< 2 for a state in the plane z = 0
  int first = 0;      ///< index of the unknown x of node 0

  /// Number of unknowns of the state.
  int count() const { return dimension * nodes.nodeCount; }
  /// A node, by its number from 0.
  UnknownPoint point(const Eigen::VectorXd& unknowns, int node) const;
  /// The node at a corner of a tile.
  UnknownPoint point(const Eigen::VectorXd& unknowns, int tile, int corner) const {
    return point(unknowns, nodes.nodeOf[std::size_t(tile)][std::size_t(corner)]);
  }
  /// Writes a state's tiles into the unknowns.
  void pack(const std::vector<model::Tile>& tiles, Eigen::VectorXd& unknowns) const;
  /// The state's tiles, whose vertices are the nodes.
  std::vector<model::Tile> tiles(const Eigen::VectorXd& unknowns) const;
};

/// Adds to the slopes of the last equation those along a point's coordinates.
void addSlope(EquationRows& rows, const UnknownPoint& point, const Vector3& slope);

/// Adds weight * (direction . point - value); slopes along further unknowns may follow.
void addPosition(EquationRows& rows, const UnknownPoint& point, const Vector3& direction,
                 double value, double weight = 1);

/// Adds weight * (|point| - radius).
void addOnSphere(EquationRows& rows, const UnknownPoint& point, double radius, double weight = 1);

/// Adds weight * (point - desired), one equation per coordinate.
void addNear(EquationRows& rows, const UnknownPoint& point, const Vector3& desired, double weight);

/// Adds that every quad has the same shape in both states: the inner products of its edges from
/// corner 0 with each other and with the diagonal. (Edge lengths and one diagonal would allow the
/// quad to fold over.) Both states have the same tiles; five equations per tile, in m^2. A quad in
/// the plane needs the same number.
void addCongruence(EquationRows& rows, const StateUnknowns& a, const StateUnknowns& b,
                   const Eigen::VectorXd& unknowns);

/// Adds that every quad of a state in space is planar. One equation per tile, in m^3. `state` has
/// three dimensions.
void addPlanarity(EquationRows& rows, const StateUnknowns& state, const Eigen::VectorXd& unknowns);

// ------------------------------------------------------------------------------------------------
// Common parts of the designs of shells.

/// The fit of a design. Throws InputError with the name of the family if its exact equations cannot
/// be fulfilled.
Eigen::VectorXd fitFamily(const std::string& family, const DesignSource& source,
                          Eigen::VectorXd start, const FitSettings& settings);

/// Unit squares at an opening angle, about the origin.
std::vector<model::Tile> unitTiles(const Lattice& lattice, double angle);

/// The tiles with every vertex moved.
template <typename Map>
std::vector<model::Tile> mapped(std::vector<model::Tile> tiles, const Map& map) {
  for (model::Tile& tile : tiles) {
    for (Vector3& vertex : tile.vertices) vertex = map(vertex);
  }
  return tiles;
}

/// Mean edge length of tiles.
double meanEdge(const std::vector<model::Tile>& tiles);

/// The side of a sheet that a tip or node of its closed boundary belongs to: 0 bottom, 1 right, 2
/// top, 3 left.
int sideOf(const Lattice& lattice, int number);

/// The direction out of that side.
Vector3 outwards(int side);

/// A flat closed state that is exactly a rectangle about the origin, with unknown half sides.
class FlatRectangle {
 public:
  /// The unknowns of half the length of the columns' and the rows' sides; they may be the same.
  FlatRectangle(const Lattice& lattice, StateUnknowns state, int halfColumns, int halfRows);

  /// Adds that the boundary's nodes lie on the rectangle.
  void addExact(EquationRows& rows, const Eigen::VectorXd& unknowns) const;

  /// Adds weight * (node - its position in an even grid) for all nodes.
  void addEvenGrid(EquationRows& rows, const Eigen::VectorXd& unknowns, double weight) const;

  /// Node `number` of the closed boundary, anticlockwise from the bottom left.
  UnknownPoint boundaryPoint(const Eigen::VectorXd& unknowns, int number) const;

 private:
  void addOnSide(EquationRows& rows, const Eigen::VectorXd& unknowns, int number, int side) const;

  Lattice lattice_;
  StateUnknowns state_;
  std::array<int, 2> halves_;
  std::vector<LatticeCorner> boundary_;
};

}  // namespace kirireel::generate
