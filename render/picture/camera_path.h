/// Where the camera stands over a whole run: still, in orbit, or led by keyframes.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "render/picture/camera.h"

namespace kirireel {

/// Where a led camera stands at one time.
struct CameraKey {
  double time = 0;  ///< simulated seconds
  ViewAngles view;  ///< its azimuth may pass full turns
  double zoom = 1;  ///< positive

  bool operator==(const CameraKey&) const = default;
};

/// What is asked of the camera. Angles are radians, lengths metres, times simulated seconds.
struct CameraChoice {
  std::optional<ViewAngles> view;    ///< absent: from above for flat models, else from a corner
  std::optional<bool> orthographic;  ///< absent: only along an axis
  double margin = 0.06;              ///< part of the picture left free on each side, 0 to 0.45
  double zoom = 1;                   ///< enlarges the middle of the picture, positive
  std::optional<double> distance;    ///< of the eye from the centre, metres; absent: as it fits
  double orbit = 0;                  ///< radians that the camera turns about +z in all
  std::vector<CameraKey> keys;  ///< rising in time; when given, they take the place of the view
};

/// The angles of PyBullet's camera, as PyKirigami has them: yaw turns the eye about +z, 0 from the
/// front; pitch is negative for an eye above. Radians. azimuth = yaw - pi / 2, elevation = -pitch.
ViewAngles viewFromYawPitch(double yaw, double pitch);

/// The camera of every picture of one run.
class CameraPath {
 public:
  /// points: what must be in sight, at least one. aspect: width / height of the pictures. Throws
  /// InputError when there are no points or the keys' times do not rise.
  CameraPath(const CameraChoice& choice, std::span<const Vector3> points, double aspect);

  /// The camera at a time, simulated seconds, with a share of its orbit behind it, 0 to 1. Before
  /// the first key and after the last it stands still but for the orbit. Costs nothing beside a
  /// picture.
  Camera at(double time, double turn) const;

  /// Whether the camera stands still, so that all pictures share one scale and one view.
  bool isStill() const { return choice_.keys.empty() && choice_.orbit == 0; }

 private:
  CameraKey keyAt(double time) const;

  CameraChoice choice_;
  CameraFit fit_;
  Camera still_;
  Vector3 ballCentre_ = Vector3::Zero();
  double ballRadius_ = 1;
};

}  // namespace kirireel
