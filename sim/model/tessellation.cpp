#include "sim/model/tessellation.h"

#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include <fmt/format.h>

#include "sim/base/error.h"

namespace kirireel {
namespace {

using Complex = std::complex<double>;

/// As many tiles as a model file may hold.
constexpr int kMaxTiles = 250000;
/// Shortest side of a tile, metres.
constexpr double kMinLength = 1e-6;
/// Longest side of the sheet, metres: as far as a model file's coordinates may reach.
constexpr double kMaxExtent = 1e6;

bool isEven(int column, int row) {
  return (column + row) % 2 == 0;
}

/// A step from a tile to the neighbour that shares one of its corners.
struct Step {
  int columns;
  int rows;
};

/// For corners 0-3 (bottom left, bottom right, top right, top left). Every corner of a tile
/// belongs to exactly one neighbour, be it in the sheet or just outside.
std::array<Step, 4> cornerNeighbours(bool even) {
  constexpr Step kWest{-1, 0}, kEast{1, 0}, kSouth{0, -1}, kNorth{0, 1};
  if (even) return {kWest, kSouth, kEast, kNorth};
  return {kSouth, kEast, kNorth, kWest};
}

/// The constant F of one tile: it turns with the neighbours of the tile, and its corners differ by
/// the neighbours' constants. Counted from the sheet's middle, which puts that at the origin.
Complex constantOf(const TessellationShape& shape, int column, int row) {
  const double x = column - 0.5 * (shape.columns - 1);
  const double y = row - 0.5 * (shape.rows - 1);
  const double along = 0.5 * (x + y);
  const double across = 0.5 * (x - y);
  if (isEven(column, row)) return {along * shape.length, -across * shape.width};
  return {across * shape.length, along * shape.width};
}

Vector3 cornerPosition(const TessellationShape& shape, Complex halfTurn, int column, int row,
                       const Step& step) {
  Complex even = constantOf(shape, column, row);
  Complex odd = constantOf(shape, column + step.columns, row + step.rows);
  if (!isEven(column, row)) std::swap(even, odd);
  // One formula for both tiles at a corner, so that their vertices agree to the last bit. Adding 0
  // makes a negative zero positive.
  const Complex point = odd * std::conj(halfTurn) + even * halfTurn;
  return {point.real() + 0.0, point.imag() + 0.0, 0.0};
}

std::vector<Joint> tessellationJoints(const TessellationShape& shape) {
  std::vector<Joint> joints;
  for (int i = 0; i < shape.columns; ++i) {
    for (int j = 0; j < shape.rows; ++j) {
      const int tile = i * shape.rows + j;
      const bool even = isEven(i, j);
      // To the right: top right with top left, or bottom right with bottom left.
      if (i + 1 < shape.columns) {
        joints.push_back({{tile, even ? 2 : 1}, {tile + shape.rows, even ? 3 : 0}, shape.face});
      }
      // Upwards: top left with bottom left, or top right with bottom right.
      if (j + 1 < shape.rows) {
        joints.push_back({{tile, even ? 3 : 2}, {tile + 1, even ? 0 : 1}, shape.face});
      }
    }
  }
  return joints;
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
      fmt::format("tessellation: error: the {} angle is {:g} degrees; give a number "
                  "from 0 to 180",
                  name, value * 180 / std::numbers::pi));
}

}  // namespace

Model makeTessellation(const TessellationShape& shape) {
  requireCounts(shape);
  requireLength("length", shape.length, shape.columns);
  requireLength("width", shape.width, shape.rows);
  requireAngle("start", shape.startAngle);
  requireAngle("target", shape.targetAngle);
  Model model;
  model.name = "tessellation";
  model.tiles = tessellationTiles(shape, shape.startAngle);
  model.joints = tessellationJoints(shape);
  model.target = tessellationTiles(shape, shape.targetAngle);
  return model;
}

std::vector<Tile> tessellationTiles(const TessellationShape& shape, double angle) {
  const Complex halfTurn = std::polar(1.0, 0.5 * angle);
  std::vector<Tile> tiles;
  tiles.reserve(static_cast<size_t>(shape.columns) * shape.rows);
  for (int i = 0; i < shape.columns; ++i) {
    for (int j = 0; j < shape.rows; ++j) {
      Tile& tile = tiles.emplace_back();
      for (const Step& step : cornerNeighbours(isEven(i, j))) {
        tile.vertices.push_back(cornerPosition(shape, halfTurn, i, j, step));
      }
    }
  }
  return tiles;
}

}  // namespace kirireel
