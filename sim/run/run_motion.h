/// Motion of the bricks of a run: time steps, the solver, states within a step and the exactness of
/// joints.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/base/state_tape.h"
#include "sim/brick/brick.h"
#include "sim/run/dynamics.h"
#include "sim/run/run_figures.h"
#include "sim/scene/scene.h"
#include "sim/scene/scene_parts.h"

namespace kirireel::run {

// ------------------------------------------------------------------------------------------------
// Constant data of a run.

/// The bricks of a scene, their joints, and derived quantities.
struct SceneBricks {
  /// Keeps a reference to the scene, whose path must be chosen (not Auto). Throws InputError for
  /// invalid pair forces and for needs that the scene cannot satisfy.
  explicit SceneBricks(const scene::Scene& given);

  const scene::Scene& scene;         ///< the scene of the run
  std::vector<brick::Brick> bricks;  ///< one per tile
  std::vector<brick::Pivot> pivots;  ///< of all joints
  scene::Ties
      ties;  ///< exact pivots, ligaments that replace the other pivots, and other pair forces
  scene::Needs needs;   ///< modelled features
  double size = 0;      ///< of the model, metres
  double tileSize = 0;  ///< metres
};

// ------------------------------------------------------------------------------------------------
// Time steps.

/// The time of a run, with checks at equal intervals: one timestep, or several if steps keep a
/// tolerance in time. A step ends at the next check or a due time. Checks are counted: times do not
/// accumulate rounding errors.
class StepClock {
 public:
  /// `checkInterval`: seconds, > 0.
  explicit StepClock(double checkInterval)
      : checkInterval_(checkInterval), length_(checkInterval) {}

  /// End of the last step, seconds since the start.
  double time() const { return static_cast<double>(checks_) * checkInterval_ + sinceCheck_; }
  /// Interval between two checks, seconds.
  double checkInterval() const { return checkInterval_; }
  /// Length of the current or last step, seconds.
  double length() const { return length_; }

  /// Whether a time is past or present, up to rounding.
  bool isDue(double moment) const { return moment <= time() + kSameTime * checkInterval_; }
  /// Whether a time is present or in the future, up to rounding.
  bool isAhead(double moment) const { return moment >= time() - kSameTime * checkInterval_; }

  /// Sets the length of the next step: to `due` or to the next check, whichever is earlier.
  void beginStep(double due);
  /// Advances the time by the step.
  void endStep();

  void transfer(StateTape& tape) { tape.transfer(checks_, sinceCheck_, length_); }

 private:
  /// Times closer than this fraction of an interval are equal.
  static constexpr double kSameTime = 1e-6;

  double checkInterval_;
  double length_;
  long checks_ = 0;        // number of checks, including pauses
  double sinceCheck_ = 0;  // seconds
};

// ------------------------------------------------------------------------------------------------
// Bricks in motion.

/// Data of one step for the energy account.
struct StepSpan {
  double time = 0;     ///< its start, seconds
  double seconds = 0;  ///< its length, seconds
  const Motion& from;  ///< the state at its start
  const Motion& to;    ///< the state at its end
  std::span<const mechanics::PassedState>
      passed;                ///< intermediate states, if springs move within the step
  bool springsMove = false;  ///< false: springs keep their state at the start
  double damped = 0;         ///< joules, see StepReport
  double impacted = 0;       ///< joules, see StepReport
};

/// The bricks at the end of the last step, the solver that moves them, and the states within that
/// step.
class RunMotion {
 public:
  /// The bricks start at the model's poses. Keeps references to both. Throws InputError if the
  /// solver does not support the scene.
  RunMotion(const SceneBricks& bricks, const StepClock& clock);

  /// Interval between two checks of a scene's run, seconds.
  static double checkIntervalOf(const scene::Scene& scene);

  /// The current state: one pose and one velocity per brick.
  Motion& now() { return now_; }
  /// The current state, read only.
  const Motion& now() const { return now_; }
  /// The current poses.
  const Poses& poses() const { return now_.poses; }
  /// The poses at the start of the run.
  const Poses& start() const { return start_; }
  /// The solver that takes the steps.
  Dynamics& solver() { return *solver_; }
  /// The solver, read only.
  const Dynamics& solver() const { return *solver_; }
  /// A new solver for the same bricks, as at the start of a run.
  std::unique_ptr<Dynamics> makeSolver() const;
  /// A second solver in the same state as the run's.
  std::unique_ptr<Dynamics> copyOfSolver();

  /// Contacts now allow at most the overlaps of this state. Joints must be closed.
  void beginContactsHere();
  /// Makes the current state the start.
  void beginHere();
  /// Restores the start, at rest, with a new solver.
  void goBack();

  /// Stores the current state as the start of the next step.
  void beginStep();
  /// Moves the bricks by one step. If `isToTolerance`, keeps the scene's tolerance in time, which
  /// requires exact joints, see wantsTolerance(). Otherwise uses fixed steps.
  StepReport advance(const mechanics::TimedLoads& loads, bool isToTolerance);
  /// Restores the state from the start of the step.
  void takeBack() { now_ = before_; }
  /// The state at the start of the step.
  const Motion& before() const { return before_; }

  /// Whether the scene requests a tolerance in time that a run of it can keep.
  bool wantsTolerance() const { return wantsTolerance_; }
  /// Whether a brick is too far away, or its pose is not finite.
  bool isLost() const;
  /// The last step, which started at `begin` (seconds).
  StepSpan span(double begin, const StepReport& report, bool isToTolerance) const;

  /// The poses at a time within the last step, seconds. Joints are not closed again.
  Poses posesAt(double time) const;
  /// The same with joints closed. Bricks marked in `pinned` stay fixed, one entry per brick. The
  /// joints of an engine are not closed.
  Poses closedPosesAt(double time, const std::vector<bool>& pinned);
  /// The velocities at a time after the start of the last step, seconds.
  std::vector<Velocity> velocitiesAt(double seconds) const;
  /// The motion at a time after the start of the last step, seconds. Joints are not closed again.
  Motion motionAfter(double seconds) const;
  /// The motion of these poses at a time within the last step, seconds.
  Motion motionAt(double time, const Poses& poses) const;

  void transfer(StateTape& tape) { tape.transfer(now_, before_, *solver_); }

 private:
  Poses posesAfter(double seconds) const;

  const SceneBricks& bricks_;
  const StepClock& clock_;
  bool wantsTolerance_;
  Motion now_;
  Motion before_;          // the state at the start of the last step
  Poses start_;            // joints closed unless they are compliant
  Poses contactStart_;     // contacts allow at most its overlaps
  bool isSmooth_ = false;  // the last step kept its tolerance everywhere
  std::unique_ptr<Dynamics> solver_;
  std::unique_ptr<Dynamics> projection_;  // closes joints within a step; created when needed
};

// ------------------------------------------------------------------------------------------------
// Exactness of the joints.

/// Whether the joints of a run's tiles can be closed. If so, they are held exactly from then on.
class JointFit {
 public:
  /// Keeps a reference to `bricks`.
  explicit JointFit(const SceneBricks& bricks) : bricks_(bricks) {}

  /// Closes the joints of the start and holds them, unless they are compliant. Compliant joints do
  /// not need to be closed, which could push bricks into each other.
  void closeAtStart(RunMotion& motion, RunFigures& figures);
  /// Closes joints that were compliant along the path and holds them exactly. Keeps them open if
  /// closing causes overlaps, or if it moves tiles of rounded coordinates too far.
  void closeAtEndOfPath(RunMotion& motion, RunFigures& figures);
  /// Sets the joint stiffness of the run's start.
  void hold(Dynamics& solver) const;

  /// Whether joints could not be closed, and are therefore slightly compliant.
  bool isMisfit() const { return isMisfit_; }
  /// Whether overlaps prevent compliant joints from closing.
  bool isHeldOpen() const { return isHeldOpen_; }
  /// Why the joints are not as requested. Empty if they are.
  std::string trouble() const;

  void transfer(StateTape& tape) { tape.transfer(isMisfit_, isHeldOpen_); }

 private:
  bool close(RunMotion& motion, RunFigures& figures);

  const SceneBricks& bricks_;
  bool isMisfit_ = false;
  bool isHeldOpen_ = false;
  double pushedAtStart_ = 0;  // overlap that closing the joints caused, metres
};

}  // namespace kirireel::run
