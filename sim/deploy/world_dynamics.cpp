// An engine as the solver of a run: in each of its substeps the loads are computed anew from the
// present poses and applied as plain forces, the damping taken at the present velocities. So an
// engine's step is explicit in the springs, and short substeps are needed where they are stiff.
// What an engine cannot hold (links, obstacles, pins) is refused.
#include "sim/deploy/world_dynamics.h"

#include <algorithm>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/world/bullet_world.h"

namespace kirireel {
namespace {

constexpr int kSubsteps = 20;  // as PyKirigami has

// The pivots of a scene whose joints are all points that tiles share. Throws InputError at a link.
std::vector<Pivot> sharedPivots(const Scene& scene, const std::vector<Brick>& bricks) {
  std::vector<Pivot> pivots = makePivots(scene.model.joints, bricks);
  for (const Pivot& pivot : pivots) {
    if (pivot.distance == 0) continue;
    throw InputError(fmt::format(
        "error: tiles {} and {} are linked at a distance, which --solver bullet cannot hold; "
        "use --solver direct",
        scene.model.fileOrder.countsFrom + pivot.brickA,
        scene.model.fileOrder.countsFrom + pivot.brickB));
  }
  return pivots;
}

// Throws InputError for a scene with obstacles.
void requireNoObstacles(const Environment& environment) {
  if (environment.obstacles.empty()) return;
  throw InputError("error: --solver bullet knows no obstacles; use --solver direct");
}

}  // namespace

WorldDynamics::WorldDynamics(std::unique_ptr<BrickWorld> world, int substeps,
                             std::size_t brickCount)
    : world_(std::move(world)), substeps_(substeps), loads_(brickCount) {}

// Pinning none is allowed, since every run says so at its start.
void WorldDynamics::setPinned(const std::vector<bool>& pinned) {
  if (std::find(pinned.begin(), pinned.end(), true) == pinned.end()) return;
  throw InputError("error: --solver bullet cannot pin tiles; use --solver direct");
}

// One step as equal substeps. The motion is written to the engine first: what was changed outside
// (closed joints, a reset) counts.
StepReport WorldDynamics::advance(Motion& motion, double step, const LoadSource& actuation) {
  world_->writeMotion(motion);
  for (int substep = 0; substep < substeps_; ++substep) {
    actuation(motion.poses, loads_);
    for (std::size_t i = 0; i < loads_.size(); ++i) {
      Vector6 velocity;
      velocity << motion.velocities[i].linear, motion.velocities[i].angular;
      // An engine takes no stiffness or damping: the load is a plain force at the present state.
      const Vector6 force = loads_[i].force - loads_[i].damping * velocity;
      world_->applyLoad(static_cast<int>(i), force.head<3>(), force.tail<3>());
    }
    world_->advance(step / substeps_);
    world_->readMotion(motion);
  }
  StepReport report;
  report.steps = substeps_;
  return report;
}

// An engine has no estimate of its error: it takes the time as one step.
StepReport WorldDynamics::advanceToTolerance(Motion& motion, double seconds,
                                             const TimedLoads& actuation) {
  return advance(motion, seconds,
                 [&](const Poses& poses, std::vector<Load>& loads) { actuation(0, poses, loads); });
}

std::unique_ptr<Dynamics> makeBulletDynamics(const Scene& scene, const std::vector<Brick>& bricks,
                                             const Poses& start) {
  requireNoObstacles(scene.environment);
  BulletSettings settings;
  settings.iterations = scene.solver.iterations;
  auto world = std::make_unique<BulletWorld>(bricks, start, sharedPivots(scene, bricks),
                                             scene.environment, settings);
  return std::make_unique<WorldDynamics>(std::move(world),
                                         scene.solver.substeps.value_or(kSubsteps), bricks.size());
}

}  // namespace kirireel
