// Rows of equations on a turning field's constants, with their slopes.
//
// Places and constants are complex numbers; the unknowns are their real and imaginary parts. A row
// takes the component along a direction d, d . z = Re(conj(d) z), of a sum of c F over places. Its
// slopes are d . c along Re F and d . (i c) along Im F, for c = e^(-i theta/2) at the odd and e^(i
// theta/2) at the even place of a corner, or +-1 and +-lambda in a block.
//
// Places just outside the sheet have constants too: they decide where the free corners at its sides
// stand. The four places diagonally outside belong to no corner and to no block that is used.
#include "sim/generate/lattice_equations.h"

#include <cmath>
#include <utility>

namespace kirireel {
namespace {

/// The inner product of two plane vectors.
double dot(Complex a, Complex b) {
  return (std::conj(a) * b).real();
}

// Places diagonally outside, which nothing refers to.
bool isGhostCorner(const Lattice& lattice, const Cell& cell) {
  const bool outsideColumns = cell.column < 0 || cell.column >= lattice.columns;
  const bool outsideRows = cell.row < 0 || cell.row >= lattice.rows;
  return outsideColumns && outsideRows;
}

/// Half blocks whose lower left places are even on the sides to the left and right and odd at the
/// bottom and the top, or the other way round.
std::vector<TileBlock> sideBlocks(const Lattice& lattice, bool evenAtLeftAndRight) {
  std::vector<TileBlock> blocks;
  for (int column = 0; column + 1 < lattice.columns; ++column) {
    for (const int row : {-1, lattice.rows - 1}) {
      // A block's parity is that of its lower left place. Sides at the bottom and the top take the
      // other parity, since neighbouring sides have their mouths at different nodes.
      if (isEven({column, row}) != evenAtLeftAndRight) blocks.push_back({{column, row}});
    }
  }
  for (int row = 0; row + 1 < lattice.rows; ++row) {
    for (const int column : {-1, lattice.columns - 1}) {
      if (isEven({column, row}) == evenAtLeftAndRight) blocks.push_back({{column, row}});
    }
  }
  return blocks;
}

}  // namespace

std::vector<LatticeCorner> closedBoundary(const Lattice& lattice) {
  const int right = lattice.columns - 1;
  const int top = lattice.rows - 1;
  std::vector<LatticeCorner> nodes;
  for (int i = 0; i <= right; ++i) nodes.push_back({{i, 0}, 0});
  for (int j = 0; j <= top; ++j) nodes.push_back({{right, j}, 1});
  for (int i = right; i >= 0; --i) nodes.push_back({{i, top}, 2});
  for (int j = top; j >= 0; --j) nodes.push_back({{0, j}, 3});
  return nodes;
}

// Side by side, as closedBoundary() goes round.
std::vector<LatticeCorner> tips(const Lattice& lattice) {
  const int right = lattice.columns - 1;
  const int top = lattice.rows - 1;
  std::vector<LatticeCorner> found;
  const auto append = [&](const Cell& cell, int stepColumn, int stepRow) {
    for (int k = 0; k < 4; ++k) {
      const Cell beyond = cornerNeighbour(cell, k);
      // A corner whose neighbour lies outside has no joint.
      const bool isThere =
          beyond.column == cell.column + stepColumn && beyond.row == cell.row + stepRow;
      if (isThere) found.push_back({cell, k});
    }
  };
  for (int i = 0; i <= right; ++i) append({i, 0}, 0, -1);
  for (int j = 0; j <= top; ++j) append({right, j}, 1, 0);
  for (int i = right; i >= 0; --i) append({i, top}, 0, 1);
  for (int j = top; j >= 0; --j) append({0, j}, -1, 0);
  return found;
}

std::vector<TileBlock> innerBlocks(const Lattice& lattice) {
  std::vector<TileBlock> blocks;
  for (int column = 0; column + 1 < lattice.columns; ++column) {
    for (int row = 0; row + 1 < lattice.rows; ++row) blocks.push_back({{column, row}});
  }
  return blocks;
}

std::vector<TileBlock> sideBlocksClosedAtStart(const Lattice& lattice) {
  return sideBlocks(lattice, true);
}

std::vector<TileBlock> sideBlocksClosedAtEnd(const Lattice& lattice) {
  return sideBlocks(lattice, false);
}

Eigen::VectorXd LatticeUnknowns::pack(const TurningField& field, int further) const {
  Eigen::VectorXd unknowns = Eigen::VectorXd::Zero(firstFurther() + further);
  for (int column = -1; column <= lattice().columns; ++column) {
    for (int row = -1; row <= lattice().rows; ++row) {
      const int place = places_.placeAt({column, row});
      unknowns[2 * place] = field.at({column, row}).real();
      unknowns[2 * place + 1] = field.at({column, row}).imag();
    }
  }
  return unknowns;
}

TurningField LatticeUnknowns::field(const Eigen::VectorXd& unknowns) const {
  TurningField field(lattice());
  for (int column = -1; column <= lattice().columns; ++column) {
    for (int row = -1; row <= lattice().rows; ++row) {
      const int place = places_.placeAt({column, row});
      field.at({column, row}) = {unknowns[2 * place], unknowns[2 * place + 1]};
    }
  }
  return field;
}

// The slope along both parts of a constant that enters as factor * F, taken along a direction.
void LatticeUnknowns::addSlope(EquationRows& rows, const Cell& cell, Complex factor,
                               Complex direction) const {
  const int place = places_.placeAt(cell);
  rows.slope(2 * place, dot(direction, factor));
  rows.slope(2 * place + 1, dot(direction, factor * Complex(0, 1)));
}

void LatticeUnknowns::addPosition(EquationRows& rows, const TurningField& field,
                                  const LatticeCorner& corner, double angle, Complex direction,
                                  double value, double weight) const {
  const Complex halfTurn = std::polar(1.0, 0.5 * angle);
  Cell even = corner.cell;
  Cell odd = cornerNeighbour(corner.cell, corner.corner);
  if (!isEven(corner.cell)) std::swap(even, odd);
  const Complex position = field.corner(corner.cell, corner.corner, angle);
  rows.begin(weight * (dot(direction, position) - value));
  addSlope(rows, odd, std::conj(halfTurn), weight * direction);
  addSlope(rows, even, halfTurn, weight * direction);
}

void LatticeUnknowns::addBlock(EquationRows& rows, const TurningField& field,
                               const TileBlock& block, const Eigen::VectorXd& unknowns,
                               int logarithm) const {
  const double ratio = logarithm < 0 ? 1 : std::exp(unknowns[logarithm]);
  const double signedRatio = isEven(block.lowerLeft) ? ratio : -ratio;
  const Complex across = field.at(block.at(1, 0)) - field.at(block.at(0, 1));
  const Complex along = field.at(block.at(1, 1)) - field.at(block.at(0, 0));
  for (const Complex direction : {Complex(1, 0), Complex(0, 1)}) {
    rows.begin(dot(direction, along - signedRatio * across));
    addSlope(rows, block.at(1, 1), 1, direction);
    addSlope(rows, block.at(0, 0), -1, direction);
    addSlope(rows, block.at(1, 0), -signedRatio, direction);
    addSlope(rows, block.at(0, 1), signedRatio, direction);
    // d lambda / d log lambda = lambda, which signedRatio holds already.
    if (logarithm >= 0) rows.slope(logarithm, -dot(direction, signedRatio * across));
  }
}

void LatticeUnknowns::addConstants(EquationRows& rows, const TurningField& field,
                                   const TurningField& wanted, double weight) const {
  for (int column = -1; column <= lattice().columns; ++column) {
    for (int row = -1; row <= lattice().rows; ++row) {
      const Cell cell{column, row};
      if (isGhostCorner(lattice(), cell)) continue;
      const Complex difference = field.at(cell) - wanted.at(cell);
      const int place = places_.placeAt(cell);
      rows.begin(weight * difference.real());
      rows.slope(2 * place, weight);
      rows.begin(weight * difference.imag());
      rows.slope(2 * place + 1, weight);
    }
  }
}

}  // namespace kirireel
