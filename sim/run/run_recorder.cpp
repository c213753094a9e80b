// Measures and delivers a run. A sample between two steps is interpolated from their poses. Its
// joints are closed again if those at both ends of the step are closed. A checkpoint stores each
// sample with the clock and the figures at that time: a resumed run delivers them again before it
// continues.
#include "sim/run/run_recorder.h"

#include <array>
#include <utility>

namespace kirireel::run {

RunRecorder::RunRecorder(const SceneBricks& bricks, StepClock& clock, RunMotion& motion,
                         const ActingForces& forces, const RunObservers& observers,
                         const AssembledState& nearest, Checkpoints* checkpoints)
    : clock_(clock),
      motion_(motion),
      forces_(forces),
      observers_(observers),
      checkpoints_(checkpoints),
      figures_(bricks.scene.model, bricks.bricks, bricks.pivots, bricks.scene.environment.pivotZone,
               motion.poses(), nearest) {
  if (observers_.sample && bricks.scene.solver.kind == scene::SolverKind::Direct) {
    mechanics_.emplace(bricks, forces);
  }
}

void RunRecorder::begin(bool jointsAreCompliant) {
  figures_.begin(motion_.poses(), jointsAreCompliant);
  beginStep();
  showStep();
}

void RunRecorder::beginStep() {
  if (mechanics_) mechanics_->begin(clock_.time(), motion_.now());
}

void RunRecorder::endStep(const StepReport& report, bool isToTolerance) {
  if (mechanics_) mechanics_->end(motion_.span(clock_.time(), report, isToTolerance));
}

void RunRecorder::addImpact(const Motion& before, const Motion& after) {
  if (mechanics_) mechanics_->addImpact(before, after);
}

void RunRecorder::observe(const StepReport& report, bool jointsAreCompliant) {
  figures_.observe(clock_.time(), motion_.poses(), report, jointsAreCompliant, statesWithin());
}

// Trials are measured only at the ends of their steps.
StatesWithin RunRecorder::statesWithin() {
  if (isTrial_) return {};
  StatesWithin within = {clock_.time() - clock_.length(), {}};
  const auto timeAt = [&](double share) { return within.begin + share * clock_.length(); };
  std::array<Poses, 2> open, closed;
  const bool isClosed =
      figures_.areClosed(motion_.posesAt(within.begin)) && figures_.areClosed(motion_.poses());
  for (std::size_t k = 0; k < open.size() && isClosed; ++k) {
    const double time = timeAt(static_cast<double>(k + 1) / 3);
    open[k] = motion_.posesAt(time);
    closed[k] = motion_.closedPosesAt(time, forces_.pinned());
  }
  const ThirdsCorrection correction(open, closed);
  for (int k = 1; k <= kMomentsBetween; ++k) {
    const double share = static_cast<double>(k) / (kMomentsBetween + 1);
    Poses& poses = within.states.emplace_back(motion_.posesAt(timeAt(share)));
    if (isClosed) correction.addTo(poses, share);
  }
  return within;
}

void RunRecorder::showStep() {
  if (observers_.step && !observers_.step(figures_.lastStep())) shouldStop_ = true;
}

void RunRecorder::takeSamples() {
  for (;;) {
    const double due = static_cast<double>(sampleCount_) * observers_.sampleInterval;
    if (!clock_.isDue(due)) return;  // also when not a number
    if (clock_.isAhead(due)) {
      takeSample();
    } else if (figures_.wereClosed()) {
      takeSample(due, motion_.closedPosesAt(due, forces_.pinned()));
    } else {
      takeSample(due, motion_.posesAt(due));
    }
  }
}

void RunRecorder::takeLastSample() {
  if (!isOver_ && lastSampleTime_ < clock_.time()) takeSample();
}

void RunRecorder::takeSample(double time, Poses poses) {
  // Interruptible work comes first.
  const double share = 1 - (clock_.time() - time) / clock_.length();
  std::optional<trajectory::Mechanics> mechanics;
  if (mechanics_) mechanics = mechanics_->at(time, motion_.motionAt(time, poses), share);
  trajectory::Sample sample = figures_.sampleAt(time, std::move(poses));
  ++sampleCount_;
  lastSampleTime_ = time;
  sample.mechanics = std::move(mechanics);
  sample.pinned = forces_.pinnedTiles();
  if (checkpoints_) {
    checkpoints_->samples().transfer(sample);
    transferAsOfSample(checkpoints_->samples());
  }
  if (observers_.sample && !observers_.sample(sample)) shouldStop_ = true;
}

RunMechanics::Account RunRecorder::account() const {
  return mechanics_ ? mechanics_->account() : RunMechanics::Account{};
}

void RunRecorder::goBackTo(const RunMechanics::Account& account) {
  if (mechanics_) mechanics_->goBackTo(account);
}

// The data that a checkpoint stores with a sample.
void RunRecorder::transferAsOfSample(StateTape& tape) {
  tape.transfer(clock_, sampleCount_, lastSampleTime_, figures_);
}

// The states of the figures up to a sample are unknown: those of the checkpoint may be later.
std::optional<trajectory::Sample> RunRecorder::showAgain(double time) {
  StateTape latest;
  transferAsOfSample(latest);
  trajectory::Sample shown;
  checkpoints_->playSamples([&](StateTape& samples) {
    samples.transfer(shown);
    transferAsOfSample(samples);
    shouldStop_ = observers_.sample && !observers_.sample(shown);
    return !shouldStop_;
  });
  if (shouldStop_ && shown.time < time) {
    isOver_ = true;
    figures_.endWith(shown);
    std::erase_if(events_, [&](const trajectory::Event& event) { return event.time > shown.time; });
    return shown;
  }
  StateTape played(latest.numbers());
  transferAsOfSample(played);
  return std::nullopt;
}

void RunRecorder::transfer(StateTape& tape) {
  transferAsOfSample(tape);
  tape.transfer(events_);
  figures_.transferStates(tape);
  if (mechanics_) tape.transfer(*mechanics_);
}

}  // namespace kirireel::run
