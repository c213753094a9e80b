/// Equations on the constants of a turning field, for the fit of planar designs.
#pragma once

#include <array>

#include "sim/generate/constrained_fit.h"
#include "sim/model/turning_field.h"

namespace kirireel {

/// One corner in a sheet.
struct LatticeCorner {
  Cell cell;
  int corner = 0;  ///< 0-3: bottom left, bottom right, top right, top left
};

/// The nodes round the closed sheet (theta = 0), anticlockwise from the bottom left: columns along
/// the bottom, rows up the right, columns along the top, rows down the left. Each by one of the
/// corners that meet there.
std::vector<LatticeCorner> closedBoundary(const Lattice& lattice);

/// The corners that no joint holds, anticlockwise from the bottom left: the tips of the open sheet.
std::vector<LatticeCorner> tips(const Lattice& lattice);

/// A 2 x 2 block of places: the void between four tiles, or half of one at the sheet's side.
struct TileBlock {
  Cell lowerLeft;

  Cell at(int column, int row) const { return {lowerLeft.column + column, lowerLeft.row + row}; }
};

/// Blocks between tiles, by columns.
std::vector<TileBlock> innerBlocks(const Lattice& lattice);

/// Half blocks at the sides that are closed at theta = 0.
std::vector<TileBlock> sideBlocksClosedAtStart(const Lattice& lattice);

/// Half blocks at the sides that are closed at theta = pi.
std::vector<TileBlock> sideBlocksClosedAtEnd(const Lattice& lattice);

/// Unknowns: the field's constants (real and imaginary part of each place), then further ones.
class LatticeUnknowns {
 public:
  explicit LatticeUnknowns(const Lattice& lattice) : places_(lattice) {}

  const Lattice& lattice() const { return places_.lattice(); }
  /// The first unknown after the constants.
  int firstFurther() const { return 2 * places_.placeCount(); }
  /// The unknowns of a field, and zeros for `further` more.
  Eigen::VectorXd pack(const TurningField& field, int further) const;
  /// The field that the unknowns describe; further ones are not looked at.
  TurningField field(const Eigen::VectorXd& unknowns) const;

  /// Adds the equation weight * (direction . v(theta) - value) of one corner, with the position
  /// along a direction given as a complex number. Slopes along other unknowns may follow.
  /// `angle` in radians, `value` in metres along `direction`, a unit complex number.
  void addPosition(EquationRows& rows, const TurningField& field, const LatticeCorner& corner,
                   double angle, Complex direction, double value, double weight = 1) const;

  /// Adds both equations of a block with the ratio lambda of its sides; the unknown that is
  /// lambda's logarithm, or -1 when lambda is 1.
  void addBlock(EquationRows& rows, const TurningField& field, const TileBlock& block,
                const Eigen::VectorXd& unknowns, int logarithm) const;

  /// Adds weight * (F - wanted F) for all places of the sheet and at its sides.
  void addConstants(EquationRows& rows, const TurningField& field, const TurningField& wanted,
                    double weight) const;

 private:
  void addSlope(EquationRows& rows, const Cell& cell, Complex factor, Complex direction) const;

  TurningField places_;  ///< numbers the places
};

}  // namespace kirireel
