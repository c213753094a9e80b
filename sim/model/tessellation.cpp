// Tessellations of equal parallelograms, from the exact motion of their lattice (turning_field.h).
// The constants are those of regularField(): sides of `length` along x and of `width` at `skew`
// from the y axis. Both states are evaluated from the same constants, so that start and target are
// congruent to rounding, and no solver is needed.
#include "sim/model/tessellation.h"

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/base/geometry.h"
#include "sim/model/turning_field.h"

namespace kirireel {
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
      fmt::format("tessellation: error: the {} angle is {:g} degrees; give a number "
                  "from 0 to 180",
                  name, value / kDegree));
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
  model.joints = latticeJoints({shape.columns, shape.rows}, shape.face);
  model.target = tessellationTiles(shape, shape.targetAngle);
  return model;
}

std::vector<Tile> tessellationTiles(const TessellationShape& shape, double angle) {
  return fieldOf(shape).tiles(angle);
}

}  // namespace kirireel
