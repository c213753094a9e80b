// Closing joints: Gauss-Newton steps on the gaps, in the metric of the step (whose factor is at
// hand) or of the masses, from the end of a step or any open state. What it costs is paid from the
// speed.
#include <algorithm>
#include <cmath>

#include "sim/joints/stepper.h"

namespace kirireel {
namespace {

// All lengths are in length scales.
constexpr double kGapTolerance = 1e-12;     // closing aims at this
constexpr double kGapAccepted = 1e-10;      // and a step is good below this
constexpr double kOverlapTolerance = 1e-9;  // overlap of a contact in work that counts as none
constexpr double kJumpShare = 0.3;          // of what the step moved: so far may closing move
constexpr double kJumpFloor = 1e-9;
constexpr double kBend = 0.01;        // closing that moves less than this part bends a smooth path
constexpr double kForeseeable = 0.1;  // largest ratio of closing moves taken for steady
// A factor serves the next move too, where gaps are small and a move leaves less of them. Wide gaps
// want each its own: else the moves are together longer than they need to be.
constexpr double kSmallGap = 1e-2;
constexpr double kFactorKept = 0.03;
constexpr int kClosingRounds = 12;
constexpr int kOverlapRounds = 3;
constexpr int kAssemblyRounds = 100;

double largestOf(const Eigen::VectorXd& gaps) {
  return gaps.size() > 0 ? gaps.lpNorm<Eigen::Infinity>() : 0;
}

}  // namespace

/// Moves to the step's end and closes the joints there: with the contacts that push held, or, where
/// that fails (compact states leave them no room), without. Returns whether the joints closed
/// without a jump to another branch.
template <int D>
bool Stepper<D>::moveAndClose(const Poses& start, double step) {
  poses_ = start;
  displace(step * program_.x);
  if (!program_.exactJoints) return true;
  if (closeJoints(program_.contacts, step)) return true;
  if (program_.contacts.empty()) return false;
  poses_ = start;
  displace(step * program_.x);
  system_.placeJoints(start);
  return system_.factor({}) && closeJoints({}, step);
}

/// The energy that a step has at its end, closing included, is at most that at its start: what
/// closing costs beyond what the step has lost comes out of the bricks' speed, and where that is
/// too little they stay where they are. On a smooth path energy comes and goes, and none is taken.
template <int D>
void Stepper<D>::payForClosing(const Poses& start, double step) {
  if (program_.contacts.empty() || !program_.exactJoints) return;
  const Vector move = step * program_.x;
  if (norm(closing_) <= kBend * norm(move)) return;
  const double cost = system_.workAgainst(loads_, move, closing_);
  if (cost <= 0) return;
  const double before = system_.kineticEnergy(start, startSpeed_);
  const double after = system_.kineticEnergy(start, program_.x);
  const double work = system_.workAgainst(loads_, Vector::Zero(move.size()), move);
  const double excess = after + work + cost - before;
  if (excess <= 0) return;
  program_.x *= std::sqrt(std::max(0.0, 1 - excess / after));
  if (excess > after) standStill(start);
}

/// What joints and contacts always allow.
template <int D>
void Stepper<D>::standStill(const Poses& start) {
  poses_ = start;
  program_.x.setZero();
}

/// Gauss-Newton on the joints' gaps, on the factor at hand: the smallest move by A in which the
/// contacts that push hold their gaps. The first rounds also take overlaps back. As the factor is
/// of the step's start, moves shrink by a steady ratio; what follows the last one is foreseen from
/// it (Broyden's good update with a memory of one: Kelley 2003, "Solving Nonlinear Equations with
/// Newton's Method", 4.2).
template <int D>
bool Stepper<D>::closeJoints(const std::vector<Row>& contacts, double step) {
  const double scale = settings_.lengthScale;
  const double allowed = kJumpShare * step * norm(program_.x) + kJumpFloor * scale;
  double moved = 0;
  Vector gaps = system_.jointGaps(poses_);
  double gap = largestOf(gaps);
  bool refactored = false;
  closing_ = Vector::Zero(program_.x.size());
  Vector lastMove = closing_;
  for (int round = 0; round < kClosingRounds && (moved <= allowed || isShortest_); ++round) {
    const bool overlapping = round < kOverlapRounds && anyOverlap(contacts);
    if (gap <= kGapTolerance * scale && !overlapping) break;
    const Vector move = foreseen(closingMove(gaps, contacts, overlapping), lastMove);
    lastMove = move;
    closing_ += move;
    displace(move);
    moved += norm(move);
    const double before = gap;
    gaps = system_.jointGaps(poses_);
    gap = largestOf(gaps);
    if (!std::isfinite(gap)) return false;
    if (gap <= std::max(0.2 * before, kGapTolerance * scale) || overlapping) continue;
    if (gap <= 0.1 * kGapAccepted * scale && refactored) break;
    system_.placeJoints(poses_);
    if (!system_.factor(contacts)) return false;
    refactored = true;
    lastMove.setZero();
  }
  jumped_ = moved > allowed;
  return gap <= kGapAccepted * scale && (!jumped_ || isShortest_);
}

template <int D>
Eigen::VectorXd Stepper<D>::closingMove(const Vector& gaps, const std::vector<Row>& contacts,
                                        bool withOverlaps) const {
  Vector move = Vector::Zero(program_.x.size());
  system_.addJointImpulse(-system_.kappa(), gaps, move);
  if (withOverlaps) {
    for (const Row& row : contacts) {
      if (row.active) row.addNormal(system_.rho() * overlap(row), move);
    }
  }
  system_.solveInPlace(move);
  return move;
}

/// The move together with those that would follow it, if each is to the next as the last is to it.
template <int D>
Eigen::VectorXd Stepper<D>::foreseen(const Vector& move, const Vector& lastMove) const {
  const double square = product(lastMove, lastMove);
  const double ratio = square > 0 ? product(move, lastMove) / square : 0;
  return std::abs(ratio) < kForeseeable ? Vector(move / (1 - ratio)) : move;
}

/// How far a contact falls short of the gap that it aims at, metres.
template <int D>
double Stepper<D>::overlap(const Row& row) const {
  return std::max(0.0, row.aim - contactGap(row.contact, poses_));
}

template <int D>
bool Stepper<D>::anyOverlap(const std::vector<Row>& contacts) const {
  return std::any_of(contacts.begin(), contacts.end(), [&](const Row& row) {
    return row.active && overlap(row) > kOverlapTolerance * settings_.lengthScale;
  });
}

/// Scalar product of two moves of all bricks, turns counted at one length scale from the centre.
template <int D>
double Stepper<D>::product(const Vector& a, const Vector& b) const {
  double sum = 0;
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    const Velocity partOfA = Space::unpack(a.segment<D>(D * i));
    const Velocity partOfB = Space::unpack(b.segment<D>(D * i));
    sum += partOfA.linear.dot(partOfB.linear) +
           settings_.lengthScale * settings_.lengthScale * partOfA.angular.dot(partOfB.angular);
  }
  return sum;
}

template <int D>
double Stepper<D>::norm(const Vector& move) const {
  return std::sqrt(product(move, move));
}

/// Takes from the velocities, in the metric of the masses, what joints and held contacts forbid.
template <int D>
bool Stepper<D>::projectVelocities(Motion& motion, bool withFriction) {
  const Vector warm = program_.multipliers;
  system_.setMasses(motion.poses);
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    const Velocity& velocity = motion.velocities[i];
    program_.x.template segment<D>(D * i) = Space::pack(pinned_[i] ? Velocity{} : velocity);
  }
  program_.force = system_.timesA(program_.x);
  program_.multipliers.setZero();
  program_.contacts.clear();
  for (Row row : kept_) {
    placeRow(row, motion.poses);
    holdPinned(row);
    row.bias = row.multiplier = row.slipBound = 0;
    row.slipMultiplier.setZero();
    row.active = row.trialImpulse(program_.x, system_.rho()) > 0;
    program_.contacts.push_back(std::move(row));
  }
  const bool found = withFriction ? solveWithFriction(motion.poses) : solveVelocities(motion.poses);
  program_.multipliers = warm;
  if (!found) return false;
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    motion.velocities[i] = Space::unpack(program_.x.template segment<D>(D * i));
  }
  return true;
}

template <int D>
bool Stepper<D>::collide(Motion& motion) {
  return projectVelocities(motion, true);
}

template <int D>
double Stepper<D>::project(Motion& motion) {
  std::vector<Row> pushing;
  for (const Row& row : kept_) {
    if (row.multiplier > 0) pushing.push_back(row);
  }
  const double gap = closeGaps(motion.poses, std::move(pushing));
  if (!system_.hasJoints() && kept_.empty()) return gap;
  return projectVelocities(motion, false) ? gap : std::numeric_limits<double>::infinity();
}

template <int D>
double Stepper<D>::assemble(Poses& poses) {
  return closeGaps(poses, {});
}

/// The largest gap of joints, whose gaps are given, and of these contacts.
template <int D>
double Stepper<D>::largestGap(const Vector& gaps, const std::vector<Row>& held) const {
  double largest = largestOf(gaps);
  for (const Row& row : held) {
    largest = std::max(largest, std::abs(contactGap(row.contact, poses_)));
  }
  return largest;
}

/// Factors the masses with the joints and these contacts, where the bricks are.
template <int D>
bool Stepper<D>::factorMasses(std::vector<Row>& held) {
  system_.setMasses(poses_);
  system_.placeJoints(poses_);
  for (Row& row : held) {
    placeRow(row, poses_);
    holdPinned(row);
    row.active = true;
    row.slipBound = 0;
  }
  return system_.factor(held);
}

/// Closes the joints and the gaps of these contacts, moving the bricks as little as their masses
/// allow. Returns the largest gap left.
template <int D>
double Stepper<D>::closeGaps(Poses& poses, std::vector<Row> held) {
  const double scale = settings_.lengthScale;
  poses_ = poses;
  Vector gaps = system_.jointGaps(poses_);
  double gap = largestGap(gaps, held);
  bool isCurrent = false;
  for (int round = 0; round < kAssemblyRounds && gap > kGapTolerance * scale; ++round) {
    if (!isCurrent && !factorMasses(held)) break;
    Vector move = Vector::Zero(D * bricks_.size());
    system_.addJointImpulse(-system_.kappa(), gaps, move);
    for (const Row& row : held) {
      row.addNormal(-system_.rho() * contactGap(row.contact, poses_), move);
    }
    system_.solveInPlace(move);
    displace(move);
    const double before = gap;
    gaps = system_.jointGaps(poses_);
    gap = largestGap(gaps, held);
    isCurrent = before <= kSmallGap * scale && gap < kFactorKept * before;
    if (gap > 0.9 * before && gap < kGapAccepted * scale) break;
  }
  poses = poses_;
  return gap;
}

template class Stepper<3>;
template class Stepper<6>;

}  // namespace kirireel
