/// Where a face that touches rubs: points that represent an even pressure.
#pragma once

#include <vector>

#include "sim/base/geometry.h"

namespace kirireel::mechanics {

/// A point that carries a share of what pushes a face.
struct RubbingPoint {
  Vector3 point;     ///< metres
  double share = 1;  ///< of the whole push, > 0; the shares of a face add up to 1
};

/// Points for an even pressure on convex polygons in one plane that do not overlap. They have the
/// centroid of the whole, and resist a turn about it just as the pressure does.
/// O(corners): 4 points for each.
std::vector<RubbingPoint> evenPressure(const std::vector<std::vector<Vector3>>& parts);

/// Where a face rubs, whatever the place of its push.
class RubbingRegion {
 public:
  /// Every push acts at a single point.
  RubbingRegion() = default;

  /// The convex hull of points that touch, in a plane across `normal`. Hulls can be points and
  /// lines.
  RubbingRegion(const std::vector<Vector3>& touching, const Vector3& normal);

  /// Points for a push at `centre`. The pressure is even on the hull if `centre` is its centroid.
  /// Else it is even on the hull shrunk about some point, as little as it takes to have its
  /// centroid there.
  std::vector<RubbingPoint> points(const Vector3& centre) const;

 private:
  double scaleFor(const Vector3& centre) const;

  std::vector<Vector3> hull_;  // no corners: a point, two: a line
  Vector3 normal_ = Vector3::Zero();
  Vector3 centroid_ = Vector3::Zero();
  std::vector<RubbingPoint> even_;  // under a push at the centroid
};

}  // namespace kirireel::mechanics
