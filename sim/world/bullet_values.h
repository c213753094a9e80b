/// Our values as Bullet's and back. For the files of this module alone.
#pragma once

#include <Eigen/Eigenvalues>
#include <LinearMath/btQuaternion.h>
#include <LinearMath/btVector3.h>

#include "sim/base/geometry.h"
#include "sim/model/brick.h"

namespace kirireel {

// Debian ships Bullet in both precisions; mixed, it compiles and corrupts memory.
static_assert(sizeof(btScalar) == sizeof(double), "Bullet must be built in double precision");

/// A vector in Bullet's type; metres stay metres.
inline btVector3 toBullet(const Vector3& v) {
  return {v.x(), v.y(), v.z()};
}

/// A vector of Bullet's in ours.
inline Vector3 fromBullet(const btVector3& v) {
  return {v.x(), v.y(), v.z()};
}

/// A rotation in Bullet's type.
inline btQuaternion toBullet(const Quaternion& q) {
  return {q.x(), q.y(), q.z(), q.w()};
}

/// A rotation of Bullet's in ours.
inline Quaternion fromBullet(const btQuaternion& q) {
  return Quaternion(q.w(), q.x(), q.y(), q.z()).normalized();
}

/// Bullet wants diagonal inertias, so a body's axes are its brick's principal axes.
struct PrincipalAxes {
  Quaternion rotation;  ///< from principal axes to brick axes
  Vector3 inertia;      ///< about the principal axes
};

/// The principal axes of a brick, right-handed.
inline PrincipalAxes principalAxes(const Brick& brick) {
  /// Eigenvectors are orthonormal but may be left-handed, which no rotation is.
  const Eigen::SelfAdjointEigenSolver<Matrix3> solver(brick.inertia);
  Matrix3 axes = solver.eigenvectors();
  if (axes.determinant() < 0) axes.col(2) = -axes.col(2);
  return {Quaternion(axes).normalized(), solver.eigenvalues()};
}

}  // namespace kirireel
