// At a regular state the displacements that joints allow are those of the velocities they allow, up
// to the square of their size: closing the joints after a step changes it by a small part. At a
// singular state the velocities form a larger space than the paths, and closing leads back to the
// start. So a step d = 1/2 h^2 a is predicted in that space and replaced by the nearest closed
// state, in the metric of the masses:
//   1. Steps of first order find a state on the path. They do not find its time, because they lose
//      velocity at the start.
//   2. What is missing to d is projected onto the velocities that joints allow in the state, the
//      bricks move by it, and the joints are closed, until nothing changes. On the path, away from
//      its singular start, joints are regular.
// On a straight path with the tangent t this is d = 1/2 h^2 t (t.M a) / (t.M t), the motion under
// the loads. Bends change it by the square of its size.
#include "sim/mechanics/singular_start.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace kirireel::mechanics {
namespace {

// Size of the step, length scales. The bend of the path changes the speed at its end by about this
// share. Smaller steps end too near to the singular state, where the joints' determinant is
// proportional to the distance.
constexpr double kMinSize = 1e-5;
constexpr double kMaxSize = 1e-3;
constexpr double kShortestFirst = 1e-3;  // over the longest step
constexpr double kSingular = 0.1;        // share of d that closing takes away at singular states
constexpr double kFirstOrder = 0.25;     // such a step, over the longest step
constexpr long kMaxSteps = 100;          // of these in one search, halves included
constexpr unsigned kMaxSearches = 16;
constexpr long kMaxBrickSteps = 20000;  // of all searches, times the number of bricks
constexpr double kSameSize = 1e-4;      // of changes that end the search, over the step
constexpr double kSameSpeed = 1e-6;     // of changes that end a projection, over the speed
constexpr int kMaxRounds = 30;
constexpr double kClosedJoints = 1e-10;  // length scales
constexpr double kMoment = 1e-3;         // over the step: a time in which losses are measured

/// A displacement or a velocity of all bricks.
using Move = std::vector<Velocity>;

Move sum(const Move& a, double factor, const Move& b) {
  Move result = a;
  for (std::size_t i = 0; i < a.size(); ++i) {
    result[i].linear += factor * b[i].linear;
    result[i].angular += factor * b[i].angular;
  }
  return result;
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

/// Whether joints allow a step by about this displacement, so that closing changes it little.
bool isRegular(JointSolver& solver, double scale, const Poses& start, const Move& desired) {
  Poses closed = moved(start, desired);
  solver.assemble(closed);
  const Move missing = sum(desired, -1, moveBetween(start, closed));
  return sizeOf(missing, scale) < kSingular * sizeOf(desired, scale);
}

/// Steps of first order under these loads, until a state at a distance of one step is reached.
/// Nothing if they do not leave the start.
std::optional<Poses> followLoads(JointSolver& solver, const ExtrapolationSettings& settings,
                                 const Motion& start, const LoadSource& loads, StepReport& report) {
  Motion state = start;
  const double most = kMaxSize * settings.lengthScale;
  const long last = report.steps + kMaxSteps;
  double size = 0;
  for (long k = 0; k < kMaxSteps && report.steps < last && size < most; ++k) {
    report += solver.advance(state, kFirstOrder * settings.longestStep, loads, nullptr);
    size = sizeOf(moveBetween(start.poses, state.poses), settings.lengthScale);
  }
  // Forgets these steps.
  solver.setJointStiffness(solver.jointStiffness());
  return size < most ? std::nullopt : std::optional(std::move(state.poses));
}

/// A state on a path from the start. Steps of first order may stay at the start, because closing
/// leads back to it: then the loads on some bricks are reversed.
std::optional<Poses> stateOnPath(JointSolver& solver, const ExtrapolationSettings& settings,
                                 const Motion& start, const LoadSource& loads, StepReport& report) {
  std::optional<Poses> found;
  const long last = report.steps + kMaxBrickSteps / static_cast<long>(start.poses.size());
  for (unsigned search = 0; search < kMaxSearches && report.steps < last && !found; ++search) {
    const LoadSource mixed = [&](const Poses& poses, std::vector<brick::Load>& out) {
      loads(poses, out);
      std::mt19937 bits(search);
      for (brick::Load& load : out) {
        if (search > 0 && bits() % 2 == 1) load.force = -load.force;
      }
    };
    found = followLoads(solver, settings, start, mixed, report);
  }
  return found;
}

/// Projects velocities onto those that joints allow, again until nothing changes: near a singular
/// state each projection is incomplete.
bool projectFully(JointSolver& solver, double scale, Motion& motion) {
  const double size = sizeOf(motion.velocities, scale);
  for (int round = 0; round < kMaxRounds; ++round) {
    const Move before = motion.velocities;
    if (!solver.collide(motion)) return false;
    if (sizeOf(sum(before, -1, motion.velocities), scale) <= kSameSpeed * size) return true;
  }
  return false;
}

/// The closed state on a path that is nearest to a displacement, with the velocities that joints
/// allow there, of those that belong to it. `near`: on the path. Nothing if it is not found.
std::optional<Motion> nearestOnPath(JointSolver& solver, double scale, const Poses& start,
                                    const Move& desired, const Move& velocities,
                                    const Poses& near) {
  const double size = sizeOf(desired, scale);
  Motion end{near, velocities};
  for (int round = 0; round < kMaxRounds; ++round) {
    if (!(solver.project(end) <= kClosedJoints * scale)) return std::nullopt;
    Motion rest{end.poses, sum(desired, -1, moveBetween(start, end.poses))};
    if (!projectFully(solver, scale, rest) || !projectFully(solver, scale, end))
      return std::nullopt;
    if (sizeOf(rest.velocities, scale) <= kSameSize * size) return end;
    end = {moved(end.poses, rest.velocities), velocities};
  }
  return std::nullopt;
}

/// Adds the cost of the trials, and the step's losses to dampers: their power grows with the square
/// of the time.
void countStep(JointSolver& solver, const Motion& end, double step, const LoadSource& loads,
               const StepReport& trials, StepReport& report) {
  report.steps += trials.steps;
  report.factorizations += trials.factorizations;
  report.work += trials.work;
  Motion after = end;
  LoadGain given;
  report.damped += solver.eulerStep(after, kMoment * step, loads, given).damped / (3 * kMoment);
}

}  // namespace

std::optional<double> leaveSingularState(JointSolver& solver, const ExtrapolationSettings& settings,
                                         Motion& motion, double seconds, const TimedLoads& loads,
                                         const StepFilter& mayTake, StepReport& report) {
  const double scale = settings.lengthScale;
  if (sizeOf(motion.velocities, scale) > 0) return std::nullopt;
  const LoadSource now = [&](const Poses& poses, std::vector<brick::Load>& out) {
    loads(0, poses, out);
  };
  StepReport trials;
  const auto speedAfter = [&](double step) {
    Motion end = motion;
    LoadGain given;
    trials += solver.eulerStep(end, step, now, given);
    return end.velocities;
  };
  for (double step = std::min(seconds, settings.longestStep);
       step >= kShortestFirst * settings.longestStep; step *= 0.5) {
    const Move whole = speedAfter(step), half = speedAfter(0.5 * step);
    // Twice the speed after half the step: the drag at its middle.
    const Move speed = sum(half, 1, half);
    const double size = 0.5 * step * sizeOf(speed, scale);
    const double error = 0.5 * step * sizeOf(sum(whole, -1, speed), scale);
    if (size < kMinSize * scale) return std::nullopt;
    if (size > kMaxSize * scale || error > settings.tolerance * scale) continue;
    Move desired = speed;
    for (Velocity& part : desired) part = {0.5 * step * part.linear, 0.5 * step * part.angular};
    if (isRegular(solver, scale, motion.poses, desired)) return std::nullopt;
    const auto near = stateOnPath(solver, settings, motion, now, trials);
    std::optional<Motion> end;
    if (near) end = nearestOnPath(solver, scale, motion.poses, desired, speed, *near);
    if (!end || (mayTake && !mayTake(motion, *end, step))) {
      report.singularTime += seconds;
      return std::nullopt;
    }
    motion = *end;
    countStep(solver, motion, step, now, trials, report);
    return step;
  }
  return std::nullopt;
}

}  // namespace kirireel::mechanics
