// At a regular state the displacements that joints allow are those of the velocities they allow, up
// to the square of their size. At a singular state the velocities form a larger space than the
// paths, and closing leads back to the start. A path is found in three steps:
//
// 1. Steps of first order find a closed state at some distance. They do not find its time, because
//    they lose velocity at the start. They may also stay at the start. A closed sheet opens under
//    forces away from its centre, so these are tried if the loads fail. If the displacement is
//    against the loads, forces in the opposite direction find the other side.
// 2. On the path, at the size s, the least stiff constraint is proportional to s. The motion ends
// at
//    the least size at which projections resolve it. Sheets of more tiles need a larger size.
// 3. Collocation finds the motion until then. The accelerations a(t) are a polynomial through three
//    nodes. None of them is the singular start. The states at the nodes are
//      x = start + integral of (t - s) a(s) ds,   v = integral of a(s) ds,
//    moved to the nearest closed state and projected on the velocities that joints allow there, in
//    the metric of the masses. Bends of the path change the end by the square of its size.
#include "sim/mechanics/singular_start.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/LU>

namespace kirireel::mechanics {
namespace {

// Sizes of displacements are in length scales.
constexpr double kSmallest = 1e-3;   // first size of the motion's end
constexpr double kLargest = 0.3;     // last size
constexpr double kGrowth = 4;        // factor from one size to the next
constexpr double kReach = 0.1;       // size of the state that steps of first order find
constexpr double kLongest = 60;      // duration of the motion, over the longest step
constexpr double kProbe = 1.0 / 64;  // step that measures accelerations, over the longest step
constexpr double kSingular = 0.1;    // fraction of a displacement that closing removes
constexpr double kFirstOrder = 0.1;  // length of first-order steps, over the time to kReach
constexpr long kSteps = 30;          // most first-order steps
constexpr long kHalvedSteps = 300;   // most first-order steps, halves included
constexpr double kSameSize = 1e-6;   // relative change of the size that ends a search
constexpr double kSameSpeed = 1e-6;  // relative change of the speed that ends a projection
constexpr double kSameEnd = 1e-6;    // relative change of the last speed that ends collocation
constexpr int kMaxProjections = 30;
constexpr int kMaxRounds = 8;            // rounds of the other searches
constexpr double kClosedJoints = 1e-10;  // length scales
constexpr double kMoment = 1e-3;         // time to measure accelerations, over the duration
constexpr double kSameLoads = 0.1;       // relative change of loads that keeps a departure

// Times of the nodes over the duration.
constexpr int kNodes = 3;
constexpr std::array<double, kNodes> kTimes = {0.5, 0.75, 1};

/// A displacement, a velocity or an acceleration of all bricks.
using Move = std::vector<Velocity>;

Move sum(const Move& a, double factor, const Move& b) {
  Move result = a;
  for (std::size_t i = 0; i < a.size(); ++i) {
    result[i].linear += factor * b[i].linear;
    result[i].angular += factor * b[i].angular;
  }
  return result;
}

Move scaled(double factor, const Move& move) {
  return sum(Move(move.size()), factor, move);
}

double sizeOf(const Move& move, double scale) {
  double largest = 0;
  for (const Velocity& part : move) {
    largest = std::max(largest, part.linear.norm() + scale * part.angular.norm());
  }
  return largest;
}

Poses moved(const Poses& poses, const Move& move) {
  Poses result = poses;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    result[i] = displaced(poses[i], move[i].linear, move[i].angular);
  }
  return result;
}

Move moveBetween(const Poses& from, const Poses& to) {
  Move move(from.size());
  for (std::size_t i = 0; i < from.size(); ++i) {
    move[i].linear = to[i].position - from[i].position;
    move[i].angular = turnBetween(from[i].rotation, to[i].rotation);
  }
  return move;
}

/// The search for a departure.
class DepartureSearch {
 public:
  DepartureSearch(const std::vector<brick::Brick>& bricks, JointSolver& solver,
                  const ExtrapolationSettings& settings, const Motion& start,
                  const TimedLoads& loads)
      : bricks_(bricks), solver_(solver), settings_(settings), start_(start), loads_(loads) {}

  bool isAtRest() const { return size(start_.velocities) == 0; }
  bool isSingular();
  std::optional<Departure> find();

  const StepReport& report() const { return report_; }

 private:
  double size(const Move& move) const { return sizeOf(move, settings_.lengthScale); }
  Move moveTo(const Poses& poses) const { return moveBetween(start_.poses, poses); }
  double longest() const { return kLongest * settings_.longestStep; }
  double timeTo(double distance, double acceleration) const;
  double product(const Move& a, const Move& b) const;
  Move fromCentre() const;

  LoadSource loadsAfter(double seconds) const;
  LoadSource forces(const Move& accelerations) const;
  std::optional<Move> follow(const LoadSource& loads, long mostSteps);
  std::optional<Move> moveOnPath(long mostSteps);
  std::optional<Departure> findWithin(long mostSteps);

  bool projectFully(Motion& motion);
  std::optional<Motion> nearestOnPath(const Move& desired, const Move& velocities,
                                      const Poses& near);
  std::optional<Move> acceleration(const Motion& motion, double seconds, double duration);
  bool setNodes(const std::array<Move, kNodes>& accelerations, double duration);
  void countError(const std::array<Move, kNodes>& accelerations, double duration);
  Departure departure(double duration) const;
  std::optional<Departure> collocate(const Move& along, double distance, double duration);

  const std::vector<brick::Brick>& bricks_;
  JointSolver& solver_;
  const ExtrapolationSettings& settings_;
  const Motion& start_;
  const TimedLoads& loads_;
  StepReport report_;
  Move free_;  // acceleration at the start by the velocities that joints allow
  std::array<Motion, kNodes> nodes_;
  double dampedPower_ = 0;  // at the last node, watts
};

LoadSource DepartureSearch::loadsAfter(double seconds) const {
  return [this, seconds](const Poses& poses, std::vector<brick::Load>& out) {
    loads_(seconds, poses, out);
  };
}

/// How long an even acceleration (m/s^2) takes to this distance (length scales), seconds.
double DepartureSearch::timeTo(double distance, double acceleration) const {
  return std::sqrt(2 * distance * settings_.lengthScale / acceleration);
}

/// In the metric of the masses.
double DepartureSearch::product(const Move& a, const Move& b) const {
  double sum = 0;
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    const Quaternion back = start_.poses[i].rotation.conjugate();
    sum += bricks_[i].mass * a[i].linear.dot(b[i].linear) +
           (back * a[i].angular).dot(bricks_[i].inertia * (back * b[i].angular));
  }
  return sum;
}

/// Constant forces that would give free bricks these accelerations.
LoadSource DepartureSearch::forces(const Move& accelerations) const {
  return [this, accelerations](const Poses& poses, std::vector<brick::Load>& out) {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const Quaternion& turn = start_.poses[i].rotation;
      out[i] = {};
      out[i].force.head<3>() = bricks_[i].mass * accelerations[i].linear;
      out[i].force.tail<3>() =
          turn * (bricks_[i].inertia * (turn.conjugate() * accelerations[i].angular));
    }
  };
}

/// Accelerations away from the centre of all bricks, as large as those of the loads.
Move DepartureSearch::fromCentre() const {
  const Vector3 centre = meanPosition(start_.poses);
  Move away(start_.poses.size());
  for (std::size_t i = 0; i < away.size(); ++i) away[i].linear = start_.poses[i].position - centre;
  return scaled(size(free_) / size(away), away);
}

/// Whether loads move the bricks, and closing takes a part of their displacement away.
bool DepartureSearch::isSingular() {
  const double probe = kProbe * settings_.longestStep;
  Motion after = start_;
  LoadGain given;
  report_ += solver_.eulerStep(after, probe, loadsAfter(0), given);
  free_ = scaled(1 / probe, after.velocities);
  if (!(timeTo(kSmallest, size(free_)) < longest())) return false;
  const Move desired = scaled(kSmallest * settings_.lengthScale / size(free_), free_);
  Poses closed = moved(start_.poses, desired);
  solver_.assemble(closed);
  return size(sum(desired, -1, moveTo(closed))) >= kSingular * size(desired);
}

/// Steps of first order under these loads, until a state at the distance kReach is reached. Returns
/// its displacement, or nothing if they do not leave the start.
std::optional<Move> DepartureSearch::follow(const LoadSource& loads, long mostSteps) {
  Motion state = start_;
  const double step = kFirstOrder * timeTo(kReach, size(free_));
  const long last = report_.steps + mostSteps;
  Move move = moveTo(state.poses);
  while (report_.steps < last && size(move) < kReach * settings_.lengthScale) {
    report_ += solver_.advance(state, step, loads, nullptr);
    move = moveTo(state.poses);
  }
  solver_.forgetSteps();
  if (size(move) < kReach * settings_.lengthScale) return std::nullopt;
  return move;
}

/// The displacement to a state on a path, on the side to which the loads pull.
std::optional<Move> DepartureSearch::moveOnPath(long mostSteps) {
  std::optional<Move> move = follow(loadsAfter(0), mostSteps);
  if (!move) move = follow(forces(fromCentre()), mostSteps);
  if (!move || product(*move, free_) >= 0) return move;
  return follow(forces(scaled(-size(free_) / size(*move), *move)), mostSteps);
}

/// Projects velocities onto those that joints allow, again until nothing changes: near a singular
/// state each projection is incomplete.
bool DepartureSearch::projectFully(Motion& motion) {
  const double speed = size(motion.velocities);
  for (int round = 0; round < kMaxProjections; ++round) {
    const Move before = motion.velocities;
    if (!solver_.collide(motion)) return false;
    if (size(sum(before, -1, motion.velocities)) <= kSameSpeed * speed) return true;
  }
  return false;
}

/// The closed state on a path that is nearest to a displacement, with the velocities that joints
/// allow there, of those that belong to it. `near`: on the path. Nothing if it is not found.
std::optional<Motion> DepartureSearch::nearestOnPath(const Move& desired, const Move& velocities,
                                                     const Poses& near) {
  Motion end{near, velocities};
  for (int round = 0; round < kMaxRounds; ++round) {
    if (!(solver_.project(end) <= kClosedJoints * settings_.lengthScale)) return std::nullopt;
    const Move move = moveTo(end.poses);
    Motion rest{end.poses, sum(desired, -1, move)};
    if (!projectFully(rest) || !projectFully(end)) return std::nullopt;
    if (size(rest.velocities) <= kSameSize * size(move)) return end;
    end = {moved(end.poses, rest.velocities), velocities};
  }
  return std::nullopt;
}

/// The acceleration by the velocities that joints allow in a state, at this time of the motion.
std::optional<Move> DepartureSearch::acceleration(const Motion& motion, double seconds,
                                                  double duration) {
  const double step = kMoment * duration;
  Motion after = motion;
  LoadGain given;
  const StepReport taken = solver_.eulerStep(after, step, loadsAfter(seconds), given);
  dampedPower_ = taken.damped / step;
  report_ += taken;
  Motion result{motion.poses, scaled(1 / step, sum(after.velocities, -1, motion.velocities))};
  if (!projectFully(result)) return std::nullopt;
  return result.velocities;
}

/// Weights of the accelerations at the nodes in the speed (first) and the displacement (second) at
/// each node, for a unit duration. The polynomial passes through the nodes from `first` on.
std::array<Eigen::Matrix<double, kNodes, kNodes>, 2> weights(int first) {
  const int count = kNodes - first;
  Eigen::MatrixXd values(count, count), speeds(kNodes, count), moves(kNodes, count);
  for (int j = 0; j < kNodes; ++j) {
    for (int m = 0; m < count; ++m) {
      if (j >= first) values(j - first, m) = std::pow(kTimes[j], m);
      speeds(j, m) = std::pow(kTimes[j], m + 1) / (m + 1);
      moves(j, m) = std::pow(kTimes[j], m + 2) / ((m + 1) * (m + 2));
    }
  }
  std::array<Eigen::Matrix<double, kNodes, kNodes>, 2> result;
  for (auto& matrix : result) matrix.setZero();
  result[0].rightCols(count) = speeds * values.inverse();
  result[1].rightCols(count) = moves * values.inverse();
  return result;
}

/// Moves the nodes to the states that follow from their accelerations.
bool DepartureSearch::setNodes(const std::array<Move, kNodes>& accelerations, double duration) {
  const auto [speeds, moves] = weights(0);
  for (int j = 0; j < kNodes; ++j) {
    Move move(start_.poses.size()), velocities = move;
    for (int k = 0; k < kNodes; ++k) {
      move = sum(move, duration * duration * moves(j, k), accelerations[k]);
      velocities = sum(velocities, duration * speeds(j, k), accelerations[k]);
    }
    const auto node = nearestOnPath(move, velocities, nodes_[j].poses);
    if (!node) return false;
    nodes_[j] = *node;
  }
  return true;
}

/// The error at the end, estimated by a polynomial of one order less, counts as rounding beyond the
/// tolerance: without rounding the motion could be shorter.
void DepartureSearch::countError(const std::array<Move, kNodes>& accelerations, double duration) {
  const auto difference = weights(0)[1] - weights(1)[1];
  Move error(start_.poses.size());
  for (int k = 0; k < kNodes; ++k) {
    error = sum(error, duration * duration * difference(kNodes - 1, k), accelerations[k]);
  }
  report_.rounding += std::max(0.0, size(error) - settings_.tolerance * settings_.lengthScale);
}

/// The power of dampers grows with the square of the time.
Departure DepartureSearch::departure(double duration) const {
  Departure result{.start = start_, .damped = dampedPower_ * duration / 3, .now = start_};
  for (int j = 0; j < kNodes; ++j) result.states.push_back({kTimes[j] * duration, nodes_[j]});
  result.loads.resize(bricks_.size());
  loads_(0, start_.poses, result.loads);
  return result;
}

/// The motion of this duration to about this distance. `along`: the displacement to a state on the
/// path.
std::optional<Departure> DepartureSearch::collocate(const Move& along, double distance,
                                                    double duration) {
  Poses near = moved(start_.poses, along);
  for (int j = kNodes - 1; j >= 0; --j) {
    const double share = distance * settings_.lengthScale / size(along) * kTimes[j] * kTimes[j];
    const Move move = scaled(share, along);
    const auto node = nearestOnPath(move, scaled(2 / (kTimes[j] * duration), move), near);
    if (!node) return std::nullopt;
    nodes_[j] = *node;
    near = node->poses;
  }
  for (int round = 0; round < kMaxRounds; ++round) {
    std::array<Move, kNodes> accelerations;
    for (int j = 0; j < kNodes; ++j) {
      const auto found = acceleration(nodes_[j], kTimes[j] * duration, duration);
      if (!found) return std::nullopt;
      accelerations[j] = *found;
    }
    const Move before = nodes_.back().velocities;
    if (!setNodes(accelerations, duration)) return std::nullopt;
    const Move& speed = nodes_.back().velocities;
    if (size(sum(speed, -1, before)) > kSameEnd * size(speed)) continue;
    countError(accelerations, duration);
    return departure(duration);
  }
  return std::nullopt;
}

/// The shortest motion that rounding allows, along a path that this number of steps finds.
std::optional<Departure> DepartureSearch::findWithin(long mostSteps) {
  const std::optional<Move> along = moveOnPath(mostSteps);
  if (!along) return std::nullopt;
  // An acceleration `pull` times `along`.
  const double pull = product(*along, free_) / product(*along, *along);
  for (double distance = kSmallest; distance < kLargest; distance *= kGrowth) {
    const double duration = timeTo(distance, pull * size(*along));
    if (!(duration < longest())) break;
    if (auto result = collocate(*along, distance, duration)) return result;
  }
  return std::nullopt;
}

/// Often no joints can close after the first steps. Halves of them then fail too, at up to 65 times
/// the cost. So steps without halves, which continue with open joints, come first.
std::optional<Departure> DepartureSearch::find() {
  const bool wasHalving = solver_.setHalving(false);
  std::optional<Departure> found = findWithin(kSteps);
  solver_.setHalving(true);
  if (!found) found = findWithin(kHalvedSteps);
  solver_.setHalving(wasHalving);
  return found;
}

}  // namespace

std::optional<Departure> leaveSingularState(const std::vector<brick::Brick>& bricks,
                                            JointSolver& solver,
                                            const ExtrapolationSettings& settings,
                                            const Motion& motion, double seconds,
                                            const TimedLoads& loads, const StepFilter& mayTake,
                                            StepReport& report) {
  DepartureSearch search(bricks, solver, settings, motion, loads);
  if (!search.isAtRest() || !search.isSingular()) return std::nullopt;
  std::optional<Departure> found = search.find();
  report.steps += search.report().steps;
  report.factorizations += search.report().factorizations;
  report.work += search.report().work;
  const auto mayPass = [&] {
    const Motion* from = &motion;
    double begin = 0;
    for (const PassedState& state : found->states) {
      if (!mayTake(*from, state.motion, state.seconds - begin)) return false;
      from = &state.motion;
      begin = state.seconds;
    }
    return true;
  };
  if (!found || (mayTake && !mayPass())) {
    report.singularTime += seconds;
    return std::nullopt;
  }
  report.rounding += search.report().rounding;
  return found;
}

bool Departure::isCurrent(const Motion& motion, const TimedLoads& loadsNow) const {
  for (std::size_t i = 0; i < now.poses.size(); ++i) {
    if (motion.poses[i].position != now.poses[i].position ||
        motion.velocities[i].linear != now.velocities[i].linear)
      return false;
  }
  std::vector<brick::Load> present(loads.size());
  loadsNow(0, start.poses, present);
  double largest = 0, change = 0;
  for (std::size_t i = 0; i < loads.size(); ++i) {
    largest = std::max(largest, loads[i].force.norm());
    change = std::max(change, (present[i].force - loads[i].force).norm());
  }
  return change <= kSameLoads * largest;
}

double Departure::advance(JointSolver& solver, Motion& motion, double seconds,
                          std::vector<PassedState>& passed, StepReport& report) {
  const double begin = done, duration = states.back().seconds;
  done = std::min(begin + seconds, duration);
  for (const PassedState& state : states) {
    if (state.seconds > begin && state.seconds < done)
      passed.push_back({state.seconds - begin, state.motion});
  }
  now = states.back().motion;
  if (!isOver()) {
    const std::span<const PassedState> before(states.data(), states.size() - 1);
    now = {posesBetween(start, before, states.back().motion, duration, done),
           velocitiesBetween(start, before, states.back().motion, duration, done)};
    solver.assemble(now.poses);
  }
  motion = now;
  ++report.steps;
  report.damped += damped * (std::pow(done / duration, 3) - std::pow(begin / duration, 3));
  return done - begin;
}

}  // namespace kirireel::mechanics
