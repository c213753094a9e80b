/// A deployment by dynamics: the loop over its steps.
#pragma once

#include <optional>

#include "sim/base/interruption.h"
#include "sim/base/state_tape.h"
#include "sim/run/assembled_state.h"
#include "sim/run/checkpoints.h"
#include "sim/run/rest.h"
#include "sim/run/result.h"
#include "sim/run/run_drive.h"
#include "sim/run/run_mechanics.h"
#include "sim/run/run_motion.h"
#include "sim/run/run_recorder.h"
#include "sim/run/timeline_runner.h"
#include "sim/scene/scene.h"

namespace kirireel::run {

/// The outcome of a run and its reason.
struct RunEnding {
  Outcome outcome = Outcome::OutOfTime;  ///< how it ends
  std::string reason;                    ///< one line, as shown in the summary
};

/// Determines the reason for the end of a run.
class RunReasons {
 public:
  /// Keeps references to these parts of a run at its end.
  RunReasons(const SceneBricks& bricks, const CurrentTarget& target, const RunMotion& motion,
             const ActingForces& forces, const RestWatch& rest)
      : bricks_(bricks), target_(target), motion_(motion), forces_(forces), rest_(rest) {}

  /// For bricks at rest: settled, or locked before the target. Unless `isTrial`, it also determines
  /// the cause, which costs up to a few factorisations.
  RunEnding atRest(bool isTrial) const;
  /// For a run that reached its maximum duration. `time`: its end, seconds.
  RunEnding late(double time) const;

 private:
  std::string stopReason() const;
  std::string friction() const;
  std::string failingSteps() const;
  std::vector<std::string> loadedPins() const;
  std::vector<std::string> otherForces() const;
  std::vector<Vector6> forcesAtRest() const;
  bool isGravityActing() const;
  bool isFrictionActing() const;
  bool isImmobile() const;

  const SceneBricks& bricks_;
  const CurrentTarget& target_;
  const RunMotion& motion_;
  const ActingForces& forces_;
  const RestWatch& rest_;
};

/// CPU time of a run, including earlier processes.
class SpentTime {
 public:
  /// Starts counting in this thread.
  void begin() { begin_ = threadCpuSeconds(); }
  /// CPU seconds so far, including those before a checkpoint.
  double seconds() const { return earlier_ + threadCpuSeconds() - begin_; }

  void transfer(StateTape& tape) {
    double spent = seconds();
    tape.transfer(spent);
    if (tape.isPlaying()) earlier_ = spent;
  }

 private:
  double begin_ = 0;
  double earlier_ = 0;
};

/// Steps a scene until it is at rest, locked, diverged or out of time. Results depend only on the
/// steps, not on the observers or their sampling interval.
class Run : private TimelineStage {
 public:
  /// `nearest`: see assembleAtTarget(). The scene's path must be chosen (not Auto). Keeps
  /// references to the scene, the checkpoints and the guide; the last two may be null. `guide`: see
  /// RunDrive.
  Run(const scene::Scene& scene, const AssembledState& nearest, const RunObservers& observers,
      Checkpoints* checkpoints = nullptr, const MechanismPath* guide = nullptr);
  // Its parts refer to each other.
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;

  /// Call this before a trial: it omits the reason for its end.
  void markAsTrial() {
    isTrial_ = true;
    recorder_.markAsTrial();
  }

  /// Runs to the end, from a checkpoint if one was found. The trajectory holds no samples: they go
  /// to the observer. Interrupted (see sim/base/interruption.h) ends the run after its last whole
  /// step. A trial throws it instead.
  DeploymentResult finish();

  /// Cost so far.
  const DeployCost& cost() const { return recorder_.figures().cost(); }
  /// Accuracy so far.
  const Accuracy& accuracy() const { return recorder_.figures().accuracy(); }
  /// Whether overlaps cover all pairs that are near at the start; see maxPairs().
  bool seesAllPairs() const { return recorder_.figures().seesAllPairs(); }
  /// Whether overlaps prevent compliant joints from closing.
  bool isHeldOpen() const { return joints_.isHeldOpen(); }

 private:
  // The loop.
  void start();
  void advanceToEnd();
  bool shouldContinue();
  void advance();
  double nextMoment() const;
  void takeStep();
  std::string faultOfStep() const;
  StepReport advanceBricks();
  void end(RunEnding ending);
  void interrupt() { end({Outcome::Interrupted, "ended early by the caller"}); }
  DeploymentResult result();
  void warnOfEnergy(std::vector<std::string>& warnings) const;

  // Actions at rest.
  bool watchesStall() const;
  bool stiffensIfStalled();
  void restOrContinue();
  RunReasons reasons();
  bool isOnlySlow();
  bool isOnlyPulled() const;
  bool areOnSprings() const;
  RestProbe probe();
  void settleAtNearest();
  void settleAtEquilibrium();
  void endAt(const Poses& poses);

  // The timeline and its actions on the run.
  bool followTimeline(bool atRest);
  void setPinned(const std::vector<bool>& pinned) override;
  void goTo(const std::vector<model::Tile>* target) override;
  void reset() override;
  void quit() override;

  // Checkpoints.
  void transfer(StateTape& tape);
  void saveState();
  void resumeFrom(const RunState& state);

  double time() const { return clock_.time(); }
  double targetErrorNow() const { return target_.error(motion_.poses()); }

  const SceneBricks bricks_;
  StepClock clock_;
  CurrentTarget target_;
  RunDrive drive_;
  TimelineRunner timeline_;
  RunMotion motion_;
  ActingForces forces_;
  JointFit joints_;
  RestWatch rest_;
  Perturber perturber_;
  RunRecorder recorder_;
  Checkpoints* checkpoints_;
  SpentTime spent_;
  bool isTrial_ = false;
  std::optional<RunEnding> ending_;  // set when the run has ended
};

}  // namespace kirireel::run
