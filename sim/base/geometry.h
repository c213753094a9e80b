/// Vectors, poses and motions. SI units, right-handed axes, z up, column vectors, radians.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace kirireel {

/// A point (metres) or a direction, or three numbers of any unit that is said.
using Vector3 = Eigen::Vector3d;
/// A rotation, an inertia or a stiffness.
using Matrix3 = Eigen::Matrix3d;
/// Linear and angular part, one after the other.
using Vector6 = Eigen::Matrix<double, 6, 1>;
/// By the same six.
using Matrix6 = Eigen::Matrix<double, 6, 6>;
/// Six numbers of each of two bricks, or three of each of four points.
using Vector12 = Eigen::Matrix<double, 12, 1>;
/// By the same twelve.
using Matrix12 = Eigen::Matrix<double, 12, 12>;
/// A rotation; unit wherever it is one of a pose.
using Quaternion = Eigen::Quaterniond;

/// One degree in radians.
inline constexpr double kDegree = std::numbers::pi / 180;

/// How far the length of a direction or quaternion that a file holds may be from 1.
inline constexpr double kUnitTolerance = 1e-6;

/// The mean of one or more points.
inline Vector3 meanPoint(const std::vector<Vector3>& points) {
  Vector3 sum = Vector3::Zero();
  for (const Vector3& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

/// Position and rotation of one brick: a point r in brick axes stands at position + rotation * r.
struct Pose {
  Vector3 position = Vector3::Zero();            ///< of the brick's centre of mass, metres
  Quaternion rotation = Quaternion::Identity();  ///< unit, from brick axes to world axes

  /// Where a point of the brick's own axes stands in the world, metres.
  Vector3 apply(const Vector3& point) const { return position + rotation * point; }
};

/// How one brick moves, in world axes.
struct Velocity {
  Vector3 linear = Vector3::Zero();   ///< of the centre of mass, m/s
  Vector3 angular = Vector3::Zero();  ///< rad/s
};

/// The poses of all bricks at one time, in the order of the model's tiles.
using Poses = std::vector<Pose>;

/// The state that a deployment advances: one entry a brick.
struct Motion {
  Poses poses;                       ///< one a brick
  std::vector<Velocity> velocities;  ///< one a brick
};

/// The rotations as matrices, brick axes to world axes: cheaper than quaternions where a brick has
/// several points.
inline std::vector<Matrix3> rotationMatrices(const Poses& poses) {
  std::vector<Matrix3> matrices;
  matrices.reserve(poses.size());
  for (const Pose& pose : poses) matrices.push_back(pose.rotation.toRotationMatrix());
  return matrices;
}

/// The matrix [v]x with [v]x w = v x w.
inline Matrix3 crossMatrix(const Vector3& v) {
  Matrix3 matrix;
  matrix << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return matrix;
}

/// The unit quaternion of the rotation vector (axis times angle in radians).
/// The exponential map: exp(v/2) as a quaternion, (cos(a/2), sin(a/2) v / a) with a = |v|.
inline Quaternion rotationFromVector(const Vector3& vector) {
  const double angle = vector.norm();
  // sin(angle / 2) / angle, by its series where the quotient would lose digits.
  const double scale = angle > 1e-4 ? std::sin(0.5 * angle) / angle : 0.5 - angle * angle / 48.0;
  const Vector3 imaginary = scale * vector;
  return Quaternion(std::cos(0.5 * angle), imaginary.x(), imaginary.y(), imaginary.z());
}

/// The rotation vector of the shortest turn from one rotation to another, radians, world axes.
/// The logarithm of to * from^-1. At a half turn its direction is one of two.
inline Vector3 turnBetween(const Quaternion& from, const Quaternion& to) {
  Quaternion turn = to * from.conjugate();
  if (turn.w() < 0) turn.coeffs() = -turn.coeffs();
  const double sine = turn.vec().norm();
  // 2 atan2(sine, w) / sine, by its limit where the quotient would lose digits.
  return sine < 1e-12 ? Vector3(2 * turn.vec())
                      : Vector3(2 * std::atan2(sine, turn.w()) / sine * turn.vec());
}

/// A pose after a move in metres and a turn by a rotation vector about the pose's position, world
/// axes.
inline Pose displaced(const Pose& pose, const Vector3& move, const Vector3& turn) {
  return {pose.position + move, (rotationFromVector(turn) * pose.rotation).normalized()};
}

/// Poses on the way from one state to another, at a share from 0 to 1: positions go straight,
/// rotations by the shortest turn.
/// Both states have the same bricks. Joints that are closed at both ends may open on the way.
inline Poses interpolate(const Poses& from, const Poses& to, double share) {
  Poses poses(from.size());
  for (std::size_t i = 0; i < from.size(); ++i) {
    poses[i].position = from[i].position + share * (to[i].position - from[i].position);
    poses[i].rotation = from[i].rotation.slerp(share, to[i].rotation);
  }
  return poses;
}

/// The rate at which the rotation vector of a turn changes while what was turned has an angular
/// velocity: the inverse of the left Jacobian of SO(3) (Barfoot, State Estimation for Robotics,
/// 2017, eq. 7.77).
inline Vector3 turnRate(const Vector3& turn, const Vector3& angular) {
  const double angle = turn.norm();
  const double half = 0.5 * angle;
  // (1 - half cot(half)) / angle^2, by its limit where the quotient would lose digits.
  const double part =
      angle < 1e-3 ? 1.0 / 12 : (1 - half * std::cos(half) / std::sin(half)) / (angle * angle);
  return angular - 0.5 * turn.cross(angular) + part * turn.cross(turn.cross(angular));
}

/// Poses on the way between two motions that are `seconds` apart, at a share from 0 to 1: cubics
/// that have the places, turns and velocities of both ends.
/// Hermite's cubics: positions and rotation vectors p(s) = p_0 + (3 s^2 - 2 s^3)(p_1 - p_0) + s (1
/// - s)^2 h v_0 - s^2 (1 - s) h v_1, with s the share and h the seconds.
inline Poses interpolate(const Motion& from, const Motion& to, double seconds, double share) {
  const double rest = 1 - share;
  const double begin = seconds * share * rest * rest;
  const double end = -seconds * share * share * rest;
  const double way = share * share * (3 - 2 * share);
  Poses poses(from.poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Pose& first = from.poses[i];
    const Pose& last = to.poses[i];
    poses[i].position = first.position + way * (last.position - first.position) +
                        begin * from.velocities[i].linear + end * to.velocities[i].linear;
    const Vector3 turn = turnBetween(first.rotation, last.rotation);
    const Vector3 turned = way * turn + begin * from.velocities[i].angular +
                           end * turnRate(turn, to.velocities[i].angular);
    poses[i].rotation = (rotationFromVector(turned) * first.rotation).normalized();
  }
  return poses;
}

}  // namespace kirireel
