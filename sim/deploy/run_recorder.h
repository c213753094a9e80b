/// What is measured of a run while it goes on, and shown to those who watch it.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "sim/base/state_tape.h"
#include "sim/deploy/checkpoints.h"
#include "sim/deploy/result.h"
#include "sim/deploy/run_figures.h"
#include "sim/deploy/run_mechanics.h"
#include "sim/deploy/run_motion.h"
#include "sim/trajectory/trajectory.h"

namespace kirireel::deploy {

/// What is shown of a run while it goes on. Either function may be empty; one that returns false
/// ends the run.
struct RunObservers {
  /// Seconds between the samples: these do not need to be whole steps. Infinity: the start and the
  /// end alone.
  double sampleInterval = std::numeric_limits<double>::infinity();
  SampleObserver sample;                                    ///< gets each sample; may be empty
  std::function<bool(const trajectory::StepRecord&)> step;  ///< the start counts as one
};

/// Measures the start of a run and each step, and gives observers their steps and samples. Nothing
/// in the run depends on them: a sample between two steps is made from their poses.
class RunRecorder {
 public:
  /// All must outlive this; `checkpoints`, which keep the samples, may be null. `nearest`: see
  /// assembleAtTarget().
  RunRecorder(const SceneBricks& bricks, StepClock& clock, RunMotion& motion,
              const ActingForces& forces, const RunObservers& observers,
              const AssembledState& nearest, Checkpoints* checkpoints);

  /// To be called before a run that is only tried.
  void beTrial() { isTrial_ = true; }

  /// Measures and shows the start; `jointsAreCompliant`: they are compliant on purpose.
  void begin(bool jointsAreCompliant);
  /// To be called before a step, once springs are set for it.
  void beginStep();
  /// Accounts for a step from its length on, before its time has passed.
  void endStep(const StepReport& report, bool isToTolerance);
  /// Measures the state that the step led to. Where it is ended from within (see
  /// sim/base/interruption.h) nothing has changed.
  void observe(const StepReport& report, bool jointsAreCompliant);
  /// Shows the last step.
  void showStep();

  /// Takes a sample of the state now.
  void takeSample() { takeSample(clock_.time(), motion_.poses()); }
  /// Takes the samples that became due with the last step.
  void takeSamples();
  /// Takes that of the end, which is the last step's, unless it was taken.
  void takeLastSample();

  /// Whether an observer wants the run to end.
  bool isAskedToEnd() const { return isAskedToEnd_; }
  /// What has been measured so far.
  RunFigures& figures() { return figures_; }
  /// The figures so far.
  const RunFigures& figures() const { return figures_; }
  /// What has happened so far.
  std::vector<trajectory::Event>& events() { return events_; }

  /// The account of energies, for steps that are taken back.
  RunMechanics::Account account() const;
  /// Goes back to an earlier account, where steps are taken back.
  void goBackTo(const RunMechanics::Account& account);

  /// Shows the samples that the checkpoint holds, of a run that it was made of at `time` (seconds).
  /// Returns the one before that at which the observer ended the run: clock and figures are then as
  /// of it, and no sample follows.
  std::optional<trajectory::Sample> showAgain(double time);

  /// Records or plays back.
  void transfer(StateTape& tape);

 private:
  StatesWithin statesWithin();
  void takeSample(double time, Poses poses);
  void transferAsOfSample(StateTape& tape);

  StepClock& clock_;
  RunMotion& motion_;
  const ActingForces& forces_;
  RunObservers observers_;
  Checkpoints* checkpoints_;
  RunFigures figures_;
  std::optional<RunMechanics> mechanics_;  // where samples are taken that can have them
  std::vector<trajectory::Event> events_;
  long sampleCount_ = 0;       // samples taken
  double lastSampleTime_ = 0;  // seconds
  bool isTrial_ = false;
  bool isAskedToEnd_ = false;
  bool isOver_ = false;  // ended among samples that were shown again
};

}  // namespace kirireel::deploy
