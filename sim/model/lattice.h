/// The lattice of quads that most kirigami sheets are: tiles in columns and rows, joined at corners
/// so that neighbours turn against each other.
#pragma once

#include <vector>

#include "sim/model/model.h"

namespace kirireel {

/// Where a tile stands in a lattice; also one step outside it.
struct Cell {
  int column = 0;  ///< along x, from 0
  int row = 0;     ///< along y, from 0
};

/// Even and odd cells turn in opposite senses.
inline bool isEven(const Cell& cell) {
  return (cell.column + cell.row) % 2 == 0;
}

/// The cell whose tile shares corner 0-3 (bottom left, bottom right, top right, top left) of the
/// given cell's tile. Every corner belongs to exactly one neighbour, be it in the sheet or outside.
Cell cornerNeighbour(const Cell& cell, int corner);

/// How many tiles stand where.
struct Lattice {
  int columns = 0;  ///< at least 1
  int rows = 0;     ///< at least 1

  int tileCount() const { return columns * rows; }
  /// Tiles are numbered up the columns, one column after the other.
  int tileAt(const Cell& cell) const { return cell.column * rows + cell.row; }
  Cell cellOf(int tile) const { return {tile / rows, tile % rows}; }
  bool contains(const Cell& cell) const {
    return cell.column >= 0 && cell.column < columns && cell.row >= 0 && cell.row < rows;
  }
};

/// The joints of the lattice on the given face: each tile to its right, then upwards.
/// There are (columns - 1) rows + columns (rows - 1) of them.
std::vector<Joint> latticeJoints(const Lattice& lattice, JointFace face);

}  // namespace kirireel
