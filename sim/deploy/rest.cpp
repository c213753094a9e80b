// How a run leaves a start in balance, and whether bricks that hardly move are at rest: two pieces,
// each with its own explanation.
#include "sim/deploy/rest.h"

#include <algorithm>
#include <random>

namespace kirireel {

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
                    const LoadSource& actuation, double tileSize) {
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
// A sheet that is pulled as a whole, yet cannot open, has a motion without a difference in angular
// velocities: that does not count.
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

bool movesByItself(const std::vector<Velocity>& after, bool areJoined, double tileSize,
                   double modelSize) {
  double fastest = areJoined ? fastestOpening(after) * tileSize : 0;
  for (const Velocity& velocity : after) {
    if (areJoined) break;
    fastest = std::max(fastest, velocity.linear.norm() + velocity.angular.norm() * tileSize);
  }
  return fastest > kSpeed * modelSize;
}

std::vector<Velocity> symmetricNudge(const std::vector<Velocity>& whole, const Poses& poses,
                                     std::span<const Symmetry> group, Dynamics& dynamics) {
  std::vector<Velocity> symmetric = symmetricMean(whole, group);
  const double left = fastestOpening(fitted(symmetric, poses, dynamics));
  const double most = fastestOpening(fitted(whole, poses, dynamics));
  if (!(left > kLeft * most)) return {};
  return symmetric;
}

}  // namespace kirireel
