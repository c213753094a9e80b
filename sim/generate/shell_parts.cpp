// Parts that the fits of shells share: a start of unit squares, the exact rectangle of a flat
// state, and the message of a fit that failed.
//
// The rectangle is |x| = a, |y| = b with unknown half sides a and b (m): its own size is free,
// since the sheet's size follows from the curved state. Every boundary node of side s satisfies o_s
// . p = a or b, with o_s the direction out of the side; a corner node satisfies both.
#include "sim/generate/shell_parts.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "sim/base/error.h"

namespace kirireel {
Eigen::VectorXd fitFamily(const std::string& family, const DesignSource& source,
                          Eigen::VectorXd start, const FitSettings& settings) {
  const Fit fit = fitDesign(source, std::move(start), settings);
  if (fit.violation <= kExactFit) return fit.unknowns;
  throw InputError(
      fmt::format("{}: error: no sheet of this shape was found (its equations miss by {:.2g}); "
                  "give sizes and parameters nearer to the usual ones",
                  family, fit.violation));
}

std::vector<Tile> unitTiles(const Lattice& lattice, double angle) {
  return regularField(lattice, 1, Complex(0, 1)).tiles(angle);
}

// From the origin, so that an asymmetric sheet has its larger side.
Vector3 halfExtent(const std::vector<Tile>& tiles) {
  Vector3 half = Vector3::Zero();
  for (const Tile& tile : tiles) {
    for (const Vector3& vertex : tile.vertices) half = half.cwiseMax(vertex.cwiseAbs());
  }
  return half;
}

double meanEdge(const std::vector<Tile>& tiles) {
  Model model;
  model.tiles = tiles;
  return tileSize(model);
}

int sideOf(const Lattice& lattice, int number) {
  // Numbers at which the bottom, the right and the top side end.
  const int ends[] = {lattice.columns, lattice.columns + lattice.rows,
                      2 * lattice.columns + lattice.rows};
  return static_cast<int>(std::upper_bound(std::begin(ends), std::end(ends), number) -
                          std::begin(ends));
}

Vector3 outwards(int side) {
  const Vector3 directions[] = {-Vector3::UnitY(), Vector3::UnitX(), Vector3::UnitY(),
                                -Vector3::UnitX()};
  return directions[side];
}

FlatRectangle::FlatRectangle(const Lattice& lattice, StateUnknowns state, int halfColumns,
                             int halfRows)
    : lattice_(lattice),
      state_(std::move(state)),
      halves_{halfColumns, halfRows},
      boundary_(closedBoundary(lattice)) {}

void FlatRectangle::addExact(EquationRows& rows, const Eigen::VectorXd& unknowns) const {
  const int count = static_cast<int>(boundary_.size());
  for (int number = 0; number < count; ++number) {
    const int side = sideOf(lattice_, number);
    addOnSide(rows, unknowns, number, side);
    // A node at a corner lies on the side before it, too.
    const int before = sideOf(lattice_, (number + count - 1) % count);
    if (before != side) addOnSide(rows, unknowns, number, before);
  }
}

void FlatRectangle::addEvenGrid(EquationRows& rows, const Eigen::VectorXd& unknowns,
                                double weight) const {
  for (int column = 0; column <= lattice_.columns; ++column) {
    for (int row = 0; row <= lattice_.rows; ++row) {
      const double shares[] = {2.0 * column / lattice_.columns - 1, 2.0 * row / lattice_.rows - 1};
      const UnknownPoint point = state_.point(unknowns, column * (lattice_.rows + 1) + row);
      for (int axis = 0; axis < 2; ++axis) {
        const int half = halves_[std::size_t(axis)];
        addPosition(rows, point, Vector3::Unit(axis), shares[axis] * unknowns[half], weight);
        // The wanted place moves with the half side.
        rows.slope(half, -weight * shares[axis]);
      }
    }
  }
}

UnknownPoint FlatRectangle::boundaryPoint(const Eigen::VectorXd& unknowns, int number) const {
  const LatticeCorner& corner = boundary_[std::size_t(number)];
  return state_.point(unknowns, lattice_.tileAt(corner.cell), corner.corner);
}

void FlatRectangle::addOnSide(EquationRows& rows, const Eigen::VectorXd& unknowns, int number,
                              int side) const {
  // Bottom and top are at y = -+ the half side of the rows.
  const int half = halves_[side % 2 == 0 ? 1 : 0];
  addPosition(rows, boundaryPoint(unknowns, number), outwards(side), unknowns[half]);
  rows.slope(half, -1);
}

}  // namespace kirireel
