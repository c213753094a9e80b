/// Two congruent states of one sheet of quads, as unknowns of a fit.
#pragma once

#include <vector>

#include "sim/base/geometry.h"
#include "sim/generate/constrained_fit.h"
#include "sim/model/lattice.h"

namespace kirireel {

/// Which corners of a sheet share a node: joints are shared nodes, so that they are closed exactly.
struct NodeMap {
  std::vector<std::vector<int>> nodeOf;  ///< [tile][corner], from 0
  int nodeCount = 0;
};

/// The nodes of the open sheet: corners that joints hold together.
NodeMap openNodes(const Lattice& lattice);

/// The nodes of the sheet closed at the start (theta = 0): a grid of columns + 1 by rows + 1.
NodeMap nodesClosedAtStart(const Lattice& lattice);

/// The nodes of the sheet closed again after all tiles have turned (theta = pi).
NodeMap nodesClosedAtEnd(const Lattice& lattice);

/// A point whose coordinates are unknowns.
struct UnknownPoint {
  Vector3 value = Vector3::Zero();
  int first = 0;      ///< the unknown that is x; y and z follow
  int dimension = 3;  ///< 2 for a point in the plane z = 0
};

/// The nodes of one state as unknowns.
struct StateUnknowns {
  NodeMap nodes;
  int dimension = 3;  ///< 2 for a state in the plane z = 0
  int first = 0;      ///< the unknown that is x of node 0

  int count() const { return dimension * nodes.nodeCount; }
  UnknownPoint point(const Eigen::VectorXd& unknowns, int node) const;
  UnknownPoint point(const Eigen::VectorXd& unknowns, int tile, int corner) const {
    return point(unknowns, nodes.nodeOf[std::size_t(tile)][std::size_t(corner)]);
  }
  /// Writes a state's tiles into the unknowns.
  void pack(const std::vector<Tile>& tiles, Eigen::VectorXd& unknowns) const;
  std::vector<Tile> tiles(const Eigen::VectorXd& unknowns) const;
};

/// Adds to the slopes of the last equation those along a point's coordinates.
void addSlope(EquationRows& rows, const UnknownPoint& point, const Vector3& slope);

/// Adds weight * (direction . point - value); slopes along further unknowns may follow.
void addPosition(EquationRows& rows, const UnknownPoint& point, const Vector3& direction,
                 double value, double weight = 1);

/// Adds weight * (|point| - radius).
void addOnSphere(EquationRows& rows, const UnknownPoint& point, double radius, double weight = 1);

/// Adds weight * (point - wanted), one equation a coordinate.
void addNear(EquationRows& rows, const UnknownPoint& point, const Vector3& wanted, double weight);

/// Adds that every quad has the same shape in both states: the inner products of its edges from
/// corner 0 with each other and with the diagonal. (Edge lengths and one diagonal would allow the
/// quad to fold over.)
/// Both states have the same tiles; five equations a tile, in m^2. A quad in the plane needs the
/// same number.
void addCongruence(EquationRows& rows, const StateUnknowns& a, const StateUnknowns& b,
                   const Eigen::VectorXd& unknowns);

/// Adds that every quad of a state in space is planar.
/// One equation a tile, in m^3. `state` has three dimensions.
void addPlanarity(EquationRows& rows, const StateUnknowns& state, const Eigen::VectorXd& unknowns);

}  // namespace kirireel
