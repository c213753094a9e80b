// The choice of a solver for a scene.
#include "sim/run/dynamics.h"

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
#include "sim/engines/bullet_world.h"
#include "sim/mechanics/friction_region.h"
#include "sim/run/forces.h"
#include "sim/scene/scene_parts.h"
#include "sim/trajectory/measures.h"

namespace kirireel::run {

double misfitStiffness(const scene::Scene& scene, const std::vector<brick::Brick>& bricks) {
  return kMisfitRatio * placeStiffness(scene.springs, bricks);
}

bool keepsTolerance(const scene::Scene& scene) {
  return scene.solver.tolerance > 0 && scene.solver.kind == scene::SolverKind::Direct &&
         !scene.solver.substeps && scene.path.kind != scene::PathKind::Guided &&
         !scene.path.jointsAreCompliant();
}

std::vector<mechanics::Support> frictionOnGround(const scene::Environment& environment,
                                                 const std::vector<brick::Brick>& bricks) {
  std::vector<mechanics::Support> supports;
  if (!environment.ground) return supports;
  const double push = environment.ground->friction * std::max(0.0, -environment.gravity.z());
  if (push == 0) return supports;
  std::vector<std::vector<std::vector<Vector3>>> parts(bricks.size());
  for (const brick::BrickPiece& piece : brick::convexPieces(bricks)) {
    parts[static_cast<std::size_t>(piece.brick)].push_back(piece.shape.bottom);
  }
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    for (const mechanics::FrictionPoint& part : mechanics::evenPressure(parts[i])) {
      supports.push_back({static_cast<int>(i), part.point, push * bricks[i].mass * part.share});
    }
  }
  return supports;
}

contacts::FaceContact faceContactOf(const scene::Scene& scene) {
  const bool isPulled =
      scene.actuation.drive == scene::Drive::Target && scene.model.target && scene.springs.pull();
  return isPulled ? contacts::FaceContact::Plane : contacts::FaceContact::Region;
}

std::unique_ptr<Dynamics> makeDynamics(const scene::Scene& scene, const scene::Needs& needs,
                                       const std::vector<brick::Brick>& bricks, const Poses& start,
                                       contacts::FaceContact faces) {
  if (scene.solver.kind == scene::SolverKind::Bullet) {
    return makeBulletDynamics(scene, bricks, start);
  }
  return std::make_unique<DirectDynamics>(scene, needs, bricks, start, faces);
}

std::unique_ptr<Dynamics> makeDynamics(const scene::Scene& scene, const scene::Needs& needs,
                                       const std::vector<brick::Brick>& bricks,
                                       const Poses& start) {
  return makeDynamics(scene, needs, bricks, start, faceContactOf(scene));
}

// ------------------------------------------------------------------------------------------------
// The direct solver with contacts. It has two kinds of steps.
//
// *Fixed steps* (advance): the joint solver's own step with a contact finder.
//
// *Steps to a tolerance* (advanceToTolerance): see tolerance_steps.cpp.
//
// The solver handles obstacles and the ground only through their contacts.

namespace {

// Smaller overlaps, as a fraction of a tile and of the thickness, are ignored.
constexpr double kTilePart = 1e-5;
constexpr double kThicknessPart = 2e-3;
// Points of bricks touch below this fraction of the tolerance in time.
constexpr double kTouchingPart = 0.1;

/// Whether the bricks of a planar scene press on the ground.
bool liesOnGround(const scene::Scene& scene, const scene::Needs& needs) {
  return needs.planar.on && scene.environment.ground && scene.environment.gravity.z() < 0;
}

/// Points of friction of the bricks of a planar scene on the ground.
std::vector<mechanics::Support> groundSupports(const scene::Scene& scene, const scene::Needs& needs,
                                               const std::vector<brick::Brick>& bricks) {
  if (!liesOnGround(scene, needs)) return {};
  return frictionOnGround(scene.environment, bricks);
}

/// The forces of all contact points of two bodies.
struct PairSum {
  Vector3 force = Vector3::Zero();
  Vector3 moment = Vector3::Zero();  // about the origin
  Vector3 pointSum = Vector3::Zero();
  double weight = 0;
  bool isPushed = false;  // points with only friction count until one pushes

  void add(const mechanics::TouchForce& touch, double sign) {
    force += sign * touch.force;
    moment += sign * touch.point.cross(touch.force);
    if (touch.push > 0 && !std::exchange(isPushed, true)) {
      pointSum.setZero();
      weight = 0;
    }
    const double share = isPushed ? touch.push : touch.force.norm();
    pointSum += share * touch.point;
    weight += share;
  }

  /// About the centre of the pushing points, or of the friction points if no point pushes.
  trajectory::Hold resultant(int tile, int other) const {
    const Vector3 point = pointSum / weight;
    return {trajectory::HoldKind::Contact, tile, other, force, moment - point.cross(force), point};
  }
};

/// The solver of a scene's joints and forces between pairs.
std::unique_ptr<mechanics::JointSolver> solverOf(const scene::Scene& scene,
                                                 const scene::Needs& needs,
                                                 const std::vector<brick::Brick>& bricks) {
  scene::Ties ties = scene::dynamicTies(scene, bricks);
  return mechanics::makeJointSolver(
      bricks, ties.pivots,
      {needs.planar.on, model::tileSize(scene.model), groundSupports(scene, needs, bricks),
       std::move(ties.pairForces)});
}

void requireFree(const std::optional<contacts::ObstacleOverlap>& overlap,
                 const model::Model& model) {
  if (!overlap) return;
  throw InputError(
      fmt::format("error: tile {} overlaps obstacle {} by {} at the start. Move the obstacle",
                  model.fileOrder.countsFrom + overlap->brick, overlap->obstacle,
                  lengthText(overlap->depth, model.unit)));
}

// Obstacles are bodies in space.
void requireSpace(const scene::Scene& scene, const scene::Needs& needs) {
  if (!needs.planar.on || scene.environment.obstacles.empty()) return;
  throw InputError(
      "error: obstacles work only with bricks in space. Remove `planar = on` or the obstacles");
}

}  // namespace

DirectDynamics::DirectDynamics(const scene::Scene& scene, const scene::Needs& needs,
                               const std::vector<brick::Brick>& bricks, const Poses& start,
                               contacts::FaceContact faces)
    : bricks_(bricks),
      countsFrom_(scene.model.fileOrder.countsFrom),
      tileSize_(model::tileSize(scene.model)),
      environment_(scene.environment),
      solver_(solverOf(scene, needs, bricks_)),  // which refers to its bricks
      substeps_(scene.solver.substeps.value_or(1)),
      keepsEnergy_(!scene::dynamicTies(scene, bricks).pairForces.empty()),
      isLying_(liesOnGround(scene, needs)),
      hasGroundFriction_(!groundSupports(scene, needs, bricks).empty()),
      touching_(std::min(kTilePart * tileSize_, kThicknessPart * scene.brick.thickness)) {
  requireSpace(scene, needs);
  if (!needs.contacts.on && !needs.ground.on && !needs.obstacles.on) return;
  const auto finder = [&](double tolerance) {
    auto made = std::make_unique<contacts::ContactFinder>(
        bricks, start, brick::makePivots(scene.model.joints, bricks), scene.environment,
        needs.planar.on, tolerance, faces);
    requireFree(made->overlapWithObstacle(start), scene.model);
    return made;
  };
  contacts_ = finder(touching_);
  if (!keepsTolerance(scene)) return;
  touching_ = std::min(touching_, kTouchingPart * scene.solver.tolerance * tileSize_);
  exactContacts_ = finder(touching_);
}

// Leaves a state that cannot be closed unchanged.
bool DirectDynamics::assemble(Poses& poses) {
  Poses closed = poses;
  if (solver_->assemble(closed) > model::kClosedShare * tileSize_) return false;
  poses = std::move(closed);
  return true;
}

void DirectDynamics::fitVelocities(Motion& motion) {
  solver_->collide(motion);
}

void DirectDynamics::setPinned(const std::vector<bool>& pinned) {
  isPinned_ = std::ranges::find(pinned, true) != pinned.end();
  solver_->setPinned(pinned);
}

/// The actuation with the environment.
mechanics::TimedLoads DirectDynamics::allLoads(const mechanics::TimedLoads& actuation) const {
  return [this, &actuation](double seconds, const Poses& poses, std::vector<brick::Load>& loads) {
    checkInterruption();  // a step may be halved many times
    actuation(seconds, poses, loads);
    addEnvironmentLoads(environment_, bricks_, poses, loads);
  };
}

StepReport DirectDynamics::advance(Motion& motion, double step,
                                   const mechanics::LoadSource& actuation) {
  const mechanics::TimedLoads timeless =
      [&](double, const Poses& poses, std::vector<brick::Load>& loads) { actuation(poses, loads); };
  const mechanics::TimedLoads all = allLoads(timeless);
  const mechanics::LoadSource now = [&](const Poses& poses, std::vector<brick::Load>& loads) {
    all(0, poses, loads);
  };
  StepReport report;
  for (int substep = 0; substep < substeps_; ++substep) {
    report += solver_->advance(motion, step / substeps_, now, contacts_.get());
  }
  return report;
}

void DirectDynamics::setTolerance(const TimeTolerance& tolerance) {
  contacts::ContactFinder* exact = exactContacts_ ? exactContacts_.get() : contacts_.get();
  toleranceSteps_ = std::make_unique<ToleranceSteps>(
      bricks_, *solver_, ToleranceContacts{contacts_.get(), exact, touching_, hasGroundFriction_},
      mechanics::ExtrapolationSettings{tolerance.tolerance, tolerance.longestStep, tileSize_,
                                       keepsEnergy_},
      tolerance.firstOrderStep);
}

StepReport DirectDynamics::advanceToTolerance(Motion& motion, double seconds,
                                              const mechanics::TimedLoads& actuation) {
  const mechanics::TimedLoads all = allLoads(actuation);
  return toleranceSteps_->advance(motion, seconds, all, isPinned_);
}

std::span<const mechanics::PassedState> DirectDynamics::passed() const {
  if (!toleranceSteps_) return {};
  return toleranceSteps_->passed();
}

std::vector<trajectory::Hold> DirectDynamics::contacts(const Poses& poses) const {
  std::map<std::pair<int, int>, PairSum> pairs;
  for (const mechanics::TouchForce& touch : solver_->touchForces(poses)) {
    const bool isSwapped = brick::isBrick(touch.brickB) && touch.brickB < touch.brickA;
    const int tile = isSwapped ? touch.brickB : touch.brickA;
    const int other = isSwapped ? touch.brickA : touch.brickB;
    pairs[{tile, other}].add(touch, isSwapped ? -1 : 1);
  }
  // The solver of planar scenes has no motion along the normal. The ground carries the weight where
  // it balances the moment of friction, which acts at the bottom.
  for (std::size_t i = 0; isLying_ && i < bricks_.size(); ++i) {
    PairSum& ground = pairs[{static_cast<int>(i), brick::kFixed}];
    const double weight = -bricks_[i].mass * environment_.gravity.z();
    const Vector3 down = -Vector3::UnitZ() - ground.force / weight;
    const Vector3 centre = poses[i].position + 0.5 * bricks_[i].thickness * down;
    ground.add({static_cast<int>(i), brick::kFixed, centre, weight * Vector3::UnitZ(), weight}, 1);
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
  if (load.brickB == brick::kFixed) return fmt::format("tile {} and the ground", tile);
  return brick::isBrick(load.brickB)
             ? fmt::format("tiles {} and {}", tile, countsFrom_ + load.brickB)
             : fmt::format("tile {} and obstacle {}", tile, brick::kFirstObstacle - load.brickB);
}

std::vector<std::string> DirectDynamics::loadedContacts() const {
  std::vector<std::string> names;
  for (const mechanics::ContactLoad& load : solver_->contactLoads()) names.push_back(nameOf(load));
  return names;
}

void DirectDynamics::transfer(StateTape& tape) {
  tape.transfer(*solver_, isPinned_);
  if (toleranceSteps_) tape.transfer(*toleranceSteps_);
  if (contacts_) tape.transfer(*contacts_);
  if (exactContacts_) tape.transfer(*exactContacts_);
}

// ------------------------------------------------------------------------------------------------
// An engine as the solver of a run. Each substep recomputes the loads from the current poses and
// velocities and applies them as forces. An engine's step is therefore explicit in the springs, and
// stiff springs need short substeps. Links, obstacles and pins are refused, because engines do not
// support them.

namespace {

constexpr int kSubsteps = 20;  // as in PyKirigami

// The pivots of a scene. Throws InputError for other joints.
std::vector<brick::Pivot> sharedPivots(const scene::Scene& scene,
                                       const std::vector<brick::Brick>& bricks) {
  std::vector<brick::Pivot> pivots = brick::makePivots(scene.model.joints, bricks);
  for (const brick::Pivot& pivot : pivots) {
    if (pivot.joinsPoints()) continue;
    throw InputError(fmt::format(
        "error: `solver = bullet` does not support joints of the kind {}, as between tiles {} and "
        "{}. Use `solver = direct`",
        model::kindName(scene.model.joints[static_cast<std::size_t>(pivot.joint)]),
        scene.model.fileOrder.countsFrom + pivot.brickA,
        scene.model.fileOrder.countsFrom + pivot.brickB));
  }
  return pivots;
}

// Throws InputError for a scene with obstacles.
void requireNoObstacles(const scene::Environment& environment) {
  if (environment.obstacles.empty()) return;
  throw InputError("error: `solver = bullet` does not support obstacles. Use `solver = direct`");
}

}  // namespace

WorldDynamics::WorldDynamics(std::unique_ptr<engines::BrickWorld> world, int substeps,
                             std::size_t brickCount)
    : world_(std::move(world)), substeps_(substeps), loads_(brickCount) {}

// An empty set of pins is allowed, because every run sets its pins at the start.
void WorldDynamics::setPinned(const std::vector<bool>& pinned) {
  if (std::find(pinned.begin(), pinned.end(), true) == pinned.end()) return;
  throw InputError("error: `solver = bullet` does not support pinned tiles. Use `solver = direct`");
}

// One step as equal substeps. The motion is first written to the engine, because it may have been
// changed outside (closed joints, a reset).
StepReport WorldDynamics::advance(Motion& motion, double step,
                                  const mechanics::LoadSource& actuation) {
  world_->writeMotion(motion);
  for (int substep = 0; substep < substeps_; ++substep) {
    actuation(motion.poses, loads_);
    for (std::size_t i = 0; i < loads_.size(); ++i) {
      Vector6 velocity;
      velocity << motion.velocities[i].linear, motion.velocities[i].angular;
      // An engine has no stiffness or damping of loads: they are forces at the current state.
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

// An engine has no error estimate, so this is one step.
StepReport WorldDynamics::advanceToTolerance(Motion& motion, double seconds,
                                             const mechanics::TimedLoads& actuation) {
  return advance(motion, seconds, [&](const Poses& poses, std::vector<brick::Load>& loads) {
    actuation(0, poses, loads);
  });
}

std::unique_ptr<Dynamics> makeBulletDynamics(const scene::Scene& scene,
                                             const std::vector<brick::Brick>& bricks,
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
// Keeping a path symmetric. If a state differs from the mean of its images under the group
// (model/isometry.h) by more than the asymmetry of closed states, the mean replaces it. The images
// under the generators of the group decide, because a large group has few of them. The mean of
// closed states is closed to the second order of the difference. If this is not enough, its joints
// are closed. If they cannot be closed, the state stays as it is.

namespace {

// Tolerance of the symmetry of a state, fraction of a tile.
constexpr double kSymmetric = 1e-6;
// Asymmetry of closed states due to the model's rounded data, fraction of a tile.
constexpr double kNegligible = 5e-10;
// Largest gap of closed joints, fraction of a tile.
constexpr double kClosedImage = 1e-11;

}  // namespace

// The pivots are kept to measure whether a mean is still closed.
SymmetricStates::SymmetricStates(const scene::Scene& scene, std::vector<model::Symmetry> group)
    : group_(std::move(group)),
      generators_(model::generatorsOf(group_)),
      tile_(model::tileSize(scene.model)) {
  pivots_ =
      brick::makePivots(scene.model.joints, brick::makeBricks(scene.model.tiles, scene.brick));
}

// Drops symmetries that the state does not have. The remaining ones form a group and are kept from
// now on.
void SymmetricStates::keepThoseOf(const Poses& state) {
  std::erase_if(group_, [&](const model::Symmetry& symmetry) {
    return model::asymmetry(state, std::span(&symmetry, 1), tile_) > kSymmetric * tile_;
  });
  generators_ = model::generatorsOf(group_);
}

// Replaces a state that has drifted by its mean over the group. Leaves the state unchanged if the
// mean cannot be closed.
void SymmetricStates::restore(Poses& poses, Dynamics& dynamics) const {
  if (group_.size() < 2) return;
  if (model::asymmetry(poses, generators_, tile_) <= kNegligible * tile_) return;
  Poses mean = model::symmetricMean(poses, group_);
  const bool isExact = !std::isfinite(dynamics.jointStiffness());
  const bool isOpen = isExact && trajectory::jointGap(pivots_, mean).max > kClosedImage * tile_;
  if (isOpen && !dynamics.assemble(mean)) return;
  poses = std::move(mean);
}

}  // namespace kirireel::run
