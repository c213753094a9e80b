/// Friction on a touching face, by points that represent an even pressure.
#pragma once

#include <vector>

#include "sim/base/geometry.h"

namespace kirireel::mechanics {

/// A point that carries a share of a face's normal force.
struct FrictionPoint {
  Vector3 point;     ///< metres
  double share = 1;  ///< of the normal force, > 0; the shares of a face add up to 1
};

/// Points for an even pressure on convex polygons in one plane that do not overlap. They have the
/// centroid of the whole, and resist a turn about it just as the pressure does. O(corners): 4
/// points for each, 6 in slender parts.
std::vector<FrictionPoint> evenPressure(const std::vector<std::vector<Vector3>>& parts);

/// The region of a face with friction, for any position of its normal force.
class FrictionRegion {
 public:
  /// A region in which every force acts at a single point.
  FrictionRegion() = default;

  /// The convex hull of points that touch, in a plane across `normal`. Hulls can be points and
  /// lines.
  FrictionRegion(const std::vector<Vector3>& touching, const Vector3& normal);

  /// Points for a normal force at `centre`. The pressure is even on the hull if `centre` is its
  /// centroid. Otherwise it is even on the hull scaled about some point, with the largest
  /// scale <= 1 that moves its centroid to `centre`.
  std::vector<FrictionPoint> points(const Vector3& centre) const;

 private:
  double scaleFor(const Vector3& centre) const;

  std::vector<Vector3> hull_;  // no corners: a point, two: a line
  Vector3 normal_ = Vector3::Zero();
  Vector3 centroid_ = Vector3::Zero();
  std::vector<FrictionPoint> even_;  // for a force at the centroid
};

}  // namespace kirireel::mechanics
