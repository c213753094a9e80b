/// Figures that are measured during a run.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "sim/run/assembled_state.h"
#include "sim/run/result.h"
#include "sim/run/state_interpolator.h"
#include "sim/scene/scene.h"
#include "sim/trajectory/measures.h"
#include "sim/trajectory/trajectory.h"

namespace kirireel::run {

/// The poses of a run at a time.
struct TimedPoses {
  double time = 0;     ///< seconds
  const Poses& poses;  ///< one per brick
};

/// The same with its own copy of the poses.
struct TimedState {
  double time = 0;  ///< seconds
  Poses poses;      ///< one per brick
};

/// Equidistant states within a step.
struct StatesWithin {
  double begin = 0;           ///< start of the step, seconds
  std::vector<Poses> states;  ///< in order
};

/// Joint gaps of the states that a run measured, metres.
struct GapRecord {
  long count = 0;         ///< number of states, including the start
  double sumOfMeans = 0;  ///< of each state, the mean over pivots
  double before = 0;      ///< largest gap of the second last state
  double now = 0;         ///< largest gap of the last state
};

/// Measures a run. The deepest overlaps of the recording come from samples and from states between
/// two samples. The growth of overlaps comes from the ends of steps and states within them: it does
/// not depend on the frame rate. A figure that is a maximum or minimum keeps its state. All others
/// follow from the records of the steps and can be recomputed.
class RunFigures {
 public:
  /// `asRead`: the poses before joints are closed. `nearest`: see assembleAtTarget(). Keeps
  /// references to model, bricks and pivots.
  RunFigures(const model::Model& model, const std::vector<brick::Brick>& bricks,
             std::span<const brick::Pivot> pivots, double pivotZone, const Poses& asRead,
             const AssembledState& nearest);

  /// Measures the start. Its joints are closed unless `jointsAreCompliant`.
  void begin(const Poses& start, bool jointsAreCompliant);
  /// Measures the state after a step, at `time` (seconds), and states within the step. If it is
  /// interrupted (see sim/base/interruption.h), nothing changes.
  void observe(double time, const Poses& poses, const StepReport& report, bool jointsAreCompliant,
               const StatesWithin& within);
  /// Adds work outside the steps, in multiplications.
  void addWork(double work) { cost_.took.work += work; }

  /// The figures so far, metres.
  const Accuracy& accuracy() const { return accuracy_; }
  /// The smallest target error with closed joints so far, metres. < 0 without a target.
  double assembledError() const { return assembledError_; }
  /// Cost of the steps so far.
  const DeployCost& cost() const { return cost_; }
  /// The target error of a state, metres; 0 without a target.
  double targetErrorOf(const Poses& poses) const;
  /// The overlaps of a state. They do not change any figure.
  trajectory::PenetrationDepths overlapsOf(const Poses& poses) { return overlaps_->at(poses); }
  /// Whether overlaps cover all pairs that are near at the start; see maxPairs().
  bool seesAllPairs() const { return overlaps_->seesAllPairs(); }
  /// Whether the joints were closed at both ends of the last step.
  bool wereClosed() const;
  /// Whether the joints of a state are closed.
  bool areClosed(const Poses& poses) const;
  /// The record of the last step.
  const trajectory::StepRecord& lastStep() const { return steps_.back(); }

  /// A sample of these poses with its measures and the records of the steps since the previous
  /// sample. States between both samples also count for the deepest overlaps.
  trajectory::Sample sampleAt(double time, Poses poses);
  /// Makes a sample the end of the run, although later steps were measured. The states of figures
  /// up to this sample are then unknown.
  void endWith(const trajectory::Sample& sample);

  /// Copies the figures into the result.
  void copyTo(DeploymentResult& result) const;

  /// Records or plays back the figures as of a sample.
  void transfer(StateTape& tape);
  /// Records or plays back the remaining state of the measurement.
  void transferStates(StateTape& tape);

 private:
  void raiseOverlaps(const trajectory::PenetrationDepths& depths, const TimedPoses& state);
  void keepState(const char* figure, const TimedPoses& state);
  void raise(double Accuracy::*figure, double value, const TimedPoses& state);
  void observeTarget(const TimedPoses& state, const trajectory::JointGap& gap);

  const model::Model& model_;
  const std::vector<brick::Brick>& bricks_;
  std::span<const brick::Pivot> pivots_;
  double tileSize_;  // metres
  std::unique_ptr<trajectory::PenetrationMeter> overlaps_;
  Poses asRead_;
  Accuracy accuracy_;
  DeployCost cost_;
  double assembledError_;  // metres; < 0 without a target
  GapRecord gaps_;
  std::vector<trajectory::FigureState> states_;
  std::vector<trajectory::StepRecord> steps_;  // since the last sample
  StateInterpolator interpolator_;
  TimedState lastSample_;     // empty poses before the first sample
  bool isCompliant_ = false;  // whether joints were compliant in the last step
};

/// Measures the growth of overlaps beyond the start, for the contacts that a scene requests.
class OverlapWatch {
 public:
  explicit OverlapWatch(const scene::Scene& scene);

  /// A run's own figures cover all pairs. Here pairs without contacts are excluded.
  void observe(const Poses& poses);
  /// The largest growth so far, metres. 0 if the user switched contacts off.
  double grown(const Accuracy& accuracy) const;

 private:
  scene::ContactFilter filter_;
  std::vector<brick::Brick> bricks_;
  std::vector<brick::Pivot> pivots_;
  trajectory::PenetrationMeter meter_;
  double grown_ = 0;
};

}  // namespace kirireel::run
