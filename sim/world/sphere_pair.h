/// A brick and a sphere that stays: where the two meet.
#pragma once

#include <vector>

#include "sim/brick/brick.h"
#include "sim/brick/contact.h"

namespace kirireel {

/// The point of a brick's surface that is nearest to another point.
struct NearestPoint {
  Vector3 point;         ///< in brick axes
  Vector3 away;          ///< unit, from there to the other point; a face's normal on a face
  double distance = 0;   ///< metres, negative within the brick
  bool isOnFace = true;  ///< else on an edge or a corner
};

/// `faces`: of a convex brick, outward, see brickFaces. `to`: in brick axes.
/// Costs a look at every face, O(corners).
NearestPoint nearestPoint(const std::vector<std::vector<Vector3>>& faces, const Vector3& to);

/// Finds contacts at the surface's nearest points: a face of the brick keeps off the sphere's point
/// there, a corner or a point of an edge off the plane that touches the sphere there. They turn
/// with the bricks, so every step finds them anew.
class SpherePair {
 public:
  /// Numbers of the brick and of the body that stands for the sphere, whose origin is the centre.
  /// `tolerance`: overlap in metres that counts as none.
  SpherePair(int brick, int sphere, const Brick& shape, double radius, double tolerance);

  int brick() const { return brick_; }
  int sphere() const { return sphere_; }

  /// How deep the sphere reaches into the brick at this pose, metres, from 0.
  double overlap(const Pose& brick, const Vector3& centre) const;

  /// Appends the contact of the feature that was nearest at the start, then, when asked again in
  /// the same step, of the one that is nearest at the end. Returns the overlap at the end.
  double appendViolated(const Pose& start, const Pose& end, const Vector3& centre, long step,
                        std::vector<Contact>& contacts);

 private:
  NearestPoint nearest(const Pose& brick, const Vector3& centre) const;
  Contact contactAt(const Pose& brick, const Vector3& centre) const;

  int brick_, sphere_;
  std::vector<std::vector<Vector3>> faces_;
  double radius_;
  double tolerance_;
  std::vector<Contact> given_;  // in this step
  long givenStep_ = -1;
};

}  // namespace kirireel
