/// Which points of a model the eye sees, so that numbers stand on nothing that hides them.
#pragma once

#include <vector>

#include "sim/model/model.h"

namespace kirireel {

/// Tiles seen from far away in one direction. Tiles have no thickness here.
class LineOfSight {
 public:
  /// towardsEye: unit vector, world axes. The tiles are copied.
  LineOfSight(const std::vector<Tile>& tiles, const Vector3& towardsEye);

  /// Whether no other tile stands between the eye and this point of a tile; metres, world axes.
  /// `tile` is the number of the tile that the point belongs to, which never hides it.
  bool isClear(const Vector3& point, std::size_t tile) const;

 private:
  struct Screen {
    std::vector<std::vector<Vector3>> parts;  ///< convex
    Vector3 normal;
    Vector3 middle;
    double radius = 0;  ///< of a ball round the middle that holds the tile, metres
  };

  bool hides(const Screen& screen, const Vector3& point) const;

  std::vector<Screen> screens_;
  Vector3 towardsEye_;
};

}  // namespace kirireel
