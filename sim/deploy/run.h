/// A deployment by dynamics in progress: the loop over its steps.
#pragma once

#include <optional>

#include "sim/base/interruption.h"
#include "sim/base/state_tape.h"
#include "sim/deploy/assembled_state.h"
#include "sim/deploy/checkpoints.h"
#include "sim/deploy/rest.h"
#include "sim/deploy/result.h"
#include "sim/deploy/run_drive.h"
#include "sim/deploy/run_mechanics.h"
#include "sim/deploy/run_motion.h"
#include "sim/deploy/run_recorder.h"
#include "sim/deploy/timeline_runner.h"
#include "sim/scene/scene.h"

namespace kirireel::deploy {

/// How a run ended, and why, in one line.
struct RunEnding {
  Outcome outcome = Outcome::OutOfTime;  ///< how it ends
  std::string reason;                    ///< one line, as the summary has it
};

/// Says how a run stands, for the reason of its end.
class RunReasons {
 public:
  /// The parts of a run at its end; all must outlive this.
  RunReasons(const SceneBricks& bricks, const CurrentTarget& target, const RunMotion& motion,
             const ActingForces& forces, const RestWatch& rest)
      : bricks_(bricks), target_(target), motion_(motion), forces_(forces), rest_(rest) {}

  /// Of bricks that came to rest: settled, or locked short of the target. What holds them up is
  /// looked for, which costs up to a factorisation, unless this `isTrial`.
  RunEnding atRest(bool isTrial) const;
  /// Of a run whose time is up.
  RunEnding late() const;

 private:
  std::string holdup() const;
  std::string friction() const;
  bool isImmobile() const;

  const SceneBricks& bricks_;
  const CurrentTarget& target_;
  const RunMotion& motion_;
  const ActingForces& forces_;
  const RestWatch& rest_;
};

/// CPU time of a run, in this process and those before it.
class SpentTime {
 public:
  /// Counts what this thread does from now on.
  void begin() { begin_ = threadCpuSeconds(); }
  /// CPU seconds so far, those before a checkpoint included.
  double seconds() const { return earlier_ + threadCpuSeconds() - begin_; }

  /// Records or plays back.
  void transfer(StateTape& tape) {
    double spent = seconds();
    tape.transfer(spent);
    if (tape.isPlaying()) earlier_ = spent;
  }

 private:
  double begin_ = 0;
  double earlier_ = 0;
};

/// Steps a scene from its start until it rests, locks, diverges, or its time is up. All that it
/// does and measures depends on the steps alone, not on who looks at it and how often.
class Run : private TimelineStage {
 public:
  /// `nearest`: see assembleAtTarget(). The scene's path must be chosen (not Auto). Scene
  /// and checkpoints must outlive the run; the latter may be null.
  Run(const scene::Scene& scene, const AssembledState& nearest, const RunObservers& observers,
      Checkpoints* checkpoints = nullptr);
  // Its parts refer to each other.
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;

  /// To be called before a run that is only tried: the reason for its end is left out.
  void beTrial() {
    isTrial_ = true;
    recorder_.beTrial();
  }

  /// Runs to the end, from the checkpoint that was found if there is one. The trajectory holds no
  /// samples: they go to the observer. Interrupted (see sim/base/interruption.h) ends the run after
  /// its last whole step, yet is thrown by a trial.
  DeploymentResult finish();

  /// What it has cost so far.
  const DeployCost& cost() const { return recorder_.figures().cost(); }
  /// How well it has gone so far.
  const Accuracy& accuracy() const { return recorder_.figures().accuracy(); }
  /// Whether the figures of overlaps are of all pairs that are near at the start; see mostPairs().
  bool seesAllPairs() const { return recorder_.figures().seesAllPairs(); }
  /// Whether bricks keep compliant joints from closing.
  bool isHeldOpen() const { return joints_.isHeldOpen(); }

 private:
  // The loop.
  void start();
  void advanceToEnd();
  bool goesOn();
  void advance();
  double nextMoment() const;
  void takeStep();
  StepReport advanceBricks();
  void end(RunEnding ending);
  void interrupt() { end({Outcome::Interrupted, "ended early by the caller"}); }
  DeploymentResult result();
  void warnOfEnergy(std::vector<std::string>& warnings) const;

  // What may go on at rest.
  bool watchesStall() const;
  bool stiffensWhereStalled();
  void restOrGoOn();
  RunReasons reasons();
  bool isOnlySlow();
  bool isOnlyPulled() const;
  void settleAtNearest();

  // The timeline, and what it does to the run.
  bool followTimeline(bool atRest);
  void setPinned(const std::vector<bool>& pinned) override { motion_.solver().setPinned(pinned); }
  void goTo(const std::vector<model::Tile>* target) override;
  void reset() override;
  void quit() override;

  // Checkpoints.
  void transfer(StateTape& tape);
  void saveState();
  void goOnFrom(const RunState& state);

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
  NudgeGiver nudges_;
  RunRecorder recorder_;
  Checkpoints* checkpoints_;
  SpentTime spent_;
  bool isTrial_ = false;
  std::optional<RunEnding> ending_;  // once it has ended
};

}  // namespace kirireel::deploy
