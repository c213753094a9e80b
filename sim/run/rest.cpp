// Rest. A run rests while its fastest corner is slower than the settle speed, or while all steps
// fail and no brick moves. The rest time follows from the motion, not from the ends of steps: the
// time at which the fastest speed falls below the limit is computed within the step.
//
// The second part distinguishes rest from slow motion. The third part gives perturbations that
// leave an equilibrium.
#include "sim/run/rest.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <random>
#include <utility>

namespace kirireel::run {
namespace {

// Failed steps that move no brick farther than this fraction of a tile count as no motion.
constexpr double kStuckShare = 1e-3;
// In a singular state, joints allow speeds that do not lead anywhere: a step moves the bricks by
// less than this fraction of what their speed gives.
constexpr double kStillShare = 0.01;
// Number of parts of a step that are tested for the start of rest, and number of bisections.
constexpr int kRestChecks = 16;
constexpr int kRestHalvings = 30;

}  // namespace

double fastestCorner(const std::vector<brick::Brick>& bricks, const Motion& motion) {
  double fastest = 0;
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    const Velocity& velocity = motion.velocities[i];
    for (const std::vector<Vector3>* face : {&bricks[i].bottom, &bricks[i].top}) {
      for (const Vector3& corner : *face) {
        const Vector3 arm = motion.poses[i].rotation * corner;
        fastest = std::max(fastest, (velocity.linear + velocity.angular.cross(arm)).norm());
      }
    }
  }
  return fastest;
}

void RestWatch::observe(const RunMotion& motion, double length, const StepReport& report,
                        bool isOnPath) {
  if (report.unconverged == 0) {
    jamStart_.clear();
  } else if (!isStuck(motion.poses())) {
    jamStart_ = motion.poses();
  }
  const double tile = bricks_.tileSize;
  const double speed = fastestCorner(bricks_.bricks, motion.now());
  const bool isStill =
      farthestMove(motion.before().poses, motion.poses(), tile) < kStillShare * speed * length;
  const double limit = bricks_.scene.stop.settleSpeed * bricks_.size;
  const bool isSlow = speed < limit;
  if (isOnPath || !(isSlow || isStill || isStuck(motion.poses()))) {
    rested_ = 0;
    return;
  }
  const double within = isSlow ? restWithinStep(motion, length, limit) : length;
  rested_ = within < length ? within : rested_ + length;
}

// How long the fastest speed was below a limit up to the end of the last step, seconds. It must be
// below the limit at the end. Returns the step's length if it never was above. Speeds may
// oscillate: the step is tested in parts, then bisected.
double RestWatch::restWithinStep(const RunMotion& motion, double length, double limit) const {
  const auto isFast = [&](double seconds) {
    return fastestCorner(bricks_.bricks, motion.motionAfter(seconds)) >= limit;
  };
  const double part = length / kRestChecks;
  int fast = kRestChecks - 1;
  while (fast >= 0 && !isFast(fast * part)) --fast;
  if (fast < 0) return length;
  double above = fast * part;
  double below = above + part;
  for (int k = 0; k < kRestHalvings; ++k) {
    const double middle = 0.5 * (above + below);
    (isFast(middle) ? above : below) = middle;
  }
  return length - below;
}

void RestWatch::doubleRestTime() {
  rested_ = 0;
  needed_ *= 2;
}

double RestWatch::moment(double now) const {
  if (!(rested_ > 0)) return std::numeric_limits<double>::infinity();
  return now + needed_ - rested_;
}

bool RestWatch::isStuck(const Poses& poses) const {
  const double tile = bricks_.tileSize;
  return !jamStart_.empty() && farthestMove(jamStart_, poses, tile) < kStuckShare * tile;
}

// ------------------------------------------------------------------------------------------------
// Is a state that hardly moves at rest, or only slow?
//
// From rest, an implicit Euler step of length h moves bricks of mass M, damping D and stiffness K
// under the force F by dx = (M / h^2 + D / h + K)^-1 F. For long h, mass and damping vanish, and
// dx approaches K^-1 F, Newton's step to equilibrium. Steps grow by a factor of 16, up to 1e7 s,
// and show where the bricks would end. If none moves a thousandth of a tile, the state is at
// rest.

namespace {

// Steps grow by this factor up to kLongest seconds. Rounding errors of the forces then move bricks
// by less than a millionth of a tile.
constexpr double kStepGrowth = 16;
constexpr double kLongest = 1e7;
// Displacement that counts as motion, fraction of a tile.
constexpr double kMoved = 1e-3;
// The same at an equilibrium, after the last step.
constexpr double kEquilibriumMove = 1e-8;

}  // namespace

double farthestMove(const Poses& from, const Poses& to, double tileSize) {
  double farthest = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const double turn = to[i].rotation.angularDistance(from[i].rotation);
    farthest = std::max(farthest, (to[i].position - from[i].position).norm() + turn * tileSize);
  }
  return farthest;
}

RestProbe probeRest(Dynamics& dynamics, const Motion& motion, double step,
                    const mechanics::LoadSource& actuation, double tileSize) {
  RestProbe probe;
  Motion trial = motion;
  for (double length = kStepGrowth * step; length < kLongest && !probe.movesOn;
       length *= kStepGrowth) {
    probe.poses = trial.poses;
    trial.velocities.assign(trial.poses.size(), Velocity{});
    const StepReport report = dynamics.advance(trial, length, actuation);
    probe.work += report.work;
    probe.isConverged = false;
    if (report.unconverged > 0) break;  // a failed step has no information
    probe.movesOn = farthestMove(motion.poses, trial.poses, tileSize) > kMoved * tileSize;
    const double last = farthestMove(probe.poses, trial.poses, tileSize);
    probe.isConverged = !probe.movesOn && last <= kEquilibriumMove * tileSize;
  }
  probe.poses = trial.poses;
  return probe;
}

// ------------------------------------------------------------------------------------------------
// Only a perturbation leaves an equilibrium. The perturbation consists of velocities v_i of a
// millionth of the model's size per second. It grows as exp(s t) with the growth rate s of the
// equilibrium and becomes visible after about ln(1e6) / s = 14 / s.
//
// If the start moves by itself, the perturbation would only add a difference between seeds: 1e-6 of
// a tile after half a second of a cap. A start moves by itself if its forces make it faster than
// the perturbation within kPerturbationTime. At a singular state joints leave only the rounding of
// the loads, which is slower. A sheet that is pulled as a whole, but cannot open, moves without a
// difference in angular velocities: that does not count. If no drive and no spring acts between
// bricks, any motion counts. Pins of the timeline's start already hold.
//
// Symmetries: the mean over the group's images of the v_i keeps a symmetric motion symmetric.

namespace {

constexpr double kSpeed = 1e-6;  // model sizes per second
// A symmetric perturbation needs at least this fraction of the rotations of a whole perturbation.
constexpr double kLeft = 1e-3;

/// Uniform in [-1, 1), with identical bits in all standard libraries.
double uniform(std::mt19937& generator) {
  return static_cast<double>(generator()) / 2147483648.0 - 1.0;
}

/// The largest deviation of an angular velocity from the mean, rad/s. 0 for a rigid motion.
double fastestOpening(const std::vector<Velocity>& velocities) {
  Vector3 mean = Vector3::Zero();
  for (const Velocity& velocity : velocities) mean += velocity.angular;
  mean /= static_cast<double>(velocities.size());
  double fastest = 0;
  for (const Velocity& velocity : velocities) {
    fastest = std::max(fastest, (velocity.angular - mean).norm());
  }
  return fastest;
}

/// The part of the velocities that joints allow at a state.
std::vector<Velocity> fitted(const std::vector<Velocity>& velocities, const Poses& poses,
                             Dynamics& dynamics) {
  Motion motion = {poses, velocities};
  dynamics.fitVelocities(motion);
  return motion.velocities;
}

}  // namespace

std::vector<Velocity> perturbation(const std::vector<brick::Brick>& bricks, const Poses& poses,
                                   double modelSize, unsigned seed) {
  std::mt19937 generator(seed);
  const double speed = kSpeed * modelSize;
  std::vector<Velocity> velocities(bricks.size());
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    const Vector3 side = (bricks[i].bottom[1] - bricks[i].bottom[0]).normalized();
    const double along = uniform(generator);
    const double across = uniform(generator);
    const double up = uniform(generator);
    const Vector3 direction =
        along * side + across * bricks[i].normal.cross(side) + up * bricks[i].normal;
    velocities[i].linear = speed * (poses[i].rotation * direction);
  }
  return velocities;
}

bool movesByItself(const std::vector<brick::Brick>& bricks, const Motion& after, bool drivenApart,
                   double tileSize, double modelSize) {
  const double fastest =
      drivenApart ? fastestOpening(after.velocities) * tileSize : fastestCorner(bricks, after);
  return fastest > kSpeed * modelSize;
}

std::vector<Velocity> symmetricPerturbation(const std::vector<Velocity>& whole, const Poses& poses,
                                            std::span<const model::Symmetry> group,
                                            Dynamics& dynamics) {
  std::vector<Velocity> symmetric = model::symmetricMean(whole, group);
  const double left = fastestOpening(fitted(symmetric, poses, dynamics));
  const double most = fastestOpening(fitted(whole, poses, dynamics));
  if (!(left > kLeft * most)) return {};
  return symmetric;
}

std::vector<Velocity> Perturber::whole(const Poses& poses) const {
  return perturbation(bricks_.bricks, poses, bricks_.size, bricks_.scene.solver.seed);
}

/// Whether a drive or springs act between joined bricks, in addition to the environment.
bool Perturber::areDrivenApart() const {
  const scene::Scene& scene = bricks_.scene;
  if (bricks_.pivots.empty()) return false;
  return scene.actuation.drive != scene::Drive::None || !bricks_.ties.pairForces.empty();
}

void Perturber::giveAtStart(RunMotion& motion, const mechanics::LoadSource& loads,
                            const JointFit& joints, const std::vector<bool>& pinned) {
  given_ = Perturbed::Wholly;
  std::vector<Velocity> velocities = whole(motion.poses());
  if (bricks_.scene.solver.kind == scene::SolverKind::Bullet) {
    motion.now().velocities = std::move(velocities);
    return;
  }
  const std::unique_ptr<Dynamics> solver = motion.makeSolver();
  joints.hold(*solver);
  solver->setPinned(pinned);
  Motion trial = {motion.poses(), std::vector<Velocity>(bricks_.bricks.size())};
  solver->advance(trial, kPerturbationTime, loads);
  if (movesByItself(bricks_.bricks, trial, areDrivenApart(), bricks_.tileSize, bricks_.size)) {
    given_ = Perturbed::No;
    return;
  }
  SymmetricStates symmetries(bricks_.scene);
  symmetries.keepThoseOf(motion.poses());
  if (symmetries.group().size() > 1) {
    std::vector<Velocity> symmetric =
        symmetricPerturbation(velocities, motion.poses(), symmetries.group(), *solver);
    if (!symmetric.empty()) {
      given_ = Perturbed::InSymmetry;
      velocities = std::move(symmetric);
    }
  }
  motion.now().velocities = std::move(velocities);
}

void Perturber::giveAtRest(RunMotion& motion) {
  given_ = Perturbed::Wholly;
  const std::vector<Velocity> more = whole(motion.poses());
  for (std::size_t i = 0; i < more.size(); ++i) {
    motion.now().velocities[i].linear += more[i].linear;
  }
}

}  // namespace kirireel::run
