// Which corner of a tile belongs to which neighbour. In a rotating lattice neighbours turn in
// opposite senses, so that an even tile shares its corners 0, 1, 2, 3 (from bottom left,
// anticlockwise) with its neighbours in the west, south, east and north, and an odd tile with those
// in the south, east, north and west. A joint therefore lies at the corner that both lists give to
// each other. J. N. Grima, K. E. Evans, Auxetic behavior from rotating squares, Journal of
// Materials Science Letters 19, 2000, describe the mechanism.
#include "sim/model/lattice.h"

namespace kirireel {

Cell cornerNeighbour(const Cell& cell, int corner) {
  constexpr Cell kWest{-1, 0}, kEast{1, 0}, kSouth{0, -1}, kNorth{0, 1};
  constexpr Cell kOfEven[] = {kWest, kSouth, kEast, kNorth};
  constexpr Cell kOfOdd[] = {kSouth, kEast, kNorth, kWest};
  const Cell& step = isEven(cell) ? kOfEven[corner] : kOfOdd[corner];
  return {cell.column + step.column, cell.row + step.row};
}

std::vector<Joint> latticeJoints(const Lattice& lattice, JointFace face) {
  std::vector<Joint> joints;
  for (int tile = 0; tile < lattice.tileCount(); ++tile) {
    const Cell cell = lattice.cellOf(tile);
    const bool even = isEven(cell);
    // To the right: top right with top left, or bottom right with bottom left.
    if (cell.column + 1 < lattice.columns) {
      joints.push_back({{tile, even ? 2 : 1}, {tile + lattice.rows, even ? 3 : 0}, face});
    }
    // Upwards: top left with bottom left, or top right with bottom right.
    if (cell.row + 1 < lattice.rows) {
      joints.push_back({{tile, even ? 3 : 2}, {tile + 1, even ? 0 : 1}, face});
    }
  }
  return joints;
}

}  // namespace kirireel
