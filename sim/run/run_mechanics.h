/// Mechanics of a run with dynamics, in addition to poses: acting forces, energies and reaction
/// forces.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/base/state_tape.h"
#include "sim/brick/brick.h"
#include "sim/brick/contact.h"
#include "sim/mechanics/joint_solver.h"
#include "sim/run/dynamics.h"
#include "sim/run/run_drive.h"
#include "sim/run/run_motion.h"
#include "sim/run/timeline_runner.h"
#include "sim/trajectory/trajectory.h"

namespace kirireel::run {

// ------------------------------------------------------------------------------------------------
// Acting forces.

/// The forces on the bricks of a run at present: its drive, drags, compliant joints, forces between
/// pairs, gravity, damping and contacts.
class ActingForces {
 public:
  /// Keeps references to all.
  ActingForces(const SceneBricks& bricks, const StepClock& clock, const TimelineRunner& timeline,
               const RunDrive& drive, const RunMotion& motion)
      : bricks_(bricks), clock_(clock), timeline_(timeline), drive_(drive), motion_(motion) {}

  /// Loads of the drive and of drags, which move during a step.
  mechanics::TimedLoads timedLoads() const;
  /// The loads at the current time.
  mechanics::LoadSource loadsNow() const;

  /// Energy of all springs at this time of the run (seconds) and these poses, without forces
  /// between pairs of bricks; joules, >= 0.
  double springEnergy(double time, const Poses& poses) const;
  /// Energy in forces between pairs of bricks, joules: springs at hinges, ligaments and others.
  double pairEnergy(const Poses& poses) const;
  /// Adds the force on the first tile of each joint that is replaced by a pair force, newtons. One
  /// entry per joint.
  void addForcesOfReplacedJoints(const Poses& poses, std::vector<Vector3>& jointForces) const;
  /// Forces at the bricks' centres of mass whose energy is not stored: gravity, expansion; N.
  std::vector<Vector3> freeForces(const Poses& poses) const;
  /// All applied forces except contacts, for bricks in this motion: force and torque about the
  /// centre of mass of each, N and N m.
  std::vector<Vector6> appliedForces(double time, const Motion& motion) const;
  /// Stiffness of the joints, N/m. Infinity: exact.
  double jointStiffness() const { return motion_.solver().jointStiffness(); }
  /// Time of the run, seconds.
  double time() const { return clock_.time(); }
  /// Whether the drive acts. A timeline may switch it off.
  bool isDriveOn() const { return timeline_.forcesAreOn(); }
  /// The pinned bricks, one entry per brick.
  const std::vector<bool>& pinned() const { return timeline_.pinned(); }
  /// The same as a list, ascending.
  std::vector<int> pinnedTiles() const { return timeline_.pinnedTiles(); }
  /// Whether the contacts are known. They come from the last step, so there are none before it.
  bool areContactsKnown() const;
  /// The grips and the contacts of a state at a time.
  std::vector<trajectory::Hold> holds(double time, const Motion& motion) const;

 private:
  void addLoads(double seconds, const Poses& poses, std::vector<brick::Load>& loads) const;

  const SceneBricks& bricks_;
  const StepClock& clock_;
  const TimelineRunner& timeline_;
  const RunDrive& drive_;
  const RunMotion& motion_;
};

/// Adds a contact's force to the forces on its tiles: N, and N m about the centres of mass.
void addContact(const trajectory::Hold& contact, const Poses& poses, std::vector<Vector6>& forces);

// ------------------------------------------------------------------------------------------------
// Energies and forces.

/// Keeps the energy account of a run and computes the forces of states.
class RunMechanics {
 public:
  /// Keeps references to both. The solver must be the direct one.
  RunMechanics(const SceneBricks& bricks, const ActingForces& acting);

  /// Call this before each step and at the start of the run, when springs are set. Changes of
  /// spring energy since the previous step count as work.
  void begin(double time, const Motion& motion);
  /// Call this after each step.
  void end(const StepSpan& step);
  /// Call this when an impact between two steps changes velocities.
  void addImpact(const Motion& before, const Motion& after);

  /// The mechanics of a state at a time, at a share ([0, 1]) of the last step.
  trajectory::Mechanics at(double time, const Motion& motion, double share);

  /// The current energy account.
  struct Account {
    trajectory::Energies before;  ///< at the start of the last step
    trajectory::Energies now;     ///< at the end of the last step
    Poses reached;                ///< poses at the end of the last step; empty before the start
    double largestWork = 0;       ///< absolute value at the end of any step, joules
    /// Mean accelerations of the centres of mass in the last step, m/s^2; one entry per brick.
    std::vector<Vector3> accelerations;

    static constexpr auto fields() {
      return describeFields<Account>(field("before", &Account::before), field("now", &Account::now),
                                     field("reached", &Account::reached),
                                     field("largest_work", &Account::largestWork, "J"),
                                     field("accelerations", &Account::accelerations, "m/s^2"));
    }
  };
  /// The account after the last step, joules.
  const Account& account() const { return account_; }
  /// Restores an earlier account when steps are undone.
  void goBackTo(const Account& account) { account_ = account; }

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

}  // namespace kirireel::run
