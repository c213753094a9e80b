/// What is measured of a run while it goes on.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "sim/deploy/assembled_state.h"
#include "sim/deploy/continuation.h"
#include "sim/deploy/result.h"
#include "sim/trajectory/measures.h"
#include "sim/trajectory/trajectory.h"

namespace kirireel::deploy {

/// The poses of a run at a time, seconds.
struct TimedPoses {
  double time = 0;     ///< of the run, seconds
  const Poses& poses;  ///< one a brick
};

/// The same with poses of its own.
struct TimedState {
  double time = 0;  ///< of the run, seconds
  Poses poses;      ///< one a brick
};

/// States within a step, at equal times from each other and from its ends.
struct StatesWithin {
  double begin = 0;           ///< when the step begins, seconds
  std::vector<Poses> states;  ///< in order
};

/// Joint gaps of the states that a run measured, metres.
struct GapRecord {
  long count = 0;         ///< of states, the start included
  double sumOfMeans = 0;  ///< each the mean over pivots
  double before = 0;      ///< largest gap of the state before the last
  double now = 0;         ///< largest gap of the last state
};

/// Measures a run. Samples, and moments between two samples, decide the deepest overlaps of what is
/// recorded. The ends of steps, and moments within them, decide how far overlaps grow: that figure
/// does not depend on the frame rate. A figure that one state decides keeps that state. All others
/// follow from the steps' records, so they can be computed again.
class RunFigures {
 public:
  /// `asRead`: where the bricks stand before joints are closed. `nearest`: see assembleAtTarget().
  /// Model, bricks and pivots must outlive this.
  RunFigures(const model::Model& model, const std::vector<model::Brick>& bricks,
             std::span<const model::Pivot> pivots, double pivotZone, const Poses& asRead,
             const AssembledState& nearest);

  /// Measures the start, its joints closed unless they are compliant (`jointsAreCompliant`).
  void begin(const Poses& start, bool jointsAreCompliant);
  /// Measures the state that a step led to at a time, seconds, and states within the step. If it is
  /// interrupted (see sim/base/interruption.h), nothing has changed.
  void observe(double time, const Poses& poses, const StepReport& report, bool jointsAreCompliant,
               const StatesWithin& within);
  /// Counts work beside the steps, in multiplications.
  void addWork(double work) { cost_.took.work += work; }

  /// The figures so far, metres.
  const Accuracy& accuracy() const { return accuracy_; }
  /// The least target error found with joints closed so far, metres; negative without a target.
  double assembledError() const { return assembledError_; }
  /// What the steps took so far.
  const DeployCost& cost() const { return cost_; }
  /// The target error of a state, metres; 0 without a target.
  double targetErrorOf(const Poses& poses) const;
  /// The overlaps of a state, which enter no figure.
  trajectory::PenetrationDepths overlapsOf(const Poses& poses) { return overlaps_->at(poses); }
  /// Whether the figures of overlaps are of all pairs that are near at the start; see mostPairs().
  bool seesAllPairs() const { return overlaps_->seesAllPairs(); }
  /// Whether the joints were closed at the start and at the end of the last step.
  bool wereClosed() const;
  /// Whether the joints of a state are closed.
  bool areClosed(const Poses& poses) const;
  /// The record of the last step.
  const trajectory::StepRecord& lastStep() const { return steps_.back(); }

  /// A sample of these poses with its measures, and the steps up to its time since the one before.
  /// The sample, and moments between it and the sample before, decide the deepest overlaps.
  trajectory::Sample sampleAt(double time, Poses poses);
  /// Makes a sample the end of the run, though later steps were measured. Which states the figures
  /// up to it were reached in is not known.
  void endWith(const trajectory::Sample& sample);

  /// Puts the figures in their places.
  void leave(DeploymentResult& result) const;

  /// The figures as of a sample.
  void transfer(StateTape& tape);
  /// What measuring goes on from beside them.
  void transferStates(StateTape& tape);

 private:
  void raiseOverlaps(const trajectory::PenetrationDepths& depths, const TimedPoses& state);
  void keepState(const char* figure, const TimedPoses& state);
  void raise(double Accuracy::*figure, double value, const TimedPoses& state);
  void observeTarget(const TimedPoses& state, const trajectory::JointGap& gap);

  const model::Model& model_;
  const std::vector<model::Brick>& bricks_;
  std::span<const model::Pivot> pivots_;
  double tileSize_;  // metres
  std::unique_ptr<trajectory::PenetrationMeter> overlaps_;
  Poses asRead_;
  Accuracy accuracy_;
  DeployCost cost_;
  double assembledError_;  // metres; negative without a target
  GapRecord gaps_;
  std::vector<trajectory::FigureState> states_;
  std::vector<trajectory::StepRecord> steps_;  // since the last sample
  StateInterpolator interpolator_;
  TimedState lastSample_;     // no poses before the first
  bool isCompliant_ = false;  // the joints, at the last step
};

}  // namespace kirireel::deploy
