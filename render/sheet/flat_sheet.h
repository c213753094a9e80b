/// The start of a planar model in its own plane, and the gaps beside its joints.
#pragma once

#include <compare>
#include <vector>

#include <Eigen/Core>

#include "sim/model/model.h"

namespace kirireel {

using Vector2 = Eigen::Vector2d;

/// A gap narrower than this counts as closed, radians.
inline constexpr double kClosedAngle = 1e-6;

/// A tile seen from the side that it faces: anticlockwise.
using FlatTile = std::vector<Vector2>;

/// A planar start. A point of the plane stands at turn^-1 (x, y, height) in the world.
struct FlatSheet {
  std::vector<FlatTile> tiles;
  Quaternion turn = Quaternion::Identity();  ///< from the world to the plane's axes
  double height = 0;                         ///< of the plane above the turned origin, metres
};

/// Throws InputError for a start that is not flat or has tiles on both faces. Vertices keep their
/// order and number.
FlatSheet flatSheet(const Model& model);

/// Throws InputError for a joint, of this number, that does not hold two corners together.
void requirePivot(const Joint& joint, std::size_t number);

/// The end of an edge of a tile: edge k runs from vertex k to the next.
struct EdgeEnd {
  int tile = 0;
  int edge = 0;
  bool atStart = false;

  auto operator<=>(const EdgeEnd&) const = default;
};

/// The gap between two tiles at a corner that they share, anticlockwise from the first's edge to
/// the second's.
struct CornerGap {
  EdgeEnd first;     ///< the end of the edge that arrives at the corner
  EdgeEnd second;    ///< the start of the edge that leaves it
  double angle = 0;  ///< radians, 0 when closed
};

/// The narrower of the two gaps between the tiles of a pivot. The first where both are equal.
CornerGap narrowGap(const std::vector<FlatTile>& tiles, const Joint& joint);

/// The direction from the given end into its edge. A unit vector.
Vector2 directionFrom(const std::vector<FlatTile>& tiles, const EdgeEnd& end);

}  // namespace kirireel
