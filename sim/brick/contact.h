/// A place where a brick may touch another brick or something that does not move.
#pragma once

#include <vector>

#include "sim/base/geometry.h"

namespace kirireel {

/// Index of "something that does not move" (the ground) in a contact.
inline constexpr int kFixed = -1;

/// A point of brick A that may not pass a plane of brick B. Both are kept in their bricks' axes, so
/// that the gap is exact at any later pose, not only where the contact was found.
struct Contact {
  int brickA = 0;
  int brickB = kFixed;  ///< or kFixed
  Vector3 pointA;       ///< on brick A, in its axes
  Vector3 pointB;       ///< on the plane, in the axes of brick B, or of the world
  Vector3 normal;       ///< unit, from B towards A, in the axes of brick B, or of the world
  double friction = 0;  ///< Coulomb coefficient of the pair
  double slack = 0;     ///< overlap that the pair had at the start and may keep, metres
};

/// Signed distance of the point from the plane at the given poses plus the slack, metres; negative
/// where the contact is violated.
inline double contactGap(const Contact& contact, const Poses& poses) {
  const Vector3 point = poses[contact.brickA].apply(contact.pointA);
  if (contact.brickB == kFixed) {
    return contact.normal.dot(point - contact.pointB) + contact.slack;
  }
  const Pose& pose = poses[contact.brickB];
  return (pose.rotation * contact.normal).dot(point - pose.apply(contact.pointB)) + contact.slack;
}

/// Tells a solver what its bricks run into.
class ContactSource {
 public:
  virtual ~ContactSource() = default;

  /// Appends the contacts that a move from `start` to `end` violates. The bricks do not overlap at
  /// `start` beyond rounding (or the overlap they began with). Returns whether any was appended.
  virtual bool appendViolated(const Poses& start, const Poses& end,
                              std::vector<Contact>& contacts) = 0;

  /// Whether a contact that carried load in the last step still is the only thing that keeps its
  /// bricks apart at `poses`, so that the next step may start with it.
  virtual bool isCurrent(const Poses& poses, const Contact& contact) const = 0;
};

}  // namespace kirireel
