/// What is measured of a run while it goes on.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "sim/deploy/assembled_state.h"
#include "sim/deploy/deployment.h"
#include "sim/joints/extrapolation.h"
#include "sim/joints/joint_solver.h"
#include "sim/joints/reactions.h"
#include "sim/measure/measures.h"
#include "sim/trajectory/trajectory.h"

namespace kirireel {

// ------------------------------------------------------------------------------------------------
// What is measured of a run: the figures of its summary, and the states in which they were
// reached.

/// Looks at the start of a run and at the end of each step. A figure that one state decides keeps
/// that state, and all others follow from the steps' records: so they can be computed again.
class RunFigures {
 public:
  /// `asRead`: where the bricks stand before joints are closed. `nearest`: see assembleAtTarget().
  /// Model, bricks and pivots must outlive this.
  RunFigures(const Model& model, const std::vector<Brick>& bricks, std::span<const Pivot> pivots,
             double pivotZone, const Poses& asRead, const AssembledState& nearest);

  /// Measures the start, its joints closed unless they are compliant (`jointsGive`).
  void begin(const Poses& start, bool jointsGive);
  /// Measures the state that a step led to at a time, seconds. Where it is ended from within (see
  /// sim/base/interruption.h) nothing has changed.
  void observe(double time, const Poses& poses, const StepReport& report, bool jointsGive);
  /// Counts work beside the steps, in multiplications.
  void addWork(double work) { cost_.took.work += work; }

  const Accuracy& accuracy() const { return accuracy_; }
  const DeployCost& cost() const { return cost_; }
  /// The target error of a state, metres; 0 without a target.
  double targetErrorOf(const Poses& poses) const;
  /// The overlaps of a state, which enter no figure.
  PenetrationDepths overlapsOf(const Poses& poses) { return overlaps_->at(poses); }
  /// Whether the figures of overlaps are of all pairs that are near at the start; see mostPairs().
  bool seesAllPairs() const { return overlaps_->seesAllPairs(); }
  /// Whether the joints were closed at the start and at the end of the last step.
  bool wereClosed() const;
  /// The record of the last step.
  const StepRecord& lastStep() const { return steps_.back(); }

  /// A sample of these poses with its measures, and the steps up to its time since the one before.
  Sample sampleAt(double time, Poses poses);
  /// Makes a sample the end of the run, though later steps were measured. Which states the figures
  /// up to it were reached in is not known.
  void endWith(const Sample& sample);

  /// Puts the figures in their places.
  void leave(DeploymentResult& result) const;

  /// The figures as of a sample.
  void transfer(StateTape& tape);
  /// What measuring goes on from beside them.
  void transferStates(StateTape& tape);

 private:
  void raise(double& figure, const char* name, double value);
  void keepState(const char* name);
  void noteOverlaps(const PenetrationDepths& depths);
  void observeTarget(const JointGap& gap);

  const Model& model_;
  const std::vector<Brick>& bricks_;
  std::span<const Pivot> pivots_;
  double tileSize_;  // metres
  std::unique_ptr<PenetrationMeter> overlaps_;
  Poses asRead_;
  Accuracy accuracy_;
  DeployCost cost_;
  double assembledError_;  // metres; negative without a target
  long count_ = 0;         // of states measured, the start included
  double gapSum_ = 0;      // of their mean gaps
  double gapBefore_ = 0;   // the largest of the state before the last
  double gapNow_ = 0;      // likewise of the last
  std::vector<FigureState> states_;
  std::vector<StepRecord> steps_;  // since the last sample
  double time_ = 0;                // of the state that is measured
  const Poses* poses_ = nullptr;   // likewise
};

// ------------------------------------------------------------------------------------------------
// What a run with dynamics knows of its states beyond poses: energies and forces.

/// What acts on the bricks of a run at present.
class ActingForces {
 public:
  virtual ~ActingForces() = default;

  /// Energy stored in all springs but those at hinges, as they pull at a time of the run (seconds),
  /// in the bricks at these poses; joules, from 0.
  virtual double springEnergy(double time, const Poses& poses) const = 0;
  /// The same in springs at hinges.
  virtual double hingeEnergy(const Poses& poses) const = 0;
  /// Adds what ligaments pull the first tile of their joint with, newtons; one entry a joint.
  virtual void addLigamentForces(const Poses& poses, std::vector<Vector3>& jointForces) const = 0;
  /// Forces on the bricks' centres of mass that store no energy here: gravity and expansion, N.
  virtual std::vector<Vector3> freeForces(const Poses& poses) const = 0;
  /// Everything that is applied to bricks that move so, contacts apart: force and torque about the
  /// centre of mass of each, N and N m.
  virtual std::vector<Vector6> appliedForces(double time, const Motion& motion) const = 0;
  /// Stiffness of the joints, N/m; infinity: exact.
  virtual double jointStiffness() const = 0;
  /// Which bricks are pinned, one entry a brick.
  virtual std::vector<bool> pinned() const = 0;
  /// The grips and the contacts of a state at a time.
  virtual std::vector<Hold> holds(double time, const Motion& motion) const = 0;
};

/// One step of a run, as its energies see it.
struct StepSpan {
  double time = 0;     ///< where it begins, seconds
  double seconds = 0;  ///< its length
  const Motion& from;
  const Motion& to;
  std::span<const PassedState> passed;  ///< in between, where springs move on within the step
  bool springsMove = false;             ///< or stand as they are at its beginning
  double damped = 0;                    ///< joules, see StepReport
  double impacted = 0;
};

/// Keeps the account of a run's energies, and solves for the forces of states.
class RunMechanics {
 public:
  /// All must outlive this. `joints`: how many the model has; `planar`, `lengthScale`: see
  /// JointSolverSettings.
  RunMechanics(const std::vector<Brick>& bricks, std::span<const Pivot> pivots, std::size_t joints,
               bool planar, double lengthScale, const ActingForces& acting);

  /// To be called before each step, and at the start of the run, once springs are set for it: what
  /// has changed since the step before was work.
  void begin(double time, const Motion& motion);
  /// To be called after each step.
  void end(const StepSpan& step);

  /// The mechanics of a state at a time, which is so far (0 to 1) on the way through the last step.
  Mechanics at(double time, const Motion& motion, double share);

  /// The account at present.
  struct Account {
    Energies before;  ///< where the last step began
    Energies now;

    void transfer(StateTape& tape) { tape.transfer(before, now); }
  };
  const Account& account() const { return account_; }
  /// Goes back to an earlier account, where steps are taken back.
  void goBackTo(const Account& account) { account_ = account; }

  void transfer(StateTape& tape) { tape.transfer(account_); }

 private:
  double workOfFreeForces(const Motion& from, const Motion& to) const;
  double workOfMovingSprings(const StepSpan& step) const;
  double workOfMovingSprings(double time, double seconds, const Motion& from,
                             const Motion& to) const;

  const std::vector<Brick>& bricks_;
  std::span<const Pivot> pivots_;
  std::size_t joints_;
  const ActingForces& acting_;
  std::unique_ptr<ReactionSolver> reactions_;
  Account account_;
};

}  // namespace kirireel
