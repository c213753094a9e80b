/// The seam between the deployment and the two solvers.
#pragma once

#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim/joints/extrapolation.h"
#include "sim/joints/joint_solver.h"
#include "sim/scene/scene.h"
#include "sim/trajectory/trajectory.h"

namespace kirireel {

/// Of joints that cannot be held exactly, because the tiles do not fit each other in the states on
/// the way, N/m: a hundred thousand times the pull's usual stiffness.
constexpr double kMisfitStiffness = 1e7;

/// Of joints that are held exactly, N/m.
constexpr double kExactJoints = std::numeric_limits<double>::infinity();

/// How exact the motion is to be in time.
struct TimeTolerance {
  double tolerance = 1e-4;            ///< error of a step, tiles, above 0
  double firstOrderStep = 1.0 / 240;  ///< where contacts crowd or joints are singular, seconds
  double longestStep = 1.0 / 60;      ///< seconds
};

/// Whether a scene's run, its path chosen, keeps a tolerance in time. Tiles that are led go by a
/// guide that moves with the steps, on joints that often are compliant: steps are fixed there.
bool keepsTolerance(const Scene& scene);

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

  /// The joints' stiffness at present, N/m; infinity: exact.
  virtual double jointStiffness() const = 0;

  /// The resultants of the contacts of the last step at the poses where the bricks are now, each
  /// pair once, in order of tiles; none where the solver does not tell.
  virtual std::vector<Hold> contacts(const Poses& poses) const = 0;

  /// The contacts that carried load in the last step, the strongest first, as in "tiles 3 and 4",
  /// "tile 3 and the ground", "tile 3 and obstacle 0"; none where the solver does not tell.
  virtual std::vector<std::string> loadedContacts() const = 0;

  /// Advances the motion by `step` seconds; `actuation` gives the loads beyond gravity and damping.
  virtual StepReport advance(Motion& motion, double step, const LoadSource& actuation) = 0;

  /// To be called before advanceToTolerance() and transfer(), where the former is used.
  /// A solver whose scene has a tolerance itself also keeps it where bricks touch.
  virtual void setTolerance(const TimeTolerance& tolerance) = 0;
  /// The same with loads that change on the way, in steps that keep the tolerance where that can be
  /// done, else in fixed steps of first order: see TimeTolerance. Joints must be exact.
  virtual StepReport advanceToTolerance(Motion& motion, double seconds,
                                        const TimedLoads& actuation) = 0;

  /// The states between the ends of the last call of advanceToTolerance(), in order.
  virtual std::span<const PassedState> passed() const = 0;

  /// What the next step takes from those before, beside the motion, as far as the solver tells: an
  /// engine does not.
  virtual void transfer(StateTape& tape) = 0;
};

/// The solver that the scene asks for.
std::unique_ptr<Dynamics> makeDynamics(const Scene& scene, const Needs& needs,
                                       const std::vector<Brick>& bricks, const Poses& start);

}  // namespace kirireel
