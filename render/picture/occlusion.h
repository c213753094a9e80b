/// Ambient occlusion: how much of the light that comes from all sides other bricks keep from a
/// face.
#pragma once

#include <span>
#include <vector>

#include "sim/brick/brick.h"

namespace kirireel {

/// Bricks as things that keep light away, one state of a run at a time.
class Occluders {
 public:
  /// faces: of each brick, as brickFaces() has them, at their poses in world axes. Sorts the bricks
  /// once. Bricks without faces are not allowed.
  explicit Occluders(const std::vector<std::vector<std::vector<Vector3>>>& faces);

  /// The part of the light from all sides, as a face receives it, that other bricks keep away: 0 to
  /// 1, the mean of some points of the face. brick: that the face is of; corners: of the face,
  /// world axes; normal: unit, outward. Looks at the bricks whose centres are within the reach
  /// along x; of these few are near.
  double occlusion(int brick, std::span<const Vector3> corners, const Vector3& normal) const;

 private:
  /// A polygon that looks away from its brick.
  struct Wall {
    std::vector<Vector3> corners;
    Vector3 normal;
    double offset = 0;  ///< normal . point for the points of its plane
  };
  /// A brick and the sphere around it.
  struct Occluder {
    int brick = 0;
    Vector3 centre;
    double radius = 0;
    std::vector<Wall> walls;
  };

  double occlusionAt(int brick, const Vector3& point, const Vector3& normal) const;

  std::vector<Occluder> occluders_;  ///< by the x of their centres
  double mostRadius_ = 0;
  double reach_ = 0;  ///< from this distance on bricks keep no light away, metres
};

}  // namespace kirireel
