// The normal of a flat sheet is the sum of the tiles' area vectors, each flipped to the side of the
// first. Its error is the error of the vertices divided by the size of the sheet. The upper side is
// the one from which most of the area is anticlockwise.

#include "sim/model/sheet_frame.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>

#include "sim/base/geometry.h"
#include "sim/model/convex_parts.h"

namespace kirireel::model {
namespace {

/// Smaller differences of area, as a fraction of the whole, do not choose the upper side.
constexpr double kEvenArea = 1e-9;

// Differences from the rounding of doubles, as a fraction of the model's size.
constexpr double kFlat = 1e-9;
// Differences from the rounding of the numbers in a file, in digits. The largest in 1,700 random
// planes of 17 sheets is 3.1, in a sheet with a target that is twice as wide as its start.
constexpr double kFlatDigits = 5;

/// Smaller relative differences of principal moments count as equal.
constexpr double kEvenMoments = 1e-6;

/// Smaller relative differences, and differences of angles in radians, count as equal.
constexpr double kSameRectangle = 1e-7;

Eigen::Vector2d directionAt(double angle) {
  return {std::cos(angle), std::sin(angle)};
}

/// The sides of the rectangle around points with its sides rotated by this angle, radians.
Eigen::Vector2d rectangleSides(const std::vector<Eigen::Vector2d>& points, double angle) {
  const Eigen::Vector2d x = directionAt(angle), y(-x.y(), x.x());
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& point : points) {
    box.extend(Eigen::Vector2d(x.dot(point), y.dot(point)));
  }
  return box.sizes();
}

/// Whether each tile is perpendicular to one axis, the same for all. Rounding keeps such tiles in
/// their plane, so the distances of parallel tiles are real.
bool areAcrossAxis(const std::vector<Tile>& tiles, double tolerance) {
  for (int axis = 0; axis < 3; ++axis) {
    const bool areAcross = std::ranges::all_of(tiles, [&](const Tile& tile) {
      return std::ranges::all_of(tile.vertices, [&](const Vector3& vertex) {
        return std::abs(vertex[axis] - tile.vertices.front()[axis]) <= tolerance;
      });
    });
    if (areAcross) return true;
  }
  return false;
}

}  // namespace

double flatTolerance(const Model& model) {
  return flatTolerance(modelSize(model), model.rounding);
}

double flatTolerance(double size, double rounding) {
  return std::max(kFlat * size, kFlatDigits * rounding);
}

Vector3 meanNormal(const std::vector<Tile>& tiles, const Vector3& ifEven) {
  const Vector3 first = tileNormal(tiles.front());
  Vector3 sum = Vector3::Zero();
  double sameSide = 0, total = 0;
  for (const Tile& tile : tiles) {
    const Vector3 area = tileArea(tile) * tileNormal(tile);
    const double along = area.dot(first);
    sum += along < 0 ? Vector3(-area) : area;
    sameSide += along;
    total += std::abs(along);
  }
  const bool isEven = std::abs(sameSide) <= kEvenArea * total;
  const bool isOpposite = isEven ? sum.dot(ifEven) < 0 : sameSide < 0;
  return (isOpposite ? -1 : 1) * sum.normalized();
}

SheetFrame frameAlong(const Vector3& normal, const Vector3& origin) {
  SheetFrame frame;
  frame.origin = origin;
  frame.normal = normal;
  // A normal that points straight down has no unique shortest rotation. Rotate about x.
  const Vector3 axis = Vector3::UnitZ().cross(normal);
  const double angle = std::atan2(axis.norm(), normal.z());
  const Eigen::AngleAxisd turn(angle,
                               axis.isZero() ? Vector3::UnitX() : Vector3(axis.normalized()));
  frame.x = turn * Vector3::UnitX();
  frame.y = normal.cross(frame.x);
  return frame;
}

std::optional<SheetFrame> sheetFrame(const Model& model) {
  const double size = modelSize(model);
  const bool isExact = areAcrossAxis(model.tiles, kFlat * size);
  return sheetFrame(model.tiles, flatTolerance(size, isExact ? 0 : model.rounding));
}

SheetFrame viewFrame(const Model& model) {
  if (const std::optional<SheetFrame> frame = sheetFrame(model)) return *frame;
  std::vector<Vector3> points;
  for (const Tile& tile : model.tiles) {
    points.insert(points.end(), tile.vertices.begin(), tile.vertices.end());
  }
  const Vector3 middle = meanPoint(points);
  Matrix3 moments = Matrix3::Zero();
  for (const Vector3& point : points) {
    moments += (point - middle) * (point - middle).transpose();
  }
  const SymmetricEigen found = eigenOf(moments);
  const double below = found.values[1] - found.values[0], above = found.values[2] - found.values[1];
  if (std::max(below, above) <= kEvenMoments * found.values[2]) return {};
  Vector3 axis = found.vectors.col(above > below ? 2 : 0);
  double side = 0;
  for (const Tile& tile : model.tiles) side += tileArea(tile) * tileNormal(tile).dot(axis);
  if (side < 0) axis = -axis;
  // The identity is the frame of a vertical axis.
  if (axis.head<2>().norm() <= kFlat) return {};
  return frameAlong(axis, middle);
}

std::optional<SheetFrame> sheetFrame(const std::vector<Tile>& tiles, double tolerance) {
  SheetFrame frame;
  if (liesFlat(tiles, tolerance)) {
    frame.origin.z() = tiles.front().vertices.front().z();
    return frame;
  }
  frame = frameAlong(meanNormal(tiles, tileNormal(tiles.front())), tiles.front().vertices.front());
  if (!isParallel(frame, tiles, tolerance)) return std::nullopt;
  return frame;
}

double smallestRectangleAngle(std::vector<Eigen::Vector2d> points, double gain,
                              const std::function<double(const Eigen::Vector2d&)>& weight) {
  constexpr double kQuarter = std::numbers::pi / 2;
  const std::vector<Eigen::Vector2d> outline = convexOutline(std::move(points));
  const auto weightAt = [&](double angle) {
    if (!weight) return 0.0;
    const Eigen::Vector2d sides = rectangleSides(outline, angle);
    const double along = weight(directionAt(angle)), across = weight(directionAt(angle + kQuarter));
    if (std::abs(sides.x() - sides.y()) <= kSameRectangle * sides.norm()) {
      return std::max(along, across);
    }
    return sides.x() > sides.y() ? along : across;
  };
  double best = 0, least = (1 - gain) * rectangleSides(outline, 0).prod(), most = weightAt(0);
  for (std::size_t k = 0; k < outline.size(); ++k) {
    const Eigen::Vector2d side = outline[(k + 1) % outline.size()] - outline[k];
    const double along = std::atan2(side.y(), side.x());
    double angle = along - kQuarter * std::round(along / kQuarter);
    if (angle < -kQuarter / 2 + kSameRectangle) angle += kQuarter;
    const double area = rectangleSides(outline, angle).prod();
    const bool isEqual = std::abs(area - least) <= kSameRectangle * least;
    if (!isEqual && area > least) continue;
    const double own = weightAt(angle);
    const bool isAsHeavy = std::abs(own - most) <= kSameRectangle * most;
    const double more = std::abs(angle) - std::abs(best);
    const bool turnsLess =
        more < -kSameRectangle || (more < kSameRectangle && best != 0 && angle > best);
    if (isEqual && (isAsHeavy ? !turnsLess : own < most)) continue;
    best = angle;
    least = area;
    most = own;
  }
  return best;
}

bool isParallel(const SheetFrame& frame, const std::vector<Tile>& tiles, double tolerance) {
  const double level = frame.toFrame(tiles.front().vertices.front()).z();
  return std::ranges::all_of(tiles, [&](const Tile& tile) {
    return std::ranges::all_of(tile.vertices, [&](const Vector3& vertex) {
      return std::abs(frame.toFrame(vertex).z() - level) <= tolerance;
    });
  });
}

std::vector<Tile> toFrame(const SheetFrame& frame, std::vector<Tile> tiles) {
  for (Tile& tile : tiles) {
    for (Vector3& vertex : tile.vertices) vertex = frame.toFrame(vertex);
  }
  return tiles;
}

Poses toFrame(const SheetFrame& frame, Poses poses) {
  for (Pose& pose : poses) pose = frame.toFrame(pose);
  return poses;
}

Poses toWorld(const SheetFrame& frame, Poses poses) {
  for (Pose& pose : poses) pose = frame.toWorld(pose);
  return poses;
}

}  // namespace kirireel::model
