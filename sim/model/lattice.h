/// Lattices of quads, and their exact motion.
#pragma once

#include <complex>
#include <vector>

#include "sim/model/model.h"

namespace kirireel::model {

// ------------------------------------------------------------------------------------------------
// The lattice of quads that most kirigami sheets are: tiles in columns and rows, joined at corners
// so that neighbours turn against each other.

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

  /// How many tiles there are.
  int tileCount() const { return columns * rows; }
  /// Tiles are numbered up the columns, one column after the other.
  int tileAt(const Cell& cell) const { return cell.column * rows + cell.row; }
  /// Tiles are counted column by column.
  Cell cellOf(int tile) const { return {tile / rows, tile % rows}; }
  /// Whether a tile stands there.
  bool contains(const Cell& cell) const {
    return cell.column >= 0 && cell.column < columns && cell.row >= 0 && cell.row < rows;
  }
};

/// The joints of the lattice on the given face: each tile to its right, then upwards.
/// There are (columns - 1) rows + columns (rows - 1) of them.
std::vector<Joint> latticeJoints(const Lattice& lattice, JointFace face);

// ------------------------------------------------------------------------------------------------
// The exact motion of every planar lattice of quads whose voids are parallelograms.

/// A place or a turn in the plane.
using Complex = std::complex<double>;

/// One complex constant F for each tile of a lattice and each place just outside its sides. The
/// corner that an odd and an even tile share stands, when neighbours have turned by theta against
/// each other, at
///   v(theta) = F_odd e^(-i theta / 2) + F_even e^(i theta / 2)   (complex coordinates).
/// Tiles keep their shape and joints stay closed at every theta whatever the constants are; the
/// voids, one for each 2 x 2 block of places, are closed at theta = 0 and at pi when for the
/// block's constants (lower left 00, right 10, above 01, opposite 11)
///   F11 - F00 = s lambda (F10 - F01),   s = 1 if place 00 is even, else -1,   lambda > 0 real.
class TurningField {
 public:
  /// A field whose constants are all 0.
  explicit TurningField(const Lattice& lattice)
      : lattice_(lattice), constants_(std::size_t(placeCount())) {}

  /// Its columns and rows.
  const Lattice& lattice() const { return lattice_; }
  /// Tiles and places just outside, corners included.
  int placeCount() const { return (lattice_.columns + 2) * (lattice_.rows + 2); }
  /// The number of a cell's place, from 0.
  int placeAt(const Cell& cell) const {
    return (cell.column + 1) * (lattice_.rows + 2) + cell.row + 1;
  }
  /// The constant at a cell, to be set.
  Complex& at(const Cell& cell) { return constants_[std::size_t(placeAt(cell))]; }
  /// The constant at a cell.
  const Complex& at(const Cell& cell) const { return constants_[std::size_t(placeAt(cell))]; }

  /// Where a tile's corner 0-3 stands at the angle theta, radians.
  Complex corner(const Cell& cell, int corner, double angle) const;

  /// All tiles at the angle theta, in the plane z = 0.
  std::vector<Tile> tiles(double angle) const;

 private:
  Lattice lattice_;
  std::vector<Complex> constants_;
};

/// The field of equal parallelograms with the given sides, counted from the sheet's middle.
/// `along` and `up` are the sides as complex numbers x + i y, metres, not parallel to each other.
TurningField regularField(const Lattice& lattice, Complex along, Complex up);

// ------------------------------------------------------------------------------------------------
// The rotating rectangles and parallelograms: m x n tiles joined at corners, one degree of freedom
// in the plane.

/// What to generate. Lengths in metres, angles in radians; at most 250,000 tiles.
struct TessellationShape {
  int columns = 4;                          ///< tiles along x, at least 1
  int rows = 4;                             ///< tiles along y, at least 1
  double length = 1;                        ///< of a tile along x when closed, positive
  double width = 1;                         ///< of a tile's other side, positive
  double skew = 0;                          ///< of that side from the y axis, clockwise, below pi/2
  double startAngle = 0;                    ///< between neighbouring tiles, 0 (closed) to pi
  double targetAngle = 1.5707963267948966;  ///< of the target, 0 to pi
  JointFace face = JointFace::Both;         ///< where neighbours are joined
};

/// The tessellation with its target and its joints. Tile column * rows + row stands in the given
/// column and row; its vertices start bottom left and run anticlockwise.
/// Throws InputError for counts, lengths or angles out of range.
Model makeTessellation(const TessellationShape& shape);

/// Its tiles at one opening angle theta, in the axes in which even tiles (column + row even) are
/// turned by -theta/2 and odd ones by +theta/2, centred on the origin: the mechanism's exact motion
///   v(theta) = F_odd e^(-i theta/2) + F_even e^(i theta/2)   (complex coordinates),
/// closed and rigid for every theta.
std::vector<Tile> tessellationTiles(const TessellationShape& shape, double angle);

}  // namespace kirireel::model
