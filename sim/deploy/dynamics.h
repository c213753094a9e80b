/// The dynamics of bricks: what a deployment steps through, whatever solver there is.
#pragma once

#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim/contacts/contact_finder.h"
#include "sim/deploy/tolerance_steps.h"
#include "sim/engines/brick_world.h"
#include "sim/mechanics/extrapolation.h"
#include "sim/mechanics/joint_solver.h"
#include "sim/model/brick.h"
#include "sim/model/hinge.h"
#include "sim/model/isometry.h"
#include "sim/scene/scene.h"
#include "sim/trajectory/trajectory.h"

namespace kirireel::deploy {

// ------------------------------------------------------------------------------------------------
// The seam between the deployment and the two solvers.

/// The joint ratio where joints cannot be held exactly, because the tiles do not fit each other in
/// the states on the way.
inline constexpr double kMisfitRatio = 2.5e4;

/// The stiffness of such joints, N/m.
double misfitStiffness(const scene::Scene& scene, const std::vector<model::Brick>& bricks);

/// Of joints that are held exactly, N/m.
constexpr double kExactJoints = std::numeric_limits<double>::infinity();

/// How exact the motion is to be in time.
struct TimeTolerance {
  double tolerance = 1e-4;            ///< error of a step, tiles, above 0
  double firstOrderStep = 1.0 / 240;  ///< where contacts crowd or joints are singular, seconds
  double longestStep = 1.0 / 60;      ///< seconds
};

/// Whether a scene's run, its path chosen, keeps a tolerance in time. Guided tiles go by a
/// guide that moves with the steps, on joints that often are compliant: steps are fixed there.
bool keepsTolerance(const scene::Scene& scene);

/// Advances all bricks by one step.
class Dynamics {
 public:
  virtual ~Dynamics() = default;

  /// Closes joints that are open, where the solver does that. Returns false, and changes nothing,
  /// where it cannot be done: tiles that do not fit each other in any state nearby.
  virtual bool assemble(Poses& poses) = 0;

  /// Takes from the velocities what joints do not allow, where the solver does that.
  virtual void fitVelocities(Motion& /*motion*/) {}

  /// Holds these bricks where they are until told otherwise; one entry a brick. Throws InputError
  /// where the solver cannot.
  virtual void setPinned(const std::vector<bool>& pinned) = 0;
  /// Makes joints springs, or exact again; see JointSolver::setJointStiffness.
  virtual void setJointStiffness(double stiffness) = 0;
  /// Has steps that fail tried in halves or not; see JointSolverSettings::isHalving.
  virtual void setHalving(bool /*isOn*/) {}

  /// The joints' stiffness at present, N/m; infinity: exact.
  virtual double jointStiffness() const = 0;

  /// The resultants of the contacts of the last step at the poses where the bricks are now, each
  /// pair once, in order of tiles; none where the solver does not tell.
  virtual std::vector<trajectory::Hold> contacts(const Poses& poses) const = 0;

  /// The contacts that carried load in the last step, the strongest first, as in "tiles 3 and 4",
  /// "tile 3 and the ground", "tile 3 and obstacle 0"; none where the solver does not tell.
  virtual std::vector<std::string> loadedContacts() const = 0;

  /// Advances the motion by `step` seconds; `actuation` gives the loads beyond gravity and damping.
  virtual StepReport advance(Motion& motion, double step,
                             const mechanics::LoadSource& actuation) = 0;

  /// To be called before advanceToTolerance() and transfer(), where the former is used.
  /// A solver whose scene has a tolerance itself also keeps it where bricks touch.
  virtual void setTolerance(const TimeTolerance& tolerance) = 0;
  /// The same with loads that change on the way, in steps that keep the tolerance where that can be
  /// done, else in fixed steps of first order: see TimeTolerance. Joints must be exact.
  virtual StepReport advanceToTolerance(Motion& motion, double seconds,
                                        const mechanics::TimedLoads& actuation) = 0;

  /// The states between the ends of the last call of advanceToTolerance(), in order.
  virtual std::span<const mechanics::PassedState> passed() const = 0;

  /// What the next step takes from those before, beside the motion, as far as the solver tells: an
  /// engine does not.
  virtual void transfer(StateTape& tape) = 0;
};

/// The solver that the scene asks for.
std::unique_ptr<Dynamics> makeDynamics(const scene::Scene& scene, const scene::Needs& needs,
                                       const std::vector<model::Brick>& bricks, const Poses& start);

// ------------------------------------------------------------------------------------------------
// `--solver direct`: exact joints.

/// The direct joint solver with implicit loads, and the contacts that the scene needs.
class DirectDynamics : public Dynamics {
 public:
  /// Throws InputError for a planar scene with obstacles, for a tile that lies in an obstacle at
  /// the start, and for springs or ligaments that the scene cannot have. `bricks` may end with the
  /// call.
  DirectDynamics(const scene::Scene& scene, const scene::Needs& needs,
                 const std::vector<model::Brick>& bricks, const Poses& start);

  bool assemble(Poses& poses) override;
  void fitVelocities(Motion& motion) override;
  void setPinned(const std::vector<bool>& pinned) override;
  void setJointStiffness(double stiffness) override { solver_->setJointStiffness(stiffness); }
  void setHalving(bool isOn) override { solver_->setHalving(isOn); }
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

  std::vector<model::Brick> bricks_;
  int countsFrom_;   // the first tile, in messages
  double tileSize_;  // metres
  scene::Environment environment_;
  std::unique_ptr<mechanics::JointSolver> solver_;
  int substeps_;
  bool keepsEnergy_;                                   // to a tolerance in time
  bool isRubbing_;                                     // planar bricks on a ground with friction
  bool isPinned_ = false;                              // some brick
  double touching_;                                    // gap of points that touch, metres
  std::unique_ptr<contacts::ContactFinder> contacts_;  // null where nothing can be touched
  /// The same, finer, for steps to a tolerance; null without one.
  std::unique_ptr<contacts::ContactFinder> exactContacts_;
  std::unique_ptr<ToleranceSteps> toleranceSteps_;  // null where no tolerance is asked for
};

// ------------------------------------------------------------------------------------------------
// Bricks in the world of a physics engine: the baselines.

/// An engine's own solver in short substeps, with the actuation taken anew in each.
class WorldDynamics : public Dynamics {
 public:
  /// `substeps` of the engine in each step.
  WorldDynamics(std::unique_ptr<engines::BrickWorld> world, int substeps, std::size_t brickCount);

  bool assemble(Poses& /*poses*/) override {
    return true;  // engines pull open joints together as they go
  }
  void setPinned(const std::vector<bool>& pinned) override;
  void setJointStiffness(double /*stiffness*/) override {}         // they give as it is
  double jointStiffness() const override { return kExactJoints; }  // as far as engines tell
  std::vector<trajectory::Hold> contacts(const Poses& /*poses*/) const override { return {}; }
  std::vector<std::string> loadedContacts() const override { return {}; }
  StepReport advance(Motion& motion, double step, const mechanics::LoadSource& actuation) override;
  void setTolerance(const TimeTolerance& /*tolerance*/) override {}  // engines step by fixed steps
  StepReport advanceToTolerance(Motion& motion, double seconds,
                                const mechanics::TimedLoads& actuation) override;
  std::span<const mechanics::PassedState> passed() const override { return {}; }
  void transfer(StateTape& /*tape*/) override {}

 private:
  std::unique_ptr<engines::BrickWorld> world_;
  int substeps_;
  std::vector<model::Load> loads_;
};

/// `--solver bullet`: Bullet's sequential impulses.
/// Throws InputError for links and obstacles.
std::unique_ptr<Dynamics> makeBulletDynamics(const scene::Scene& scene,
                                             const std::vector<model::Brick>& bricks,
                                             const Poses& start);

// ------------------------------------------------------------------------------------------------
// States that keep the symmetries of their model.

/// Keeps a path to the symmetries that its model and its ends have: rounding, and contacts that are
/// found in the order of the bricks, break them a little in each move, and singular states make
/// much of a little.
class SymmetricStates {
 public:
  /// With all symmetries of the scene's model.
  explicit SymmetricStates(const scene::Scene& scene)
      : SymmetricStates(scene, model::symmetriesOf(scene.model)) {}
  /// With these, a group.
  SymmetricStates(const scene::Scene& scene, std::vector<model::Symmetry> group);

  /// The symmetries that states keep; the identity alone where there are none.
  const std::vector<model::Symmetry>& group() const { return group_; }

  /// Leaves those symmetries alone that a state has, too.
  void keepThoseOf(const Poses& state);

  /// Replaces a state by the mean of its images under the symmetries. Exact joints that this opens,
  /// by about the square of the images' distance, are closed again by `dynamics`; a state in which
  /// they cannot be stays as it is.
  void restore(Poses& poses, Dynamics& dynamics) const;

 private:
  std::vector<model::Symmetry> group_;
  std::vector<model::Pivot> pivots_;
  double tile_;  // metres
};

}  // namespace kirireel::deploy
