#include "sim/deploy/bullet_dynamics.h"

namespace kirireel {
namespace {

constexpr int kSubsteps = 20;  // as PyKirigami has

}  // namespace

BulletDynamics::BulletDynamics(const Scene& scene, const std::vector<Brick>& bricks,
                               const Poses& start)
    : world_(bricks, start, makePivots(scene.model.joints, bricks), scene.environment,
             scene.solver.iterations),
      substeps_(scene.solver.substeps.value_or(kSubsteps)),
      loads_(bricks.size()) {}

StepReport BulletDynamics::advance(Motion& motion, double step, const LoadSource& actuation) {
  world_.writeMotion(motion);
  for (int substep = 0; substep < substeps_; ++substep) {
    actuation(motion.poses, loads_);
    for (std::size_t i = 0; i < loads_.size(); ++i) {
      Vector6 velocity;
      velocity << motion.velocities[i].linear, motion.velocities[i].angular;
      const Vector6 force = loads_[i].force - loads_[i].damping * velocity;
      world_.applyLoad(static_cast<int>(i), force.head<3>(), force.tail<3>());
    }
    world_.advance(step / substeps_);
    world_.readMotion(motion);
  }
  StepReport report;
  report.steps = substeps_;
  return report;
}

}  // namespace kirireel
