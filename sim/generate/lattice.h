/// Lattices of quads, and their exact motion.
#pragma once

#include <complex>
#include <vector>

#include "sim/model/model.h"

namespace kirireel::generate {

// ------------------------------------------------------------------------------------------------
// The lattice of quadrilaterals of most kirigami sheets: tiles in columns and rows. Neighbours are
// joined at corners and turn against each other.

/// Position of a tile in a lattice, including one cell outside it.
struct Cell {
  int column = 0;  ///< along x, zero-based
  int row = 0;     ///< along y, zero-based
};

/// Even and odd cells turn in opposite senses.
inline bool isEven(const Cell& cell) {
  return (cell.column + cell.row) % 2 == 0;
}

/// The neighbour that shares a corner with the cell's tile. Corners 0-3: bottom left, bottom right,
/// top right, top left. Each corner has exactly one neighbour, possibly outside the sheet.
Cell cornerNeighbour(const Cell& cell, int corner);

/// Size of a lattice.
struct Lattice {
  int columns = 0;  ///< >= 1
  int rows = 0;     ///< >= 1

  /// Number of tiles.
  int tileCount() const { return columns * rows; }
  /// The number of a cell's tile: column by column, upwards within each.
  int tileAt(const Cell& cell) const { return cell.column * rows + cell.row; }
  /// The cell of a tile number.
  Cell cellOf(int tile) const { return {tile / rows, tile % rows}; }
  /// Whether a cell is inside the lattice.
  bool contains(const Cell& cell) const {
    return cell.column >= 0 && cell.column < columns && cell.row >= 0 && cell.row < rows;
  }
};

/// The joints of the lattice on the given face: for each tile first to the right, then upwards.
/// There are (columns - 1) rows + columns (rows - 1) joints.
std::vector<model::Joint> latticeJoints(const Lattice& lattice, model::JointFace face);

// ------------------------------------------------------------------------------------------------
// The exact motion of every planar lattice of quads whose voids are parallelograms.

/// A position or a rotation in the plane.
using Complex = std::complex<double>;

/// One complex constant F for each tile of a lattice and each position just outside its sides. If
/// neighbours have turned by theta against each other, the common corner of an odd and an even tile
/// is at
///   v(theta) = F_odd e^(-i theta / 2) + F_even e^(i theta / 2)   (complex coordinates).
/// Tiles keep their shape and joints stay closed at every theta and for any constants. Each 2 x 2
/// block of positions is a void. It is closed at theta = 0 and at pi if the block's constants
/// (lower left 00, right 10, above 01, opposite 11) fulfil
///   F11 - F00 = s lambda (F10 - F01),   s = 1 if cell 00 is even, else -1,   lambda > 0 real.
class TurningField {
 public:
  /// A field whose constants are all 0.
  explicit TurningField(const Lattice& lattice)
      : lattice_(lattice), constants_(std::size_t(placeCount())) {}

  /// Its columns and rows.
  const Lattice& lattice() const { return lattice_; }
  /// Number of tiles and outside positions, corners included.
  int placeCount() const { return (lattice_.columns + 2) * (lattice_.rows + 2); }
  /// The zero-based number of a cell's position.
  int placeAt(const Cell& cell) const {
    return (cell.column + 1) * (lattice_.rows + 2) + cell.row + 1;
  }
  /// The constant at a cell, for assignment.
  Complex& at(const Cell& cell) { return constants_[std::size_t(placeAt(cell))]; }
  /// The constant at a cell.
  const Complex& at(const Cell& cell) const { return constants_[std::size_t(placeAt(cell))]; }

  /// Position of a tile's corner 0-3 at the angle theta, radians.
  Complex corner(const Cell& cell, int corner, double angle) const;

  /// All tiles at the angle theta, in the plane z = 0.
  std::vector<model::Tile> tiles(double angle) const;

 private:
  Lattice lattice_;
  std::vector<Complex> constants_;
};

/// The field of equal parallelograms with the given sides, centred on the sheet's middle. `along`
/// and `up` are the sides as complex numbers x + i y, metres, not parallel.
TurningField regularField(const Lattice& lattice, Complex along, Complex up);

// ------------------------------------------------------------------------------------------------
// Rotating rectangles and parallelograms: m x n tiles joined at corners, one planar degree of
// freedom.

/// Parameters of a tessellation. Lengths in metres, angles in radians; at most 250,000 tiles.
struct TessellationShape {
  int columns = 4;                          ///< tiles along x, >= 1
  int rows = 4;                             ///< tiles along y, >= 1
  double length = 1;                        ///< of a tile along x when closed, > 0
  double width = 1;                         ///< of a tile's other side, > 0
  double skew = 0;                          ///< of that side from the y axis, clockwise, < pi/2
  double startAngle = 0;                    ///< between neighbouring tiles, 0 (closed) to pi
  double targetAngle = 1.5707963267948966;  ///< of the target, 0 to pi
  model::JointFace face = model::JointFace::Both;  ///< face of all joints
};

/// The tessellation with its target and its joints. The tile in a column and row has the number
/// column * rows + row. Its vertices are anticlockwise from the bottom left. Throws InputError for
/// counts, lengths or angles out of range.
model::Model makeTessellation(const TessellationShape& shape);

/// Its tiles at one opening angle theta, centred on the origin. Even tiles (column + row even) are
/// rotated by -theta/2 and odd ones by +theta/2. This is the exact motion of the mechanism:
///   v(theta) = F_odd e^(-i theta/2) + F_even e^(i theta/2)   (complex coordinates),
/// closed and rigid for every theta.
std::vector<model::Tile> tessellationTiles(const TessellationShape& shape, double angle);

}  // namespace kirireel::generate
