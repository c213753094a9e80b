// Neighbours at each corner of a tile. In a rotating lattice neighbours turn in opposite senses. An
// even tile shares its corners 0, 1, 2, 3 (from bottom left, anticlockwise) with its neighbours in
// the west, south, east and north, and an odd tile with those in the south, east, north and west. A
// joint lies at the corner that both lists assign to each other. J. N. Grima, K. E. Evans, Auxetic
// behavior from rotating squares, Journal of Materials Science Letters 19, 2000, describe the
// mechanism.
#include "sim/generate/lattice.h"

#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/base/geometry.h"

namespace kirireel::generate {

Cell cornerNeighbour(const Cell& cell, int corner) {
  constexpr Cell kWest{-1, 0}, kEast{1, 0}, kSouth{0, -1}, kNorth{0, 1};
  constexpr Cell kOfEven[] = {kWest, kSouth, kEast, kNorth};
  constexpr Cell kOfOdd[] = {kSouth, kEast, kNorth, kWest};
  const Cell& step = isEven(cell) ? kOfEven[corner] : kOfOdd[corner];
  return {cell.column + step.column, cell.row + step.row};
}

std::vector<model::Joint> latticeJoints(const Lattice& lattice, model::JointFace face) {
  std::vector<model::Joint> joints;
  for (int tile = 0; tile < lattice.tileCount(); ++tile) {
    const Cell cell = lattice.cellOf(tile);
    const bool even = isEven(cell);
    // The right neighbour: its top left corner joins our top right one, or the bottom ones join.
    if (cell.column + 1 < lattice.columns) {
      joints.push_back({{tile, even ? 2 : 1}, {tile + lattice.rows, even ? 3 : 0}, face});
    }
    // The upper neighbour: its bottom left corner joins our top left one, or the right ones join.
    if (cell.row + 1 < lattice.rows) {
      joints.push_back({{tile, even ? 3 : 2}, {tile + 1, even ? 0 : 1}, face});
    }
  }
  return joints;
}

// ------------------------------------------------------------------------------------------------
// Evaluates the motion v(theta) = F_odd e^(-i theta/2) + F_even e^(i theta/2).
//
// Tiles stay rigid: all corners of an even tile have the same F_even. Their differences are
// differences of F_odd only, rotated by -theta/2. Those of an odd tile are rotated by +theta/2.
// Joints stay closed: both tiles compute their common corner as the same sum. Neighbours therefore
// turn by theta against each other. The regular field has its constants at the positions of a
// lattice of parallelograms with sides a (along) and b (up), as complex numbers:
//   x = column - (columns - 1)/2,            y = row - (rows - 1)/2,
//   F_even = (x + y)/2 a - (x - y)/2 b,      F_odd = (x - y)/2 a + (x + y)/2 b

Complex TurningField::corner(const Cell& cell, int corner, double angle) const {
  const Complex halfTurn = std::polar(1.0, 0.5 * angle);
  Complex even = at(cell);
  Complex odd = at(cornerNeighbour(cell, corner));
  if (!isEven(cell)) std::swap(even, odd);
  // The same formula for both tiles at a corner makes their vertices bitwise equal. Adding 0 makes
  // a negative zero positive.
  const Complex point = odd * std::conj(halfTurn) + even * halfTurn;
  return {point.real() + 0.0, point.imag() + 0.0};
}

std::vector<model::Tile> TurningField::tiles(double angle) const {
  std::vector<model::Tile> tiles(std::size_t(lattice_.tileCount()));
  for (int tile = 0; tile < lattice_.tileCount(); ++tile) {
    for (int k = 0; k < 4; ++k) {
      const Complex point = corner(lattice_.cellOf(tile), k, angle);
      tiles[std::size_t(tile)].vertices.emplace_back(point.real(), point.imag(), 0);
    }
  }
  return tiles;
}

TurningField regularField(const Lattice& lattice, Complex along, Complex up) {
  TurningField field(lattice);
  for (int column = -1; column <= lattice.columns; ++column) {
    for (int row = -1; row <= lattice.rows; ++row) {
      const double x = column - 0.5 * (lattice.columns - 1);
      const double y = row - 0.5 * (lattice.rows - 1);
      const double sum = 0.5 * (x + y);
      const double difference = 0.5 * (x - y);
      const Cell cell{column, row};
      field.at(cell) = isEven(cell) ? sum * along - difference * up : difference * along + sum * up;
    }
  }
  return field;
}

// ------------------------------------------------------------------------------------------------
// Tessellations of equal parallelograms, from the exact motion of their lattice (lattice.h). The
// constants are those of regularField(): sides of `length` along x and of `width` at `skew` from
// the y axis. Both states use the same constants, so start and target are congruent to rounding,
// and no solver is needed.

namespace {

/// As many tiles as a model file may hold.
constexpr int kMaxTiles = 250000;
/// Shortest side of a tile, metres.
constexpr double kMinLength = 1e-6;
/// Longest side of the sheet, metres: as far as a model file's coordinates may reach.
constexpr double kMaxExtent = 1e6;

TurningField fieldOf(const TessellationShape& shape) {
  const Complex up(shape.width * std::sin(shape.skew), shape.width * std::cos(shape.skew));
  return regularField({shape.columns, shape.rows}, shape.length, up);
}

void requireCounts(const TessellationShape& shape) {
  const bool positive = shape.columns >= 1 && shape.rows >= 1;
  if (positive && static_cast<long>(shape.columns) * shape.rows <= kMaxTiles) return;
  throw InputError(
      fmt::format("tessellation: error: {} columns and {} rows; give at least 1 of "
                  "each, and at most {} tiles in all",
                  shape.columns, shape.rows, kMaxTiles));
}

void requireLength(const char* name, double value, int count) {
  if (value >= kMinLength && value * count <= kMaxExtent) return;
  throw InputError(
      fmt::format("tessellation: error: the {} of a tile is {:g} m; give at least {:g}, "
                  "and at most {:g} for {} tiles in a row",
                  name, value, kMinLength, kMaxExtent / count, count));
}

void requireAngle(const char* name, double value) {
  if (value >= 0 && value <= std::numbers::pi) return;
  throw InputError(
      fmt::format("tessellation: error: the {} angle is {:g} degrees, but must be in [0, 180]",
                  name, value / kDegree));
}

}  // namespace

model::Model makeTessellation(const TessellationShape& shape) {
  requireCounts(shape);
  requireLength("length", shape.length, shape.columns);
  requireLength("width", shape.width, shape.rows);
  requireAngle("start", shape.startAngle);
  requireAngle("target", shape.targetAngle);
  model::Model model;
  model.name = "tessellation";
  model.tiles = tessellationTiles(shape, shape.startAngle);
  model.joints = latticeJoints({shape.columns, shape.rows}, shape.face);
  model.target = tessellationTiles(shape, shape.targetAngle);
  return model;
}

std::vector<model::Tile> tessellationTiles(const TessellationShape& shape, double angle) {
  return fieldOf(shape).tiles(angle);
}

}  // namespace kirireel::generate
