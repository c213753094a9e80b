/// Whether bricks that hardly move are at rest, or only slow.
#pragma once

#include "sim/deploy/dynamics.h"

namespace kirireel {

/// What was found about a state that hardly moves.
struct RestProbe {
  bool movesOn = false;  ///< given time, a brick would go farther than rounding and noise let it
  double work = 0;       ///< that it cost, see StepReport
};

/// Looks where bricks that hardly move would go, given time: from rest, implicit steps that grow
/// from `step` seconds to months. A step that is long against the bricks' inertia and damping comes
/// near to Newton's method on what pulls them, so that soft springs and heavy bricks take no longer
/// than others. Where no brick goes a thousandth of a tile, the state is at rest.
///
/// `dynamics`: the bricks' solver in its present state, joints, pins and contacts included; it is
/// moved on and not to be used afterwards. `actuation` must pull the bricks to somewhere, else long
/// steps lead nowhere. `tileSize` in metres.
RestProbe probeRest(Dynamics& dynamics, const Motion& motion, double step,
                    const LoadSource& actuation, double tileSize);

/// How far the brick is that moved farthest from one state to another, metres: turns count at a
/// tile's size.
double farthestMove(const Poses& from, const Poses& to, double tileSize);

}  // namespace kirireel
