// How a run leaves its start, and when it is at rest.
//
// A start that stands in an unstable equilibrium is left by a nudge (see nudge.h), one that moves
// by itself without. A run rests while its fastest brick is slower than the settle speed, or while
// steps fail however short they are and no brick gets anywhere. Once it has rested for the settle
// time, these are tried in order: a stiffer pull, where a target is pulled to; long implicit steps
// from rest, which tell bricks that are only slow; what the timeline has for a state of rest; and a
// nudge, where the run had none yet or only its symmetric part, for an equilibrium that a motion
// came to may be unstable too. Where nothing of this moves the bricks, the run is over.
//
// All of this happens at moments that follow from the motion, not from where steps end: steps are
// made to end there (see Run::nextLength).
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include <fmt/format.h>

#include "sim/deploy/rest_probe.h"
#include "sim/deploy/run.h"

namespace kirireel {
namespace {

// At a target, a run that is this near to where springs rest, or to it, is not only slow.
constexpr double kThere = 1.05;
constexpr double kThereShare = 1e-6;
// So much of the model's size from the target is arrived: a stiffer pull is not tried.
constexpr double kArrivedShare = 1e-9;
// Steps that fail, and bring no brick farther than this part of a tile, are no motion.
constexpr double kStuckShare = 1e-3;
// A step is looked at in so many parts for the beginning of rest, and the part halved so often.
constexpr int kRestLooks = 16;
constexpr int kRestHalvings = 30;

}  // namespace

std::unique_ptr<Dynamics> Run::copyOfSolver() {
  std::unique_ptr<Dynamics> copy = makeSolver();
  StateTape recorded;
  recorded.transfer(*dynamics_);
  StateTape(recorded.numbers()).transfer(*copy);
  return copy;
}

/// Gives the bricks, which stand at the start, what they need to leave it: nothing where they move
/// by themselves. An engine's start is not known to its end, and it gets the whole nudge.
void Run::nudgeStart() {
  nudged_ = Nudged::Wholly;
  std::vector<Velocity> whole = nudge(bricks_.size(), size_, scene_.solver.seed);
  if (scene_.solver.kind == SolverKind::Bullet) {
    motion_.velocities = std::move(whole);
    return;
  }
  const std::unique_ptr<Dynamics> dynamics = makeSolver();
  holdJoints(*dynamics);
  Motion trial = {motion_.poses, std::vector<Velocity>(bricks_.size())};
  dynamics->advance(trial, kNudgeTime, loadsNow());
  if (movesByItself(trial.velocities, !pivots_.empty(), tileSize_, size_)) {
    nudged_ = Nudged::No;
    return;
  }
  SymmetricStates symmetries(scene_);
  symmetries.keepThoseOf(motion_.poses);
  if (symmetries.group().size() > 1) {
    std::vector<Velocity> symmetric =
        symmetricNudge(whole, motion_.poses, symmetries.group(), *dynamics);
    if (!symmetric.empty()) {
      nudged_ = Nudged::InSymmetry;
      whole = std::move(symmetric);
    }
  }
  motion_.velocities = std::move(whole);
}

/// A motion may come to an equilibrium that is not stable, as a start may be one.
void Run::nudgeAtRest() {
  nudged_ = Nudged::Wholly;
  restTime_ = 0;
  const std::vector<Velocity> whole = nudge(bricks_.size(), size_, scene_.solver.seed);
  for (std::size_t i = 0; i < whole.size(); ++i) motion_.velocities[i].linear += whole[i].linear;
}

/// Notes where the bricks are when steps begin to fail at their shortest.
void Run::watchJam(const StepReport& report) {
  const bool fails = report.unconverged > 0;
  if (!fails) {
    jamStart_.clear();
  } else if (!isStuck()) {
    jamStart_ = motion_.poses;
  }
}

/// Whether steps fail, and the bricks have stayed since they began to.
bool Run::isStuck() const {
  return !jamStart_.empty() &&
         farthestMove(jamStart_, motion_.poses, tileSize_) < kStuckShare * tileSize_;
}

/// Of all bricks, turns counted at a tile's size, m/s.
double Run::fastestSpeed(const std::vector<Velocity>& velocities) const {
  double fastest = 0;
  for (const Velocity& velocity : velocities) {
    const double speed = velocity.linear.norm() + velocity.angular.norm() * tileSize_;
    fastest = std::max(fastest, speed);
  }
  return fastest;
}

/// Whether bricks that hardly move are only slow: soft springs and heavy bricks are.
bool Run::isOnItsWay() {
  const bool targetPulls = pullsToTarget() && timeline_.forcesAreOn();
  const double arrived = std::max(kThere * leastError_, kThereShare * tileSize_);
  if (isStuck() || scene_.solver.kind == SolverKind::Bullet) return false;
  if (targetPulls ? currentTargetError() <= arrived : !hingesPull()) return false;
  const RestProbe probe = probeRest(*copyOfSolver(), motion_, look_, loadsNow(), tileSize_);
  figures_.addWork(probe.work);
  return probe.movesOn;
}

/// For how long up to the end of the last step the fastest speed has stayed below a limit that it
/// is below then, seconds; the whole step's length where it was never above. Speeds swing: looked
/// at in parts of the step, then by bisection.
double Run::restWithinStep(double limit) const {
  const auto isFast = [&](double seconds) { return fastestSpeed(velocitiesAt(seconds)) >= limit; };
  const double part = length_ / kRestLooks;
  int fast = kRestLooks - 1;
  while (fast >= 0 && !isFast(fast * part)) --fast;
  if (fast < 0) return length_;
  double above = fast * part;
  double below = above + part;
  for (int k = 0; k < kRestHalvings; ++k) {
    const double middle = 0.5 * (above + below);
    (isFast(middle) ? above : below) = middle;
  }
  return length_ - below;
}

void Run::updateRest() {
  const double limit = scene_.stop.settleSpeed * size_;
  const bool isSlow = fastestSpeed() < limit;
  if (isOnPath() || !(isSlow || isStuck())) {
    restTime_ = 0;
    return;
  }
  const double within = isSlow ? restWithinStep(limit) : length_;
  restTime_ = within < length_ ? within : restTime_ + length_;
}

double Run::restMoment() const {
  if (!(restTime_ > 0)) return std::numeric_limits<double>::infinity();
  return time() + restNeeded_ - restTime_;
}

/// Nothing moves: a stiffer pull, a nudge or the timeline may change that, else the run is over.
void Run::restOrGoOn() {
  const bool stiffer = pullsToTarget() && timeline_.forcesAreOn() && !stiffness_.exhausted();
  if (stiffer && currentTargetError() > kArrivedShare * size_) {
    stiffness_.stiffen();
    restTime_ = 0;
  } else if (isOnItsWay()) {
    restTime_ = 0;
    restNeeded_ *= 2;
  } else if (followTimeline(true) || (!timeline_.isOver(time()) && !timeline_.waitsForState())) {
    return;  // something acts now, or will
  } else if (nudged_ != Nudged::Wholly && !hasArrived()) {
    nudgeAtRest();
  } else if (timeline_.isOver(time())) {
    endAtRest();
  } else {
    end(Outcome::Locked, fmt::format("came to rest, yet {}", timeline_.pending()));
  }
}

}  // namespace kirireel
