/// How a run leaves a start in balance, and whether bricks that hardly move are at rest.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/deploy/dynamics.h"
#include "sim/model/isometry.h"

namespace kirireel {

// ------------------------------------------------------------------------------------------------
// Whether bricks that hardly move are at rest, or only slow.

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

// ------------------------------------------------------------------------------------------------
// What lets a run leave an unstable equilibrium: small velocities at random. They are an error in
// time for a start that moves by itself, so that only those get them that do not.

/// How much of the nudge a run has been given.
enum class Nudged {
  No,
  InSymmetry,  ///< the part that has the symmetries of the model and the state alone
  Wholly,
};

/// How long bricks have from rest to get faster than a nudge, seconds.
constexpr double kNudgeTime = 1.0 / 240;

/// Small velocities for `count` bricks, turns apart: each component at random within a millionth of
/// the model's size (metres) a second. The same seed gives the same ones everywhere.
std::vector<Velocity> nudge(std::size_t count, double modelSize, unsigned seed);

/// Whether bricks move by what acts on them alone: whether in `after`, which they have come to from
/// rest in kNudgeTime with joints and contacts kept, some brick is faster than a nudge. Joined ones
/// must move against each other: a sheet that is pulled along, yet cannot open, does not move.
/// Sizes in metres.
bool movesByItself(const std::vector<Velocity>& after, bool areJoined, double tileSize,
                   double modelSize);

/// The part of a nudge with the symmetries of `group`, the identity among them, where joints leave
/// some of it, else nothing: a sheet that is closed may open in a way that no symmetry keeps.
/// `dynamics` holds the joints at the state.
std::vector<Velocity> symmetricNudge(const std::vector<Velocity>& whole, const Poses& poses,
                                     std::span<const Symmetry> group, Dynamics& dynamics);

}  // namespace kirireel
