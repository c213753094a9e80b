/// Measures a run and delivers steps and samples to observers.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "sim/base/state_tape.h"
#include "sim/run/checkpoints.h"
#include "sim/run/result.h"
#include "sim/run/run_figures.h"
#include "sim/run/run_mechanics.h"
#include "sim/run/run_motion.h"
#include "sim/trajectory/trajectory.h"

namespace kirireel::run {

/// Observers of a run. Either function may be empty. A function that returns false ends the run.
struct RunObservers {
  /// Interval between samples, seconds; need not be a multiple of the step. Infinity: only the
  /// start and the end.
  double sampleInterval = std::numeric_limits<double>::infinity();
  SampleObserver sample;                                    ///< receives each sample; may be empty
  std::function<bool(const trajectory::StepRecord&)> step;  ///< the start counts as one
};

/// Measures the start of a run and each step. Delivers steps and samples to observers. The run does
/// not depend on them: a sample between two steps is interpolated from their poses.
class RunRecorder {
 public:
  /// Keeps references to all. `checkpoints` store the samples and may be null. `nearest`: see
  /// assembleAtTarget().
  RunRecorder(const SceneBricks& bricks, StepClock& clock, RunMotion& motion,
              const ActingForces& forces, const RunObservers& observers,
              const AssembledState& nearest, Checkpoints* checkpoints);

  /// Call this before a trial.
  void markAsTrial() { isTrial_ = true; }

  /// Measures and delivers the start. `jointsAreCompliant`: by request.
  void begin(bool jointsAreCompliant);
  /// Call this before a step, when its springs are set.
  void beginStep();
  /// Accounts for a step after the solver, before the clock advances.
  void endStep(const StepReport& report, bool isToTolerance);
  /// Accounts for an impact between two steps.
  void addImpact(const Motion& before, const Motion& after);
  /// Measures the state after the step. If this is interrupted (see sim/base/interruption.h),
  /// nothing changes.
  void observe(const StepReport& report, bool jointsAreCompliant);
  /// Delivers the last step.
  void showStep();

  /// Takes a sample of the current state.
  void takeSample() { takeSample(clock_.time(), motion_.poses()); }
  /// Takes the samples that became due during the last step.
  void takeSamples();
  /// Takes a sample at the end of the last step, unless it was taken.
  void takeLastSample();

  /// Whether an observer requests the end of the run.
  bool shouldStop() const { return shouldStop_; }
  /// The figures so far.
  RunFigures& figures() { return figures_; }
  /// The figures so far, read only.
  const RunFigures& figures() const { return figures_; }
  /// The events so far.
  std::vector<trajectory::Event>& events() { return events_; }

  /// The energy account, saved before steps that may be undone.
  RunMechanics::Account account() const;
  /// Restores an earlier account when a step is undone.
  void goBackTo(const RunMechanics::Account& account);

  /// Delivers the samples of a checkpoint again. The checkpoint was made at `time` (seconds) of the
  /// run. Returns the sample at which the observer ended the run, if it did. Clock and figures are
  /// then those of this sample, and no sample follows.
  std::optional<trajectory::Sample> showAgain(double time);

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
  std::optional<RunMechanics> mechanics_;  // present if samples can have mechanics
  std::vector<trajectory::Event> events_;
  long sampleCount_ = 0;       // samples taken
  double lastSampleTime_ = 0;  // seconds
  bool isTrial_ = false;
  bool shouldStop_ = false;
  bool isOver_ = false;  // ended while samples were delivered again
};

}  // namespace kirireel::run
