/// What watches a run for rest, and how a run leaves a state in balance.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/base/state_tape.h"
#include "sim/deploy/dynamics.h"
#include "sim/deploy/run_motion.h"
#include "sim/model/isometry.h"

namespace kirireel::deploy {

// ------------------------------------------------------------------------------------------------
// Since when nothing moves.

/// The speed of the brick that is fastest, turns counted at a tile's size (metres), m/s.
double fastestSpeed(const std::vector<Velocity>& velocities, double tileSize);

/// Watches the steps of a run for rest: no brick is faster than the scene's settle speed, or steps
/// fail however short they are and no brick gets anywhere.
class RestWatch {
 public:
  /// `bricks` must outlive this.
  explicit RestWatch(const SceneBricks& bricks)
      : bricks_(bricks), needed_(bricks.scene.stop.settleTime) {}

  /// Looks at the last step, `length` seconds long. While tiles are guided or opened (`isOnPath`)
  /// nothing counts as rest.
  void observe(const RunMotion& motion, double length, const StepReport& report, bool isOnPath);
  /// Something begins to act: rest counts from now on.
  void countAnew() { rested_ = 0; }
  /// What looked like rest was none: from now on it has to last twice as long.
  void doubt();

  /// When the run has rested for as long as counts, if nothing moves from `now` on, seconds;
  /// infinity while it does not rest.
  double moment(double now) const;
  /// Whether steps fail, and the bricks have stayed where they were when steps began to.
  bool isStuck(const Poses& poses) const;

  /// Records or plays back.
  void transfer(StateTape& tape) { tape.transfer(rested_, needed_, jamStart_); }

 private:
  double restWithinStep(const RunMotion& motion, double length, double limit) const;

  const SceneBricks& bricks_;
  double rested_ = 0;  // seconds up to the end of the last step
  double needed_;      // seconds that count
  Poses jamStart_;     // where steps began to fail; empty while they do not
};

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
                    const mechanics::LoadSource& actuation, double tileSize);

/// How far the brick is that moved farthest from one state to another, metres: turns count at a
/// tile's size.
double farthestMove(const Poses& from, const Poses& to, double tileSize);

// ------------------------------------------------------------------------------------------------
// What lets a run leave an unstable equilibrium: small velocities at random. They are an error in
// time for a start that moves by itself, so that only those get them that do not.

/// How much of the nudge a run has been given.
enum class Nudged {
  No,          ///< none does
  InSymmetry,  ///< the part that has the symmetries of the model and the state alone
  Wholly,      ///< all bricks stand still
};

/// How long bricks have from rest to get faster than a nudge, seconds.
constexpr double kNudgeTime = 1.0 / 240;

/// Small velocities for `count` bricks, turns apart: each component at random within a millionth of
/// the model's size (metres) a second. The same seed gives the same ones everywhere.
std::vector<Velocity> nudge(std::size_t count, double modelSize, unsigned seed);

/// Whether bricks move by what acts on them alone: whether in `after`, which they have come to from
/// rest in kNudgeTime with joints and contacts kept, some brick is faster than a nudge. If they are
/// `drivenApart`, by a drive or by springs between joined bricks, they must move against each
/// other: a sheet that is pulled along, yet cannot open, does not move. Sizes in metres.
bool movesByItself(const std::vector<Velocity>& after, bool drivenApart, double tileSize,
                   double modelSize);

/// The part of a nudge with the symmetries of `group`, the identity among them, where joints leave
/// some of it, else nothing: a sheet that is closed may open in a way that no symmetry keeps.
/// `dynamics` holds the joints at the state.
std::vector<Velocity> symmetricNudge(const std::vector<Velocity>& whole, const Poses& poses,
                                     std::span<const model::Symmetry> group, Dynamics& dynamics);

/// What a run has been given to leave states in balance, and gives it.
class NudgeGiver {
 public:
  /// `bricks` must outlive this.
  explicit NudgeGiver(const SceneBricks& bricks) : bricks_(bricks) {}

  /// Gives the bricks, which stand still, what they need to leave this start: nothing where `loads`
  /// move them by themselves. An engine's start is not known to its end, and it gets the whole
  /// nudge. `joints` are as the run's; `pinned` has one entry a brick.
  void giveAtStart(RunMotion& motion, const mechanics::LoadSource& loads, const JointFit& joints,
                   const std::vector<bool>& pinned);
  /// Gives a whole nudge to bricks that came to rest: a motion may come to an equilibrium that is
  /// not stable, as a start may be one.
  void giveAtRest(RunMotion& motion);

  /// Whether there is anything left to give.
  bool canGive() const { return given_ != Nudged::Wholly; }
  /// Another target makes other equilibria: all may be given again.
  void beginAnew() { given_ = Nudged::No; }

  /// Records or plays back.
  void transfer(StateTape& tape) { tape.transfer(given_); }

 private:
  std::vector<Velocity> whole() const;
  bool areDrivenApart() const;

  const SceneBricks& bricks_;
  Nudged given_ = Nudged::No;
};

}  // namespace kirireel::deploy
