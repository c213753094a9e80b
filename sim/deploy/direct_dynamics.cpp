#include "sim/deploy/direct_dynamics.h"

#include "sim/actuation/environment_load.h"

namespace kirireel {

DirectDynamics::DirectDynamics(const Scene& scene, const Needs& needs,
                               const std::vector<Brick>& bricks)
    : bricks_(bricks),
      environment_(scene.environment),
      solver_(makeJointSolver(bricks, makePivots(scene.model.joints, bricks),
                              {needs.planar.on, tileSize(scene.model), {}})),
      substeps_(scene.solver.substeps.value_or(1)) {}

StepReport DirectDynamics::advance(Motion& motion, double step, const LoadSource& actuation) {
  const LoadSource all = [&](const Poses& poses, std::vector<Load>& loads) {
    actuation(poses, loads);
    for (std::size_t i = 0; i < loads.size(); ++i) {
      addEnvironmentLoad(environment_, bricks_[i], poses[i], loads[i]);
    }
  };
  StepReport report;
  for (int substep = 0; substep < substeps_; ++substep) {
    report += solver_->advance(motion, step / substeps_, all, nullptr);
  }
  return report;
}

}  // namespace kirireel
