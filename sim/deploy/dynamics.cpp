// The choice of a solver for a scene.
#include "sim/deploy/dynamics.h"

#include "sim/deploy/direct_dynamics.h"
#include "sim/deploy/world_dynamics.h"

namespace kirireel {

bool keepsTolerance(const Scene& scene) {
  return scene.solver.tolerance > 0 && scene.solver.kind == SolverKind::Direct &&
         !scene.solver.substeps && scene.path.kind != PathKind::Led && !scene.path.jointsGive();
}

std::unique_ptr<Dynamics> makeDynamics(const Scene& scene, const Needs& needs,
                                       const std::vector<Brick>& bricks, const Poses& start) {
  if (scene.solver.kind == SolverKind::Bullet) {
    return makeBulletDynamics(scene, bricks, start);
  }
  return std::make_unique<DirectDynamics>(scene, needs, bricks, start);
}

}  // namespace kirireel
