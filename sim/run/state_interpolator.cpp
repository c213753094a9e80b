// q(s) = argmin |q - ((1 - s) q0 + s q1)|_M subject to c(q) = 0: the linear interpolation of two
// samples, projected onto closed joints in the mass metric by Gauss-Newton steps (Hairer, Lubich
// and Wanner, Geometric Numerical Integration, 2006, IV.4). The error of the interpolation is
// quadratic in the step. Two or three steps therefore close the joints to rounding.
#include "sim/run/state_interpolator.h"

#include <algorithm>
#include <cmath>

#include "sim/run/mechanism_path.h"
#include "sim/trajectory/measures.h"

namespace kirireel::run {
namespace {

/// Closing moves the bricks by less than this fraction of the distance between the samples. A
/// larger move indicates another branch of the mechanism.
constexpr double kMaxClosing = 0.5;
/// Tolerance for motion in the plane, tiles and radians.
constexpr double kInPlane = 1e-9;

// Whether all bricks are upright, keep their height and rotate only about the vertical between two
// samples. A run in the plane has to be interpolated in the plane: in space, rounding could tilt
// its bricks.
bool movesInPlane(const std::vector<brick::Brick>& bricks, const Poses& from, const Poses& to,
                  double tileSize) {
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    const Vector3 normal = from[i].rotation * bricks[i].normal;
    if (normal.head<2>().norm() > kInPlane) return false;
    if (turnBetween(from[i].rotation, to[i].rotation).head<2>().norm() > kInPlane) return false;
    if (std::abs(to[i].position.z() - from[i].position.z()) > kInPlane * tileSize) return false;
  }
  return true;
}

/// The largest rotation of any brick between two states, radians.
double largestTurn(const Poses& from, const Poses& to) {
  double largest = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    largest = std::max(largest, from[i].rotation.angularDistance(to[i].rotation));
  }
  return largest;
}

/// kMomentsBetween equidistant states between two states, without closing joints.
std::vector<Poses> straightMoments(const Poses& from, const Poses& to) {
  std::vector<Poses> moments;
  for (int k = 1; k <= kMomentsBetween; ++k) {
    moments.push_back(interpolate(from, to, static_cast<double>(k) / (kMomentsBetween + 1)));
  }
  return moments;
}

}  // namespace

StateInterpolator::StateInterpolator(const model::Model& model,
                                     const std::vector<brick::Brick>& bricks)
    : model_(model),
      bricks_(bricks),
      pinned_(bricks.size(), false),
      pivots_(brick::makePivots(model.joints, bricks)),
      tileSize_(model::tileSize(model)) {}

// Samples of compliant joints are open. Their joints are not closed between samples.
bool StateInterpolator::areClosed(const Poses& poses) const {
  return trajectory::jointGap(pivots_, poses).max <= model::kClosedShare * tileSize_;
}

void StateInterpolator::setPinned(const std::vector<int>& tiles) {
  pinned_.assign(bricks_.size(), false);
  for (const int tile : tiles) pinned_[static_cast<std::size_t>(tile)] = true;
}

// A solver for the plane or for space. It is created at first use and kept, because its creation
// plans the factorisation.
mechanics::JointSolver& StateInterpolator::solverFor(const Poses& from, const Poses& to) {
  const bool planar = movesInPlane(bricks_, from, to, tileSize_);
  std::unique_ptr<mechanics::JointSolver>& solver = planar ? inPlane_ : inSpace_;
  if (!solver) {
    solver = mechanics::makeJointSolver(bricks_, pivots_,
                                        {.planar = planar,
                                         .lengthScale = tileSize_,
                                         .supports = {},
                                         .pairForces = {},
                                         .isFine = true});
  }
  solver->setPinned(pinned_);
  return *solver;
}

// The closed state nearest to the interpolated one. If the joints do not close, or closing moves
// the bricks far, this returns the nearer of the two samples: it is at least a state of the run.
Poses StateInterpolator::closedBetween(const Poses& from, const Poses& to, double share) {
  const Poses straight = interpolate(from, to, share);
  Poses closed = straight;
  const double gap = solverFor(from, to).assemble(closed);
  const double distance = pathDistance(bricks_, from, to);
  const double moved = pathDistance(bricks_, straight, closed);
  if (gap <= model::kClosedShare * tileSize_ && moved <= kMaxClosing * distance) return closed;
  return share < 0.5 ? from : to;
}

// Time and poses are interpolated, and the measures are recomputed from the poses. All other
// values, including the pins, are those of the earlier sample.
trajectory::Sample StateInterpolator::between(const trajectory::Sample& from,
                                              const trajectory::Sample& to, double share) {
  if (share <= 0) return from;
  if (share >= 1) return to;
  trajectory::Sample sample = from;
  sample.time = from.time + share * (to.time - from.time);
  setPinned(from.pinned);
  const bool mustClose = !pivots_.empty() && areClosed(from.poses) && areClosed(to.poses);
  sample.poses = mustClose ? closedBetween(from.poses, to.poses, share)
                           : interpolate(from.poses, to.poses, share);
  sample.jointGap = trajectory::jointGap(pivots_, sample.poses).max;
  const std::optional<std::vector<model::Tile>>& target = model_.target;
  if (target) sample.targetError = trajectory::targetError(*target, bricks_, sample.poses);
  return sample;
}

std::vector<Poses> StateInterpolator::momentsBetween(const Poses& from, const Poses& to) {
  if (!(largestTurn(from, to) <= kMaxTurnBetween)) return {};  // also when not a number
  if (pivots_.empty() || !areClosed(from) || !areClosed(to)) return straightMoments(from, to);
  std::array<Poses, 2> closed = {interpolate(from, to, 1.0 / 3), interpolate(from, to, 2.0 / 3)};
  setPinned({});
  double gap = 0;
  for (Poses& poses : closed) gap = std::max(gap, solverFor(from, to).assemble(poses));
  if (gap > model::kClosedShare * tileSize_) return straightMoments(from, to);
  return momentsThrough(from, closed, to);
}

ThirdsCorrection::ThirdsCorrection(const std::array<Poses, 2>& open,
                                   const std::array<Poses, 2>& closed) {
  for (std::size_t third = 0; third < 2; ++third) {
    for (std::size_t i = 0; i < open[third].size(); ++i) {
      const Pose &from = open[third][i], &to = closed[third][i];
      moves_[third].push_back(to.position - from.position);
      turns_[third].push_back(turnBetween(from.rotation, to.rotation));
    }
  }
}

// p(s) = open(s) + b(s) (closed(1/3) - open(1/3)) + b(1 - s) (closed(2/3) - open(2/3)) with
// b(s) = 27/2 s (1 - s) (2/3 - s). Rotations use rotation vectors. Joints open by the fourth power
// of the rotation.
void ThirdsCorrection::addTo(Poses& poses, double share) const {
  const double whole = 13.5 * share * (1 - share);
  const std::array<double, 2> bulges = {whole * (2.0 / 3 - share), whole * (share - 1.0 / 3)};
  for (std::size_t i = 0; i < poses.size(); ++i) {
    Vector3 turn = Vector3::Zero();
    for (std::size_t third = 0; third < 2; ++third) {
      poses[i].position += bulges[third] * moves_[third][i];
      turn += bulges[third] * turns_[third][i];
    }
    poses[i].rotation = (rotationFromVector(turn) * poses[i].rotation).normalized();
  }
}

std::vector<Poses> momentsThrough(const Poses& from, const std::array<Poses, 2>& thirds,
                                  const Poses& to) {
  const ThirdsCorrection correction(
      {interpolate(from, to, 1.0 / 3), interpolate(from, to, 2.0 / 3)}, thirds);
  std::vector<Poses> moments = straightMoments(from, to);
  for (int k = 1; k <= kMomentsBetween; ++k) {
    const double share = static_cast<double>(k) / (kMomentsBetween + 1);
    correction.addTo(moments[static_cast<std::size_t>(k - 1)], share);
  }
  return moments;
}

}  // namespace kirireel::run
