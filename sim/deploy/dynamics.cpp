// The choice of a solver for a scene.
#include "sim/deploy/dynamics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/base/interruption.h"
#include "sim/deploy/forces.h"
#include "sim/engines/bullet_world.h"
#include "sim/scene/scene_parts.h"
#include "sim/trajectory/measures.h"

namespace kirireel::deploy {

double misfitStiffness(const scene::Scene& scene, const std::vector<model::Brick>& bricks) {
  return 1e5 * usualStiffness(scene.springs, bricks);
}

bool keepsTolerance(const scene::Scene& scene) {
  return scene.solver.tolerance > 0 && scene.solver.kind == scene::SolverKind::Direct &&
         !scene.solver.substeps && scene.path.kind != scene::PathKind::Guided &&
         !scene.path.jointsAreCompliant();
}

std::unique_ptr<Dynamics> makeDynamics(const scene::Scene& scene, const scene::Needs& needs,
                                       const std::vector<model::Brick>& bricks,
                                       const Poses& start) {
  if (scene.solver.kind == scene::SolverKind::Bullet) {
    return makeBulletDynamics(scene, bricks, start);
  }
  return std::make_unique<DirectDynamics>(scene, needs, bricks, start);
}

// ------------------------------------------------------------------------------------------------
// The direct solver with contacts, in two ways.
//
// *Fixed steps* (advance): the joint solver's own step with a contact finder.
//
// *Steps to a tolerance* (advanceToTolerance): see tolerance_steps.cpp.
//
// Obstacles are pinned bodies after the bricks; they are appended to the poses before the solver is
// called and taken away afterwards.

namespace {

// Overlaps below this part of a tile, and of the thickness, count as none.
constexpr double kTilePart = 1e-5;
constexpr double kThicknessPart = 2e-3;
// Points of bricks touch below this part of the tolerance in time.
constexpr double kTouchingPart = 0.1;
// Joints are closed below this part of a tile.
constexpr double kClosed = 1e-10;

/// Where the bricks of a planar scene rub on the ground: at every vertex, with an even share of the
/// weight.
std::vector<mechanics::Support> groundSupports(const scene::Scene& scene, const scene::Needs& needs,
                                               const std::vector<model::Brick>& bricks) {
  std::vector<mechanics::Support> supports;
  const scene::Environment& environment = scene.environment;
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

/// The bricks and the bodies of obstacles. The latter weigh as much as a brick, so that the
/// solver's mean weight stays what it is without them.
std::vector<model::Brick> bodiesOf(const std::vector<model::Brick>& bricks,
                                   const std::vector<contacts::ObstaclePart>& obstacles) {
  std::vector<model::Brick> bodies = bricks;
  for (const contacts::ObstaclePart& part : obstacles) {
    bodies.push_back(part.body);
    bodies.back().mass = bricks.front().mass;
    bodies.back().inertia = bricks.front().inertia;
  }
  return bodies;
}

/// The forces of all points in which two things touch.
struct PairSum {
  Vector3 force = Vector3::Zero();
  Vector3 moment = Vector3::Zero();  // about the origin
  Vector3 pointSum = Vector3::Zero();
  double weight = 0;

  void add(const mechanics::TouchForce& touch, double sign) {
    force += sign * touch.force;
    moment += sign * touch.point.cross(touch.force);
    const double share = touch.push > 0 ? touch.push : touch.force.norm();
    pointSum += share * touch.point;
    weight += share;
  }

  /// About the middle of what pushes; points that only rub count by that.
  trajectory::Hold resultant(int tile, int other) const {
    const Vector3 point = pointSum / weight;
    return {trajectory::HoldKind::Contact, tile, other, force, moment - point.cross(force), point};
  }
};

/// The solver of a scene's joints and forces between pairs, for its bricks and what else is a body.
std::unique_ptr<mechanics::JointSolver> solverOf(const scene::Scene& scene,
                                                 const scene::Needs& needs,
                                                 const std::vector<model::Brick>& bricks,
                                                 const std::vector<model::Brick>& bodies) {
  scene::Ties ties = scene::dynamicTies(scene, bricks);
  return mechanics::makeJointSolver(
      bodies, ties.pivots,
      {needs.planar.on, model::tileSize(scene.model), groundSupports(scene, needs, bricks),
       std::move(ties.pairForces)});
}

// `countsFrom`: the first tile's number.
void requireFree(const std::optional<contacts::ObstacleOverlap>& overlap, int countsFrom) {
  if (!overlap) return;
  throw InputError(fmt::format(
      "error: tile {} reaches {:.3g} m into obstacle {} at the start; move the obstacle away",
      countsFrom + overlap->brick, overlap->depth, overlap->obstacle));
}

// Obstacles are bodies in space.
void requireSpace(const scene::Scene& scene, const scene::Needs& needs) {
  if (!needs.planar.on || scene.environment.obstacles.empty()) return;
  throw InputError(
      "error: obstacles need bricks that move in space; leave --planar on away, or the obstacles");
}

}  // namespace

DirectDynamics::DirectDynamics(const scene::Scene& scene, const scene::Needs& needs,
                               const std::vector<model::Brick>& bricks, const Poses& start)
    : brickCount_(bricks.size()),
      countsFrom_(scene.model.fileOrder.countsFrom),
      tileSize_(model::tileSize(scene.model)),
      environment_(scene.environment),
      obstacles_(contacts::obstacleParts(scene.environment.obstacles)),
      bodies_(bodiesOf(bricks, obstacles_)),
      solver_(solverOf(scene, needs, bricks, bodies_)),
      substeps_(scene.solver.substeps.value_or(1)),
      keepsEnergy_(scene.hinges.areLigaments || scene.hinges.panels),
      isRubbing_(!groundSupports(scene, needs, bricks).empty()),
      touching_(std::min(kTilePart * tileSize_, kThicknessPart * scene.brick.thickness)) {
  requireSpace(scene, needs);
  if (hasObstacles()) setPinned(std::vector<bool>(brickCount_, false));
  if (!needs.contacts.on && !needs.ground.on && !needs.obstacles.on) return;
  Poses poses = start;
  appendObstacles(poses);
  const auto finder = [&](double tolerance) {
    auto made = std::make_unique<contacts::ContactFinder>(
        bodies_, poses, model::makePivots(scene.model.joints, bricks), scene.environment,
        needs.planar.on, tolerance, obstacles_);
    requireFree(made->overlapWithObstacle(poses), countsFrom_);
    return made;
  };
  contacts_ = finder(touching_);
  if (!keepsTolerance(scene)) return;
  touching_ = std::min(touching_, kTouchingPart * scene.solver.tolerance * tileSize_);
  exactContacts_ = finder(touching_);
}

void DirectDynamics::appendObstacles(Poses& poses) const {
  for (const contacts::ObstaclePart& part : obstacles_) poses.push_back(part.pose);
}

void DirectDynamics::leaveObstacles(Motion& motion) const {
  motion.poses.resize(brickCount_);
  motion.velocities.resize(brickCount_);
}

// Obstacles stay; a state that cannot be closed is given back as it was.
bool DirectDynamics::assemble(Poses& poses) {
  Poses closed = poses;
  appendObstacles(closed);
  if (solver_->assemble(closed) > kClosed * tileSize_) return false;
  closed.resize(brickCount_);
  poses = std::move(closed);
  return true;
}

void DirectDynamics::fitVelocities(Motion& motion) {
  appendObstacles(motion.poses);
  motion.velocities.resize(bodies_.size());
  solver_->collide(motion);
  leaveObstacles(motion);
}

void DirectDynamics::setPinned(const std::vector<bool>& pinned) {
  std::vector<bool> held = pinned;
  held.resize(bodies_.size(), true);
  isPinned_ = std::ranges::find(held, true) != held.end();
  solver_->setPinned(held);
}

/// The actuation with what surrounds the bricks, for all bodies.
mechanics::TimedLoads DirectDynamics::allLoads(const mechanics::TimedLoads& actuation) const {
  return [this, &actuation, brickPoses = Poses()](double seconds, const Poses& poses,
                                                  std::vector<model::Load>& loads) mutable {
    checkInterruption();  // a step may be halved many times
    brickPoses.assign(poses.begin(), poses.begin() + static_cast<std::ptrdiff_t>(brickCount_));
    loads.resize(brickCount_);
    actuation(seconds, brickPoses, loads);
    addEnvironmentLoads(environment_, std::span(bodies_).first(brickCount_), poses, loads);
    loads.resize(bodies_.size());
  };
}

StepReport DirectDynamics::advance(Motion& motion, double step,
                                   const mechanics::LoadSource& actuation) {
  const mechanics::TimedLoads timeless =
      [&](double, const Poses& poses, std::vector<model::Load>& loads) { actuation(poses, loads); };
  const mechanics::TimedLoads all = allLoads(timeless);
  const mechanics::LoadSource now = [&](const Poses& poses, std::vector<model::Load>& loads) {
    all(0, poses, loads);
  };
  appendObstacles(motion.poses);
  motion.velocities.resize(bodies_.size());
  StepReport report;
  for (int substep = 0; substep < substeps_; ++substep) {
    report += solver_->advance(motion, step / substeps_, now, contacts_.get());
  }
  leaveObstacles(motion);
  return report;
}

void DirectDynamics::setTolerance(const TimeTolerance& tolerance) {
  contacts::ContactFinder* exact = exactContacts_ ? exactContacts_.get() : contacts_.get();
  toleranceSteps_ = std::make_unique<ToleranceSteps>(
      bodies_, *solver_, ToleranceContacts{contacts_.get(), exact, touching_, isRubbing_},
      mechanics::ExtrapolationSettings{tolerance.tolerance, tolerance.longestStep, tileSize_,
                                       keepsEnergy_},
      tolerance.firstOrderStep);
}

StepReport DirectDynamics::advanceToTolerance(Motion& motion, double seconds,
                                              const mechanics::TimedLoads& actuation) {
  const mechanics::TimedLoads all = allLoads(actuation);
  appendObstacles(motion.poses);
  motion.velocities.resize(bodies_.size());
  const StepReport report = toleranceSteps_->advance(motion, seconds, all, isPinned_);
  leaveObstacles(motion);
  for (mechanics::PassedState& state : toleranceSteps_->passed()) leaveObstacles(state.motion);
  return report;
}

std::span<const mechanics::PassedState> DirectDynamics::passed() const {
  if (!toleranceSteps_) return {};
  return toleranceSteps_->passed();
}

std::vector<trajectory::Hold> DirectDynamics::contacts(const Poses& poses) const {
  Poses all = poses;
  appendObstacles(all);
  std::map<std::pair<int, int>, PairSum> pairs;
  for (const mechanics::TouchForce& touch : solver_->touchForces(all)) {
    const bool isSwapped = touch.brickB != model::kFixed && touch.brickB < touch.brickA;
    const int tile = isSwapped ? touch.brickB : touch.brickA;
    const int body = isSwapped ? touch.brickA : touch.brickB;
    const auto obstacle = static_cast<std::size_t>(body) - brickCount_;
    const bool isBrick = body < static_cast<int>(brickCount_);
    const int other = body == model::kFixed ? trajectory::Hold::kGround
                      : isBrick             ? body
                                : trajectory::Hold::kFirstObstacle - obstacles_[obstacle].obstacle;
    pairs[{tile, other}].add(touch, isSwapped ? -1 : 1);
  }
  std::vector<trajectory::Hold> holds;
  for (const auto& [pair, sum] : pairs) {
    if (sum.force.isZero(0)) continue;
    holds.push_back(sum.resultant(pair.first, pair.second));
  }
  return holds;
}

std::string DirectDynamics::nameOf(const mechanics::ContactLoad& load) const {
  const int tile = countsFrom_ + load.brickA;
  if (load.brickB == model::kFixed) return fmt::format("tile {} and the ground", tile);
  const std::size_t other = static_cast<std::size_t>(load.brickB);
  return other < brickCount_ ? fmt::format("tiles {} and {}", tile, countsFrom_ + load.brickB)
                             : fmt::format("tile {} and obstacle {}", tile,
                                           obstacles_[other - brickCount_].obstacle);
}

std::vector<std::string> DirectDynamics::loadedContacts() const {
  std::vector<std::string> names;
  for (const mechanics::ContactLoad& load : solver_->contactLoads()) {
    std::string name = nameOf(load);
    // An obstacle may have several parts.
    if (std::ranges::find(names, name) == names.end()) names.push_back(std::move(name));
  }
  return names;
}

void DirectDynamics::transfer(StateTape& tape) {
  tape.transfer(*solver_);
  if (toleranceSteps_) tape.transfer(*toleranceSteps_);
  if (contacts_) tape.transfer(*contacts_);
  if (exactContacts_) tape.transfer(*exactContacts_);
}

// ------------------------------------------------------------------------------------------------
// An engine as the solver of a run: in each of its substeps the loads are computed anew from the
// present poses and applied as plain forces, the damping taken at the present velocities. So an
// engine's step is explicit in the springs, and short substeps are needed where they are stiff.
// What an engine cannot hold (links, obstacles, pins) is refused.

namespace {

constexpr int kSubsteps = 20;  // as PyKirigami has

// The pivots of a scene whose joints are all points that tiles share. Throws InputError at a link.
std::vector<model::Pivot> sharedPivots(const scene::Scene& scene,
                                       const std::vector<model::Brick>& bricks) {
  std::vector<model::Pivot> pivots = model::makePivots(scene.model.joints, bricks);
  for (const model::Pivot& pivot : pivots) {
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
void requireNoObstacles(const scene::Environment& environment) {
  if (environment.obstacles.empty()) return;
  throw InputError("error: --solver bullet knows no obstacles; use --solver direct");
}

}  // namespace

WorldDynamics::WorldDynamics(std::unique_ptr<engines::BrickWorld> world, int substeps,
                             std::size_t brickCount)
    : world_(std::move(world)), substeps_(substeps), loads_(brickCount) {}

// Pinning none is allowed, since every run says so at its start.
void WorldDynamics::setPinned(const std::vector<bool>& pinned) {
  if (std::find(pinned.begin(), pinned.end(), true) == pinned.end()) return;
  throw InputError("error: --solver bullet cannot pin tiles; use --solver direct");
}

// One step as equal substeps. The motion is written to the engine first: what was changed outside
// (closed joints, a reset) counts.
StepReport WorldDynamics::advance(Motion& motion, double step,
                                  const mechanics::LoadSource& actuation) {
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
                                             const mechanics::TimedLoads& actuation) {
  return advance(motion, seconds, [&](const Poses& poses, std::vector<model::Load>& loads) {
    actuation(0, poses, loads);
  });
}

std::unique_ptr<Dynamics> makeBulletDynamics(const scene::Scene& scene,
                                             const std::vector<model::Brick>& bricks,
                                             const Poses& start) {
  requireNoObstacles(scene.environment);
  engines::BulletSettings settings;
  settings.iterations = scene.solver.iterations;
  auto world = std::make_unique<engines::BulletWorld>(bricks, start, sharedPivots(scene, bricks),
                                                      scene.environment, settings);
  return std::make_unique<WorldDynamics>(std::move(world),
                                         scene.solver.substeps.value_or(kSubsteps), bricks.size());
}

// ------------------------------------------------------------------------------------------------
// Keeping a path symmetric. A state is replaced by the mean of its images under the group
// (model/symmetry.h) where it has drifted from it by more than the asymmetry of closed states
// themselves; the mean of closed states is closed to the second order of the drift, and its joints
// are closed again where that is not enough. A mean that cannot be closed is not taken.

namespace {

// A state has a symmetry up to this part of a tile.
constexpr double kSymmetric = 1e-6;
// Below this part of a tile asymmetry is that of the model's own data, which closed states have.
constexpr double kNegligible = 5e-10;
// Joints are closed up to this part of a tile.
constexpr double kClosedImage = 1e-11;

}  // namespace

// The pivots are kept to measure whether a mean is still closed.
SymmetricStates::SymmetricStates(const scene::Scene& scene, std::vector<model::Symmetry> group)
    : group_(std::move(group)), tile_(model::tileSize(scene.model)) {
  pivots_ =
      model::makePivots(scene.model.joints, model::makeBricks(scene.model.tiles, scene.brick));
}

// Drops symmetries that the state does not have, so that the rest are those to be kept from here
// on. The symmetries of one state form a group again.
void SymmetricStates::keepThoseOf(const Poses& state) {
  std::erase_if(group_, [&](const model::Symmetry& symmetry) {
    return model::asymmetry(state, std::span(&symmetry, 1), tile_) > kSymmetric * tile_;
  });
}

// Replaces a state by its mean over the group where it has drifted. It leaves the state as it is
// where the mean cannot be closed.
void SymmetricStates::restore(Poses& poses, Dynamics& dynamics) const {
  if (group_.size() < 2) return;
  if (model::asymmetry(poses, group_, tile_) <= kNegligible * tile_) return;
  Poses mean = model::symmetricMean(poses, group_);
  const bool isExact = !std::isfinite(dynamics.jointStiffness());
  const bool isOpen = isExact && trajectory::jointGap(pivots_, mean).max > kClosedImage * tile_;
  if (isOpen && !dynamics.assemble(mean)) return;
  poses = std::move(mean);
}

// Velocities are averaged always: their mean is a velocity of the mean state to the first order.
void SymmetricStates::restore(Motion& motion, Dynamics& dynamics) const {
  if (group_.size() < 2) return;
  restore(motion.poses, dynamics);
  motion.velocities = model::symmetricMean(motion.velocities, group_);
}

}  // namespace kirireel::deploy
