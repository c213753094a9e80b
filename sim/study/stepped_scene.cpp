// A simpler loop than that of a run: springs of constant stiffness, a perturbation, no path, no
// timeline, no stop. Studies use it to read each step's energy, gap and cost. Its figures measure
// only the solver.
#include "sim/study/stepped_scene.h"

#include <array>

#include <fmt/format.h>

#include "sim/base/interruption.h"
#include "sim/engines/bullet_world.h"
#include "sim/generate/families.h"
#include "sim/model/isometry.h"
#include "sim/run/rest.h"
#include "sim/scene/scene_needs.h"

namespace kirireel::study {
namespace {

constexpr double kLost = 1e3;  // model sizes

// The scene with the method's step, 1 / rate seconds, and its tolerance.
scene::Scene withRate(scene::Scene scene, const Method& method) {
  scene.solver.timestep = 1.0 / method.rate;
  scene.solver.tolerance = method.tolerance;
  return scene;
}

}  // namespace

SteppedScene::SteppedScene(const scene::Scene& scene)
    : SteppedScene(scene, brick::makeBricks(scene.model.tiles, scene.brick),
                   [](const scene::Scene& asked, const std::vector<brick::Brick>& bricks,
                      const Poses& start) {
                     auto made = run::makeDynamics(asked, scene::sceneNeeds(asked), bricks, start);
                     const double step = asked.solver.timestep;
                     if (asked.solver.tolerance > 0) {
                       made->setTolerance({asked.solver.tolerance, step, step});
                     }
                     return made;
                   }) {}

SteppedScene::SteppedScene(const scene::Scene& scene, const Method& method)
    : SteppedScene(withRate(scene, method), brick::makeBricks(scene.model.tiles, scene.brick),
                   dynamicsMaker(method)) {}

SteppedScene::SteppedScene(const scene::Scene& scene, std::vector<brick::Brick> bricks,
                           const DynamicsMaker& makeSolver)
    : scene_(scene),
      bricks_(std::move(bricks)),
      pivots_(brick::makePivots(scene_.model.joints, bricks_)),
      motion_{brick::startPoses(scene_.model.tiles, bricks_),
              std::vector<Velocity>(bricks_.size())},
      size_(model::modelSize(scene_.model)) {
  if (scene_.model.target) {
    springs_.emplace(bricks_, *scene_.model.target, scene_.model.pulledTiles, scene_.springs);
  }
  loads_ = [this](const Poses& poses, std::vector<brick::Load>& out) {
    std::ranges::fill(out, brick::Load{});
    if (springs_) springs_->addLoads(poses, 1, out);
  };
  timedLoads_ = [this](double, const Poses& poses, std::vector<brick::Load>& out) {
    loads_(poses, out);
  };
  const double before = threadCpuSeconds();
  dynamics_ = makeSolver(scene_, bricks_, motion_.poses);
  // Joints that do not close are made compliant, as in a run.
  if (!dynamics_->assemble(motion_.poses))
    dynamics_->setJointStiffness(run::misfitStiffness(scene_, bricks_));
  setupSeconds_ = threadCpuSeconds() - before;
  // Without a perturbation, a run might never leave a singular closed state, which is an
  // equilibrium.
  motion_.velocities = run::perturbation(bricks_, motion_.poses, size_, scene_.solver.seed);
}

void SteppedScene::advance() {
  const double before = threadCpuSeconds();
  const double step = scene_.solver.timestep;
  report_ += scene_.solver.tolerance > 0 ? dynamics_->advanceToTolerance(motion_, step, timedLoads_)
                                         : dynamics_->advance(motion_, step, loads_);
  seconds_ += threadCpuSeconds() - before;
}

// Also false if a position is NaN: no comparison with it is true.
bool SteppedScene::isFinite() const {
  const double bound = kLost * size_;
  return std::all_of(motion_.poses.begin(), motion_.poses.end(),
                     [&](const Pose& pose) { return pose.position.norm() < bound; });
}

// Contacts and closed joints store none.
double SteppedScene::energy() const {
  double energy = trajectory::kineticEnergy(bricks_, motion_);
  if (springs_) energy += springs_->energy(motion_.poses, 1);
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    // Potential energy of gravity: -m g . x, with g the acceleration as a vector.
    energy -= bricks_[i].mass * scene_.environment.gravity.dot(motion_.poses[i].position);
  }
  return energy;
}

// The energy at the start must not be 0, because growth is relative to it.
Stability watchStability(SteppedScene& run, int steps, double cpuSeconds) {
  const double start = run.energy();
  double before = start;
  Stability result;
  while (result.steps < steps && result.finite && run.seconds() < cpuSeconds) {
    run.advance();
    ++result.steps;
    const double after = run.energy();
    result.growth = std::max(result.growth, (after - before) / start);
    result.gap = std::max(result.gap, run.gap() / run.size());
    result.finite = std::isfinite(after) && run.isFinite();
    before = after;
  }
  result.unconverged = run.report().unconverged;
  return result;
}

// ------------------------------------------------------------------------------------------------
// Names and settings of the solvers that studies compare, and the `Dynamics` made from them. Our
// own solver is created as in a run, engines as a BrickWorld within WorldDynamics.

namespace {

// The engines that share BulletWorld differ only in its method.
template <engines::BulletMethod Solver>
std::unique_ptr<engines::BrickWorld> makeBulletWorld(const Method& method,
                                                     const scene::Scene& scene,
                                                     const std::vector<brick::Brick>& bricks,
                                                     const Poses& start) {
  return std::make_unique<engines::BulletWorld>(
      bricks, start, brick::makePivots(scene.model.joints, bricks), scene.environment,
      engines::BulletSettings{Solver, method.iterations, method.jointCorrection});
}

std::unique_ptr<engines::BrickWorld> makeMultiBodyWorld(const Method& method,
                                                        const scene::Scene& scene,
                                                        const std::vector<brick::Brick>& bricks,
                                                        const Poses& start) {
  return engines::makeMultiBodyWorld(bricks, start, brick::makePivots(scene.model.joints, bricks),
                                     scene.environment, method.iterations);
}

}  // namespace

// Findings search for these names in the tables' column "engine".
constinit const Engine kDirect{"direct"};
constinit const Engine kSequentialImpulse{
    "sequential impulse", makeBulletWorld<engines::BulletMethod::SequentialImpulse>};
constinit const Engine kNncg{"nncg", makeBulletWorld<engines::BulletMethod::Nncg>};
constinit const Engine kDantzig{"dantzig", makeBulletWorld<engines::BulletMethod::Dantzig>};
constinit const Engine kMultiBody{"multibody", makeMultiBodyWorld};

Method bulletBaseline() {
  return {kSequentialImpulse, 240, 20, 50};
}

std::vector<Method> sweepMethods(const Engine& engine, Extent extent) {
  struct Sweeps {
    int substeps;
    int iterations;
  };
  std::vector<Sweeps> sweeps{{1, 10}, {1, 50}, {4, 50}, {20, 50}, {20, 200}};
  if (extent == Extent::Full) {
    sweeps.insert(sweeps.end(), {{1, 200}, {4, 10}, {4, 200}, {20, 10}, {20, 1000}});
  }
  std::vector<Method> methods;
  for (const Sweeps& sweep : sweeps) {
    methods.push_back({engine, 240, sweep.substeps, sweep.iterations});
  }
  return methods;
}

// Other engines are named by substeps x iterations, the direct solver by its step, or by its
// tolerance if it has one.
std::string toString(const Method& method) {
  if (method.tolerance > 0) return fmt::format("direct to {:.0e} tiles", method.tolerance);
  if (method.engine == kDirect) return fmt::format("direct 1/{} s", method.rate);
  std::string text =
      fmt::format("{} {} x {}", method.engine.name, method.substeps, method.iterations);
  if (method.jointCorrection != Method{}.jointCorrection) {
    text += fmt::format(" erp {}", method.jointCorrection);
  }
  return text;
}

// Ours takes the whole step. Engines get their substeps from WorldDynamics.
DynamicsMaker dynamicsMaker(const Method& method) {
  return [method](const scene::Scene& scene, const std::vector<brick::Brick>& bricks,
                  const Poses& start) -> std::unique_ptr<run::Dynamics> {
    if (method.engine == kDirect) {
      auto direct = std::make_unique<run::DirectDynamics>(scene, scene::sceneNeeds(scene), bricks,
                                                          start, run::faceContactOf(scene));
      if (method.tolerance > 0) {
        // The tolerance in tiles, the step below which the order is one, and the longest step.
        direct->setTolerance(
            {method.tolerance, scene::SolverSettings{}.timestep, 1.0 / method.rate});
      }
      return direct;
    }
    return std::make_unique<run::WorldDynamics>(
        method.engine.makeWorld(method, scene, bricks, start), method.substeps, bricks.size());
  };
}

std::function<std::vector<StudyCase>(Extent)> sheetCases(const SheetMethods& methods,
                                                         StudyCase (*makeCase)(const SheetMethod&,
                                                                               Extent)) {
  return [methods, makeCase](Extent extent) {
    std::vector<StudyCase> cases;
    for (const SheetMethod& sheet : methods(extent)) cases.push_back(makeCase(sheet, extent));
    return cases;
  };
}

std::vector<std::string> otherEngines(const Table& table, const std::string& motion) {
  std::vector<std::string> found;
  for (const Row& row : table.rows) {
    const std::string& name = table.text(row, "engine");
    const bool isOwn =
        std::ranges::any_of(std::array{kDirect, kSequentialImpulse, kNncg, kDantzig, kMultiBody},
                            [&name](const Engine& engine) { return engine.name == name; });
    const bool isKnown = isOwn || std::ranges::find(found, name) != found.end();
    if (!isKnown && table.text(row, "motion") == motion) found.push_back(name);
  }
  return found;
}

// ------------------------------------------------------------------------------------------------
// A family's model with default parameters as a scene. The best rigid motion aligns its start to
// its target: springs pull the tiles no farther than the deployment needs.

scene::Scene familyScene(const std::string& family) {
  scene::Scene scene;
  scene.model = generate::generateModel(generate::familyNamed(family), {});
  model::alignStartToTarget(scene.model);
  scene.springs = scene::paperSprings();
  return scene;
}

}  // namespace kirireel::study
