/// The exact motion of every planar lattice of quads whose voids are parallelograms.
#pragma once

#include <complex>
#include <vector>

#include "sim/model/lattice.h"

namespace kirireel {

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
  explicit TurningField(const Lattice& lattice)
      : lattice_(lattice), constants_(std::size_t(placeCount())) {}

  const Lattice& lattice() const { return lattice_; }
  /// Tiles and places just outside, corners included.
  int placeCount() const { return (lattice_.columns + 2) * (lattice_.rows + 2); }
  int placeAt(const Cell& cell) const {
    return (cell.column + 1) * (lattice_.rows + 2) + cell.row + 1;
  }
  Complex& at(const Cell& cell) { return constants_[std::size_t(placeAt(cell))]; }
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

}  // namespace kirireel
