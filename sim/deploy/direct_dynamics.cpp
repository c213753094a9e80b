#include "sim/deploy/direct_dynamics.h"

#include <algorithm>

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
      substeps_(scene.solver.substeps.value_or(1)) {
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
  solver_->setPinned(held);
}

StepReport DirectDynamics::advance(Motion& motion, double step, const LoadSource& actuation) {
  Poses brickPoses;
  const LoadSource all = [&](const Poses& poses, std::vector<Load>& loads) {
    checkInterruption();  // a step may be halved many times
    brickPoses.assign(poses.begin(), poses.begin() + static_cast<std::ptrdiff_t>(brickCount_));
    loads.resize(brickCount_);
    actuation(brickPoses, loads);
    for (std::size_t i = 0; i < brickCount_; ++i) {
      addEnvironmentLoad(environment_, bodies_[i], poses[i], loads[i]);
    }
    loads.resize(bodies_.size());
  };
  appendObstacles(motion.poses);
  motion.velocities.resize(bodies_.size());
  StepReport report;
  for (int substep = 0; substep < substeps_; ++substep) {
    report += solver_->advance(motion, step / substeps_, all, contacts_.get());
  }
  motion.poses.resize(brickCount_);
  motion.velocities.resize(brickCount_);
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
  tape.transfer(*solver_);
  if (contacts_) tape.transfer(*contacts_);
}

}  // namespace kirireel
