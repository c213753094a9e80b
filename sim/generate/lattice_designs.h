/// Planar sheets of compact reconfigurable quads: closed in one outline, and in another after every
/// tile has turned. All lengths in metres for tiles about 1 wide, angles in radians.
///
/// Each function throws InputError when no such sheet was found, which happens for shapes that are
/// far from the usual ones.
#pragma once

#include "sim/model/turning_field.h"

namespace kirireel {

/// A rectangle that becomes a sector of a ring.
struct FanShape {
  Lattice lattice{6, 6};
  double outerRadius = 10;              ///< positive
  double innerRadius = 1;               ///< positive, below the outer one
  double halfAngle = 0.52359877559830;  ///< of the sector
};
/// The rectangle is closed at theta = 0, the sector at pi.
TurningField fanField(const FanShape& shape);

/// A heart when closed at the start; closed again at pi. Any even number of columns and rows.
TurningField heartField(const Lattice& lattice);

/// A square of size x size tiles when closed at the start, a disk's inscribed polygon when closed
/// at pi.
/// `size`: odd, at least 3.
TurningField squareToDiskField(int size);

/// A square of size x size tiles when closed at the start, whose tips stand on a circle when
/// neighbours have turned by pi / 2.
/// `size`: even, at least 4.
TurningField squareToCircleField(int size);

/// Irregular quads, closed at the start and at pi: the regular lattice with its sides moved at
/// random by up to `irregularity` tiles.
/// `irregularity`: from 0, below 0.5 so that sides do not cross. The same seed gives the same sheet
/// on every machine.
TurningField irregularField(const Lattice& lattice, double irregularity, unsigned seed);

}  // namespace kirireel
