#include "sim/joints/joint_solver.h"

#include <algorithm>
#include <cmath>

#include "sim/joints/step_system.h"

namespace kirireel {
namespace {

// All lengths are in length scales, all speeds in length scales a second.
constexpr double kGapTolerance = 1e-12;    // closing aims at this
constexpr double kGapAccepted = 1e-10;     // and a step is good below this
constexpr double kSpeedTolerance = 1e-10;  // of joint rows, relative to the fastest brick
constexpr double kJumpShare = 0.3;         // closing may move this part of what the step moved
constexpr double kJumpFloor = 1e-9;
constexpr int kHalvings = 8;
constexpr int kMultiplierRounds = 6;
constexpr int kNewtonRounds = 40;
constexpr int kClosingRounds = 12;
constexpr int kContactRounds = 25;
constexpr int kAssemblyRounds = 100;

template <int D>
class Stepper : public JointSolver {
 public:
  Stepper(const std::vector<Brick>& bricks, std::span<const Pivot> pivots,
          const JointSolverSettings& settings)
      : bricks_(bricks),
        settings_(settings),
        system_(bricks, pivots),
        loads_(bricks.size()),
        u_(Vector::Zero(D * bricks.size())),
        jointMultipliers_(Vector::Zero(system_.jointRowCount())) {}

  StepReport advance(Motion& motion, double step, const LoadSource& loads,
                     ContactSource* contacts) override;
  double assemble(Poses& poses) override;

 private:
  using Space = Coordinates<D>;
  using Vector = Eigen::VectorXd;
  using Row = ContactRow<D>;

  void advanceHalving(Motion& motion, double step, int level);
  bool tryStep(const Motion& start, double step);
  bool solveContactRounds(const Motion& start, double step);
  void startRows(const Motion& start, double step);
  void addSupports(const Poses& poses, double step);
  bool solveVelocities();
  bool minimize();
  Vector gradient(const Vector& u) const;
  bool setContactStates(const Vector& u);
  double lineSearch(const Vector& du, const Vector& slope) const;
  double updateMultipliers();
  bool closeJoints(double step);
  Vector closingMove() const;
  double largestGap() const;
  double norm(const Vector& move) const;
  void finishStep(Motion& motion) const;
  void keepMultipliers();

  const std::vector<Brick>& bricks_;
  JointSolverSettings settings_;
  StepSystem<D> system_;
  const LoadSource* loadSource_ = nullptr;
  ContactSource* contactSource_ = nullptr;
  StepReport report_;

  // The step in work.
  std::vector<Load> loads_;
  Vector u_;
  Vector jointMultipliers_;  // warm from step to step
  Poses poses_;
  std::vector<Row> rows_;
  std::vector<Row> kept_;      // rows that carried load at the end of the last step
  std::vector<Row> supports_;  // likewise
};

template <int D>
StepReport Stepper<D>::advance(Motion& motion, double step, const LoadSource& loads,
                               ContactSource* contacts) {
  loadSource_ = &loads;
  contactSource_ = contacts;
  report_ = {};
  const int before = system_.factorizations();
  advanceHalving(motion, step, 0);
  report_.factorizations = system_.factorizations() - before;
  return report_;
}

template <int D>
void Stepper<D>::advanceHalving(Motion& motion, double step, int level) {
  const bool good = tryStep(motion, step);
  if (!good && level < kHalvings) {
    ++report_.halved;
    advanceHalving(motion, 0.5 * step, level + 1);
    advanceHalving(motion, 0.5 * step, level + 1);
    return;
  }
  ++report_.steps;
  if (!good) ++report_.unconverged;
  keepMultipliers();
  finishStep(motion);
}

template <int D>
bool Stepper<D>::tryStep(const Motion& start, double step) {
  (*loadSource_)(start.poses, loads_);
  system_.setStep(start, loads_, step);
  system_.placeJoints(start.poses);
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    u_.segment<D>(D * i) = Space::pack(start.velocities[i]);
  }
  startRows(start, step);
  return solveContactRounds(start, step);
}

/// Solves the step, looks what it runs into, and solves again with that until nothing is new.
template <int D>
bool Stepper<D>::solveContactRounds(const Motion& start, double step) {
  for (int round = 0; round < kContactRounds; ++round) {
    const bool solved = solveVelocities();
    poses_ = start.poses;
    for (std::size_t i = 0; i < bricks_.size(); ++i) {
      Space::displace(poses_[i], step * u_.segment<D>(D * i));
    }
    const bool closed = closeJoints(step);
    if (!solved || !closed) return false;
    if (!contactSource_) return true;
    std::vector<Contact> found;
    if (!contactSource_->appendViolated(start.poses, poses_, found)) return true;
    for (const Contact& contact : found) {
      rows_.push_back(makeContactRow<D>(contact, start.poses, step));
    }
    system_.placeJoints(start.poses);
  }
  return false;
}

template <int D>
void Stepper<D>::startRows(const Motion& start, double step) {
  rows_.clear();
  addSupports(start.poses, step);
  if (!contactSource_) return;
  for (const Row& old : kept_) {
    if (!contactSource_->isCurrent(start.poses, old.contact)) continue;
    Row row = makeContactRow<D>(old.contact, start.poses, step);
    row.multiplier = old.multiplier;
    row.slipMultiplier = old.slipMultiplier;
    row.slipBound = old.contact.friction * old.multiplier;
    rows_.push_back(row);
  }
}

template <int D>
void Stepper<D>::addSupports(const Poses& poses, double step) {
  for (std::size_t s = 0; s < settings_.supports.size(); ++s) {
    const Support& support = settings_.supports[s];
    Row row;
    row.contact = {support.brick, kFixed, support.point, Vector3::Zero(), Vector3::UnitZ(), 0};
    row.hasNormal = false;
    row.slipBound = support.largestForce * step;
    if (s < supports_.size()) row.slipMultiplier = supports_[s].slipMultiplier;
    placeRow(row, poses);
    rows_.push_back(row);
  }
}

/// Minimises 1/2 u^T A u - f^T u under joints and contacts, by the method of multipliers.
template <int D>
bool Stepper<D>::solveVelocities() {
  for (Row& row : rows_) row.active = false;
  setContactStates(u_);
  if (!system_.factor(rows_)) return false;
  for (int round = 0; round < kMultiplierRounds; ++round) {
    if (!minimize()) return false;
    const double violation = updateMultipliers();
    const double speed =
        std::max(u_.template lpNorm<Eigen::Infinity>(), 1e-3 * settings_.lengthScale);
    if (violation <= kSpeedTolerance * speed) return true;
  }
  return true;  // judged by the gap after closing
}

/// Semismooth Newton on the augmented Lagrangian for fixed multipliers.
template <int D>
bool Stepper<D>::minimize() {
  bool wholeStep = false;
  for (int round = 0; round < kNewtonRounds; ++round) {
    const bool changed = setContactStates(u_);
    // While no contact changes state the function is quadratic and a whole step is its minimum.
    if (wholeStep && !changed) return true;
    if (changed && !system_.factor(rows_)) return false;
    const Vector slope = gradient(u_);
    Vector du = -slope;
    system_.solveInPlace(du);
    const double length = rows_.empty() ? 1.0 : lineSearch(du, slope);
    u_ += length * du;
    wholeStep = length == 1.0;
    if (rows_.empty()) return true;
    if (wholeStep && norm(du) <= kSpeedTolerance * (norm(u_) + settings_.lengthScale)) return true;
  }
  return false;
}

template <int D>
Eigen::VectorXd Stepper<D>::gradient(const Vector& u) const {
  Vector result = system_.unbalance(u);
  const Vector impulse = jointMultipliers_ - system_.kappa() * system_.jointVelocity(u);
  system_.addJointImpulse(-1.0, impulse, result);
  for (const Row& row : rows_) {
    const double normal = row.trialImpulse(u, system_.rho());
    if (normal > 0) row.addNormal(-normal, result);
    if (row.rubs()) row.addTangent(-row.trialSlipImpulse(u, system_.rho(), nullptr), result);
  }
  return result;
}

/// Sets which contacts push and how they slip at u. Returns whether any state changed.
template <int D>
bool Stepper<D>::setContactStates(const Vector& u) {
  bool changed = false;
  for (Row& row : rows_) {
    const bool active = row.trialImpulse(u, system_.rho()) > 0;
    changed = changed || active != row.active;
    row.active = active;
    if (!row.rubs()) continue;
    typename Row::TangentMatrix stiffness;
    row.trialSlipImpulse(u, system_.rho(), &stiffness);
    changed = changed || stiffness != row.slipStiffness;
    row.slipStiffness = stiffness;
  }
  return changed;
}

/// A step length at which the convex function no longer falls steeply along du: the whole step, or
/// where its slope changes sign.
template <int D>
double Stepper<D>::lineSearch(const Vector& du, const Vector& slope) const {
  const double first = slope.dot(du);
  double low = 0;
  double high = 1;
  double length = 1;
  for (int round = 0; round < 30; ++round) {
    const double here = gradient(u_ + length * du).dot(du);
    if (here <= -0.1 * first) {  // first is negative: not yet clearly uphill
      if (length == 1.0 || here >= 0.5 * first) return length;
      low = length;
    } else {
      high = length;
    }
    length = 0.5 * (low + high);
  }
  return length;
}

/// Moves the multipliers; returns the largest violation of a row, m/s.
template <int D>
double Stepper<D>::updateMultipliers() {
  double violation = 0;
  if (system_.hasJoints()) {
    const Vector velocity = system_.jointVelocity(u_);
    jointMultipliers_ -= system_.kappa() * velocity;
    violation = velocity.template lpNorm<Eigen::Infinity>();
  }
  for (Row& row : rows_) {
    const double multiplier = row.trialImpulse(u_, system_.rho());
    violation = std::max(violation, std::abs(multiplier - row.multiplier) / system_.rho());
    row.multiplier = multiplier;
    if (row.rubs()) row.slipMultiplier = row.trialSlipImpulse(u_, system_.rho(), nullptr);
  }
  return violation;
}

/// Gauss-Newton on the joints' gaps and on the contacts that push, on the factor at hand. Returns
/// whether the step stayed on its branch and closed.
template <int D>
bool Stepper<D>::closeJoints(double step) {
  const double scale = settings_.lengthScale;
  double gap = largestGap();
  double moved = 0;
  bool refactored = false;
  for (int round = 0; round < kClosingRounds && gap > kGapTolerance * scale; ++round) {
    const Vector move = closingMove();
    for (std::size_t i = 0; i < bricks_.size(); ++i) {
      Space::displace(poses_[i], move.segment<D>(D * i));
    }
    moved += norm(move);
    const double before = gap;
    gap = largestGap();
    if (!std::isfinite(gap)) return false;
    if (gap <= 0.1 * before) continue;
    if (gap < 0.1 * kGapAccepted * scale && refactored) break;
    system_.placeJoints(poses_);
    if (!system_.factor(rows_)) return false;
    refactored = true;
  }
  return gap <= kGapAccepted * scale && moved <= kJumpShare * step * norm(u_) + kJumpFloor * scale;
}

template <int D>
Eigen::VectorXd Stepper<D>::closingMove() const {
  Vector move = Vector::Zero(u_.size());
  system_.addJointImpulse(-system_.kappa(), system_.jointGaps(poses_), move);
  for (const Row& row : rows_) {
    if (!row.active) continue;
    row.addNormal(-system_.rho() * (contactGap(row.contact, poses_) - row.aim), move);
  }
  system_.solveInPlace(move);
  return move;
}

/// The largest gap of a joint, or overlap beyond the aim of a contact that pushes.
template <int D>
double Stepper<D>::largestGap() const {
  double gap =
      system_.hasJoints() ? system_.jointGaps(poses_).template lpNorm<Eigen::Infinity>() : 0;
  for (const Row& row : rows_) {
    if (row.active) gap = std::max(gap, row.aim - contactGap(row.contact, poses_));
  }
  return gap;
}

/// Length of a move of all bricks, turns counted at one length scale from the centre.
template <int D>
double Stepper<D>::norm(const Vector& move) const {
  double sum = 0;
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    const Velocity part = Space::unpack(move.segment<D>(D * i));
    sum += part.linear.squaredNorm() +
           settings_.lengthScale * settings_.lengthScale * part.angular.squaredNorm();
  }
  return std::sqrt(sum);
}

template <int D>
void Stepper<D>::keepMultipliers() {
  kept_.clear();
  supports_.clear();
  for (const Row& row : rows_) {
    if (!row.hasNormal) {
      supports_.push_back(row);
    } else if (row.multiplier > 0) {
      kept_.push_back(row);
    }
  }
}

/// Writes the new state; angular momentum, not angular velocity, is carried across the turn.
template <int D>
void Stepper<D>::finishStep(Motion& motion) const {
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    Velocity velocity = Space::unpack(u_.segment<D>(D * i));
    if constexpr (D == 6) {
      const Quaternion& before = motion.poses[i].rotation;
      const Quaternion& after = poses_[i].rotation;
      const Vector3 momentum = bricks_[i].inertia * (before.conjugate() * velocity.angular);
      const Vector3 turned = after.conjugate() * (before * momentum);
      velocity.angular = after * bricks_[i].inertia.llt().solve(turned);
    }
    motion.velocities[i] = velocity;
  }
  motion.poses = poses_;
}

template <int D>
double Stepper<D>::assemble(Poses& poses) {
  rows_.clear();
  poses_ = poses;
  double gap = largestGap();
  for (int round = 0; round < kAssemblyRounds && gap > kGapTolerance * settings_.lengthScale;
       ++round) {
    system_.setMasses(poses_);
    system_.placeJoints(poses_);
    if (!system_.factor(rows_)) break;
    const Vector move = closingMove();
    for (std::size_t i = 0; i < bricks_.size(); ++i) {
      Space::displace(poses_[i], move.segment<D>(D * i));
    }
    const double before = gap;
    gap = largestGap();
    if (gap > 0.9 * before && gap < kGapAccepted * settings_.lengthScale) break;
  }
  poses = poses_;
  return gap;
}

}  // namespace

StepReport& StepReport::operator+=(const StepReport& other) {
  steps += other.steps;
  halved += other.halved;
  unconverged += other.unconverged;
  factorizations += other.factorizations;
  return *this;
}

std::unique_ptr<JointSolver> makeJointSolver(const std::vector<Brick>& bricks,
                                             std::span<const Pivot> pivots,
                                             const JointSolverSettings& settings) {
  if (settings.planar) return std::make_unique<Stepper<3>>(bricks, pivots, settings);
  return std::make_unique<Stepper<6>>(bricks, pivots, settings);
}

}  // namespace kirireel
