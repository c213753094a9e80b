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
TurningField fanField(const FanShape& shape);

/// A heart when closed at the start; closed again at pi. Any even number of columns and rows.
TurningField heartField(const Lattice& lattice);

/// A square of size x size tiles when closed at the start, a disk's inscribed polygon when closed
/// at pi.
TurningField squareToDiskField(int size);

/// A square of size x size tiles when closed at the start, whose tips stand on a circle when
/// neighbours have turned by pi / 2.
TurningField squareToCircleField(int size);

/// Irregular quads, closed at the start and at pi: the regular lattice with its sides moved at
/// random by up to `irregularity` tiles.
TurningField irregularField(const Lattice& lattice, double irregularity, unsigned seed);

}  // namespace kirireel
