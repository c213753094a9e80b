// Rest. A run rests while its fastest brick is slower than the settle speed, or while steps fail
// however short they are and no brick gets anywhere. Since when follows from the motion, not from
// where steps end: the moment at which the fastest speed falls through its limit is found within
// the step.
//
// Below: whether bricks at rest are only slow; and the nudge by which a run leaves a state in
// balance.
#include "sim/deploy/rest.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <random>
#include <utility>

namespace kirireel::deploy {
namespace {

// Steps that fail, and bring no brick farther than this part of a tile, are no motion.
constexpr double kStuckShare = 1e-3;
// A step is looked at in so many parts for the beginning of rest, and the part halved so often.
constexpr int kRestLooks = 16;
constexpr int kRestHalvings = 30;

}  // namespace

double fastestSpeed(const std::vector<Velocity>& velocities, double tileSize) {
  double fastest = 0;
  for (const Velocity& velocity : velocities) {
    const double speed = velocity.linear.norm() + velocity.angular.norm() * tileSize;
    fastest = std::max(fastest, speed);
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
  const double limit = bricks_.scene.stop.settleSpeed * bricks_.size;
  const bool isSlow = fastestSpeed(motion.now().velocities, bricks_.tileSize) < limit;
  if (isOnPath || !(isSlow || isStuck(motion.poses()))) {
    rested_ = 0;
    return;
  }
  const double within = isSlow ? restWithinStep(motion, length, limit) : length;
  rested_ = within < length ? within : rested_ + length;
}

// For how long up to the end of the last step the fastest speed has stayed below a limit that it is
// below then, seconds; the whole step's length where it was never above. Speeds swing: looked at in
// parts of the step, then by bisection.
double RestWatch::restWithinStep(const RunMotion& motion, double length, double limit) const {
  const auto isFast = [&](double seconds) {
    return fastestSpeed(motion.velocitiesAt(seconds), bricks_.tileSize) >= limit;
  };
  const double part = length / kRestLooks;
  int fast = kRestLooks - 1;
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

void RestWatch::doubt() {
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
// Is a state that hardly moves at rest, or is it only slow?
//
// From rest, an implicit Euler step of length h moves bricks of mass M, damping D and stiffness K
// under the force F by dx = (M / h^2 + D / h + K)^-1 F. For long h mass and damping drop out, and
// dx comes near to K^-1 F, Newton's step to where the forces vanish. So steps 16 times as long as
// the one before, up to 1e7 s, show where the bricks would go in the end: if none goes a thousandth
// of a tile, the state is at rest.

namespace {

// Steps grow by this factor, up to so many seconds: what forces of rounding would move stays below
// a millionth of a tile.
constexpr double kStepGrowth = 16;
constexpr double kLongest = 1e7;
// So much of a tile is a motion.
constexpr double kMoved = 1e-3;

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
    trial.velocities.assign(trial.poses.size(), Velocity{});
    const StepReport report = dynamics.advance(trial, length, actuation);
    probe.work += report.work;
    if (report.unconverged > 0) break;  // what fails tells nothing
    probe.movesOn = farthestMove(motion.poses, trial.poses, tileSize) > kMoved * tileSize;
  }
  return probe;
}

// ------------------------------------------------------------------------------------------------
// A state where forces and joints are in balance is left by nobody but chance. What a run is given
// there, velocities v_i of a millionth of the model's size a second, grows as exp(s t) with the
// equilibrium's rate s, so that it takes ln(1e6) / s = 14 / s until it shows.
//
// Where the start moves by itself the nudge would only differ from seed to seed: 1e-6 of a tile
// after half a second of a cap. It moves by itself if what acts on it makes it faster than the
// nudge within kNudgeTime. At a singular state joints leave rounding of the loads, which is slower.
// A sheet that is pulled to a target as a whole, yet cannot open, has a motion without a difference
// in angular velocities: that does not count. Where no drive and no spring acts between bricks, any
// motion counts. Pins of the timeline's start hold already.
//
// Symmetries: the mean over the group's images of the v_i keeps a symmetric motion symmetric.

namespace {

constexpr double kSpeed = 1e-6;  // model sizes a second
// Less of the turns that joints leave of a whole nudge is none.
constexpr double kLeft = 1e-3;

/// Uniform in [-1, 1) with the same bits from every standard library.
double uniform(std::mt19937& generator) {
  return static_cast<double>(generator()) / 2147483648.0 - 1.0;
}

/// The largest difference of an angular velocity from the mean, rad/s: 0 where all move as one.
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

/// What joints leave of velocities at a state.
std::vector<Velocity> fitted(const std::vector<Velocity>& velocities, const Poses& poses,
                             Dynamics& dynamics) {
  Motion motion = {poses, velocities};
  dynamics.fitVelocities(motion);
  return motion.velocities;
}

}  // namespace

std::vector<Velocity> nudge(std::size_t count, double modelSize, unsigned seed) {
  std::mt19937 generator(seed);
  const double speed = kSpeed * modelSize;
  std::vector<Velocity> velocities(count);
  for (Velocity& velocity : velocities) {
    const double x = uniform(generator);
    const double y = uniform(generator);
    const double z = uniform(generator);
    velocity.linear = speed * Vector3(x, y, z);
  }
  return velocities;
}

bool movesByItself(const std::vector<Velocity>& after, bool drivenApart, double tileSize,
                   double modelSize) {
  const double fastest =
      drivenApart ? fastestOpening(after) * tileSize : fastestSpeed(after, tileSize);
  return fastest > kSpeed * modelSize;
}

std::vector<Velocity> symmetricNudge(const std::vector<Velocity>& whole, const Poses& poses,
                                     std::span<const model::Symmetry> group, Dynamics& dynamics) {
  std::vector<Velocity> symmetric = model::symmetricMean(whole, group);
  const double left = fastestOpening(fitted(symmetric, poses, dynamics));
  const double most = fastestOpening(fitted(whole, poses, dynamics));
  if (!(left > kLeft * most)) return {};
  return symmetric;
}

std::vector<Velocity> NudgeGiver::whole() const {
  return nudge(bricks_.bricks.size(), bricks_.size, bricks_.scene.solver.seed);
}

/// Whether joined bricks are pulled against each other, by more than what surrounds them.
bool NudgeGiver::areDrivenApart() const {
  const scene::Scene& scene = bricks_.scene;
  if (bricks_.pivots.empty()) return false;
  return scene.actuation.drive != scene::Drive::None || !bricks_.ties.pairForces.empty();
}

void NudgeGiver::giveAtStart(RunMotion& motion, const mechanics::LoadSource& loads,
                             const JointFit& joints, const std::vector<bool>& pinned) {
  given_ = Nudged::Wholly;
  std::vector<Velocity> velocities = whole();
  if (bricks_.scene.solver.kind == scene::SolverKind::Bullet) {
    motion.now().velocities = std::move(velocities);
    return;
  }
  const std::unique_ptr<Dynamics> solver = motion.makeSolver();
  joints.hold(*solver);
  solver->setPinned(pinned);
  Motion trial = {motion.poses(), std::vector<Velocity>(bricks_.bricks.size())};
  solver->advance(trial, kNudgeTime, loads);
  if (movesByItself(trial.velocities, areDrivenApart(), bricks_.tileSize, bricks_.size)) {
    given_ = Nudged::No;
    return;
  }
  SymmetricStates symmetries(bricks_.scene);
  symmetries.keepThoseOf(motion.poses());
  if (symmetries.group().size() > 1) {
    std::vector<Velocity> symmetric =
        symmetricNudge(velocities, motion.poses(), symmetries.group(), *solver);
    if (!symmetric.empty()) {
      given_ = Nudged::InSymmetry;
      velocities = std::move(symmetric);
    }
  }
  motion.now().velocities = std::move(velocities);
}

void NudgeGiver::giveAtRest(RunMotion& motion) {
  given_ = Nudged::Wholly;
  const std::vector<Velocity> more = whole();
  for (std::size_t i = 0; i < more.size(); ++i) {
    motion.now().velocities[i].linear += more[i].linear;
  }
}

}  // namespace kirireel::deploy
