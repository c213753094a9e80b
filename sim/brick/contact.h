/// A place where two bricks, or a brick and something fixed, touch or nearly do.
#pragma once

#include "sim/base/geometry.h"

namespace kirireel {

/// Index of "something that does not move" (the ground) in a contact.
inline constexpr int kFixed = -1;

/// One contact point in world axes.
struct Contact {
  int brickA = 0;
  int brickB = kFixed;    ///< or kFixed
  Vector3 pointA;         ///< on brick A
  Vector3 pointB;         ///< on brick B, or on the fixed thing
  Vector3 normal;         ///< unit, from B towards A
  double distance = 0;    ///< (pointA - pointB) . normal; negative where they overlap, metres
  double friction = 0;    ///< Coulomb coefficient of the pair
};

}  // namespace kirireel
