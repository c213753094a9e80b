// A motion is represented by a few states. If all of them lie in one thin layer, the view is along
// its normal. Otherwise directions of a fixed set are compared by
//
//     v = mean over states of (A_front + kBack A_back) / A,
//
// A_front and A_back are the visible areas of the tiles' fronts and backs, from a depth buffer.
// Directions within kNearlyBest of the best are equally good. The one nearest to a default view is
// selected: oblique for a flat start, else isometric. Small errors of the depth buffer then have no
// effect, and symmetric models have a default view.
//
// The set of directions is fixed in the axes of the first state. z is its normal if it is flat and
// nothing else defines the upward direction, else the world's z. The other axes are the sides of
// the smallest rectangle around it. The choice therefore rotates with the model, and the first
// state is upright even if the alignment to the target has rotated it. A rectangle that is hardly
// smaller than the one along the axes of the file does not rotate the picture.
#include "render/picture/automatic_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include <Eigen/Eigenvalues>

#include "sim/base/interruption.h"
#include "sim/model/convex_parts.h"
#include "sim/model/sheet_frame.h"

namespace kirireel::picture {
namespace {

using Tiles = std::vector<model::Tile>;

/// Maximum thickness of the layer of a flat motion, relative to its smaller side.
constexpr double kFlatLayer = 0.15;
/// Weight of a visible back relative to a visible front.
constexpr double kBack = 0.95;
/// Directions whose value is at least this fraction of the best are equally good.
constexpr double kNearlyBest = 0.97;
/// The start is rotated if that reduces the rectangle around it by this fraction.
constexpr double kUprightGain = 0.02;
/// Normals this near to z, and angles this near to a quarter turn, differ from them by rounding.
constexpr double kRounding = 1e-7;
/// Sides of the depth buffer, pixels.
constexpr int kSide = 96;
/// Steps of the directions, degrees.
constexpr int kAzimuthStep = 15;
constexpr int kElevationStep = 10;
constexpr int kMaxElevation = 80;
/// From this elevation on, candidate azimuths are multiples of 90 degrees.
constexpr int kSteep = 70;

/// Right-handed axes.
struct Axes {
  Vector3 x = Vector3::UnitX();
  Vector3 y = Vector3::UnitY();
  Vector3 z = Vector3::UnitZ();
};

/// All vertices of some states.
std::vector<Vector3> verticesOf(std::span<const Tiles> states) {
  std::vector<Vector3> points;
  for (const Tiles& tiles : states) {
    for (const model::Tile& tile : tiles) {
      points.insert(points.end(), tile.vertices.begin(), tile.vertices.end());
    }
  }
  return points;
}

double lengthAlong(std::span<const Vector3> points, const Vector3& axis) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Vector3& point : points) {
    low = std::min(low, axis.dot(point));
    high = std::max(high, axis.dot(point));
  }
  return high - low;
}

/// x and y across a normal. Up in the picture is z, or y if the normal is nearer to z.
Axes axesAcross(const Vector3& normal) {
  const bool isLying = std::abs(normal.z()) > std::numbers::sqrt2 / 2;
  const Vector3 up =
      isLying ? (normal.z() > 0 ? Vector3(Vector3::UnitY()) : -Vector3::UnitY()) : Vector3::UnitZ();
  const Vector3 x = up.cross(normal).normalized();
  return {x, normal.cross(x), normal};
}

/// The axes turned about their z.
Axes turned(const Axes& axes, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * axes.x + s * axes.y, c * axes.y - s * axes.x, axes.z};
}

/// The axes along a normal whose x and y are sides of the smallest rectangle around the start.
Axes upright(const Tiles& start, const Vector3& normal) {
  const Axes axes = axesAcross(normal);
  std::vector<Eigen::Vector2d> points;
  for (const Vector3& point : verticesOf(std::span(&start, 1))) {
    points.emplace_back(axes.x.dot(point), axes.y.dot(point));
  }
  return turned(axes, model::smallestRectangleAngle(std::move(points), kUprightGain));
}

/// The normal of the layer that contains all points, if there is one. Its sign is undefined.
std::optional<Vector3> layerNormal(std::span<const Vector3> points, const Tiles& start) {
  const Vector3 middle = meanPoint(points);
  Matrix3 spread = Matrix3::Zero();
  for (const Vector3& point : points) {
    spread += (point - middle) * (point - middle).transpose();
  }
  const Matrix3 axes = Eigen::SelfAdjointEigenSolver<Matrix3>(spread).eigenvectors();
  // The start's own plane is exact.
  for (const Vector3& normal : {model::meanNormal(start, Vector3::UnitZ()), Vector3(axes.col(0))}) {
    const Axes across = axesAcross(normal);
    const double smaller = std::min(lengthAlong(points, across.x), lengthAlong(points, across.y));
    if (lengthAlong(points, normal) < kFlatLayer * smaller) return normal;
  }
  return std::nullopt;
}

/// The normal on the side that shows more fronts; towards z, y or x if both show as many.
Vector3 towardsFronts(const Vector3& normal, std::span<const Tiles> states) {
  double fronts = 0, area = 0;
  for (const Tiles& tiles : states) {
    for (const model::Tile& tile : tiles) {
      fronts += model::tileArea(tile) * model::tileNormal(tile).dot(normal);
      area += model::tileArea(tile);
    }
  }
  if (std::abs(fronts) > kRounding * area) return fronts > 0 ? normal : Vector3(-normal);
  for (const int axis : {2, 1, 0}) {
    // The front view is from -y.
    const double side = axis == 1 ? -normal[axis] : normal[axis];
    if (std::abs(side) > kRounding) return side > 0 ? normal : Vector3(-normal);
  }
  return normal;
}

/// Exact along an axis, as a parallel projection requires.
Vector3 withoutRounding(Vector3 direction) {
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(direction[axis]) < kRounding) direction[axis] = 0;
  }
  return direction.normalized();
}

double nearestQuarter(double angle) {
  constexpr double kQuarter = std::numbers::pi / 2;
  const double exact = kQuarter * std::round(angle / kQuarter);
  return std::abs(angle - exact) < kRounding ? exact : angle;
}

/// The angles of a camera in the direction `back`, with `up` upwards in its picture. From directly
/// above, the azimuth rotates the picture, and there is no roll.
ViewAngles anglesOf(const Vector3& direction, const Vector3& up) {
  const Vector3 back = withoutRounding(direction);
  const Vector3 right = up.cross(back).normalized();
  if (std::hypot(back.x(), back.y()) == 0) {
    return {nearestQuarter(std::atan2(-right.x(), right.y())),
            std::copysign(std::numbers::pi / 2, back.z())};
  }
  ViewAngles view{nearestQuarter(std::atan2(back.y(), back.x())),
                  nearestQuarter(std::asin(std::clamp(back.z(), -1.0, 1.0)))};
  const Vector3 level(-std::sin(view.azimuth), std::cos(view.azimuth), 0);
  view.roll = nearestQuarter(std::atan2(right.dot(back.cross(level)), right.dot(level)));
  return view;
}

/// The tiles of a state as triangles that are anticlockwise seen from the front.
struct TriangulatedState {
  std::vector<Vector3> points;
  std::vector<std::array<int, 3>> triangles;  ///< indices of points
  double area = 0;

  explicit TriangulatedState(const Tiles& tiles) {
    for (const model::Tile& tile : tiles) {
      const int first = static_cast<int>(points.size());
      const Vector3 normal = model::tileNormal(tile);
      points.insert(points.end(), tile.vertices.begin(), tile.vertices.end());
      area += model::tileArea(tile);
      for (const auto& [a, b, c] : model::trianglesOf(tile.vertices, normal)) {
        triangles.push_back({first + a, first + b, first + c});
      }
    }
  }
};

/// A parallel view of triangles in a small depth buffer.
class DepthBuffer {
 public:
  /// The value of the view for one state.
  double valueOf(const TriangulatedState& surface, const Axes& view) {
    depths_.assign(kSide * kSide, -std::numeric_limits<double>::infinity());
    sides_.assign(kSide * kSide, Seen::Nothing);
    std::vector<Vector3> seen;
    Eigen::AlignedBox2d box;
    for (const Vector3& point : surface.points) {
      seen.emplace_back(view.x.dot(point), view.y.dot(point), view.z.dot(point));
      box.extend(seen.back().head<2>());
    }
    const double scale = kSide / std::max(box.sizes().maxCoeff(), 1e-300);
    for (Vector3& point : seen) point.head<2>() = scale * (point.head<2>() - box.min());
    for (const auto& [a, b, c] : surface.triangles) draw(seen[a], seen[b], seen[c]);
    const double pixels = surface.area * scale * scale;
    return static_cast<double>(std::ranges::count(sides_, Seen::Front)) / pixels +
           kBack * (static_cast<double>(std::ranges::count(sides_, Seen::Back)) / pixels);
  }

 private:
  enum class Seen : char { Nothing, Front, Back };

  /// Pixels whose centres are in the triangle.
  void draw(const Vector3& a, const Vector3& b, const Vector3& c) {
    const auto across = [](const Vector3& from, const Vector3& to, double x, double y) {
      return (to.x() - from.x()) * (y - from.y()) - (to.y() - from.y()) * (x - from.x());
    };
    const double whole = across(a, b, c.x(), c.y());
    if (std::abs(whole) < kRounding) return;
    const auto range = [](double first, double second, double third) {
      const auto [low, high] = std::minmax({first, second, third});
      return std::pair(std::clamp(static_cast<int>(std::ceil(low - 0.5)), 0, kSide),
                       std::clamp(static_cast<int>(std::floor(high + 0.5)), 0, kSide));
    };
    const auto [left, right] = range(a.x(), b.x(), c.x());
    const auto [low, high] = range(a.y(), b.y(), c.y());
    for (int row = low; row < high; ++row) {
      for (int column = left; column < right; ++column) {
        const double x = column + 0.5, y = row + 0.5;
        const double atA = across(b, c, x, y) / whole, atB = across(c, a, x, y) / whole;
        const double atC = 1 - atA - atB;
        if (atA < 0 || atB < 0 || atC < 0) continue;
        const double depth = atA * a.z() + atB * b.z() + atC * c.z();
        const std::size_t pixel = static_cast<std::size_t>(row) * kSide + column;
        if (depth <= depths_[pixel]) continue;
        depths_[pixel] = depth;
        sides_[pixel] = whole > 0 ? Seen::Front : Seen::Back;
      }
    }
  }

  std::vector<double> depths_;
  std::vector<Seen> sides_;
};

/// A direction in some axes, and up in its picture.
Axes viewIn(const Axes& axes, double azimuth, double elevation) {
  const Vector3 out = std::cos(azimuth) * axes.x + std::sin(azimuth) * axes.y;
  const Vector3 back = std::cos(elevation) * out + std::sin(elevation) * axes.z;
  const Vector3 right = -std::sin(azimuth) * axes.x + std::cos(azimuth) * axes.y;
  return {right, back.cross(right), back};
}

/// The best of the set of directions; of equally good ones, the nearest to a default view.
Axes bestDirection(std::span<const Tiles> states, const Axes& axes, ViewAngles fallback,
                   bool fromBelow) {
  const std::vector<TriangulatedState> surfaces(states.begin(), states.end());
  DepthBuffer buffer;
  std::vector<std::pair<double, Axes>> candidates;
  double most = 0;
  for (int elevation = fromBelow ? -kMaxElevation : kElevationStep; elevation <= kMaxElevation;
       elevation += kElevationStep) {
    const int step = std::abs(elevation) >= kSteep ? 90 : kAzimuthStep;
    for (int azimuth = -90; azimuth < 270; azimuth += step) {
      checkInterruption();
      const Axes view = viewIn(axes, azimuth * kDegree, elevation * kDegree);
      double value = 0;
      for (const TriangulatedState& surface : surfaces) {
        value += buffer.valueOf(surface, view);
      }
      most = std::max(most, value);
      candidates.emplace_back(value, view);
    }
  }
  const Vector3 towardsDefault = viewIn(axes, fallback.azimuth, fallback.elevation).z;
  std::optional<Axes> best;
  for (const auto& [value, view] : candidates) {
    if (value < kNearlyBest * most) continue;
    if (!best || view.z.dot(towardsDefault) > best->z.dot(towardsDefault) + kRounding) best = view;
  }
  return *best;
}

}  // namespace

AutomaticView chooseView(std::span<const Tiles> states, bool zIsUp) {
  const Tiles& start = states.front();
  const std::vector<Vector3> points = verticesOf(states);
  if (const std::optional<Vector3> layer = layerNormal(points, start)) {
    Vector3 normal = withoutRounding(towardsFronts(*layer, states));
    const bool isLying = std::abs(normal.z()) > std::numbers::sqrt2 / 2;
    if (zIsUp && isLying && normal.z() < 0) normal = -normal;
    const Axes axes = zIsUp && !isLying ? axesAcross(normal) : upright(start, normal);
    return {anglesOf(axes.z, axes.y), true};
  }
  const std::span<const Tiles> onlyStart(&start, 1);
  const std::optional<Vector3> layer = layerNormal(verticesOf(onlyStart), start);
  const Vector3 up =
      layer && !zIsUp ? withoutRounding(towardsFronts(*layer, onlyStart)) : Vector3::UnitZ();
  const Axes best =
      bestDirection(states, upright(start, up), layer ? kObliqueView : kIsometricView, !zIsUp);
  return {anglesOf(best.z, best.y), false};
}

}  // namespace kirireel::picture
