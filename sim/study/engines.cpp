// One name for each solver that studies compare, with its settings, and the `Dynamics` that it
// becomes. Our own solver is made as a run makes it, engines as a BrickWorld within WorldDynamics.
#include "sim/study/engines.h"

#include <algorithm>

#include <fmt/format.h>

#include "sim/deploy/direct_dynamics.h"
#include "sim/deploy/world_dynamics.h"
#include "sim/world/baseline_worlds.h"
#include "sim/world/bullet_world.h"
#include "sim/world/multi_body_world.h"

namespace kirireel {
namespace {

// The engines that share BulletWorld differ in this alone. All others count as the usual sweeps.
BulletMethod bulletMethod(Engine engine) {
  if (engine == Engine::Nncg) return BulletMethod::Nncg;
  if (engine == Engine::Dantzig) return BulletMethod::Dantzig;
  return BulletMethod::SequentialImpulse;
}

// Null for an engine that this build lacks.
std::unique_ptr<BrickWorld> makeWorld(const Method& method, const Scene& scene,
                                      const std::vector<Brick>& bricks, const Poses& start) {
  const std::vector<Pivot> pivots = makePivots(scene.model.joints, bricks);
  const Environment& environment = scene.environment;
  if (method.engine == Engine::MultiBody) {
    return std::make_unique<MultiBodyWorld>(bricks, start, pivots, environment, method.iterations);
  }
  if (method.engine == Engine::Chipmunk) {
    return makeChipmunkWorld(bricks, start, pivots, environment, method.iterations);
  }
  if (method.engine == Engine::Box2d) {
    return makeBox2dWorld(bricks, start, pivots, environment, method.iterations,
                          // Box2D recommends 8 iterations for velocities and 3 for positions.
                          std::max(1, 3 * method.iterations / 8));
  }
  if (method.engine == Engine::Mujoco) {
    return makeMujocoWorld(bricks, start, pivots, environment, sceneNeeds(scene).planar.on);
  }
  return std::make_unique<BulletWorld>(
      bricks, start, pivots, environment,
      BulletSettings{bulletMethod(method.engine), method.iterations, method.jointCorrection});
}

}  // namespace

// These words stand in the tables' column "engine" and are what findings look for.
std::string toString(Engine engine) {
  switch (engine) {
    case Engine::Direct:
      return "direct";
    case Engine::SequentialImpulse:
      return "sequential impulse";
    case Engine::Nncg:
      return "nncg";
    case Engine::Dantzig:
      return "dantzig";
    case Engine::MultiBody:
      return "multibody";
    case Engine::Chipmunk:
      return "chipmunk";
    case Engine::Box2d:
      return "box2d";
    case Engine::Mujoco:
      return "mujoco";
  }
  return "unknown";
}

// Bullet is always there.
bool isAvailable(Engine engine) {
  switch (engine) {
    case Engine::Chipmunk:
      return !chipmunkVersion().empty();
    case Engine::Box2d:
      return !box2dVersion().empty();
    case Engine::Mujoco:
      return !mujocoVersion().empty();
    default:
      return true;
  }
}

Method bulletBaseline() {
  return {Engine::SequentialImpulse, 240, 20, 50};
}

// Engines are told by substeps x iterations; ours by its step, or by its tolerance where it has
// one.
std::string toString(const Method& method) {
  if (method.tolerance > 0) return fmt::format("direct to {:.0e} tiles", method.tolerance);
  if (method.engine == Engine::Direct) return fmt::format("direct 1/{} s", method.rate);
  std::string text =
      fmt::format("{} {} x {}", toString(method.engine), method.substeps, method.iterations);
  if (method.jointCorrection != Method{}.jointCorrection) {
    text += fmt::format(" erp {}", method.jointCorrection);
  }
  return text;
}

// Ours takes the whole step as it is. Engines get their substeps from WorldDynamics.
DynamicsMaker dynamicsMaker(const Method& method) {
  return [method](const Scene& scene, const std::vector<Brick>& bricks,
                  const Poses& start) -> std::unique_ptr<Dynamics> {
    if (method.engine == Engine::Direct) {
      auto direct = std::make_unique<DirectDynamics>(scene, sceneNeeds(scene), bricks, start);
      if (method.tolerance > 0) {
        // The tolerance in tiles, the step where order drops to one, and the longest step.
        direct->setTolerance({method.tolerance, SolverSettings{}.timestep, 1.0 / method.rate});
      }
      return direct;
    }
    return std::make_unique<WorldDynamics>(makeWorld(method, scene, bricks, start), method.substeps,
                                           bricks.size());
  };
}

}  // namespace kirireel
