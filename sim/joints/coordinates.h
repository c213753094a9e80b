/// The degrees of freedom of one brick: six in space, three in the plane.
#pragma once

#include "sim/base/geometry.h"

namespace kirireel {

/// D = 6: translation and rotation vector. D = 3: x, y and the turn about z.
/// The solver is written once for both; D decides at compile time. Vectors of all bricks hold D
/// numbers a brick, brick by brick: metres (or m/s) first, then radians (or rad/s).
template <int D>
struct Coordinates {
  static_assert(D == 3 || D == 6);
  static constexpr int kJointRows = D == 6 ? 3 : 2;  ///< a pivot is closed by this many rows

  using Vector = Eigen::Matrix<double, D, 1>;
  using Block = Eigen::Matrix<double, D, D>;
  using Rows = Eigen::Matrix<double, kJointRows, D>;
  using RowVector = Eigen::Matrix<double, 1, D>;
  using Gap = Eigen::Matrix<double, kJointRows, 1>;

  /// Whether coordinate k of a brick is a turn.
  static constexpr bool isTurn(int k) { return D == 6 ? k >= 3 : k == 2; }

  /// A force and torque, or a velocity, in these coordinates: what points out of the plane is
  /// dropped for D = 3.
  static Vector restrict(const Vector6& v) {
    if constexpr (D == 6)
      return v;
    else
      return {v[0], v[1], v[5]};
  }

  /// The same for a matrix: rows and columns 0, 1 and 5.
  static Block restrict(const Matrix6& m) {
    if constexpr (D == 6) {
      return m;
    } else {
      Block block;
      block << m(0, 0), m(0, 1), m(0, 5), m(1, 0), m(1, 1), m(1, 5), m(5, 0), m(5, 1), m(5, 5);
      return block;
    }
  }

  /// Inertia of a brick in world axes: its mass, its inertia about the centre of mass in its own
  /// axes, and their rotation.
  static Block inertia(double mass, const Matrix3& ownInertia, const Matrix3& rotation) {
    Block block = Block::Zero();
    if constexpr (D == 6) {
      block.template topLeftCorner<3, 3>().diagonal().setConstant(mass);
      block.template bottomRightCorner<3, 3>() = rotation * ownInertia * rotation.transpose();
    } else {
      block.diagonal() << mass, mass, rotation.row(2).dot(ownInertia * rotation.row(2).transpose());
    }
    return block;
  }

  /// Velocity of a point with arm r (world axes) from the centre of mass, by the brick's velocity.
  static Rows pointVelocity(const Vector3& r) {
    Rows rows;
    if constexpr (D == 6) {
      rows << Matrix3::Identity(), -crossMatrix(r);
    } else {
      rows << 1, 0, -r.y(), 0, 1, r.x();
    }
    return rows;
  }

  /// Velocity of that point along a direction.
  static RowVector pointVelocity(const Vector3& r, const Vector3& direction) {
    const Vector3 turning = r.cross(direction);
    RowVector row;
    if constexpr (D == 6) {
      row << direction.transpose(), turning.transpose();
    } else {
      row << direction.x(), direction.y(), turning.z();
    }
    return row;
  }

  /// The row that takes the angular velocity along a vector.
  static RowVector turning(const Vector3& vector) {
    RowVector row = RowVector::Zero();
    if constexpr (D == 6) {
      row.template tail<3>() = vector.transpose();
    } else {
      row[2] = vector.z();
    }
    return row;
  }

  /// The part of a difference of two points that joint rows see, metres.
  static Gap gap(const Vector3& difference) { return difference.head<kJointRows>(); }

  /// Of one brick; what is out of the plane is dropped for D = 3.
  static Vector pack(const Velocity& velocity) {
    if constexpr (D == 6) {
      Vector packed;
      packed << velocity.linear, velocity.angular;
      return packed;
    } else {
      return {velocity.linear.x(), velocity.linear.y(), velocity.angular.z()};
    }
  }

  static Velocity unpack(const Vector& packed) {
    if constexpr (D == 6) {
      return {packed.template head<3>(), packed.template tail<3>()};
    } else {
      return {Vector3(packed[0], packed[1], 0), Vector3(0, 0, packed[2])};
    }
  }

  /// Moves a pose by a displacement in these coordinates.
  static void displace(Pose& pose, const Vector& displacement) {
    const Velocity move = unpack(displacement);
    pose.position += move.linear;
    pose.rotation = (turnBy(move.angular) * pose.rotation).normalized();
  }

 private:
  /// The rotation by this vector. Most turns are tiny, where the series has all digits.
  static Quaternion turnBy(const Vector3& vector) {
    constexpr double kTiny = 1e-4;
    const double square = vector.squaredNorm();
    if (square > kTiny * kTiny) return rotationFromVector(vector);
    const Vector3 imaginary = (0.5 - square / 48) * vector;
    return {1 - square / 8, imaginary.x(), imaginary.y(), imaginary.z()};
  }
};

}  // namespace kirireel
