/// Vectors, poses and motions. SI units, right-handed axes, z up, column vectors, radians.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "sim/base/fields.h"

namespace kirireel {

/// A point (metres) or a direction, or three numbers with a stated unit.
using Vector3 = Eigen::Vector3d;
/// A rotation, an inertia or a stiffness.
using Matrix3 = Eigen::Matrix3d;
/// Linear and angular part, one after the other.
using Vector6 = Eigen::Matrix<double, 6, 1>;
/// Matrix in these six coordinates.
using Matrix6 = Eigen::Matrix<double, 6, 6>;
/// Six numbers for each of two bricks, or three for each of four points.
using Vector12 = Eigen::Matrix<double, 12, 1>;
/// Matrix in these twelve coordinates.
using Matrix12 = Eigen::Matrix<double, 12, 12>;
/// A rotation; a unit quaternion in poses.
using Quaternion = Eigen::Quaterniond;

/// One degree in radians.
inline constexpr double kDegree = std::numbers::pi / 180;

/// Tolerance of the length of unit directions and quaternions in files.
inline constexpr double kUnitTolerance = 1e-6;

/// Where two lines that are not parallel are nearest to each other, as multiples of their
/// directions `a` and `b` from their points.
inline std::pair<double, double> nearestOnLines(const Vector3& pointA, const Vector3& a,
                                                const Vector3& pointB, const Vector3& b) {
  const Vector3 across = a.cross(b);
  const Vector3 between = (pointB - pointA) / across.squaredNorm();
  return {between.cross(b).dot(across), between.cross(a).dot(across)};
}

/// The mean of one or more points.
Vector3 meanPoint(std::span<const Vector3> points);

/// The bounding box of points in the plane or in space; empty without points.
template <class Points>
auto boundingBox(const Points& points) {
  Eigen::AlignedBox<double, Points::value_type::SizeAtCompileTime> box;
  for (const auto& point : points) box.extend(point);
  return box;
}

/// Twice the vector area of a polygon: along the normal of anticlockwise corners (Newell's sum). It
/// is relative to the first corner, which keeps the precision of distant polygons.
Vector3 doubledVectorArea(std::span<const Vector3> corners);

/// The point of the segment from `a` to `b` nearest to a point, in the plane or in space. The
/// segment may have no length.
template <class Point>
Point nearestOnSegment(const Point& point, const Point& a, const Point& b) {
  const Point along = b - a;
  const double square = along.squaredNorm();
  return square > 0 ? Point(a + std::clamp((point - a).dot(along) / square, 0.0, 1.0) * along) : a;
}

/// Position and rotation of one brick: a point r in brick axes is at position + rotation * r.
struct Pose {
  Vector3 position = Vector3::Zero();            ///< of the brick's centre of mass, metres
  Quaternion rotation = Quaternion::Identity();  ///< unit, from brick axes to world axes

  /// The world position of a point in the brick's own axes, metres.
  Vector3 apply(const Vector3& point) const { return position + rotation * point; }

  static constexpr auto fields() {
    return describeFields<Pose>(field("position", &Pose::position, "m"),
                                field("rotation", &Pose::rotation));
  }
};

/// The velocity of one brick, in world axes.
struct Velocity {
  Vector3 linear = Vector3::Zero();   ///< of the centre of mass, m/s
  Vector3 angular = Vector3::Zero();  ///< rad/s

  static constexpr auto fields() {
    return describeFields<Velocity>(field("linear", &Velocity::linear, "m/s"),
                                    field("angular", &Velocity::angular, "rad/s"));
  }
};

/// The poses of all bricks at one time, in the order of the model's tiles.
using Poses = std::vector<Pose>;

/// The mean position of one or more bricks, metres.
Vector3 meanPosition(const Poses& poses);

/// The state that a deployment advances: one entry per brick.
struct Motion {
  Poses poses;                       ///< one per brick
  std::vector<Velocity> velocities;  ///< one per brick

  static constexpr auto fields() {
    return describeFields<Motion>(field("poses", &Motion::poses),
                                  field("velocities", &Motion::velocities));
  }
};

/// The rotations as matrices, from brick axes to world axes. They are cheaper than quaternions if a
/// brick has several points.
inline std::vector<Matrix3> rotationMatrices(const Poses& poses) {
  std::vector<Matrix3> matrices;
  matrices.reserve(poses.size());
  for (const Pose& pose : poses) matrices.push_back(pose.rotation.toRotationMatrix());
  return matrices;
}

/// The z component of the cross product of two vectors, from their x and y.
template <class A, class B>
double crossZ(const Eigen::MatrixBase<A>& a, const Eigen::MatrixBase<B>& b) {
  return a[0] * b[1] - a[1] * b[0];
}

/// The matrix [v]x with [v]x w = v x w.
inline Matrix3 crossMatrix(const Vector3& v) {
  Matrix3 matrix;
  matrix << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return matrix;
}

/// Eigenvalues and eigenvectors of a symmetric matrix.
struct SymmetricEigen {
  Eigen::VectorXd values;   ///< ascending
  Eigen::MatrixXd vectors;  ///< one orthonormal column per eigenvalue
};

/// The eigenvalues and eigenvectors of a symmetric matrix. Reads only the lower triangle. Uses QR
/// steps on the tridiagonal form, O(n^3). One function serves all sizes, because the compiler takes
/// seconds per fixed size.
SymmetricEigen eigenOf(const Eigen::MatrixXd& matrix);

/// A symmetric matrix without its negative part: the nearest positive semidefinite matrix, by
/// eigenOf().
Eigen::MatrixXd withoutNegativePart(const Eigen::MatrixXd& matrix);

/// The singular values of a matrix, descending, as many as its shorter side is long. They are the
/// eigenvalues above zero of the matrix [0 A^T; 0 A] (C. Jordan 1874, H. Wielandt). Nothing is
/// squared: the error is the rounding of the largest value. O(n^3), n rows and columns together.
Eigen::VectorXd singularValuesOf(const Eigen::MatrixXd& matrix);

/// The unit quaternion of the rotation vector (axis times angle in radians). The exponential map:
/// exp(v/2) as a quaternion, (cos(a/2), sin(a/2) v / a) with a = |v|.
inline Quaternion rotationFromVector(const Vector3& vector) {
  const double angle = vector.norm();
  // sin(angle / 2) / angle, by its series if the quotient would lose digits.
  const double scale = angle > 1e-4 ? std::sin(0.5 * angle) / angle : 0.5 - angle * angle / 48.0;
  const Vector3 imaginary = scale * vector;
  return Quaternion(std::cos(0.5 * angle), imaginary.x(), imaginary.y(), imaginary.z());
}

/// The rotation vector of the shortest rotation between two rotations, radians, world axes. The
/// logarithm of to * from^-1. For a half turn its sign is arbitrary.
inline Vector3 turnBetween(const Quaternion& from, const Quaternion& to) {
  Quaternion turn = to * from.conjugate();
  if (turn.w() < 0) turn.coeffs() = -turn.coeffs();
  const double sine = turn.vec().norm();
  // 2 atan2(sine, w) / sine, by its limit if the quotient would lose digits.
  return sine < 1e-12 ? Vector3(2 * turn.vec())
                      : Vector3(2 * std::atan2(sine, turn.w()) / sine * turn.vec());
}

/// A pose after a displacement in metres and a rotation by a rotation vector about the pose's
/// position, world axes.
inline Pose displaced(const Pose& pose, const Vector3& move, const Vector3& turn) {
  return {pose.position + move, (rotationFromVector(turn) * pose.rotation).normalized()};
}

/// Interpolates two states at a share in [0, 1]: positions linearly, rotations by the shortest
/// rotation. Both states have the same bricks. Joints that are closed at both ends may open in
/// between.
Poses interpolate(const Poses& from, const Poses& to, double share);

/// The rate of the rotation vector `turn` of a body with this angular velocity: the inverse of the
/// left Jacobian of SO(3) (Barfoot, State Estimation for Robotics, 2017, eq. 7.77).
Vector3 turnRate(const Vector3& turn, const Vector3& angular);

/// Interpolates two motions that are `seconds` apart, at a share in [0, 1], by cubics with the
/// positions, rotations and velocities of both ends. Hermite's cubics: positions and rotation
/// vectors are
///   p(s) = p_0 + (3 s^2 - 2 s^3)(p_1 - p_0) + s (1 - s)^2 h v_0 - s^2 (1 - s) h v_1
/// with s the share and h the seconds.
Poses interpolate(const Motion& from, const Motion& to, double seconds, double share);

}  // namespace kirireel
