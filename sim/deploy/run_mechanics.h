/// What a run with dynamics knows of its states beyond poses: what acts on the bricks, energies and
/// forces.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/base/state_tape.h"
#include "sim/deploy/dynamics.h"
#include "sim/deploy/run_drive.h"
#include "sim/deploy/run_motion.h"
#include "sim/deploy/timeline_runner.h"
#include "sim/mechanics/joint_solver.h"
#include "sim/model/brick.h"
#include "sim/model/contact.h"
#include "sim/trajectory/trajectory.h"

namespace kirireel::deploy {

// ------------------------------------------------------------------------------------------------
// What acts on the bricks.

/// What acts on the bricks of a run at present: its drive, drags, compliant joints, forces between
/// pairs, gravity, damping and contacts.
class ActingForces {
 public:
  /// All must outlive this.
  ActingForces(const SceneBricks& bricks, const StepClock& clock, const TimelineRunner& timeline,
               const RunDrive& drive, const RunMotion& motion)
      : bricks_(bricks), clock_(clock), timeline_(timeline), drive_(drive), motion_(motion) {}

  /// Loads of drive and drags, for steps in which they move on.
  mechanics::TimedLoads timedLoads() const;
  /// The same as they are at present.
  mechanics::LoadSource loadsNow() const;

  /// Energy stored in all springs but those between pairs, as they pull at a time of the run
  /// (seconds), in the bricks at these poses; joules, from 0.
  double springEnergy(double time, const Poses& poses) const;
  /// The same in forces between pairs of bricks: springs at hinges, ligaments and others.
  double pairEnergy(const Poses& poses) const;
  /// Adds what pairs that stand in the place of joints pull the first tile of their joint with,
  /// newtons; one entry a joint.
  void addForcesOfReplacedJoints(const Poses& poses, std::vector<Vector3>& jointForces) const;
  /// Forces on the bricks' centres of mass that store no energy here: gravity and expansion, N.
  std::vector<Vector3> freeForces(const Poses& poses) const;
  /// Everything that is applied to bricks that move so, contacts apart: force and torque about the
  /// centre of mass of each, N and N m.
  std::vector<Vector6> appliedForces(double time, const Motion& motion) const;
  /// Stiffness of the joints, N/m; infinity: exact.
  double jointStiffness() const { return motion_.solver().jointStiffness(); }
  /// Of the run, seconds.
  double time() const { return clock_.time(); }
  /// Which bricks are pinned, one entry a brick.
  const std::vector<bool>& pinned() const { return timeline_.pinned(); }
  /// The same as a list, ascending.
  std::vector<int> pinnedTiles() const { return timeline_.pinnedTiles(); }
  /// The grips and the contacts of a state at a time.
  std::vector<trajectory::Hold> holds(double time, const Motion& motion) const;

 private:
  void addLoads(double seconds, const Poses& poses, std::vector<model::Load>& loads) const;

  const SceneBricks& bricks_;
  const StepClock& clock_;
  const TimelineRunner& timeline_;
  const RunDrive& drive_;
  const RunMotion& motion_;
};

// ------------------------------------------------------------------------------------------------
// Energies and forces.

/// Keeps the account of a run's energies, and solves for the forces of states.
class RunMechanics {
 public:
  /// Both must outlive this. The solver must be the direct one.
  RunMechanics(const SceneBricks& bricks, const ActingForces& acting);

  /// To be called before each step, and at the start of the run, once springs are set for it: what
  /// has changed since the step before was work.
  void begin(double time, const Motion& motion);
  /// To be called after each step.
  void end(const StepSpan& step);

  /// The mechanics of a state at a time, which is so far (0 to 1) on the way through the last step.
  trajectory::Mechanics at(double time, const Motion& motion, double share);

  /// The account at present.
  struct Account {
    trajectory::Energies before;  ///< where the last step began
    trajectory::Energies now;     ///< where it has ended
    Poses reached;                ///< likewise; none before the start
    double largestWork = 0;       ///< at the end of any step, without its sign, joules
    /// Mean accelerations of the centres of mass in the last step, m/s^2; one entry a brick.
    std::vector<Vector3> accelerations;

    /// For files; see base/fields.h.
    static constexpr auto fields() {
      return describeFields<Account>(field("before", &Account::before), field("now", &Account::now),
                                     field("reached", &Account::reached),
                                     field("largest_work", &Account::largestWork, "J"),
                                     field("accelerations", &Account::accelerations, "m/s^2"));
    }
  };
  /// Of the last step, joules.
  const Account& account() const { return account_; }
  /// Goes back to an earlier account, where steps are taken back.
  void goBackTo(const Account& account) { account_ = account; }

  /// Records or plays back.
  void transfer(StateTape& tape) { tape.transfer(account_); }

 private:
  double workOfFreeForces(const Poses& from, const Poses& to) const;
  bool isBalanced(const mechanics::Reactions& reactions, std::span<const Vector6> applied,
                  double largest, const Poses& poses) const;
  double workOfMovingSprings(const StepSpan& step) const;
  double workOfMovingSprings(double time, double seconds, const Motion& from,
                             const Motion& to) const;

  const SceneBricks& bricks_;
  const ActingForces& acting_;
  std::unique_ptr<mechanics::ReactionSolver> reactions_;
  Account account_;
};

}  // namespace kirireel::deploy
