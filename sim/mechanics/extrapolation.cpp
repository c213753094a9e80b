// Extrapolation of the linearly implicit Euler method. Row j of the table crosses the step H in
// n_j = j Euler steps; their error is a power series in H / n_j. By Aitken and Neville
//   T_k = sum_j c_j row_j,   c_j = prod_{i != j} n_j / (n_j - n_i),
// over the rows 1 to k is of order k, and over the rows 2 to k of order k - 1. The difference of
// the two estimates the error of the latter; the former is used. Positions, rotation vectors from
// the step's start, velocities and the energy lost to dampers are combined. Then joints are closed
// and velocities made compatible, in the mass metric. Total momentum is conserved to rounding,
// except for the impulse of the loads. On request, energy is conserved to a fraction of the
// tolerance. The work of the loads is summed in each row and extrapolated in the same form. Its
// difference from the change of energy is an additional error of the step. After each row the step
// is taken, rejected or continued by the rules of SEULEX. The next step has the length and order of
// the smallest cost per second. Hairer and Wanner, Solving Ordinary Differential Equations II,
// 1996, IV.9; constraints: Lubich, Extrapolation integrators for constrained multibody systems,
// 1991.
#include "sim/mechanics/extrapolation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace kirireel::mechanics {
namespace {

// These constants are from the SEULEX code and its description, except for kFirst, kShortest,
// kRejections and kSticking.
constexpr int kFewestRows = 2;
constexpr int kMaxRows = 8;  // with more rows, rounding errors dominate
// Safety factors of the step length, and limits of its change.
constexpr double kSafety = 0.94;
constexpr double kAim = 0.65;
constexpr double kMinStepFactor = 0.02;
constexpr double kMaxFactor = 20;
// The order changes if the work per second falls by these factors.
constexpr double kFewer = 0.8;
constexpr double kMore = 0.9;
// The first step and the shortest step, over the longest one. Tolerances below kShortest allow
// shorter steps: the tolerance over the longest one.
constexpr double kFirst = 1.0 / 64;
constexpr double kShortest = 1.0 / 1024;
constexpr int kRejections = 8;
// Energy error allowed in one of the longest steps, as a fraction of the tolerance.
constexpr double kEnergyPart = 0.1;
constexpr double kSticking = 0.4;  // factor on the step length if sliding ends within a step
constexpr double kSameStepTime = 1e-9;
// Joints count as closed below this fraction of a length scale.
constexpr double kClosedGap = 1e-10;

// Rounding of an energy difference, over its change by the last digit of all positions. The weights
// of extrapolation rows add up to a hundred and more.
constexpr double kRoundings = 200;
// If rounding keeps errors above the tolerance, the tolerance rises by kSlackStep per attempt, up
// to kRounding times the weights. It falls again after a step with an error below kEasy of the
// allowed one.
constexpr double kSlackStep = 10;
constexpr double kRounding = 1e-6;
constexpr double kEasy = 0.05;

/// Cost of a step with this many rows, in Euler steps. Closing costs about one.
double costOf(int rows) {
  return 1 + 0.5 * rows * (rows + 1);
}

/// The order to begin with, as in SEULEX.
int firstOrder(double tolerance) {
  return std::clamp(static_cast<int>(std::lround(1.5 - 0.6 * std::log10(tolerance))), kFewestRows,
                    kMaxRows - 1);
}

/// The weights of the rows `first` to `last` of the table. Rows count from 1.
// With n_j = j these are c_j = prod over i != j of j / (j - i). Their sum is 1; their absolute
// values add up to some 10 for 4 rows and to more than 1000 for 8, which bounds the useful number
// of rows.
std::vector<double> weights(int first, int last) {
  std::vector<double> result;
  for (int j = first; j <= last; ++j) {
    double weight = 1;
    for (int i = first; i <= last; ++i) {
      if (i != j) weight *= static_cast<double>(j) / (j - i);
    }
    result.push_back(weight);
  }
  return result;
}

// Linear momentum sum m v (N s), and angular momentum about the origin, sum m x cross v + R I R^T w
// (N m s).
Momentum momentumOf(const std::vector<brick::Brick>& bricks, const Motion& motion) {
  Momentum sum;
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    const auto& [position, rotation] = motion.poses[i];
    const auto& [linear, angular] = motion.velocities[i];
    sum.linear += bricks[i].mass * linear;
    sum.angular += bricks[i].mass * position.cross(linear) +
                   rotation * (bricks[i].inertia * (rotation.conjugate() * angular));
  }
  return sum;
}

}  // namespace

/// A trial step: its rows and the errors of its orders.
struct Extrapolation::Trial {
  /// One crossing of the step in several Euler steps.
  struct Crossing {
    Motion end;
    std::vector<Vector3> turns;  // of the bricks from the step's start, rotation vectors
    LoadGain given;              // work and impulse of the loads
    double damped = 0;           // energy that dampers took, joules
    double impacted = 0;         // the same for contacts, joules
    std::vector<double> forces;  // of contacts in the last Euler step, JointSolver::heldForces()
  };

  const Motion& start;
  double length;  // seconds
  double energy;  // at the start, joules
  double off;     // error of positions and speeds with the rows so far, in tolerances
  std::vector<Crossing> rows;
  Motion end;  // extrapolated from all rows; finally with closed joints
  // Indexed by order; the first two entries are unused.
  std::vector<double> errors = {0, 0};   // estimates, in tolerances
  std::vector<double> lengths = {0, 0};  // possible lengths of the next step, seconds
  std::vector<double> costs = {0, 0};    // Euler steps per second with these lengths

  int order() const { return static_cast<int>(rows.size()); }
};

Extrapolation::Extrapolation(const std::vector<brick::Brick>& bricks, JointSolver& solver,
                             const ExtrapolationSettings& settings)
    : bricks_(bricks),
      solver_(solver),
      settings_(settings),
      length_(kFirst * settings.longestStep),
      order_(firstOrder(settings.tolerance)) {}

/// Crosses the step again, with one more Euler step.
bool Extrapolation::addRow(Trial& trial, const TimedLoads& loads, StepReport& report) {
  const int count = trial.order() + 1;
  const double step = trial.length / count;
  Trial::Crossing row{.end = trial.start};
  for (int k = 0; k < count; ++k) {
    const LoadSource now = [&](const Poses& poses, std::vector<brick::Load>& out) {
      loads((k + 1) * step, poses, out);
    };
    StepReport taken = solver_.eulerStep(row.end, step, now, row.given);
    row.damped += std::exchange(taken.damped, 0);
    row.impacted += std::exchange(taken.impacted, 0);
    // A step without a solution rejects the trial, which counts that.
    const bool isSolved = std::exchange(taken.unconverged, 0) == 0;
    report += taken;
    if (!isSolved) return false;
  }
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    row.turns.push_back(turnBetween(trial.start.poses[i].rotation, row.end.poses[i].rotation));
  }
  row.forces = solver_.heldForces();
  trial.rows.push_back(std::move(row));
  return true;
}

/// The weighted sum of the rows `first` to `last`: the extrapolated end of the step.
Motion Extrapolation::combine(const Trial& trial, int first, int last) const {
  const std::vector<double> shares = weights(first, last);
  Motion sum = trial.start;
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    const Pose& start = trial.start.poses[i];
    Vector3 move = Vector3::Zero(), turn = Vector3::Zero();
    Velocity velocity;
    for (int j = first; j <= last; ++j) {
      const double share = shares[static_cast<std::size_t>(j - first)];
      const Trial::Crossing& row = trial.rows[static_cast<std::size_t>(j - 1)];
      move += share * (row.end.poses[i].position - start.position);
      // Rotation vectors from a common start can be added with weights; rotations cannot.
      turn += share * row.turns[i];
      velocity.linear += share * row.end.velocities[i].linear;
      velocity.angular += share * row.end.velocities[i].angular;
    }
    sum.poses[i] = displaced(start, move, turn);
    sum.velocities[i] = velocity;
  }
  return sum;
}

/// The largest position error of a brick at the step's end, or speed error times one further step.
double Extrapolation::difference(const Motion& a, const Motion& b, double seconds) const {
  const double scale = settings_.lengthScale;
  double largest = 0;
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    const double place = (a.poses[i].position - b.poses[i].position).norm() +
                         scale * turnBetween(a.poses[i].rotation, b.poses[i].rotation).norm();
    const double speed = (a.velocities[i].linear - b.velocities[i].linear).norm() +
                         scale * (a.velocities[i].angular - b.velocities[i].angular).norm();
    const double off = place + seconds * speed;
    if (!(off <= largest)) largest = off;  // also if NaN
  }
  return largest;
}

/// The change of energy that a step of this length may have by its tolerance, joules.
double Extrapolation::allowedEnergy(const Trial& trial, double most) const {
  return kEnergyPart * trial.length / settings_.longestStep * tolerance() * most;
}

/// The rounding of a motion's energy, joules: its change by the last digits of positions and
/// rotations. The energy of stiff springs loses digits in the difference of positions.
double Extrapolation::roundingOf(const Motion& motion, double energy) const {
  // Several last digits, because a pose rounds a single one.
  constexpr double kDigits = 16;
  constexpr double kDigit = kDigits * std::numeric_limits<double>::epsilon();
  Motion moved = motion;
  Vector3 sign(1, -1, 1);
  for (Pose& pose : moved.poses) {
    const Vector3 digits = kDigit * (pose.position.cwiseAbs().array() + settings_.lengthScale);
    pose.position += digits.cwiseProduct(sign);
    pose.rotation = (rotationFromVector(kDigit * sign) * pose.rotation).normalized();
    // Neighbours move differently.
    sign = Vector3(-sign.z(), sign.x(), sign.y());
  }
  return kRoundings / kDigits * std::abs(solver_.energy(moved) - energy);
}

/// Change of energy that loads and dampers do not explain, over the allowed change in a step of
/// this length. Losses accumulate, because the Euler steps of all rows dissipate energy.
double Extrapolation::energyError(const Trial& trial) const {
  if (!settings_.keepsEnergy) return 0;
  const std::vector<double> shares = weights(1, trial.order());
  double desired = trial.energy;
  for (std::size_t j = 0; j < shares.size(); ++j) desired += shares[j] * trial.rows[j].given.work;
  const double energy = solver_.energy(trial.end);
  const double most = std::max({maxEnergy_, trial.energy, energy});
  const double allowed = std::max(allowedEnergy(trial, most), energyRounding_);
  return most > 0 ? std::abs(energy - desired) / allowed : 0;
}

/// Stores the error estimate of the latest row.
void Extrapolation::estimate(Trial& trial) const {
  const int order = trial.order();
  trial.end = combine(trial, 1, order);
  // The difference of the orders k and k - 1 is the error of the latter: H^(k) up to higher powers.
  trial.off = difference(trial.end, combine(trial, 2, order), trial.length) /
              (tolerance() * settings_.lengthScale);
  const double error = std::max(trial.off, energyError(trial));
  // The error of a step is proportional to H^order. The length with an error of kAim tolerances is
  // H (kAim / error)^(1/order).
  const double factor = kSafety * std::pow(kAim / std::max(error, 1e-12), 1.0 / order);
  const double bounded =
      std::isfinite(error) ? std::clamp(factor, kMinStepFactor, kMaxFactor) : kMinStepFactor;
  trial.errors.push_back(error);
  trial.lengths.push_back(bounded * trial.length);
  trial.costs.push_back(costOf(order) / std::min(trial.lengths.back(), settings_.longestStep));
}

/// Adds rows until the step keeps the tolerance. Returns false as soon as success is unlikely.
bool Extrapolation::tryOrders(Trial& trial, const TimedLoads& loads, StepReport& report) {
  for (int order = 1; order <= order_ + 1; ++order) {
    if (!addRow(trial, loads, report)) return false;
    if (order < kFewestRows) continue;
    estimate(trial);
    const double error = trial.errors.back();
    if (!std::isfinite(error)) return false;
    if (order < order_ - 1) continue;
    if (error <= 1) return true;
    // Largest possible reduction by further rows; the energy error may fall much more.
    const double gain = order < order_ ? order_ * (order_ + 1.0) : order_ + 1.0;
    if (trial.off > gain) return false;
  }
  return false;
}

/// Closes the joints at the step's end, and corrects the total momentum. Returns whether they
/// closed.
bool Extrapolation::finish(Trial& trial) {
  if (!(solver_.project(trial.end) <= kClosedGap * settings_.lengthScale)) return false;
  if (!isSupported_) keepMomentum(trial, trial.end);
  return true;
}

/// Adds a rigid motion of the whole, which joints allow. Total momentum then equals that of the
/// start plus the impulse of the loads. Rows with open joints conserve it only to their order.
void Extrapolation::keepMomentum(const Trial& trial, Motion& motion) const {
  const std::vector<double> shares = weights(1, trial.order());
  Momentum desired = momentumOf(bricks_, trial.start);
  for (std::size_t j = 0; j < shares.size(); ++j) {
    desired.linear += shares[j] * trial.rows[j].given.momentum.linear;
    desired.angular += shares[j] * trial.rows[j].given.momentum.angular;
  }
  double mass = 0;
  Vector3 centre = Vector3::Zero();
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    mass += bricks_[i].mass;
    centre += bricks_[i].mass * motion.poses[i].position;
  }
  centre /= mass;
  Matrix3 inertia = Matrix3::Zero();
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    const Matrix3 turn = motion.poses[i].rotation.toRotationMatrix();
    const Matrix3 arm = crossMatrix(motion.poses[i].position - centre);
    inertia += turn * bricks_[i].inertia * turn.transpose() - bricks_[i].mass * arm * arm;
  }
  const Momentum have = momentumOf(bricks_, motion);
  const Vector3 push = desired.linear - have.linear;
  const Vector3 shift = push / mass;
  // The remaining angular momentum, after the push has changed it about the origin, divided by the
  // inertia of the whole about its centre of mass.
  const Vector3 spin = inertia.llt().solve(desired.angular - have.angular - centre.cross(push));
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    motion.velocities[i].linear += shift + spin.cross(motion.poses[i].position - centre);
    motion.velocities[i].angular += spin;
  }
}

/// Gives contacts the extrapolated forces at the step's end. Those of a row are means over its last
/// Euler step. The first row is left out: the velocities at both of its ends fit the contacts at
/// its start, so its forces turn no velocity. If rows differ in their points of friction, the
/// forces of the last one remain.
void Extrapolation::keepForces(const Trial& trial) const {
  const std::vector<double> shares = weights(2, trial.order());
  std::vector<double> sum(trial.rows.back().forces.size(), 0.0);
  for (std::size_t j = 0; j < shares.size(); ++j) {
    const std::vector<double>& forces = trial.rows[j + 1].forces;
    if (forces.size() != sum.size()) return;
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += shares[j] * forces[k];
  }
  solver_.setHeldForces(sum);
}

/// Adds the step's losses to dampers and contacts, extrapolated like its end.
void Extrapolation::countLosses(const Trial& trial, StepReport& report) const {
  const std::vector<double> shares = weights(1, trial.order());
  for (std::size_t j = 0; j < shares.size(); ++j) {
    report.damped += shares[j] * trial.rows[j].damped;
    report.impacted += shares[j] * trial.rows[j].impacted;
  }
}

/// Adds the errors that rounding allowed this step beyond the tolerance.
void Extrapolation::countRounding(const Trial& trial, StepReport& report) const {
  report.rounding += (slack_ - 1) * settings_.tolerance * settings_.lengthScale;
  const double allowed = allowedEnergy(trial, maxEnergy_);
  report.energyRounding += std::max(allowed, energyRounding_) - allowed / slack_;
}

/// Error of points that slide at the step's start and stick at its end, in tolerances: half the
/// distance at their initial speed. Rows that are too coarse cannot estimate it, because all of
/// them stick immediately.
double Extrapolation::stickingError(const Trial& trial) const {
  return 0.5 * trial.length * solver_.stickSlipSpeed(trial.start) /
         (tolerance() * settings_.lengthScale);
}

/// Sets order and length of the step after an accepted step.
void Extrapolation::chooseNext(const Trial& trial, bool wasRejected) {
  const auto cost = [&](int order) { return trial.costs[static_cast<std::size_t>(order)]; };
  const int taken = trial.order();
  int best = taken;
  if (taken > kFewestRows && cost(taken - 1) < kFewer * cost(taken)) {
    best = taken - 1;
  } else if (taken <= order_ && (taken == kFewestRows || cost(taken) < kMore * cost(taken - 1))) {
    best = taken + 1;
  }
  if (wasRejected) best = std::min(best, taken);
  best = std::clamp(best, kFewestRows, kMaxRows - 1);
  double length = best <= taken ? trial.lengths[static_cast<std::size_t>(best)]
                                : trial.lengths.back() * costOf(best) / costOf(taken);
  if (wasRejected) length = std::min(length, trial.length);
  length_ = std::min(length, settings_.longestStep);
  order_ = best;
}

/// Sets order and length after a rejected step.
void Extrapolation::chooseAgain(const Trial& trial) {
  if (trial.errors.size() <= 2) {
    length_ = kMinStepFactor * trial.length;
    return;
  }
  int best = std::min(trial.order(), order_);
  const auto cost = [&](int order) { return trial.costs[static_cast<std::size_t>(order)]; };
  if (best > kFewestRows && cost(best - 1) < kMore * cost(best)) --best;
  length_ = std::min(trial.lengths[static_cast<std::size_t>(best)], 0.9 * trial.length);
  order_ = std::max(best, kFewestRows);
}

/// Tries steps of falling length until one keeps the tolerance. `energy`: of the motion.
Extrapolation::StepSearch Extrapolation::tryLengths(Motion& motion, double energy, double seconds,
                                                    const TimedLoads& loads,
                                                    const StepFilter& mayTake, StepReport& report) {
  bool isRefused = false;
  for (int tries = 0; tries < kRejections; ++tries) {
    const double parts =
        std::ceil(seconds / std::min(length_, settings_.longestStep) - kSameStepTime);
    Trial trial{motion, seconds / std::max(1.0, parts), energy, 0, {}, {}};
    const bool isSmooth = tryOrders(trial, loads, report);
    const double sticking = isSmooth ? stickingError(trial) : 0;
    if (isSmooth && sticking <= 1) {
      isRefused = !finish(trial);
      if (isRefused) break;
      if (mayTake && !mayTake(trial.start, trial.end, trial.length)) return {.isRefused = true};
      chooseNext(trial, tries > 0);
      keepForces(trial);
      countLosses(trial, report);
      countRounding(trial, report);
      if (trial.errors.back() < kEasy) slack_ = std::max(1.0, slack_ / kSlackStep);
      motion = std::move(trial.end);
      return {.taken = trial.length};
    }
    ++report.rejected;
    if (isSmooth) {
      length_ = kSticking * trial.length;
    } else {
      chooseAgain(trial);
    }
    if (length_ < std::min(kShortest, settings_.tolerance) * settings_.longestStep) break;
  }
  length_ = kFirst * settings_.longestStep;
  return {.isRefused = isRefused};
}

std::optional<double> Extrapolation::step(Motion& motion, double seconds, const TimedLoads& loads,
                                          const StepFilter& mayTake, StepReport& report) {
  double energy = 0;
  if (settings_.keepsEnergy) {
    // Joints may not allow the velocities after steps of first order. The first Euler step projects
    // them. The energy lost in this is not an error of the step.
    Motion allowed = motion;
    solver_.collide(allowed);
    energy = solver_.energy(allowed);
    maxEnergy_ = std::max(maxEnergy_, energy);
    energyRounding_ = std::max(energyRounding_, roundingOf(allowed, energy));
  }
  while (true) {
    const StepSearch search = tryLengths(motion, energy, seconds, loads, mayTake, report);
    if (search.taken || search.isRefused) return search.taken;
    const double most = kRounding / settings_.tolerance;
    if (slack_ >= most) return std::nullopt;
    slack_ = std::min(kSlackStep * slack_, most);
    order_ = firstOrder(tolerance());
  }
}

namespace {

/// The two known states before and after a time within a step.
struct StatesAround {
  const Motion& before;
  const Motion& after;
  double seconds;  // between them
  double share;    // share of this interval, [0, 1]
};

StatesAround statesAround(const Motion& from, std::span<const PassedState> passed, const Motion& to,
                          double length, double seconds) {
  const auto isLater = [&](const PassedState& state) { return state.seconds > seconds; };
  const auto next = std::ranges::find_if(passed, isLater);
  const PassedState* before = next == passed.begin() ? nullptr : &*std::prev(next);
  const PassedState* after = next == passed.end() ? nullptr : &*next;
  const double begin = before ? before->seconds : 0;
  const double end = after ? after->seconds : length;
  return {before ? before->motion : from, after ? after->motion : to, end - begin,
          (seconds - begin) / (end - begin)};
}

}  // namespace

Poses posesBetween(const Motion& from, std::span<const PassedState> passed, const Motion& to,
                   double length, double seconds) {
  const StatesAround around = statesAround(from, passed, to, length, seconds);
  return interpolate(around.before, around.after, around.seconds, around.share);
}

std::vector<Velocity> velocitiesBetween(const Motion& from, std::span<const PassedState> passed,
                                        const Motion& to, double length, double seconds) {
  const StatesAround around = statesAround(from, passed, to, length, seconds);
  std::vector<Velocity> velocities = around.before.velocities;
  for (std::size_t i = 0; i < velocities.size(); ++i) {
    const Velocity& after = around.after.velocities[i];
    velocities[i].linear += around.share * (after.linear - velocities[i].linear);
    velocities[i].angular += around.share * (after.angular - velocities[i].angular);
  }
  return velocities;
}

}  // namespace kirireel::mechanics
