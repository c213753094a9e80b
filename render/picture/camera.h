/// The camera: where the picture is taken from. Fitting it once keeps it still for a whole video.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/model/brick.h"

namespace kirireel::picture {

/// View and projection. The eye looks at the centre; what is farther than `far` or nearer than
/// `near` along the view is cut off.
struct Camera {
  Vector3 eye = Vector3(0, 0, 10);          ///< metres
  Vector3 centre = Vector3::Zero();         ///< the point in the middle of the picture, metres
  Vector3 up = Vector3::UnitY();            ///< upwards in the picture; not along the view
  bool orthographic = false;                ///< parallel projection: equal lengths look equal
  double fieldOfView = 0.3490658503988659;  ///< perspective: vertical, radians, 0 to pi
  double viewHeight = 2;                    ///< orthographic: height of the picture, metres
  double near = 0.1;                        ///< from the eye, metres, positive
  double far = 100;                         ///< from the eye, metres, more than near
};

/// The direction from the model to the eye, and how the camera is turned about it.
struct ViewAngles {
  double azimuth = -1.5707963267948966;   ///< radians, anticlockwise from +x about +z
  double elevation = 1.5707963267948966;  ///< radians above the xy plane, -pi/2 to pi/2
  double roll = 0;                        ///< of the camera, radians, anticlockwise from the eye

  bool operator==(const ViewAngles&) const = default;
};

/// From straight above, +x to the right and +y upwards.
inline constexpr ViewAngles kTopView{-1.5707963267948966, 1.5707963267948966};
/// From the front (-y), +x to the right and +z upwards.
inline constexpr ViewAngles kFrontView{-1.5707963267948966, 0};
/// From behind, from the left (-x), from the right, +z upwards; and from straight below, +x to the
/// right.
inline constexpr ViewAngles kBackView{1.5707963267948966, 0};
/// See kBackView: from the left.
inline constexpr ViewAngles kLeftView{3.141592653589793, 0};
/// From the right.
inline constexpr ViewAngles kRightView{0, 0};
/// From straight below.
inline constexpr ViewAngles kBottomView{-1.5707963267948966, -1.5707963267948966};
/// All three axes equally foreshortened, x towards the lower right: for models in space.
inline constexpr ViewAngles kIsometricView{-0.7853981633974483, 0.6154797086703873};
/// Nearly from above. The tilt shows the thickness of flat sheets.
inline constexpr ViewAngles kObliqueView{-1.5707963267948966, 1.0821041362364843};

/// Whether the view is along an axis, whatever the azimuth of one along z and the roll. Lengths
/// across it can then be compared. Exact.
bool isAlongAxis(ViewAngles view);

/// kTopView, kFrontView or kRightView for points that lie nearly in one layer across z, y or x,
/// else kIsometricView. The thickness of a layer is below 15% of its larger side.
ViewAngles defaultView(std::span<const Vector3> points);

/// How to frame points.
struct CameraFit {
  ViewAngles view = kIsometricView;  ///< the direction of the camera, unless angles are given
  double aspect = 16.0 / 9.0;        ///< width / height of the picture
  bool orthographic = false;         ///< else perspective
  double fieldOfView = 0.3490658503988659;  ///< perspective: vertical, radians
  /// Part of the picture's width and height left free on each side, 0 to 0.45.
  double margin = 0.06;
  double zoom = 1;  ///< enlarges the middle of the picture, positive; the eye stays where it is
};

/// The camera with the given view that shows all points as large as possible and in the middle.
/// At least one point: throws InputError otherwise. Near and far leave room for bricks that move
/// out of the points on the way. One pass over the points.
Camera fitCamera(std::span<const Vector3> points, const CameraFit& fit);

/// The camera with the given view that shows all of a ball, hence the same size from every side:
/// for cameras that turn. radius: metres, positive. All of the ball is between near and far.
Camera fitCameraToBall(const Vector3& centre, double radius, const CameraFit& fit);

/// The same camera nearer or farther along its view, at this distance from its centre, metres.
/// `distance` is positive. In perspective the picture's middle grows or shrinks by it.
Camera atDistance(const Camera& camera, double distance);

/// Height of the picture at the camera's centre, metres.
double heightAtCentre(const Camera& camera);

/// The brick that the point (world axes) lies within, if any. Looks at all bricks.
std::optional<int> brickAround(const std::vector<model::Brick>& bricks, const Poses& poses,
                               const Vector3& point);

/// All corners of all bricks at the given poses, world axes: what fitCamera should frame (give it
/// the corners at the start and at the target together).
std::vector<Vector3> brickCorners(const std::vector<model::Brick>& bricks, const Poses& poses);

/// The 4 x 4 matrix from world axes to clip coordinates, for pictures of the given aspect. For
/// column vectors: clip = matrix * (x, y, z, 1). The aspect is width by height.
Eigen::Matrix4d clipFromWorld(const Camera& camera, double aspect);

// ------------------------------------------------------------------------------------------------
// The camera over a whole run: still, in orbit, or at keyframes.

/// The camera at one time.
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
  /// the first key and after the last only the orbit moves it. Negligible cost next to a picture.
  Camera at(double time, double turn) const;

  /// Whether the camera does not move: all pictures share one scale and one view.
  bool isStill() const { return choice_.keys.empty() && choice_.orbit == 0; }

 private:
  CameraKey keyAt(double time) const;

  CameraChoice choice_;
  CameraFit fit_;
  Camera still_;
  Vector3 ballCentre_ = Vector3::Zero();
  double ballRadius_ = 1;
};

}  // namespace kirireel::picture
