/// The dynamics of bricks: one interface for all solvers of a deployment.
#pragma once

#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim/brick/brick.h"
#include "sim/brick/hinge.h"
#include "sim/contacts/contact_finder.h"
#include "sim/engines/brick_world.h"
#include "sim/mechanics/extrapolation.h"
#include "sim/mechanics/joint_solver.h"
#include "sim/model/isometry.h"
#include "sim/run/tolerance_steps.h"
#include "sim/scene/scene.h"
#include "sim/trajectory/trajectory.h"

namespace kirireel::run {

// ------------------------------------------------------------------------------------------------
// The interface between the deployment and the solvers.

/// The joint ratio if joints cannot be exact, because the tiles do not fit each other in
/// intermediate states.
inline constexpr double kMisfitRatio = 2.5e4;

/// The stiffness of these joints, N/m.
double misfitStiffness(const scene::Scene& scene, const std::vector<brick::Brick>& bricks);

/// Points of friction of bricks that lie on the ground, each under its own weight with an even
/// pressure. Empty without friction, ground or weight.
std::vector<mechanics::Support> frictionOnGround(const scene::Environment& environment,
                                                 const std::vector<brick::Brick>& bricks);

/// The stiffness of exact joints, N/m.
constexpr double kExactJoints = std::numeric_limits<double>::infinity();

/// Accuracy of the motion in time.
struct TimeTolerance {
  double tolerance = 1e-4;            ///< error of a step, tiles, > 0
  double firstOrderStep = 1.0 / 240;  ///< if impacts are frequent or joints singular, seconds
  double longestStep = 1.0 / 60;      ///< seconds
};

/// Whether a scene's run keeps a tolerance in time, given its selected path. Guided tiles use fixed
/// steps, since their guide moves with the steps and their joints are often compliant.
bool keepsTolerance(const scene::Scene& scene);

/// Advances all bricks by one step.
class Dynamics {
 public:
  virtual ~Dynamics() = default;

  /// Closes open joints, if the solver can. Returns false without changes if there is no closed
  /// state nearby.
  virtual bool assemble(Poses& poses) = 0;

  /// Projects the velocities on motions that keep the joints closed, if the solver can.
  virtual void fitVelocities(Motion& /*motion*/) {}

  /// Fixes these bricks until the next call. One entry per brick. Throws InputError if the solver
  /// cannot fix bricks.
  virtual void setPinned(const std::vector<bool>& pinned) = 0;
  /// Makes joints springs, or exact again; see JointSolver::setJointStiffness.
  virtual void setJointStiffness(double stiffness) = 0;
  /// Sets whether failed steps are repeated in halves; see JointSolverSettings::isHalving.
  virtual void setHalving(bool /*isOn*/) {}
  /// Sets whether moves and closed joints are found to rounding; see JointSolver::setFine.
  virtual void setFine(bool /*isOn*/) {}

  /// The joints' current stiffness, N/m; infinity: exact.
  virtual double jointStiffness() const = 0;

  /// Resultants of the contacts of the last step at the current poses, one per pair, in order of
  /// tiles. Planar bricks on the ground include its normal force, which is their weight. Empty if
  /// the solver does not report them.
  virtual std::vector<trajectory::Hold> contacts(const Poses& poses) const = 0;

  /// Contacts that carried load in the last step, the strongest first: "tiles 3 and 4", "tile 3 and
  /// the ground", "tile 3 and obstacle 0". Empty if the solver does not report them.
  virtual std::vector<std::string> loadedContacts() const = 0;

  /// Advances the motion by `step` seconds. `actuation`: loads besides gravity and damping.
  virtual StepReport advance(Motion& motion, double step,
                             const mechanics::LoadSource& actuation) = 0;

  /// Required before advanceToTolerance(), and before transfer() in runs that use it. If the scene
  /// has its own tolerance, the solver also keeps it among contacts.
  virtual void setTolerance(const TimeTolerance& tolerance) = 0;
  /// The same with loads that depend on time. Steps keep the tolerance if possible, otherwise they
  /// are fixed steps of first order: see TimeTolerance. Joints must be exact.
  virtual StepReport advanceToTolerance(Motion& motion, double seconds,
                                        const mechanics::TimedLoads& actuation) = 0;

  /// The states between the ends of the last call of advanceToTolerance(), in order.
  virtual std::span<const mechanics::PassedState> passed() const = 0;

  /// Transfers the state that the next step needs besides the motion. Engines cannot save this
  /// state.
  virtual void transfer(StateTape& tape) = 0;
};

/// Whole planes while springs pull to a target: jammed bricks reach it only if faces guide them
/// beyond their borders. Else the regions in which faces overlap.
contacts::FaceContact faceContactOf(const scene::Scene& scene);

/// The solver selected in the scene.
std::unique_ptr<Dynamics> makeDynamics(const scene::Scene& scene, const scene::Needs& needs,
                                       const std::vector<brick::Brick>& bricks, const Poses& start,
                                       contacts::FaceContact faces);
/// The same with faceContactOf(scene).
std::unique_ptr<Dynamics> makeDynamics(const scene::Scene& scene, const scene::Needs& needs,
                                       const std::vector<brick::Brick>& bricks, const Poses& start);

// ------------------------------------------------------------------------------------------------
// `--solver direct`: exact joints.

/// The direct joint solver with implicit loads and the scene's contacts.
class DirectDynamics : public Dynamics {
 public:
  /// Throws InputError for a planar scene with obstacles, for a tile inside an obstacle at the
  /// start, and for springs or ligaments that the scene does not support. `bricks` need not outlive
  /// the call.
  DirectDynamics(const scene::Scene& scene, const scene::Needs& needs,
                 const std::vector<brick::Brick>& bricks, const Poses& start,
                 contacts::FaceContact faces);

  bool assemble(Poses& poses) override;
  void fitVelocities(Motion& motion) override;
  void setPinned(const std::vector<bool>& pinned) override;
  void setJointStiffness(double stiffness) override { solver_->setJointStiffness(stiffness); }
  void setHalving(bool isOn) override { solver_->setHalving(isOn); }
  void setFine(bool isOn) override { solver_->setFine(isOn); }
  double jointStiffness() const override { return solver_->jointStiffness(); }
  std::vector<trajectory::Hold> contacts(const Poses& poses) const override;
  std::vector<std::string> loadedContacts() const override;
  StepReport advance(Motion& motion, double step, const mechanics::LoadSource& actuation) override;
  void setTolerance(const TimeTolerance& tolerance) override;
  StepReport advanceToTolerance(Motion& motion, double seconds,
                                const mechanics::TimedLoads& actuation) override;
  std::span<const mechanics::PassedState> passed() const override;
  void transfer(StateTape& tape) override;

 private:
  std::string nameOf(const mechanics::ContactLoad& load) const;
  mechanics::TimedLoads allLoads(const mechanics::TimedLoads& actuation) const;

  std::vector<brick::Brick> bricks_;
  int countsFrom_;   // number of the first tile in messages
  double tileSize_;  // metres
  scene::Environment environment_;
  std::unique_ptr<mechanics::JointSolver> solver_;
  int substeps_;
  bool keepsEnergy_;                                   // in steps to a tolerance
  bool isLying_;                                       // planar bricks on a ground, with weight
  bool hasGroundFriction_;                             // the same, with friction
  bool isPinned_ = false;                              // some brick
  double touching_;                                    // gap of points that touch, metres
  std::unique_ptr<contacts::ContactFinder> contacts_;  // null if there are no contacts
  /// A finer finder for steps to a tolerance; null without a tolerance.
  std::unique_ptr<contacts::ContactFinder> exactContacts_;
  std::unique_ptr<ToleranceSteps> toleranceSteps_;  // null without a tolerance
};

// ------------------------------------------------------------------------------------------------
// Bricks in the world of a physics engine: the baselines.

/// An engine's own solver in short substeps. Each substep computes the actuation again.
class WorldDynamics : public Dynamics {
 public:
  /// `substeps`: substeps of the engine per step.
  WorldDynamics(std::unique_ptr<engines::BrickWorld> world, int substeps, std::size_t brickCount);

  bool assemble(Poses& /*poses*/) override {
    return true;  // engines close open joints during steps
  }
  void setPinned(const std::vector<bool>& pinned) override;
  void setJointStiffness(double /*stiffness*/) override {}         // engines' joints are compliant
  double jointStiffness() const override { return kExactJoints; }  // engines do not report it
  std::vector<trajectory::Hold> contacts(const Poses& /*poses*/) const override { return {}; }
  std::vector<std::string> loadedContacts() const override { return {}; }
  StepReport advance(Motion& motion, double step, const mechanics::LoadSource& actuation) override;
  void setTolerance(const TimeTolerance& /*tolerance*/) override {}  // engines have fixed steps
  StepReport advanceToTolerance(Motion& motion, double seconds,
                                const mechanics::TimedLoads& actuation) override;
  std::span<const mechanics::PassedState> passed() const override { return {}; }
  void transfer(StateTape& /*tape*/) override {}

 private:
  std::unique_ptr<engines::BrickWorld> world_;
  int substeps_;
  std::vector<brick::Load> loads_;
};

/// `--solver bullet`: Bullet's sequential impulses. Throws InputError for links and obstacles.
std::unique_ptr<Dynamics> makeBulletDynamics(const scene::Scene& scene,
                                             const std::vector<brick::Brick>& bricks,
                                             const Poses& start);

// ------------------------------------------------------------------------------------------------
// States that keep the symmetries of their model.

/// Preserves the common symmetries of a model and the ends of its path. Rounding and the order of
/// contacts break symmetries slightly in each move. Near singular states these deviations grow
/// large.
class SymmetricStates {
 public:
  /// With all symmetries of the scene's model.
  explicit SymmetricStates(const scene::Scene& scene)
      : SymmetricStates(scene, model::symmetriesOf(scene.model)) {}
  /// With these symmetries, which must be a group.
  SymmetricStates(const scene::Scene& scene, std::vector<model::Symmetry> group);

  /// The preserved symmetries, including the identity.
  const std::vector<model::Symmetry>& group() const { return group_; }

  /// Removes the symmetries that this state does not have.
  void keepThoseOf(const Poses& state);

  /// Replaces a state by the mean of its images under the symmetries. This opens exact joints by
  /// about the square of the images' distance. `dynamics` closes them again. If it cannot, the
  /// state does not change.
  void restore(Poses& poses, Dynamics& dynamics) const;

 private:
  std::vector<model::Symmetry> group_, generators_;
  std::vector<brick::Pivot> pivots_;
  double tile_;  // metres
};

}  // namespace kirireel::run
