/// Advances joined bricks with their joints closed to rounding. Eigen only: knows poses, pivots and
/// contacts, not how contacts are found.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/base/state_tape.h"
#include "sim/base/step_report.h"
#include "sim/model/brick.h"
#include "sim/model/contact.h"
#include "sim/model/pair_force.h"

namespace kirireel::mechanics {

/// Where a brick of a planar scene rests on the ground: it hasFriction there with a known normal
/// load.
struct Support {
  int brick = 0;            ///< its number, >= 0
  Vector3 point;            ///< in the brick's axes
  double largestForce = 0;  ///< of friction, newtons
};

/// How the joints are solved.
struct JointSolverSettings {
  bool planar = false;            ///< three degrees of freedom a brick (x, y, turn about z)
  double lengthScale = 1;         ///< a typical tile edge, metres: tolerances refer to it
  std::vector<Support> supports;  ///< of planar scenes on the ground
  /// Implicit in the step, which finds its end by Newton's method unless all are springs at hinges.
  /// Ligaments need planar motion.
  model::PairForces pairForces;
  bool isHalving = true;  ///< whether steps that fail are tried in halves
};

/// Writes the load on every brick at the given poses; `loads` has one entry per brick, to be
/// replaced.
using LoadSource = std::function<void(const Poses&, std::vector<model::Load>& loads)>;

/// Linear and angular momentum of all bricks together, the latter about the origin, N s and N m s.
struct Momentum {
  Vector3 linear = Vector3::Zero();   ///< N s
  Vector3 angular = Vector3::Zero();  ///< about the origin, N m s
};

/// What the loads of a step give to all bricks together.
struct LoadGain {
  Momentum momentum;  ///< of all bricks together
  double work = 0;    ///< less what springs' dashpots and contacts take, joules
};

/// What two touching bricks push each other with.
struct ContactLoad {
  int brickA = 0;              ///< its number, >= 0
  int brickB = model::kFixed;  ///< above brickA, or what does not move
  double force = 0;            ///< newtons, the sum over the pair's points
};

/// The force at one point where two bricks, or a brick and what does not move, touch.
struct TouchForce {
  int brickA = 0;              ///< its number, >= 0
  int brickB = model::kFixed;  ///< or the ground's or an obstacle's
  Vector3 point;               ///< world axes
  Vector3 force;    ///< on brick A, friction included, newtons; brick B gets the opposite
  double push = 0;  ///< of that along the normal, newtons, >= 0
};

/// The direct solver: an implicit Euler step whose velocities satisfy all joints exactly,
///   min 1/2 (u - u*)^T A (u - u*)   with   J u = 0,   C u >= -g / h,
/// solved with the primal system A + kappa J^T J + rho C^T C and proximal refinement (augmented
/// Lagrangian), followed by Gauss-Newton closing of the joints on the same factor. Redundant joints
/// and singular states need no special care.
/// The cost of a step is one factorisation of H, a few solves with it, and as many again for each
/// round of contacts. All functions refer to the bricks and pivots of makeJointSolver(), in their
/// order; a solver is used by one thread at a time.
class JointSolver {
 public:
  virtual ~JointSolver() = default;

  /// Advances the motion by `step` seconds under the loads; `contacts` may be null. A step that
  /// would change branches, cannot close its joints or leaves bricks overlapping is redone as two
  /// halves, at most 8 levels deep. With contacts, bricks whose shortest step fails move in it as
  /// rigid pieces of all that joints and contacts connect. After that, halves are tried in every
  /// tenth step only. If the pieces are at rest, the step is not tried again while nothing changes.
  /// Joints and contacts do no work: what closing costs is taken from the speed. Loads are taken at
  /// the start of each (half) step and implicit in it. `step` is positive, joints are closed at the
  /// start to about the solver's tolerance. Loads are asked for at the start of each part of the
  /// step.
  virtual StepReport advance(Motion& motion, double step, const LoadSource& loads,
                             model::ContactSource* contacts) = 0;

  /// The contacts that eulerStep(), project() and collide() keep from now on: their points part, or
  /// slide, but approach no more. To be set again after advance(), which finds contacts itself.
  virtual void holdContacts(const std::vector<model::Contact>& contacts) = 0;
  /// Those that are held, or that carried load in the last step of advance(), with their planes.
  virtual std::vector<model::Contact> heldContacts() const = 0;
  /// Those of them that push.
  virtual std::vector<model::Contact> pushingContacts() const = 0;

  /// One step of implicit Euler, linearised at its start, with only the contacts that are held:
  /// velocities satisfy joints and contacts as they are at the start, bricks move by them, and
  /// joints are not closed again. While no contact parts or sticks its error is a power series in
  /// the step: steps of several lengths can be extrapolated (see Extrapolation). A step
  /// whose velocities were not found counts as unconverged. Adds to `given` what the loads gave.
  virtual StepReport eulerStep(Motion& motion, double step, const LoadSource& loads,
                               LoadGain& given) = 0;

  /// What the motion holds, and the forces between pairs at its poses, joules.
  virtual double energy(const Motion& motion) const = 0;

  /// The largest speed along their planes that points of contacts, and supports, have at the start
  /// of a step though they stick at its end, m/s; of the last Euler step's.
  virtual double stickSlipSpeed(const Motion& start) const = 0;

  /// Closes joints as assemble() does, brings the held contacts that pushed in the last Euler step
  /// back to their planes, and takes from the velocities, in the metric of the masses, what would
  /// open joints or bring contacts closer. Returns the largest gap left, metres; infinity where no
  /// such velocities were found.
  virtual double project(Motion& motion) = 0;

  /// An impact without rebound on the contacts that are held: the velocities after it are the
  /// nearest to those before, in the metric of the masses, that joints and contacts allow, with
  /// impulses of friction within Coulomb's bound. Returns false, with the velocities as they were,
  /// where none were found.
  virtual bool collide(Motion& motion) = 0;

  /// Holds these bricks where they are, exactly, until the next call; one entry per brick. Their
  /// velocities are zero at the end of each step. Two pinned bricks must not have an open joint.
  virtual void setPinned(const std::vector<bool>& pinned) = 0;
  /// Makes joints compliant from now on: each pivot is a spring of this stiffness (N/m, > 0),
  /// implicit in the step; infinity holds them exactly again, which is how a solver starts out.
  /// Close gaps from springs by assemble() first.
  virtual void setJointStiffness(double stiffness) = 0;
  /// Sets JointSolverSettings::isHalving.
  virtual void setHalving(bool isOn) = 0;

  /// The contacts that carried load in the last step, the strongest first; supports excluded.
  virtual std::vector<ContactLoad> contactLoads() const = 0;

  /// What the contacts of the last step and the supports push with, its mean over the step, at the
  /// poses where they are now.
  virtual std::vector<TouchForce> touchForces(const Poses& poses) const = 0;

  /// The joints' stiffness at present, N/m; infinity: exact.
  virtual double jointStiffness() const = 0;

  /// Closes the joints of an open state, moving the bricks as little as their masses allow. Returns
  /// the largest gap left, metres.
  virtual double assemble(Poses& poses) = 0;

  /// What the next step takes from those before, besides the motion: pins, the joints' stiffness,
  /// the impulses and contacts to begin with, and which bricks have touched.
  virtual void transfer(StateTape& tape) = 0;
};

/// A solver for these bricks and pivots. The pivots of a planar scene's two faces coincide and are
/// taken once.
/// `bricks` must outlive the solver. Ligaments ask for a planar scene.
std::unique_ptr<JointSolver> makeJointSolver(const std::vector<model::Brick>& bricks,
                                             std::span<const model::Pivot> pivots,
                                             const JointSolverSettings& settings);

// ------------------------------------------------------------------------------------------------
// Bricks that jam and do not move: which steps need not be tried again.

/// Follows the steps of a solver in which bricks do not move because no step that was tried keeps
/// its tolerances. As long as nothing changes, another try ends as the last one did.
class Standstill {
 public:
  /// Whether no brick moved in the last step.
  bool isWhole() const { return !poses_.empty(); }

  /// Begins a step of so many seconds from this motion, one load a brick; the loads count only
  /// where isWhole(). Returns false if it need not be tried: the last one that was began just so,
  /// and halves either failed then too or are not due.
  bool beginStep(const Motion& motion, const std::vector<model::Load>& loads, double seconds);
  /// Stores whether bricks moved in a part of the step.
  void recordStandstill() { stood_ = true; }
  /// Notes that bricks moved in a part of the step.
  void recordMotion() { moved_ = true; }
  /// Ends the step that was begun, in these poses, with these loads.
  void endStep(const Poses& poses, const std::vector<model::Load>& loads);

  /// Whether a part of the step that fails may be tried in halves: not if bricks do not move in
  /// another part, and after such steps only in every tenth.
  bool mayHalve() const { return mayHalve_ && !stood_; }

  /// To be called when something else changes than poses and loads.
  void forget() { *this = {}; }

  /// Records or plays back.
  void transfer(StateTape& tape);

 private:
  bool isAsBefore(const Motion& motion, const std::vector<model::Load>& loads,
                  double seconds) const;

  // State of the last step without motion: it ended at rest.
  Poses poses_;
  std::vector<model::Load> loads_;
  double seconds_ = 0;
  bool halved_ = false;  // it was tried in halves

  int steps_ = 0;  // consecutive, without motion
  bool mayHalve_ = true;
  bool stood_ = false;
  bool moved_ = false;
};

// ------------------------------------------------------------------------------------------------
// The forces that joints and pins carry in one state.

/// What holds the bricks of one state, besides what is applied to them. World axes.
struct Reactions {
  /// One a pivot: on its brick A, newtons; brick B gets the opposite. Of the upper pivot of a
  /// planar scene zero: both faces' pivots are one there.
  std::vector<Vector3> pivotForces;
  /// One a brick: the force (N) and the torque about its centre of mass (N m) of what pins it; zero
  /// where nothing does.
  std::vector<Vector6> pinForces;
  /// The largest force that is left unbalanced on any brick, newtons: rounding.
  double imbalance = 0;
};

/// Finds the forces in a state by a separate solve: see reactions.cpp for the equations.
class ReactionSolver {
 public:
  virtual ~ReactionSolver() = default;

  /// The forces in a state of motion under what is applied to each brick, force and torque about
  /// its centre of mass, contacts included. Where joints are redundant there are many that keep the
  /// balance; these have the least sum of squares, which is what equally stiff joints carry in the
  /// limit. `pinned`: one entry per brick. `jointStiffness` in N/m makes joints springs, whose
  /// forces follow from their gaps; infinity makes them exact.
  virtual Reactions solve(const Motion& motion, std::span<const Vector6> applied,
                          const std::vector<bool>& pinned, double jointStiffness) = 0;

  /// For each of so many joints, whether its force (the sum over its pivots) is indeterminate in
  /// the state of the last solve(), which had exact joints: whether some forces of only joints are
  /// in balance (a state of self-stress) in which it is not zero. Then only least-norm forces are
  /// known, and others keep the balance as well.
  virtual std::vector<bool> indeterminateJoints(std::size_t joints) = 0;
};

/// A solver for these bricks and pivots, which must outlive it. `planar` and `lengthScale` as in
/// JointSolverSettings.
std::unique_ptr<ReactionSolver> makeReactionSolver(const std::vector<model::Brick>& bricks,
                                                   std::span<const model::Pivot> pivots,
                                                   bool planar, double lengthScale);

}  // namespace kirireel::mechanics
