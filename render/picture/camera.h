/// The camera of a picture. A camera that is fitted once stays fixed for a whole video.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/brick/brick.h"

namespace kirireel::picture {

/// View and projection. The eye points at the centre. Parts farther than `far` or nearer than
/// `near` along the view are cut off.
struct Camera {
  Vector3 eye = Vector3(0, 0, 10);          ///< metres
  Vector3 centre = Vector3::Zero();         ///< point in the middle of the picture, metres
  Vector3 up = Vector3::UnitY();            ///< upwards in the picture; not along the view
  bool orthographic = false;                ///< parallel projection: equal lengths appear equal
  double fieldOfView = 0.3490658503988659;  ///< perspective: vertical, radians, (0, pi)
  double viewHeight = 2;                    ///< orthographic: height of the picture, metres
  double near = 0.1;                        ///< from the eye, metres, > 0
  double far = 100;                         ///< from the eye, metres, > near
};

/// The direction from the model to the eye, and the rotation of the camera about it.
struct ViewAngles {
  double azimuth = -1.5707963267948966;   ///< radians, anticlockwise from +x about +z
  double elevation = 1.5707963267948966;  ///< radians above the xy plane, [-pi/2, pi/2]
  double roll = 0;                        ///< of the camera, radians, anticlockwise from the eye

  bool operator==(const ViewAngles&) const = default;
};

/// From above, +x to the right and +y upwards.
inline constexpr ViewAngles kTopView{-1.5707963267948966, 1.5707963267948966};
/// From the front (-y), +x to the right and +z upwards.
inline constexpr ViewAngles kFrontView{-1.5707963267948966, 0};
/// From behind. This view and the left (-x) and right views have +z upwards, that from below has +x
/// to the right.
inline constexpr ViewAngles kBackView{1.5707963267948966, 0};
/// See kBackView: from the left.
inline constexpr ViewAngles kLeftView{3.141592653589793, 0};
/// From the right.
inline constexpr ViewAngles kRightView{0, 0};
/// From below.
inline constexpr ViewAngles kBottomView{-1.5707963267948966, -1.5707963267948966};
/// All three axes equally foreshortened, x towards the lower right; default of spatial models.
inline constexpr ViewAngles kIsometricView{-0.7853981633974483, 0.6154797086703873};
/// Nearly from above. The tilt shows the thickness of flat sheets.
inline constexpr ViewAngles kObliqueView{-1.5707963267948966, 1.0821041362364843};

/// Whether the view is along an axis, for any roll and for any azimuth of a view along z. Lengths
/// across the axis are then comparable. Exact.
bool isAlongAxis(ViewAngles view);

/// kTopView, kFrontView or kRightView for points in a thin layer across z, y or x, else
/// kIsometricView. The thickness of a layer is below 15% of its larger side.
ViewAngles defaultView(std::span<const Vector3> points);

/// Rules for fitting a camera to points.
struct CameraFit {
  ViewAngles view = kIsometricView;         ///< direction of the camera
  double aspect = 16.0 / 9.0;               ///< width / height of the picture
  bool orthographic = false;                ///< else perspective
  double fieldOfView = 0.3490658503988659;  ///< perspective: vertical, radians
  /// Fraction of the picture's width and height left free on each side, [0, 0.45].
  double margin = 0.06;
  double zoom = 1;  ///< enlarges the middle of the picture, > 0; the eye stays
};

/// The camera with this view that shows all points centred and as large as possible. Throws
/// InputError without points. The range of near and far has a margin for bricks that leave the
/// points' range in motion. One pass over the points.
Camera fitCamera(std::span<const Vector3> points, const CameraFit& fit);

/// The camera with this view that shows a whole ball at a size independent of the direction: for
/// rotating cameras. radius: metres, > 0. The whole ball is between near and far.
Camera fitCameraToBall(const Vector3& centre, double radius, const CameraFit& fit);

/// The same camera at another distance from its centre along its view, metres. `distance` > 0. In
/// perspective this changes the size of the picture's middle.
Camera atDistance(const Camera& camera, double distance);

/// The rotation from world axes to picture axes: +x to the right, +y up, +z towards the eye.
Matrix3 pictureFromWorld(const Camera& camera);

/// Distance of a point from the eye along the view, metres.
double distanceAlongView(const Camera& camera, const Vector3& point);

/// Height of the picture at the camera's centre, metres.
double heightAtCentre(const Camera& camera);

/// The brick that contains the point (world axes), if any. Checks all bricks.
std::optional<int> brickAround(const std::vector<brick::Brick>& bricks, const Poses& poses,
                               const Vector3& point);

/// All corners of all bricks at the given poses, world axes: the points for fitCamera (corners at
/// the start and at the target together).
std::vector<Vector3> brickCorners(const std::vector<brick::Brick>& bricks, const Poses& poses);

/// The 4 x 4 matrix from world axes to clip coordinates, for pictures of this aspect
/// (width / height). For column vectors: clip = matrix * (x, y, z, 1).
Eigen::Matrix4d clipFromWorld(const Camera& camera, double aspect);

// ------------------------------------------------------------------------------------------------
// The camera during a run: fixed, in orbit, or by keyframes.

/// The camera at one time.
struct CameraKey {
  double time = 0;  ///< simulated seconds
  ViewAngles view;  ///< azimuth may exceed full turns
  double zoom = 1;  ///< > 0

  bool operator==(const CameraKey&) const = default;
};

/// Requested camera. Angles are radians, times simulated seconds.
struct CameraChoice {
  std::optional<ViewAngles> view;    ///< absent: from above for flat models, else isometric
  std::optional<bool> orthographic;  ///< absent: only along an axis
  double margin = 0.06;              ///< fraction of the picture left free on each side, [0, 0.45]
  double zoom = 1;                   ///< enlarges the middle of the picture, > 0
  std::optional<double> distance;    ///< of the eye from the centre, in the model's unit in an
                                     ///< Appearance and metres in a CameraPath; absent: fitted
  double orbit = 0;                  ///< total rotation of the camera about +z, radians
  std::vector<CameraKey> keys;       ///< ascending in time; if not empty, they replace the view
};

/// Converts the angles of PyBullet's camera, as in PyKirigami, radians. Yaw rotates the eye about
/// +z, 0 is the front; pitch < 0 for an eye above. azimuth = yaw - pi / 2, elevation = -pitch.
ViewAngles viewFromYawPitch(double yaw, double pitch);

/// The camera of every picture of one run.
class CameraPath {
 public:
  /// points: to be kept in view, at least one. aspect: width / height of the pictures. Throws
  /// InputError if there are no points or the keys' times do not ascend.
  CameraPath(const CameraChoice& choice, std::span<const Vector3> points, double aspect);

  /// The camera at a time, simulated seconds, after the fraction `turn` of its orbit, [0, 1].
  /// Before the first and after the last key only the orbit moves it. Fast relative to painting.
  Camera at(double time, double turn) const;

  /// Whether the camera is fixed: all pictures have the same scale and view.
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
