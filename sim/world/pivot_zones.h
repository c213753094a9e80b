/// Where joints rule: contacts there would fight them.
#pragma once

#include <map>
#include <span>
#include <utility>
#include <vector>

#include "sim/brick/brick.h"

namespace kirireel {

/// The neighbourhoods of shared pivots and hinge lines. Two bricks that turn about a common corner
/// always touch there, and rounded hulls a little beside it; a contact would pry the joint open.
class PivotZones {
 public:
  /// Links, whose corners are apart, have no zone.
  PivotZones(const std::vector<Brick>& bricks, std::span<const Pivot> pivots);

  /// Whether a contact point of two bricks, given in world axes, lies within max(4 margins, 0.05
  /// mean edges) of a pivot that these two share, or of the line between both pivots of a hinge.
  bool contains(int brickA, int brickB, const Poses& poses, const Vector3& point) const;

 private:
  struct Zone {
    Vector3 from;  ///< in the axes of the pair's first brick
    Vector3 to;    ///< the hinge's other pivot, or `from` again
    double radius = 0;
    int joint = 0;
  };

  void add(const std::vector<Brick>& bricks, const Pivot& pivot);

  std::map<std::pair<int, int>, std::vector<Zone>> zones_;  // keys: lower brick index first
};

}  // namespace kirireel
