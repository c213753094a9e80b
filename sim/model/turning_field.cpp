// The motion v(theta) = F_odd e^(-i theta/2) + F_even e^(i theta/2) evaluated.
//
// Why tiles stay rigid: all corners of an even tile have the same F_even, so that their differences
// are differences of F_odd alone, turned by -theta/2; those of an odd tile are turned by +theta/2.
// Why joints stay closed: the corner is the same sum for both tiles that share it. Neighbours so
// turn by theta against each other. The regular field has its constants at the places of a lattice
// of parallelograms with sides a (along) and b (up), as complex numbers: with x = column - (columns
// - 1)/2 and y = row - (rows - 1)/2,
//   F_even = (x + y)/2 a - (x - y)/2 b,      F_odd = (x - y)/2 a + (x + y)/2 b
#include "sim/model/turning_field.h"

#include <utility>

namespace kirireel {

Complex TurningField::corner(const Cell& cell, int corner, double angle) const {
  const Complex halfTurn = std::polar(1.0, 0.5 * angle);
  Complex even = at(cell);
  Complex odd = at(cornerNeighbour(cell, corner));
  if (!isEven(cell)) std::swap(even, odd);
  // One formula for both tiles at a corner, so that their vertices agree to the last bit. Adding 0
  // makes a negative zero positive.
  const Complex point = odd * std::conj(halfTurn) + even * halfTurn;
  return {point.real() + 0.0, point.imag() + 0.0};
}

std::vector<Tile> TurningField::tiles(double angle) const {
  std::vector<Tile> tiles(std::size_t(lattice_.tileCount()));
  for (int tile = 0; tile < lattice_.tileCount(); ++tile) {
    for (int k = 0; k < 4; ++k) {
      const Complex point = corner(lattice_.cellOf(tile), k, angle);
      tiles[std::size_t(tile)].vertices.emplace_back(point.real(), point.imag(), 0);
    }
  }
  return tiles;
}

TurningField regularField(const Lattice& lattice, Complex along, Complex up) {
  TurningField field(lattice);
  for (int column = -1; column <= lattice.columns; ++column) {
    for (int row = -1; row <= lattice.rows; ++row) {
      const double x = column - 0.5 * (lattice.columns - 1);
      const double y = row - 0.5 * (lattice.rows - 1);
      const double sum = 0.5 * (x + y);
      const double difference = 0.5 * (x - y);
      const Cell cell{column, row};
      field.at(cell) = isEven(cell) ? sum * along - difference * up : difference * along + sum * up;
    }
  }
  return field;
}

}  // namespace kirireel
