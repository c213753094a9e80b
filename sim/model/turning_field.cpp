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
