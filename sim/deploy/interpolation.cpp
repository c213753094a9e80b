// q(s) = argmin |q - ((1 - s) q0 + s q1)|_M subject to c(q) = 0: the straight state between two
// samples, projected on the joints in the metric of the masses by Gauss-Newton steps (Hairer,
// Lubich and Wanner, Geometric Numerical Integration, 2006, IV.4). The straight state is wrong by
// the square of the step, so two or three steps close it to rounding.
#include "sim/deploy/interpolation.h"

#include <algorithm>

#include "sim/deploy/continuation.h"
#include "sim/measure/measures.h"

namespace kirireel {
namespace {

/// Joints count as closed below this part of a tile, here as in a run's figures.
constexpr double kClosedJoints = 1e-9;
/// Closing moves the bricks by less than this part of the way between the samples, unless it leads
/// to another branch of the mechanism.
constexpr double kMostClosing = 0.5;
/// A brick moves in the plane when it leaves it by less than this, tiles and radians.
constexpr double kInPlane = 1e-9;

// Whether all bricks are upright and only turn about the vertical, at one height, from one sample
// to the next. A run in the plane has to be interpolated in the plane: solved in space, rounding
// could tilt its bricks.
bool movesInPlane(const std::vector<Brick>& bricks, const Sample& from, const Sample& to,
                  double tileSize) {
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    const Pose& before = from.poses[i];
    const Pose& after = to.poses[i];
    const Vector3 normal = before.rotation * bricks[i].normal;
    if (normal.head<2>().norm() > kInPlane) return false;
    if (turnBetween(before.rotation, after.rotation).head<2>().norm() > kInPlane) return false;
    if (std::abs(after.position.z() - before.position.z()) > kInPlane * tileSize) return false;
  }
  return true;
}

}  // namespace

StateInterpolator::StateInterpolator(const Subject& subject)
    : subject_(subject),
      pivots_(makePivots(subject.model.joints, subject.bricks)),
      tileSize_(tileSize(subject.model)) {}

// Samples whose joints gave on purpose are open; they are not closed between.
bool StateInterpolator::areClosed(const Sample& sample) const {
  return jointGap(pivots_, sample.poses).max <= kClosedJoints * tileSize_;
}

// A solver for the plane or for space, made at its first use and kept: making one plans the
// factorisation. The pins are those of the earlier sample.
JointSolver& StateInterpolator::solverFor(const Sample& from, const Sample& to) {
  const bool planar = movesInPlane(subject_.bricks, from, to, tileSize_);
  std::unique_ptr<JointSolver>& solver = planar ? inPlane_ : inSpace_;
  if (!solver) {
    solver = makeJointSolver(subject_.bricks, pivots_,
                             {.planar = planar, .lengthScale = tileSize_, .supports = {}});
  }
  std::vector<bool> pinned(subject_.bricks.size(), false);
  for (const int tile : from.pinned) pinned[static_cast<std::size_t>(tile)] = true;
  solver->setPinned(pinned);
  return *solver;
}

// The closed state nearest to the straight one. Where the joints do not close, or closing leads far
// away, the nearer of the two samples is taken instead: it is at least a state of the run.
Poses StateInterpolator::closedBetween(const Sample& from, const Sample& to, double share) {
  const Poses straight = interpolate(from.poses, to.poses, share);
  Poses closed = straight;
  const double gap = solverFor(from, to).assemble(closed);
  const double way = pathDistance(subject_.bricks, from.poses, to.poses);
  const double moved = pathDistance(subject_.bricks, straight, closed);
  if (gap <= kClosedJoints * tileSize_ && moved <= kMostClosing * way) return closed;
  return share < 0.5 ? from.poses : to.poses;
}

// The time and the poses are interpolated, and the measures are computed anew from the poses.
// Everything else is that of the earlier sample.
Sample StateInterpolator::between(const Sample& from, const Sample& to, double share) {
  if (share <= 0) return from;
  if (share >= 1) return to;
  Sample sample = from;
  sample.time = from.time + share * (to.time - from.time);
  const bool mustClose = !pivots_.empty() && areClosed(from) && areClosed(to);
  sample.poses =
      mustClose ? closedBetween(from, to, share) : interpolate(from.poses, to.poses, share);
  sample.jointGap = jointGap(pivots_, sample.poses).max;
  const std::optional<std::vector<Tile>>& target = subject_.model.target;
  if (target) sample.targetError = targetError(*target, subject_.bricks, sample.poses);
  return sample;
}

}  // namespace kirireel
