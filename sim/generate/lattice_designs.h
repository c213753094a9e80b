/// Planar sheets of compact reconfigurable quads. They are closed in two states with different
/// outlines. Lengths are in metres for tiles about 1 m wide, angles in radians.
///
/// Each function throws InputError if no such sheet was found. This happens for shapes far from the
/// defaults.
#pragma once

#include "sim/generate/constrained_fit.h"
#include "sim/generate/lattice.h"

namespace kirireel::generate {

/// A rectangle that becomes a sector of a ring.
struct FanShape {
  Lattice lattice{6, 6};                ///< columns and rows of tiles
  double outerRadius = 10;              ///< positive
  double innerRadius = 1;               ///< positive, below the outer one
  double halfAngle = 0.52359877559830;  ///< of the sector
};
/// The rectangle is closed at theta = 0, the sector at pi.
TurningField fanField(const FanShape& shape);

/// A heart that is closed at the start and at pi. Any even number of columns and rows.
TurningField heartField(const Lattice& lattice);

/// A square of size x size tiles, closed at the start. At pi it is closed to a polygon inscribed in
/// a disk. `size`: odd, >= 3.
TurningField squareToDiskField(int size);

/// A square of size x size tiles, closed at the start. Its tips are on a circle after neighbours
/// have turned by pi / 2. `size`: even, >= 4.
TurningField squareToCircleField(int size);

/// Irregular quads, closed at the start and at pi. The sides of the regular lattice are moved at
/// random by up to `irregularity` tiles, in [0, 0.5); beyond that sides would cross. The same seed
/// gives the same sheet on every machine.
TurningField irregularField(const Lattice& lattice, double irregularity, unsigned seed);

// ------------------------------------------------------------------------------------------------
// Equations for the constants of a turning field, for the fit of planar designs.

/// One corner in a sheet.
struct LatticeCorner {
  Cell cell;       ///< its tile
  int corner = 0;  ///< 0-3: bottom left, bottom right, top right, top left
};

/// The nodes around the closed sheet (theta = 0), anticlockwise from the bottom left: columns along
/// the bottom, rows up the right, columns along the top, rows down the left. Each node is given by
/// one of its corners.
std::vector<LatticeCorner> closedBoundary(const Lattice& lattice);

/// The corners without a joint, anticlockwise from the bottom left: the tips of the open sheet.
std::vector<LatticeCorner> tips(const Lattice& lattice);

/// Half the extent of tiles about the origin, along each axis.
Vector3 halfExtent(const std::vector<model::Tile>& tiles);

/// A 2 x 2 block of positions: the void between four tiles, or half of a void at the sheet's side.
struct TileBlock {
  Cell lowerLeft;  ///< of the four positions

  /// One of the four positions, with a column and a row of 0 or 1.
  Cell at(int column, int row) const { return {lowerLeft.column + column, lowerLeft.row + row}; }
};

/// Blocks between tiles, by columns.
std::vector<TileBlock> innerBlocks(const Lattice& lattice);

/// Half blocks at the sides that are closed at theta = 0.
std::vector<TileBlock> sideBlocksClosedAtStart(const Lattice& lattice);

/// Half blocks at the sides that are closed at theta = pi.
std::vector<TileBlock> sideBlocksClosedAtEnd(const Lattice& lattice);

/// Unknowns: the real and imaginary part of the field's constant at each position, then others.
class LatticeUnknowns {
 public:
  /// The constants of a field on this lattice; further unknowns follow.
  explicit LatticeUnknowns(const Lattice& lattice) : places_(lattice) {}

  /// Its columns and rows.
  const Lattice& lattice() const { return places_.lattice(); }
  /// The first unknown after the constants.
  int firstFurther() const { return 2 * places_.placeCount(); }
  /// The unknowns of a field, followed by `further` zeros.
  Eigen::VectorXd pack(const TurningField& field, int further) const;
  /// The field with these unknowns. Further unknowns are ignored.
  TurningField field(const Eigen::VectorXd& unknowns) const;

  /// Adds the equation weight * (direction . v(theta) - value) for one corner. Slopes along other
  /// unknowns may follow. `angle` in radians. `value` in metres along `direction`, a unit complex
  /// number.
  void addPosition(EquationRows& rows, const TurningField& field, const LatticeCorner& corner,
                   double angle, Complex direction, double value, double weight = 1) const;

  /// Adds both equations of a block with the ratio lambda of its sides, given by the unknown for
  /// log lambda; -1 means lambda = 1.
  void addBlock(EquationRows& rows, const TurningField& field, const TileBlock& block,
                const Eigen::VectorXd& unknowns, int logarithm) const;

  /// Adds weight * (F - desired F) for all positions of the sheet and at its sides.
  void addConstants(EquationRows& rows, const TurningField& field, const TurningField& desired,
                    double weight) const;

 private:
  void addSlope(EquationRows& rows, const Cell& cell, Complex factor, Complex direction) const;

  TurningField places_;  ///< numbers the positions
};

}  // namespace kirireel::generate
