// Is a state that hardly moves at rest, or is it only slow?
//
// From rest, an implicit Euler step of length h moves bricks of mass M, damping D and stiffness K
// under the force F by dx = (M / h^2 + D / h + K)^-1 F. For long h mass and damping drop out, and
// dx comes near to K^-1 F, Newton's step to where the forces vanish. So steps 16 times as long as
// the one before, up to 1e7 s, show where the bricks would go in the end: if none goes a thousandth
// of a tile, the state is at rest.
#include "sim/deploy/rest_probe.h"

#include <algorithm>

namespace kirireel {
namespace {

// Steps grow by this factor, up to so many seconds: what forces of rounding would move stays below
// a millionth of a tile.
constexpr double kGrowth = 16;
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
  for (double length = kGrowth * step; length < kLongest && !probe.movesOn; length *= kGrowth) {
    trial.velocities.assign(trial.poses.size(), Velocity{});
    const StepReport report = dynamics.advance(trial, length, actuation);
    probe.work += report.work;
    if (report.unconverged > 0) break;  // what fails tells nothing
    probe.movesOn = farthestMove(motion.poses, trial.poses, tileSize) > kMoved * tileSize;
  }
  return probe;
}

}  // namespace kirireel
