#include "sim/deploy/assembled_state.h"

#include <cmath>

#include "sim/actuation/target_guide.h"
#include "sim/actuation/target_springs.h"
#include "sim/deploy/dynamics.h"
#include "sim/measure/measures.h"

namespace kirireel {
namespace {

// Steps start from rest, so that long ones come near to Newton's method on the springs' energy.
constexpr double kStep = 0.25;  // seconds
constexpr double kStiffening = 16;
constexpr int kSteps = 200;
constexpr double kConverged = 1e-7;    // change of the error in a step, relative
constexpr double kNegligible = 1e-12;  // error in tile edges

}  // namespace

AssembledState assembleAtTarget(const Scene& scene) {
  if (!scene.model.target) return {};
  Scene alone = scene;
  alone.environment = Environment{};
  alone.solver.kind = SolverKind::Direct;
  const std::vector<Tile>& target = *scene.model.target;
  const std::vector<Brick> bricks = makeBricks(scene.model.tiles, scene.brick);
  Motion motion{bestFitPoses(bricks, target), std::vector<Velocity>(bricks.size())};
  const std::unique_ptr<Dynamics> dynamics =
      makeDynamics(alone, sceneNeeds(alone), bricks, motion.poses);
  if (!dynamics->assemble(motion.poses)) dynamics->setJointStiffness(kMisfitStiffness);

  const TargetSprings springs(bricks, target, scene.model.pulledTiles, scene.springs);
  const LoadSource pull = [&springs](const Poses& poses, std::vector<Load>& loads) {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      loads[i] = springs.load(static_cast<int>(i), poses[i], kStiffening);
    }
  };
  const double negligible = kNegligible * tileSize(scene.model);
  double error = targetError(target, bricks, motion.poses);
  for (int step = 0; step < kSteps && error > negligible; ++step) {
    motion.velocities.assign(bricks.size(), Velocity{});
    dynamics->advance(motion, kStep, pull);
    const double before = error;
    error = targetError(target, bricks, motion.poses);
    if (std::abs(error - before) <= kConverged * error) break;
  }
  return {error, std::move(motion.poses)};
}

}  // namespace kirireel
