/// Detection of rest, and perturbations that leave an equilibrium.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/base/state_tape.h"
#include "sim/model/isometry.h"
#include "sim/run/dynamics.h"
#include "sim/run/run_motion.h"

namespace kirireel::run {

// ------------------------------------------------------------------------------------------------
// Detection of rest.

/// The speed of the fastest corner of a brick, m/s.
double fastestCorner(const std::vector<brick::Brick>& bricks, const Motion& motion);

/// Detects rest: no corner is faster than the scene's settle speed for the scene's settle time. A
/// run also rests if its steps keep failing and no brick moves.
class RestWatch {
 public:
  /// Keeps a reference to `bricks`.
  explicit RestWatch(const SceneBricks& bricks)
      : bricks_(bricks), needed_(bricks.scene.stop.settleTime) {}

  /// Checks the last step, `length` seconds long. While tiles are guided or opened (`isOnPath`), a
  /// run is never at rest.
  void observe(const RunMotion& motion, double length, const StepReport& report, bool isOnPath);
  /// Restarts the rest time, because something new acts.
  void restartCount() { rested_ = 0; }
  /// Doubles the required rest time after a false detection.
  void doubleRestTime();

  /// Time at which the required rest time is complete if nothing moves after `now`, seconds.
  /// Infinity while the run is not at rest.
  double moment(double now) const;
  /// Whether steps fail, and the bricks have hardly moved since steps began to fail.
  bool isStuck(const Poses& poses) const;

  void transfer(StateTape& tape) { tape.transfer(rested_, needed_, jamStart_); }

 private:
  double restWithinStep(const RunMotion& motion, double length, double limit) const;

  const SceneBricks& bricks_;
  double rested_ = 0;  // rest time at the end of the last step, seconds
  double needed_;      // required rest time, seconds
  Poses jamStart_;     // poses when steps began to fail; empty if they do not fail
};

// ------------------------------------------------------------------------------------------------
// Distinguishes rest from slow motion.

/// Result of probeRest().
struct RestProbe {
  bool movesOn = false;  ///< in the long run a brick would move farther than rounding and noise
  double work = 0;       ///< cost of the probe, see StepReport
  Poses poses;           ///< after the longest step
  /// Whether they are an equilibrium: all steps succeeded, and the last one moved no brick.
  bool isConverged = false;
};

/// Finds out where almost resting bricks would move in the long run. It takes implicit steps from
/// rest, whose length grows from `step` seconds to months. A step that is long against inertia and
/// damping approximates Newton's method on the acting forces. Soft springs and heavy bricks
/// therefore need no more steps. If no brick moves a thousandth of a tile, the state is at rest.
///
/// `dynamics`: the bricks' solver in its current state, with joints, pins and contacts. It is
/// changed and must not be used afterwards. `actuation` must have an equilibrium, otherwise long
/// steps are meaningless. `tileSize` in metres.
RestProbe probeRest(Dynamics& dynamics, const Motion& motion, double step,
                    const mechanics::LoadSource& actuation, double tileSize);

/// The largest displacement of a brick between two states, metres. Rotations count at the radius
/// `tileSize`.
double farthestMove(const Poses& from, const Poses& to, double tileSize);

// ------------------------------------------------------------------------------------------------
// A perturbation leaves an unstable equilibrium by small random velocities. For a start that moves
// by itself it would be an error in time. Such starts get no perturbation.

/// The part of the perturbation that a run has received.
enum class Perturbed {
  No,          ///< nothing
  InSymmetry,  ///< only the part with the symmetries of the model and the state
  Wholly,      ///< the whole perturbation
};

/// Time in which bricks must become faster than a perturbation from rest, seconds.
constexpr double kPerturbationTime = 1.0 / 240;

/// Random velocities for bricks at these poses, without rotations. Each component along a brick's
/// first side, across it and along its normal is within a millionth of the model's size (metres)
/// per second, so velocities rotate with the model. The same seed gives the same result on all
/// machines.
std::vector<Velocity> perturbation(const std::vector<brick::Brick>& bricks, const Poses& poses,
                                   double modelSize, unsigned seed);

/// Whether the acting forces move the bricks. `after` is the motion at kPerturbationTime after
/// rest, with joints and contacts. Some corner must be faster than a perturbation. If bricks are
/// `drivenApart`, by a drive or by springs between them, the motion must be relative: a sheet that
/// is pulled along, but cannot open, does not count. Sizes in metres.
bool movesByItself(const std::vector<brick::Brick>& bricks, const Motion& after, bool drivenApart,
                   double tileSize, double modelSize);

/// The part of a perturbation with the symmetries of `group`, which includes the identity. Empty if
/// joints leave almost none of it: a closed sheet may open only in a motion without symmetry.
/// `dynamics` holds the joints at the state.
std::vector<Velocity> symmetricPerturbation(const std::vector<Velocity>& whole, const Poses& poses,
                                            std::span<const model::Symmetry> group,
                                            Dynamics& dynamics);

/// Gives perturbations to a run and records them.
class Perturber {
 public:
  /// Keeps a reference to `bricks`.
  explicit Perturber(const SceneBricks& bricks) : bricks_(bricks) {}

  /// Gives a perturbation to bricks at rest at the start, unless `loads` move them. The start of an
  /// engine's run cannot be tested and always gets the whole perturbation. `joints` are those of
  /// the run; `pinned` has one entry per brick.
  void giveAtStart(RunMotion& motion, const mechanics::LoadSource& loads, const JointFit& joints,
                   const std::vector<bool>& pinned);
  /// Gives a whole perturbation to bricks that came to rest: the equilibrium after a motion may be
  /// unstable too.
  void giveAtRest(RunMotion& motion);

  /// Whether a perturbation remains.
  bool canGive() const { return given_ != Perturbed::Wholly; }
  /// Allows all perturbations again, because another target has other equilibria.
  void reset() { given_ = Perturbed::No; }

  void transfer(StateTape& tape) { tape.transfer(given_); }

 private:
  std::vector<Velocity> whole(const Poses& poses) const;
  bool areDrivenApart() const;

  const SceneBricks& bricks_;
  Perturbed given_ = Perturbed::No;
};

}  // namespace kirireel::run
