// Between two keys at t0 and t1 each number v (azimuth, elevation, log of the zoom) is the cubic
// Hermite polynomial in s = (t - t0) / (t1 - t0), L = t1 - t0:
//
//     v(s) = (1 - q) v0 + q v1 + s (1-s)^2 L m0 - s^2 (1-s) L m1,    q = s^2 (3 - 2 s)
//
// with slopes m from the neighbours of a key (Catmull and Rom's choice), 0 at the first and the
// last. The path has no kinks and passes through every key. The zoom goes by its logarithm, so that
// it grows by equal factors in equal times.
#include "render/picture/camera_path.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sim/base/error.h"

namespace kirireel {
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

/// Numbers of a key that change between keys. Azimuth and elevation in radians, log of the zoom.
Eigen::Vector3d values(const CameraKey& key) {
  return {key.view.azimuth, key.view.elevation, std::log(key.zoom)};
}

/// Change a second at a key: the slope between its neighbours, zero at both ends, so that the
/// camera starts and stops softly.
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

}  // namespace kirireel
