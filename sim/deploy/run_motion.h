/// How the bricks of a run move: the time in steps, the solver, the states between two steps, and
/// whether joints are exact.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/base/state_tape.h"
#include "sim/deploy/dynamics.h"
#include "sim/deploy/run_figures.h"
#include "sim/model/brick.h"
#include "sim/scene/scene.h"
#include "sim/scene/scene_parts.h"

namespace kirireel::deploy {

// ------------------------------------------------------------------------------------------------
// What of a run does not change.

/// The bricks of a scene, how they are joined, and what follows from both.
struct SceneBricks {
  /// The scene must outlive this, its path be chosen (not Auto). Throws InputError for forces
  /// between pairs and needs that the scene cannot have.
  explicit SceneBricks(const scene::Scene& given);

  const scene::Scene& scene;         ///< that the run is of
  std::vector<model::Brick> bricks;  ///< one a tile
  std::vector<model::Pivot> pivots;  ///< of all joints
  scene::Ties
      ties;  ///< exact pivots, ligaments in the place of the others, and what else acts in pairs
  scene::Needs needs;   ///< what is modelled
  double size = 0;      ///< of the model, metres
  double tileSize = 0;  ///< metres
};

// ------------------------------------------------------------------------------------------------
// Time.

/// The time of a run. A look is a whole timestep, or several where a tolerance in time is kept. A
/// step ends with the next look, or earlier where something is due. Looks are counted, so that
/// their times do not gather rounding.
class StepClock {
 public:
  /// `look`: seconds from one to the next, above 0.
  explicit StepClock(double look) : look_(look), length_(look) {}

  /// Seconds from the start to the end of the last step.
  double time() const { return static_cast<double>(looks_) * look_ + sinceLook_; }
  /// Seconds from one look to the next.
  double look() const { return look_; }
  /// Of the last step, or of that in work, seconds.
  double length() const { return length_; }

  /// Whether a moment is past or present, up to rounding.
  bool isDue(double moment) const { return moment <= time() + kSameTime * look_; }
  /// Whether a moment is present or to come, up to rounding.
  bool isAhead(double moment) const { return moment >= time() - kSameTime * look_; }
  /// Whether there are steps to make up to the look that is nearest to `end`, seconds.
  bool isBefore(double end) const { return sinceLook_ > 0 || time() < end - 0.5 * look_; }

  /// Sets the length of the next step: to `due`, or to the next look where that is earlier.
  void beginStep(double due);
  /// Lets the time of the step pass.
  void endStep();

  /// Records or plays back.
  void transfer(StateTape& tape) { tape.transfer(looks_, sinceLook_, length_); }

 private:
  /// Times closer than this part of a look are the same.
  static constexpr double kSameTime = 1e-6;

  double look_;
  double length_;
  long looks_ = 0;        // pauses included
  double sinceLook_ = 0;  // seconds
};

// ------------------------------------------------------------------------------------------------
// The bricks in motion.

/// One step of a run, as its energies see it.
struct StepSpan {
  double time = 0;     ///< where it begins, seconds
  double seconds = 0;  ///< its length
  const Motion& from;  ///< at its beginning
  const Motion& to;    ///< at its end
  std::span<const mechanics::PassedState>
      passed;                ///< in between, where springs move on within the step
  bool springsMove = false;  ///< or stand as they are at its beginning
  double damped = 0;         ///< joules, see StepReport
  double impacted = 0;       ///< joules, see StepReport
};

/// The bricks of a run at the end of its last step, the solver that moves them, and the states
/// within that step.
class RunMotion {
 public:
  /// The bricks stand where the model has them. Both must outlive this. Throws InputError where the
  /// solver cannot do what the scene asks for.
  RunMotion(const SceneBricks& bricks, const StepClock& clock);

  /// Seconds from one look at a scene's run to the next.
  static double lookOf(const scene::Scene& scene);

  /// The state now: one pose and one velocity a brick.
  Motion& now() { return now_; }
  /// The same, to be read.
  const Motion& now() const { return now_; }
  /// The poses now.
  const Poses& poses() const { return now_.poses; }
  /// The poses that the run began in.
  const Poses& start() const { return start_; }
  /// The solver that takes the steps.
  Dynamics& solver() { return *solver_; }
  /// The same, to be asked.
  const Dynamics& solver() const { return *solver_; }
  /// A new solver for the same bricks, as at the start of a run.
  std::unique_ptr<Dynamics> makeSolver() const;
  /// Another in the state of the run's.
  std::unique_ptr<Dynamics> copyOfSolver();

  /// From now on contacts keep the overlaps of this state, joints closed, at most.
  void beginContactsHere();
  /// Makes this state the start.
  void beginHere();
  /// Back to the start, at rest, with a new solver.
  void goBack();

  /// Keeps the state as that in which the next step begins.
  void beginStep();
  /// Moves the bricks by the length of a step, to the scene's tolerance in time where
  /// `isToTolerance` (joints must be exact, see wantsTolerance()), else by fixed steps.
  StepReport advance(const mechanics::TimedLoads& loads, bool isToTolerance);
  /// Back to where the step began.
  void takeBack() { now_ = before_; }

  /// Whether the scene asks for a tolerance in time that a run of it keeps.
  bool wantsTolerance() const { return wantsTolerance_; }
  /// Whether a brick has left all bounds, or is nowhere.
  bool isLost() const;
  /// The last step, which began at a time (seconds).
  StepSpan span(double begin, const StepReport& report, bool isToTolerance) const;

  /// The poses at a time within the last step, seconds; joints as they come.
  Poses posesAt(double time) const;
  /// The same with joints closed, and these bricks held where they come to lie; one entry a brick.
  /// An engine's joints stay as they come.
  Poses closedPosesAt(double time, const std::vector<bool>& pinned);
  /// How fast the bricks are so many seconds after the start of the last step.
  std::vector<Velocity> velocitiesAt(double seconds) const;
  /// How the bricks move in these poses at a time within the last step.
  Motion motionAt(double time, const Poses& poses) const;

  /// Records or plays back.
  void transfer(StateTape& tape) { tape.transfer(now_, before_, *solver_); }

 private:
  const SceneBricks& bricks_;
  const StepClock& clock_;
  bool wantsTolerance_;
  Motion now_;
  Motion before_;          // where the last step began
  Poses start_;            // joints closed unless they are compliant
  Poses contactStart_;     // contacts keep its overlaps at most
  bool isSmooth_ = false;  // the last step kept its tolerance throughout
  std::unique_ptr<Dynamics> solver_;
  std::unique_ptr<Dynamics> projection_;  // closes joints of states within a step; made when needed
};

// ------------------------------------------------------------------------------------------------
// Whether joints are exact.

/// How well the tiles of a run fit each other: whether their joints can be closed, and are held
/// exactly from then on.
class JointFit {
 public:
  /// `bricks` must outlive this.
  explicit JointFit(const SceneBricks& bricks) : bricks_(bricks) {}

  /// Closes the joints of the start, unless they are compliant, and holds them. Joints that are
  /// compliant need not be closed first, which can push bricks into each other.
  void closeAtStart(RunMotion& motion, RunFigures& figures);
  /// Closes joints that were compliant on the way and holds them exactly, unless that pushes bricks
  /// into each other, or tiles of rounded coordinates back to where alone they fit.
  void closeAtEndOfPath(RunMotion& motion, RunFigures& figures);
  /// Holds the joints as the start of the run does.
  void hold(Dynamics& solver) const;

  /// Whether joints could not be closed, and are slightly compliant.
  bool isMisfit() const { return isMisfit_; }
  /// Whether bricks keep joints that were compliant from closing.
  bool isHeldOpen() const { return isHeldOpen_; }
  /// What keeps the joints from being as asked for; empty when nothing does.
  std::string trouble() const;

  /// Records or plays back.
  void transfer(StateTape& tape) { tape.transfer(isMisfit_, isHeldOpen_); }

 private:
  bool close(RunMotion& motion, RunFigures& figures);

  const SceneBricks& bricks_;
  bool isMisfit_ = false;
  bool isHeldOpen_ = false;
  double pushedAtStart_ = 0;  // metres that closing the joints pushed bricks into each other
};

}  // namespace kirireel::deploy
