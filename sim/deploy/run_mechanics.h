/// What a run with dynamics knows of its states beyond poses: energies and forces.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "sim/joints/extrapolation.h"
#include "sim/joints/reactions.h"
#include "sim/trajectory/trajectory.h"

namespace kirireel {

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
