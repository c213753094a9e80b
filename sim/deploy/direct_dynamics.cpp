#include "sim/deploy/direct_dynamics.h"

#include <algorithm>

#include "sim/actuation/environment_load.h"

namespace kirireel {

namespace {

// Overlaps below this part of a tile, and of the thickness, count as none.
constexpr double kTilePart = 1e-5;
constexpr double kThicknessPart = 2e-3;

/// Where the bricks of a planar scene rub on the ground: at every vertex, with an even share of the
/// weight.
std::vector<Support> groundSupports(const Scene& scene, const Needs& needs,
                                    const std::vector<Brick>& bricks) {
  std::vector<Support> supports;
  const Environment& environment = scene.environment;
  if (!needs.planar.on || !environment.ground) return supports;
  const double push = environment.ground->friction * std::max(0.0, -environment.gravity.z());
  if (push == 0) return supports;
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    const double share = bricks[i].mass / static_cast<double>(bricks[i].bottom.size());
    for (const Vector3& point : bricks[i].bottom) {
      supports.push_back({static_cast<int>(i), point, push * share});
    }
  }
  return supports;
}

}  // namespace

DirectDynamics::DirectDynamics(const Scene& scene, const Needs& needs,
                               const std::vector<Brick>& bricks, const Poses& start)
    : bricks_(bricks),
      environment_(scene.environment),
      solver_(makeJointSolver(
          bricks, makePivots(scene.model.joints, bricks),
          {needs.planar.on, tileSize(scene.model), groundSupports(scene, needs, bricks)})),
      substeps_(scene.solver.substeps.value_or(1)) {
  if (!needs.contacts.on && !needs.ground.on) return;
  contacts_ = std::make_unique<ContactFinder>(
      bricks, start, makePivots(scene.model.joints, bricks), scene.environment, needs.planar.on,
      std::min(kTilePart * tileSize(scene.model), kThicknessPart * scene.brick.thickness));
}

StepReport DirectDynamics::advance(Motion& motion, double step, const LoadSource& actuation) {
  const LoadSource all = [&](const Poses& poses, std::vector<Load>& loads) {
    actuation(poses, loads);
    for (std::size_t i = 0; i < loads.size(); ++i) {
      addEnvironmentLoad(environment_, bricks_[i], poses[i], loads[i]);
    }
  };
  StepReport report;
  for (int substep = 0; substep < substeps_; ++substep) {
    report += solver_->advance(motion, step / substeps_, all, contacts_.get());
  }
  return report;
}

}  // namespace kirireel
