// A view is two angles, azimuth a and elevation e. The picture's axes follow from them (unit
// vectors in world axes):
//
//     right = (-sin a, cos a, 0)
//     up    = (-sin e cos a, -sin e sin a, cos e)
//     back  = ( cos e cos a,  cos e sin a, sin e)     from the centre towards the eye
//
// The camera's roll then rotates right and up about back.
//
// Fit in parallel projection: the points are projected on these axes. The picture's height is the
// larger of their height and their width / aspect, divided by 1 - 2 margin and by the zoom.
//
// Fit in perspective: let z be along `back`, and the eye at (X, Z). A point (x, z) is inside if
//   |x - X| <= s (Z - z),    s = tan(field of view / 2) (1 - 2 margin)
// The smallest Z of all points is (r - l) / 2 s, at X = (r + l) / 2, with
//   r = max(x + s z),    l = min(x - s z)
// The larger Z of the picture's two directions is taken. The zoom then narrows the field of view
// and does not move the eye, so the perspective does not change.
//
// For rotating cameras, a ball around all points is fitted instead, which has the same size from
// every side. The cone with half the angle t of the shorter side touches a ball of radius R at the
// distance R / sin t.
//
// Clip coordinates follow OpenGL's conventions: x to the right, y up, z from -1 near to 1 far after
// division by w.
#include "render/picture/camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "sim/base/error.h"

namespace kirireel::picture {
namespace {

/// Flat models: largest thickness of the layer of all points, as a fraction of its larger side.
/// Thicker models, such as a sheet that folds, have the isometric view.
constexpr double kFlatView = 0.15;

/// Empty, with low > high, until something is added.
struct AxisRange {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  double middle() const { return 0.5 * (low + high); }
  double length() const { return high - low; }
};

/// Unit axes of the picture in world axes.
struct PictureAxes {
  Vector3 right;
  Vector3 up;
  Vector3 back;  ///< towards the eye
};

/// Right is never zero, not even for a view along z, where `up` would not define it.
PictureAxes pictureAxes(ViewAngles view) {
  const double ca = std::cos(view.azimuth), sa = std::sin(view.azimuth);
  const double ce = std::cos(view.elevation), se = std::sin(view.elevation);
  const Vector3 right(-sa, ca, 0), up(-se * ca, -se * sa, ce), back(ce * ca, ce * sa, se);
  if (view.roll == 0) return {right, up, back};
  const double cr = std::cos(view.roll), sr = std::sin(view.roll);
  return {cr * right + sr * up, cr * up - sr * right, back};
}

/// The picture axes in which a camera sees.
PictureAxes pictureAxes(const Camera& camera) {
  const Vector3 back = (camera.eye - camera.centre).normalized();
  const Vector3 right = camera.up.cross(back).normalized();
  return {right, back.cross(right), back};
}

/// The points in picture axes, and their extents.
struct Extents {
  std::vector<Vector3> points;
  AxisRange x, y, z;
};

Extents projectPoints(std::span<const Vector3> points, const PictureAxes& axes) {
  Extents extents;
  for (const Vector3& point : points) {
    const Vector3 seen(axes.right.dot(point), axes.up.dot(point), axes.back.dot(point));
    extents.points.push_back(seen);
    extents.x.add(seen.x());
    extents.y.add(seen.y());
    extents.z.add(seen.z());
  }
  return extents;
}

/// Diagonal of the extents; 1 for a single point.
double diagonal(const Extents& extents) {
  const double length = Vector3(extents.x.length(), extents.y.length(), extents.z.length()).norm();
  return length > 0 ? length : 1;
}

/// Position of the eye for which all points are between both borders in one direction of the
/// picture. A point at (x, z) is inside if |x - eye| <= slope * (distance - z).
struct SideFit {
  double eye = 0;       ///< across the view
  double distance = 0;  ///< along it
};

SideFit fitSide(const Extents& extents, int axis, double slope) {
  double rightmost = -std::numeric_limits<double>::infinity();
  double leftmost = std::numeric_limits<double>::infinity();
  for (const Vector3& point : extents.points) {
    rightmost = std::max(rightmost, point[axis] + slope * point.z());
    leftmost = std::min(leftmost, point[axis] - slope * point.z());
  }
  return {0.5 * (rightmost + leftmost), (rightmost - leftmost) / (2 * slope)};
}

Vector3 toWorld(const PictureAxes& axes, double x, double y, double z) {
  return x * axes.right + y * axes.up + z * axes.back;
}

/// The diagonal if all points are on one line along the view and have no height.
Camera fitOrthographic(const Extents& extents, const PictureAxes& axes, const CameraFit& fit) {
  const double size = diagonal(extents);
  Camera camera;
  camera.up = axes.up;
  camera.orthographic = true;
  const double needed = std::max(extents.y.length(), extents.x.length() / fit.aspect);
  camera.viewHeight = (needed > 0 ? needed : size) / (1 - 2 * fit.margin) / fit.zoom;
  camera.centre = toWorld(axes, extents.x.middle(), extents.y.middle(), extents.z.middle());
  // A margin in front and behind for bricks that leave the fitted points during a deployment.
  camera.eye = camera.centre + 3 * size * axes.back;
  camera.near = 0.01 * size;
  camera.far = 6 * size;
  return camera;
}

/// The eye stays at least a twentieth of the diagonal in front of the nearest point.
Camera fitPerspective(const Extents& extents, const PictureAxes& axes, const CameraFit& fit) {
  const double size = diagonal(extents);
  const double slopeY = std::tan(0.5 * fit.fieldOfView) * (1 - 2 * fit.margin);
  const SideFit x = fitSide(extents, 0, slopeY * fit.aspect);
  const SideFit y = fitSide(extents, 1, slopeY);
  const double nearest = extents.z.high + 0.05 * size;
  const double eyeZ = std::max({x.distance, y.distance, nearest});
  Camera camera;
  camera.up = axes.up;
  camera.fieldOfView = 2 * std::atan(std::tan(0.5 * fit.fieldOfView) / fit.zoom);
  camera.eye = toWorld(axes, x.eye, y.eye, eyeZ);
  camera.centre = toWorld(axes, x.eye, y.eye, extents.z.middle());
  camera.near = 0.02 * (eyeZ - extents.z.middle());
  camera.far = (eyeZ - extents.z.middle()) + 4 * size;
  return camera;
}

}  // namespace

bool isAlongAxis(ViewAngles view) {
  if (std::abs(view.elevation) == kTopView.elevation) return true;
  return std::ranges::any_of(
      std::array{kFrontView, kBackView, kLeftView, kRightView}, [&view](const ViewAngles& axis) {
        return view.azimuth == axis.azimuth && view.elevation == axis.elevation;
      });
}

ViewAngles defaultView(std::span<const Vector3> points) {
  AxisRange x, y, z;
  for (const Vector3& point : points) {
    x.add(point.x());
    y.add(point.y());
    z.add(point.z());
  }
  // A narrow strip is a layer across two axes and takes the first view.
  const auto isThin = [](const AxisRange& across, const AxisRange& a, const AxisRange& b) {
    return across.length() < kFlatView * std::max(a.length(), b.length());
  };
  if (isThin(z, x, y)) return kTopView;
  if (isThin(y, x, z)) return kFrontView;
  return isThin(x, y, z) ? kRightView : kIsometricView;
}

Camera fitCamera(std::span<const Vector3> points, const CameraFit& fit) {
  if (points.empty()) throw InputError("error: the camera has no points to frame; give it bricks");
  const PictureAxes axes = pictureAxes(fit.view);
  const Extents extents = projectPoints(points, axes);
  return fit.orthographic ? fitOrthographic(extents, axes, fit)
                          : fitPerspective(extents, axes, fit);
}

Camera fitCameraToBall(const Vector3& centre, double radius, const CameraFit& fit) {
  const PictureAxes axes = pictureAxes(fit.view);
  const double room = (1 - 2 * fit.margin) * std::min(1.0, fit.aspect);
  const double slope = std::tan(0.5 * fit.fieldOfView);
  Camera camera;
  camera.up = axes.up;
  camera.centre = centre;
  camera.orthographic = fit.orthographic;
  camera.viewHeight = 2 * radius / room / fit.zoom;
  camera.fieldOfView = 2 * std::atan(slope / fit.zoom);
  // The cone of the picture's shorter side touches the ball.
  const double distance =
      fit.orthographic ? 6 * radius : radius / std::sin(std::atan(slope * room));
  camera.eye = centre + distance * axes.back;
  camera.near = 0.02 * distance;
  camera.far = distance + 8 * radius;
  return camera;
}

Camera atDistance(const Camera& camera, double distance) {
  const double before = (camera.eye - camera.centre).norm();
  Camera moved = camera;
  moved.eye = camera.centre + distance / before * (camera.eye - camera.centre);
  moved.near = 0.02 * distance;
  moved.far = camera.far - before + distance;
  return moved;
}

Matrix3 pictureFromWorld(const Camera& camera) {
  const auto [right, up, back] = pictureAxes(camera);
  Matrix3 rotation;
  rotation << right.transpose(), up.transpose(), back.transpose();
  return rotation;
}

double distanceAlongView(const Camera& camera, const Vector3& point) {
  return (camera.centre - camera.eye).normalized().dot(point - camera.eye);
}

double heightAtCentre(const Camera& camera) {
  if (camera.orthographic) return camera.viewHeight;
  return 2 * std::tan(0.5 * camera.fieldOfView) * (camera.eye - camera.centre).norm();
}

std::optional<int> brickAround(const std::vector<brick::Brick>& bricks, const Poses& poses,
                               const Vector3& point) {
  for (std::size_t k = 0; k < bricks.size(); ++k) {
    const Vector3 inside = poses[k].rotation.conjugate() * (point - poses[k].position);
    const auto isBehind = [&inside](const std::vector<Vector3>& face) {
      const Vector3 normal = (face[1] - face[0]).cross(face[2] - face[1]);
      return normal.dot(inside - face[0]) < 0;
    };
    // A concave brick contains a point if one of its convex pieces does.
    for (const brick::BrickPiece& piece : brick::convexPieces(bricks[k])) {
      const auto faces = brick::brickFaces(piece.shape);
      if (std::all_of(faces.begin(), faces.end(), isBehind)) return static_cast<int>(k);
    }
  }
  return std::nullopt;
}

std::vector<Vector3> brickCorners(const std::vector<brick::Brick>& bricks, const Poses& poses) {
  std::vector<Vector3> corners;
  for (std::size_t brick = 0; brick < bricks.size(); ++brick) {
    for (const Vector3& point : bricks[brick].bottom) corners.push_back(poses[brick].apply(point));
    for (const Vector3& point : bricks[brick].top) corners.push_back(poses[brick].apply(point));
  }
  return corners;
}

Eigen::Matrix4d clipFromWorld(const Camera& camera, double aspect) {
  const PictureAxes axes = pictureAxes(camera);
  Eigen::Matrix4d view = Eigen::Matrix4d::Identity();
  view.block<1, 3>(0, 0) = axes.right;
  view.block<1, 3>(1, 0) = axes.up;
  view.block<1, 3>(2, 0) = axes.back;
  view.block<3, 1>(0, 3) = -view.block<3, 3>(0, 0) * camera.eye;

  const double depth = camera.far - camera.near;
  Eigen::Matrix4d projection = Eigen::Matrix4d::Zero();
  if (camera.orthographic) {
    projection(0, 0) = 2 / (camera.viewHeight * aspect);
    projection(1, 1) = 2 / camera.viewHeight;
    projection(2, 2) = -2 / depth;
    projection(2, 3) = -(camera.far + camera.near) / depth;
    projection(3, 3) = 1;
  } else {
    const double slope = std::tan(0.5 * camera.fieldOfView);
    projection(0, 0) = 1 / (slope * aspect);
    projection(1, 1) = 1 / slope;
    projection(2, 2) = -(camera.far + camera.near) / depth;
    projection(2, 3) = -2 * camera.far * camera.near / depth;
    projection(3, 2) = -1;
  }
  return projection * view;
}

// ------------------------------------------------------------------------------------------------
// Between two keys at t0 and t1, each number v (azimuth, elevation, log of the zoom) is the cubic
// Hermite polynomial in s = (t - t0) / L with L = t1 - t0:
//
//     v(s) = (1 - q) v0 + q v1 + s (1-s)^2 L m0 - s^2 (1-s) L m1,    q = s^2 (3 - 2 s)
//
// The slopes m follow from the neighbours of a key (Catmull and Rom); they are 0 at the first and
// last key. The path has no kinks and passes through every key. The logarithm of the zoom is
// interpolated, so the zoom grows by equal factors in equal times.

namespace {

constexpr double kQuarterTurn = 1.5707963267948966;

void requireRisingTimes(const std::vector<CameraKey>& keys) {
  for (std::size_t k = 1; k < keys.size(); ++k) {
    if (keys[k].time > keys[k - 1].time) continue;
    throw InputError(fmt::format(
        "error: the camera's key at {:g} s does not come after the one at {:g} s; give the keys in "
        "the order of their times",
        keys[k].time, keys[k - 1].time));
  }
}

/// The interpolated numbers of a key: azimuth and elevation in radians, log of the zoom.
Eigen::Vector3d values(const CameraKey& key) {
  return {key.view.azimuth, key.view.elevation, std::log(key.zoom)};
}

/// Change per second at a key: the slope between its neighbours; 0 at both ends for a soft start
/// and stop.
Eigen::Vector3d slopeAt(const std::vector<CameraKey>& keys, std::size_t k) {
  if (k == 0 || k + 1 == keys.size()) return Eigen::Vector3d::Zero();
  return (values(keys[k + 1]) - values(keys[k - 1])) / (keys[k + 1].time - keys[k - 1].time);
}

/// The cubic between two keys with these slopes (Hermite).
CameraKey between(const std::vector<CameraKey>& keys, std::size_t k, double time) {
  const double length = keys[k + 1].time - keys[k].time;
  const double s = (time - keys[k].time) / length;
  const double rise = s * s * (3 - 2 * s);
  const Eigen::Vector3d mixed = (1 - rise) * values(keys[k]) + rise * values(keys[k + 1]) +
                                s * (1 - s) * (1 - s) * length * slopeAt(keys, k) -
                                s * s * (1 - s) * length * slopeAt(keys, k + 1);
  return {time, {mixed[0], std::clamp(mixed[1], -kQuarterTurn, kQuarterTurn)}, std::exp(mixed[2])};
}

}  // namespace

ViewAngles viewFromYawPitch(double yaw, double pitch) {
  return {yaw - kQuarterTurn, -pitch};
}

CameraPath::CameraPath(const CameraChoice& choice, std::span<const Vector3> points, double aspect)
    : choice_(choice) {
  requireRisingTimes(choice.keys);
  fit_.view = choice.view.value_or(defaultView(points));
  fit_.orthographic = choice.orthographic.value_or(isStill() && isAlongAxis(fit_.view));
  fit_.aspect = aspect;
  fit_.margin = choice.margin;
  fit_.zoom = choice.zoom;
  still_ = fitCamera(points, fit_);
  if (isStill()) return;
  Eigen::AlignedBox3d box;
  for (const Vector3& point : points) box.extend(point);
  ballCentre_ = box.center();
  double radius = 0;
  for (const Vector3& point : points) radius = std::max(radius, (point - ballCentre_).norm());
  if (radius > 0) ballRadius_ = radius;
}

CameraKey CameraPath::keyAt(double time) const {
  const std::vector<CameraKey>& keys = choice_.keys;
  if (keys.empty()) return {time, fit_.view, 1};
  const auto next = std::find_if(keys.begin(), keys.end(),
                                 [time](const CameraKey& key) { return key.time > time; });
  if (next == keys.begin()) return keys.front();
  if (next == keys.end()) return keys.back();
  return between(keys, static_cast<std::size_t>(next - keys.begin()) - 1, time);
}

Camera CameraPath::at(double time, double turn) const {
  Camera camera = still_;
  if (!isStill()) {
    const CameraKey key = keyAt(time);
    CameraFit fit = fit_;
    fit.view = key.view;
    fit.view.azimuth += std::clamp(turn, 0.0, 1.0) * choice_.orbit;
    fit.zoom *= key.zoom;
    camera = fitCameraToBall(ballCentre_, ballRadius_, fit);
  }
  return choice_.distance ? atDistance(camera, *choice_.distance) : camera;
}

}  // namespace kirireel::picture
