/// What the designs of shells have in common.
#pragma once

#include <array>
#include <string>

#include "sim/generate/constrained_fit.h"
#include "sim/generate/lattice_equations.h"
#include "sim/generate/two_states.h"

namespace kirireel {

/// The fit of a design. Throws InputError naming the family when its exact equations do not come to
/// hold.
Eigen::VectorXd fitFamily(const std::string& family, const DesignSource& source,
                          Eigen::VectorXd start, const FitSettings& settings);

/// Unit squares at an opening angle, about the origin.
std::vector<Tile> unitTiles(const Lattice& lattice, double angle);

/// Half the extent of tiles about the origin, along each axis.
Vector3 halfExtent(const std::vector<Tile>& tiles);

/// The tiles with every vertex moved.
template <typename Map>
std::vector<Tile> mapped(std::vector<Tile> tiles, const Map& map) {
  for (Tile& tile : tiles) {
    for (Vector3& vertex : tile.vertices) vertex = map(vertex);
  }
  return tiles;
}

/// Mean edge length of tiles.
double meanEdge(const std::vector<Tile>& tiles);

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

  /// Adds weight * (node - its place in an even grid) for all nodes.
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

}  // namespace kirireel
