#include "sim/deploy/direct_dynamics.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sim/actuation/environment_load.h"
#include "sim/base/error.h"
#include "sim/base/interruption.h"

namespace kirireel {

namespace {

// Overlaps below this part of a tile, and of the thickness, count as none.
constexpr double kTilePart = 1e-5;
constexpr double kThicknessPart = 2e-3;
// Joints are closed below this part of a tile.
constexpr double kClosed = 1e-10;
// Times closer than this part of each other are the same.
constexpr double kSameTime = 1e-9;

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

/// The bricks and the bodies of obstacles. The latter weigh as much as a brick, so that the
/// solver's mean weight stays what it is without them.
std::vector<Brick> bodiesOf(const std::vector<Brick>& bricks,
                            const std::vector<ObstaclePart>& obstacles) {
  std::vector<Brick> bodies = bricks;
  for (const ObstaclePart& part : obstacles) {
    bodies.push_back(part.body);
    bodies.back().mass = bricks.front().mass;
    bodies.back().inertia = bricks.front().inertia;
  }
  return bodies;
}

void requireSpace(const Scene& scene, const Needs& needs) {
  if (!needs.planar.on || scene.environment.obstacles.empty()) return;
  throw InputError(
      "error: obstacles need bricks that move in space; leave --planar on away, or the obstacles");
}

}  // namespace

DirectDynamics::DirectDynamics(const Scene& scene, const Needs& needs,
                               const std::vector<Brick>& bricks, const Poses& start)
    : brickCount_(bricks.size()),
      countsFrom_(scene.model.fileOrder.countsFrom),
      tileSize_(tileSize(scene.model)),
      environment_(scene.environment),
      obstacles_(obstacleParts(scene.environment.obstacles)),
      bodies_(bodiesOf(bricks, obstacles_)),
      solver_(makeJointSolver(bodies_, makePivots(scene.model.joints, bricks),
                              {needs.planar.on, tileSize_, groundSupports(scene, needs, bricks)})),
      substeps_(scene.solver.substeps.value_or(1)),
      isRubbing_(!groundSupports(scene, needs, bricks).empty()),
      isTouching_(isRubbing_) {
  requireSpace(scene, needs);
  if (hasObstacles()) setPinned(std::vector<bool>(brickCount_, false));
  if (!needs.contacts.on && !needs.ground.on && !needs.obstacles.on) return;
  Poses poses = start;
  appendObstacles(poses);
  contacts_ = std::make_unique<ContactFinder>(
      bodies_, poses, makePivots(scene.model.joints, bricks), scene.environment, needs.planar.on,
      std::min(kTilePart * tileSize_, kThicknessPart * scene.brick.thickness), obstacles_);
}

void DirectDynamics::appendObstacles(Poses& poses) const {
  for (const ObstaclePart& part : obstacles_) poses.push_back(part.pose);
}

void DirectDynamics::leaveObstacles(Motion& motion) const {
  motion.poses.resize(brickCount_);
  motion.velocities.resize(brickCount_);
}

bool DirectDynamics::assemble(Poses& poses) {
  Poses closed = poses;
  appendObstacles(closed);
  if (solver_->assemble(closed) > kClosed * tileSize_) return false;
  closed.resize(brickCount_);
  poses = std::move(closed);
  return true;
}

void DirectDynamics::setPinned(const std::vector<bool>& pinned) {
  std::vector<bool> held = pinned;
  held.resize(bodies_.size(), true);
  isPinned_ = std::ranges::find(held, true) != held.end();
  if (extrapolation_) extrapolation_->setPinned(isPinned_);
  solver_->setPinned(held);
}

/// The actuation with what surrounds the bricks, for all bodies.
TimedLoads DirectDynamics::allLoads(const TimedLoads& actuation) const {
  return [this, &actuation, brickPoses = Poses()](double seconds, const Poses& poses,
                                                  std::vector<Load>& loads) mutable {
    checkInterruption();  // a step may be halved many times
    brickPoses.assign(poses.begin(), poses.begin() + static_cast<std::ptrdiff_t>(brickCount_));
    loads.resize(brickCount_);
    actuation(seconds, brickPoses, loads);
    for (std::size_t i = 0; i < brickCount_; ++i) {
      addEnvironmentLoad(environment_, bodies_[i], poses[i], loads[i]);
    }
    loads.resize(bodies_.size());
  };
}

StepReport DirectDynamics::advance(Motion& motion, double step, const LoadSource& actuation) {
  const TimedLoads timeless = [&](double, const Poses& poses, std::vector<Load>& loads) {
    actuation(poses, loads);
  };
  const TimedLoads all = allLoads(timeless);
  const LoadSource now = [&](const Poses& poses, std::vector<Load>& loads) {
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

/// Whether bricks would touch at the end of a step, or have passed through each other in it.
bool DirectDynamics::meetOnTheWay(const Motion& from, const Motion& to) {
  if (!contacts_) return false;
  met_.clear();
  contacts_->startStep(from.poses);
  contacts_->appendViolated(to.poses, met_);
  return !met_.empty();
}

/// Goes on from one moment of the call to another in equal steps of first order, among contacts.
StepReport DirectDynamics::goOnByFirstOrder(Motion& motion, double begin, double end,
                                            const TimedLoads& loads) {
  const double parts = std::ceil((end - begin) / firstOrderStep_ - kSameTime);
  const int count = std::max(1, static_cast<int>(parts));
  StepReport report;
  for (int k = 0; k < count; ++k) {
    const double now = begin + k * (end - begin) / count;
    if (now > 0) passed_.push_back({now, motion});
    const LoadSource loadsNow = [&](const Poses& poses, std::vector<Load>& out) {
      loads(now, poses, out);
    };
    report += solver_->advance(motion, (end - begin) / count, loadsNow, contacts_.get());
  }
  isTouching_ = isRubbing_ || !solver_->contactLoads().empty();
  return report;
}

void DirectDynamics::setTolerance(const TimeTolerance& tolerance) {
  firstOrderStep_ = tolerance.firstOrderStep;
  extrapolation_ = std::make_unique<Extrapolation>(
      bodies_, *solver_,
      ExtrapolationSettings{tolerance.tolerance, tolerance.longestStep, tileSize_});
  extrapolation_->setPinned(isPinned_);
}

StepReport DirectDynamics::advanceToTolerance(Motion& motion, double seconds,
                                              const TimedLoads& actuation) {
  const TimedLoads all = allLoads(actuation);
  const StepFilter isFree = [this](const Motion& from, const Motion& to) {
    return !meetOnTheWay(from, to);
  };
  double done = 0;
  const TimedLoads fromHere = [&](double after, const Poses& poses, std::vector<Load>& loads) {
    all(done + after, poses, loads);
  };
  passed_.clear();
  met_.clear();
  appendObstacles(motion.poses);
  motion.velocities.resize(bodies_.size());
  StepReport report;
  while (!isTouching_ && done < (1 - kSameTime) * seconds) {
    const std::optional<double> taken =
        extrapolation_->step(motion, seconds - done, fromHere, isFree, report);
    if (!taken) break;
    done += *taken;
    if (done < (1 - kSameTime) * seconds) passed_.push_back({done, motion});
  }
  if (done < (1 - kSameTime) * seconds) {
    const bool touch = isTouching_ || !met_.empty();
    (touch ? report.touchingTime : report.singularTime) += seconds - done;
    if (!passed_.empty()) passed_.pop_back();  // the first of the steps that follow
    report += goOnByFirstOrder(motion, done, seconds, all);
  }
  leaveObstacles(motion);
  for (PassedState& state : passed_) leaveObstacles(state.motion);
  return report;
}

std::string DirectDynamics::nameOf(const ContactLoad& load) const {
  const int tile = countsFrom_ + load.brickA;
  if (load.brickB == kFixed) return fmt::format("tile {} and the ground", tile);
  const std::size_t other = static_cast<std::size_t>(load.brickB);
  return other < brickCount_ ? fmt::format("tiles {} and {}", tile, countsFrom_ + load.brickB)
                             : fmt::format("tile {} and obstacle {}", tile,
                                           obstacles_[other - brickCount_].obstacle);
}

std::vector<std::string> DirectDynamics::loadedContacts() const {
  std::vector<std::string> names;
  for (const ContactLoad& load : solver_->contactLoads()) {
    std::string name = nameOf(load);
    // An obstacle may have several parts.
    if (std::ranges::find(names, name) == names.end()) names.push_back(std::move(name));
  }
  return names;
}

void DirectDynamics::transfer(StateTape& tape) {
  tape.transfer(*solver_, isTouching_);
  if (extrapolation_) tape.transfer(*extrapolation_);
  if (contacts_) tape.transfer(*contacts_);
}

}  // namespace kirireel
