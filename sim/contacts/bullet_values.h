/// Converts our types to Bullet's and back. Only for the files that include Bullet.
#pragma once

#include <LinearMath/btQuaternion.h>
#include <LinearMath/btVector3.h>

#include "sim/base/geometry.h"

namespace kirireel::contacts {

// Debian ships Bullet in both precisions; mixed, it compiles and corrupts memory.
static_assert(sizeof(btScalar) == sizeof(double), "Bullet must be built in double precision");

/// Converts a vector; metres stay metres.
inline btVector3 toBullet(const Vector3& v) {
  return {v.x(), v.y(), v.z()};
}

/// Converts a vector back.
inline Vector3 fromBullet(const btVector3& v) {
  return {v.x(), v.y(), v.z()};
}

/// Converts a rotation.
inline btQuaternion toBullet(const Quaternion& q) {
  return {q.x(), q.y(), q.z(), q.w()};
}

/// Converts a rotation back; the result is a unit quaternion.
inline Quaternion fromBullet(const btQuaternion& q) {
  return Quaternion(q.w(), q.x(), q.y(), q.z()).normalized();
}

}  // namespace kirireel::contacts
