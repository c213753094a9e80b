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
#include "sim/brick/brick.h"
#include "sim/brick/contact.h"
#include "sim/brick/pair_force.h"

namespace kirireel::mechanics {

/// A point at which a brick of a planar scene rests on the ground, with friction under a known
/// normal load.
struct Support {
  int brick = 0;            ///< its number, >= 0
  Vector3 point;            ///< in the brick's axes
  double largestForce = 0;  ///< of friction, newtons
};

/// How the joints are solved.
struct JointSolverSettings {
  bool planar = false;            ///< three degrees of freedom per brick (x, y, rotation about z)
  double lengthScale = 1;         ///< a typical tile edge, metres: tolerances refer to it
  std::vector<Support> supports;  ///< of planar scenes on the ground
  /// Implicit in the step. Newton's method finds its end, unless all forces are hinge springs.
  /// Ligaments require planar motion.
  brick::PairForces pairForces;
  bool isHalving = true;  ///< whether failed steps are repeated as halves
  bool isFine = false;    ///< whether advance() and assemble() end at rounding, see setFine()
};

/// Writes the load on every brick at the given poses. `loads` has one entry per brick, which are
/// replaced.
using LoadSource = std::function<void(const Poses&, std::vector<brick::Load>& loads)>;

/// Linear and angular momentum of all bricks together, the latter about the origin, N s and N m s.
struct Momentum {
  Vector3 linear = Vector3::Zero();   ///< N s
  Vector3 angular = Vector3::Zero();  ///< about the origin, N m s
};

/// Momentum and work of a step's loads.
struct LoadGain {
  Momentum momentum;  ///< of all bricks together
  double work = 0;    ///< minus the losses in dashpots and contacts, joules
};

/// Contact force between two bricks.
struct ContactLoad {
  int brickA = 0;              ///< its number, >= 0
  int brickB = brick::kFixed;  ///< > brickA, or a fixed body
  double force = 0;            ///< newtons, the sum over the pair's points
};

/// The contact force at one point of two bricks, or of a brick and a fixed body.
struct TouchForce {
  int brickA = 0;              ///< its number, >= 0
  int brickB = brick::kFixed;  ///< or the ground's or an obstacle's
  Vector3 point;               ///< world axes
  Vector3 force;    ///< on brick A, friction included, newtons; brick B gets the opposite
  double push = 0;  ///< its normal component, newtons, >= 0
};

/// The direct solver: an implicit Euler step whose velocities satisfy all joints exactly,
///   min 1/2 (u - u*)^T A (u - u*)   with   J u = 0,   C u >= -g / h,
/// solved with the primal system A + kappa J^T J + rho C^T C and proximal refinement (augmented
/// Lagrangian), followed by Gauss-Newton closing of the joints on the same factor. Redundant joints
/// and singular states are no special cases. The cost of a step is one factorisation of H, a few
/// solves with it, and as many again for each round of contacts. All functions refer to the bricks
/// and pivots of makeJointSolver(), in their order; a solver is used by one thread at a time.
class JointSolver {
 public:
  virtual ~JointSolver() = default;

  /// Advances the motion by `step` seconds under the loads; `contacts` may be null. A step that
  /// would change branches, cannot close its joints or leaves bricks overlapping is repeated as two
  /// halves, at most 8 levels deep. With contacts, bricks whose shortest step fails move in it as
  /// rigid pieces of all that joints and contacts connect. After that, halves are tried in every
  /// tenth step only. If the pieces are at rest, the step is not tried again while nothing changes.
  /// Joints and contacts do no work: the work of closing is subtracted from the kinetic energy.
  /// Loads are computed at the start of each (half) step and are implicit in it. `step` > 0. At the
  /// start, joints are closed to about the solver's tolerance.
  virtual StepReport advance(Motion& motion, double step, const LoadSource& loads,
                             brick::ContactSource* contacts) = 0;

  /// Sets the contacts that eulerStep(), project() and collide() hold: their points may separate or
  /// slide, but not approach. Set them again after advance(), which finds contacts itself.
  virtual void holdContacts(const std::vector<brick::Contact>& contacts) = 0;
  /// The held contacts, or those that carried load in the last step of advance(), with their
  /// planes.
  virtual std::vector<brick::Contact> heldContacts() const = 0;
  /// The pushing contacts among them.
  virtual std::vector<brick::Contact> pushingContacts() const = 0;

  /// One step of implicit Euler, linearised at its start, with only the contacts that are held:
  /// velocities satisfy joints and contacts at the start, bricks move by them, and joints are not
  /// closed again. While no contact separates or sticks, the error is a power series in the step,
  /// so steps of several lengths can be extrapolated (see Extrapolation). A step without a solution
  /// for its velocities counts as unconverged. Adds momentum and work of the loads to `given`.
  virtual StepReport eulerStep(Motion& motion, double step, const LoadSource& loads,
                               LoadGain& given) = 0;

  /// Kinetic energy of the motion plus energy of the pair forces at its poses, joules.
  virtual double energy(const Motion& motion) const = 0;

  /// Forces of the held contacts and supports in the last Euler step, means over it in newtons, and
  /// the points of their friction: numbers for extrapolation, in an order that only the held
  /// contacts determine.
  virtual std::vector<double> heldForces() const = 0;
  /// Replaces them, with the size of heldForces(). Pushes are >= 0.
  virtual void setHeldForces(const std::vector<double>& forces) = 0;

  /// The largest initial slip speed of points that stick at the end of the last Euler step, m/s:
  /// points of contacts and supports.
  virtual double stickSlipSpeed(const Motion& start) const = 0;

  /// When the slip of a point of friction first passes 0 between two motions or after them, if it
  /// is linear in time. In units of the time between the motions, > 0; infinity: never. Slip below
  /// `slow` (m/s) counts as 0. Points that stick in the last Euler step do not count.
  virtual double timeOfReversal(const Motion& start, const Motion& end, double slow) const = 0;

  /// Closes joints like assemble(), moves the held contacts that pushed in the last Euler step back
  /// to their planes, and projects the velocities, in the metric of the masses, to those that keep
  /// joints closed and contacts apart. Returns the largest remaining gap, metres; infinity if no
  /// such velocities were found.
  virtual double project(Motion& motion) = 0;

  /// An impact without rebound on the held contacts. The velocities after it are the nearest to
  /// those before, in the metric of the masses, that joints and contacts allow, with friction
  /// impulses within Coulomb's bound. If no such velocities are found, keeps them unchanged and
  /// returns false.
  virtual bool collide(Motion& motion) = 0;

  /// Fixes these bricks exactly until the next call; one entry per brick. Their velocities are zero
  /// at the end of each step. Two pinned bricks must not have an open joint.
  virtual void setPinned(const std::vector<bool>& pinned) = 0;
  /// Makes joints compliant from now on: each pivot is a spring of this stiffness (N/m, > 0),
  /// implicit in the step. Infinity, the initial value, makes them exact; call assemble() first to
  /// close the gaps of springs.
  virtual void setJointStiffness(double stiffness) = 0;
  /// Forgets impulses of earlier steps, as after trial steps.
  virtual void forgetSteps() = 0;
  /// Sets JointSolverSettings::isHalving. Returns its previous value.
  virtual bool setHalving(bool isOn) = 0;
  /// Sets whether velocities and closed joints are found to rounding. Near singular states, the
  /// tolerances for dynamics let moves depend on the axes and on the order of the bricks.
  virtual void setFine(bool isOn) = 0;

  /// The contacts that carried load in the last step, the strongest first; supports excluded.
  virtual std::vector<ContactLoad> contactLoads() const = 0;

  /// Forces of the last step's contacts and of the supports, means over the step, at these poses.
  virtual std::vector<TouchForce> touchForces(const Poses& poses) const = 0;

  /// Current stiffness of the joints, N/m; infinity: exact.
  virtual double jointStiffness() const = 0;

  /// Closes the joints of an open state with the smallest displacement in the metric of the masses.
  /// Returns the largest remaining gap, metres.
  virtual double assemble(Poses& poses) = 0;

  /// State that the next step needs from earlier steps, besides the motion: pins, the joints'
  /// stiffness, initial impulses and contacts, and which bricks have touched.
  virtual void transfer(StateTape& tape) = 0;
};

/// A solver for these bricks and pivots. The pivots on both faces of a planar scene coincide and
/// count once. `bricks` must outlive the solver. Ligaments need a planar scene.
std::unique_ptr<JointSolver> makeJointSolver(const std::vector<brick::Brick>& bricks,
                                             std::span<const brick::Pivot> pivots,
                                             const JointSolverSettings& settings);

// ------------------------------------------------------------------------------------------------
// Jammed bricks: steps that can be skipped.

/// Records steps of a solver in which no brick moves because no trial keeps its tolerances. Another
/// trial has the same result as long as nothing changes.
class Standstill {
 public:
  /// Whether no brick moved in the last step.
  bool isWhole() const { return !poses_.empty(); }

  /// Begins a step of `seconds` from this motion, with one load per brick. Loads matter only if
  /// isWhole(). Returns false if the step can be skipped: the last one had the same inputs and no
  /// motion, and its halves had none either or are not due.
  bool beginStep(const Motion& motion, const std::vector<brick::Load>& loads, double seconds);
  /// Stores whether bricks moved in a part of the step.
  void recordStandstill() { stood_ = true; }
  /// Stores that bricks moved in a part of the step.
  void recordMotion() { moved_ = true; }
  /// Ends the step at these poses with these loads.
  void endStep(const Poses& poses, const std::vector<brick::Load>& loads);

  /// Whether a failed part of the step may be tried in halves: not if another part had no motion,
  /// and after such steps only in every tenth.
  bool mayHalve() const { return mayHalve_ && !stood_; }

  /// Call this if anything except poses and loads changes.
  void forget() { *this = {}; }

  void transfer(StateTape& tape);

 private:
  bool isAsBefore(const Motion& motion, const std::vector<brick::Load>& loads,
                  double seconds) const;

  // State of the last step without motion: it ended at rest.
  Poses poses_;
  std::vector<brick::Load> loads_;
  double seconds_ = 0;
  bool halved_ = false;  // it was tried in halves

  int steps_ = 0;  // consecutive, without motion
  bool mayHalve_ = true;
  bool stood_ = false;
  bool moved_ = false;
};

// ------------------------------------------------------------------------------------------------
// The forces that joints and pins carry in one state.

/// Reaction forces of one state. World axes.
struct Reactions {
  /// One per pivot: on its brick A, newtons; brick B gets the opposite. Zero for the upper pivots
  /// of a planar scene, which coincide with the lower ones.
  std::vector<Vector3> pivotForces;
  /// One per brick: force (N) of its pin, and torque (N m) about its centre of mass; zero without a
  /// pin.
  std::vector<Vector6> pinForces;
  /// The largest unbalanced force on any brick, by rounding, newtons.
  double imbalance = 0;
};

/// Finds the forces in a state by a separate solve: see reactions.cpp for the equations.
class ReactionSolver {
 public:
  virtual ~ReactionSolver() = default;

  /// The reactions to the forces and torques (about the centre of mass) that are applied to each
  /// brick, contacts included. If joints are redundant, many reactions are in equilibrium. The
  /// result has the least sum of squares: it is the limit of equally stiff joints. `pinned`: one
  /// entry per brick. `jointStiffness` in N/m makes joints springs, whose forces follow from their
  /// gaps; infinity makes them exact.
  virtual Reactions solve(const Motion& motion, std::span<const Vector6> applied,
                          const std::vector<bool>& pinned, double jointStiffness) = 0;

  /// For each of `joints` joints, whether its force (the sum over its pivots) is statically
  /// indeterminate in the state of the last solve(), which had exact joints: whether a state of
  /// self-stress has a nonzero force in it. Then solve() gives the forces of least norm.
  virtual std::vector<bool> indeterminateJoints(std::size_t joints) = 0;
};

/// A solver for these bricks and pivots, which must outlive it. `planar` and `lengthScale` as in
/// JointSolverSettings.
std::unique_ptr<ReactionSolver> makeReactionSolver(const std::vector<brick::Brick>& bricks,
                                                   std::span<const brick::Pivot> pivots,
                                                   bool planar, double lengthScale);

}  // namespace kirireel::mechanics
