// Forces of joints in one state.
//
// With exact joints the accelerations a of the bricks and the forces l of the joints satisfy
//   M a = F + J^T l,   J a = b,
// with F the applied forces minus w x I w of rotating bricks, and b = -(dJ/dt) u. The accelerations
// are unique. The method of multipliers computes them with the factor of H = M + kappa J^T J. The
// forces are not unique if joints are redundant: all l + s with J^T s = 0, the states of
// self-stress, are in equilibrium too. The forces of least norm lie in the range of J, l = J w,
// with
//   J^T J w = r,   r = M a - F.
// They are the limit of the forces of equally stiff joints, each with a gap of J w / stiffness. J^T
// J is singular if the bricks can move, in directions that do not change J w. Iterated Tikhonov
// regularisation with the same factor,
//   w += kappa H^-1 (r - J^T J w),
// multiplies the error in each round by 1 / (1 + kappa s^2) for each singular value s of J M^-1/2.
//
// Which joints belong to a state of self-stress: with J^T J w = J^T z, s = z - J w is the
// projection of z onto all such states. For a random z, a row of s is zero, with probability one,
// only if it is zero in every state of self-stress. The projector I - J J^+ then has a zero on its
// diagonal.
//
// Pellegrino and Calladine 1986, "Matrix analysis of statically and kinematically indeterminate
// frameworks", Int. J. Solids Structures 22, 409-428; Hanke and Groetsch 1998, "Nonstationary
// iterated Tikhonov regularization", J. Optim. Theory Appl. 98, 37-53.
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "sim/mechanics/joint_solver.h"
#include "sim/mechanics/step_system.h"

namespace kirireel::mechanics {
namespace {

constexpr int kAccelerationRounds = 6;
constexpr int kForceRounds = 12;
constexpr double kForceRounding = 1e-14;  // error of forces, relative to the largest
// A round that reduces the residual by less than this factor is the last.
constexpr double kWorthwhileRound = 0.5;
// Number of random states. A second one covers joints that the first misses by chance.
constexpr int kProbes = 2;
// Joints in self-stress exceed this in a random state with entries in [-1, 1].
constexpr double kTakesPart = 1e-6;

/// Centripetal acceleration of an arm's end, which the joints must balance: w x (w x r).
Vector3 centripetal(const Velocity& velocity, const Vector3& arm) {
  return velocity.angular.cross(velocity.angular.cross(arm));
}

/// The reactions with D degrees of freedom per brick.
template <int D>
class Reactor final : public ReactionSolver {
 public:
  Reactor(const std::vector<brick::Brick>& bricks, std::span<const brick::Pivot> pivots,
          double lengthScale)
      : bricks_(bricks), pivots_(pivots), system_(bricks, pivots, lengthScale) {
    for (std::size_t p = 0; p < pivots.size(); ++p) {
      if (D == 6 || !pivots[p].isUpper) solved_.push_back(p);
    }
  }

  // Forces of joints and pins in one state. With compliant joints they follow from the gaps, with
  // exact ones from the two solves above. The system is factored again, because it depends on the
  // state.
  Reactions solve(const Motion& motion, std::span<const Vector6> applied,
                  const std::vector<bool>& pinned, double jointStiffness) override {
    motion_ = motion;
    pinned_ = pinned;
    for (std::size_t i = 0; i < bricks_.size(); ++i) {
      if (pinned_[i]) motion_.velocities[i] = {};
    }
    system_.setPinned(pinned);
    system_.setMasses(motion_.poses);
    system_.placeJoints(motion_.poses);
    Reactions result;
    result.pivotForces.assign(pivots_.size(), Vector3::Zero());
    if (!solved_.empty()) {
      const Vector forces = std::isfinite(jointStiffness)
                                ? Vector(-jointStiffness * system_.jointGaps(motion_.poses))
                                : exactForces(applied, result.imbalance);
      for (std::size_t k = 0; k < solved_.size(); ++k) {
        result.pivotForces[solved_[k]] = inSpace(forces, k);
      }
    }
    result.pinForces = pinForces(applied, result.pivotForces);
    return result;
  }

  // Two random states: a joint cannot be missed in both by chance.
  std::vector<bool> indeterminateJoints(std::size_t joints) override {
    std::vector<bool> found(joints, false);
    if (solved_.empty()) return found;
    std::mt19937 numbers;  // same seed in each state
    for (int probe = 0; probe < kProbes; ++probe) {
      const Vector stress = selfStress(numbers);
      std::vector<Vector3> sums(joints, Vector3::Zero());
      for (std::size_t k = 0; k < solved_.size(); ++k) {
        sums[static_cast<std::size_t>(pivots_[solved_[k]].joint)] += inSpace(stress, k);
      }
      for (std::size_t j = 0; j < joints; ++j) {
        if (sums[j].norm() > kTakesPart) found[j] = true;
      }
    }
    return found;
  }

 private:
  using Space = Coordinates<D>;
  using Vector = Eigen::VectorXd;
  static constexpr int kRows = Space::kJointRows;

  const brick::Pivot& pivot(std::size_t k) const { return pivots_[solved_[k]]; }

  // From the pivot's point of B to that of A, world axes, metres.
  Vector3 between(const brick::Pivot& pivot) const {
    return motion_.poses[pivot.brickA].apply(pivot.pointA) -
           motion_.poses[pivot.brickB].apply(pivot.pointB);
  }

  /// The part of pivot k in the values of all joint rows.
  Vector3 inSpace(const Vector& values, std::size_t k) const {
    const brick::PivotRows rows = brick::pivotRows(pivot(k), between(pivot(k)));
    Vector3 vector = Vector3::Zero();
    for (int row = 0; row < pivot(k).rowCount(D == 3); ++row) {
      vector += values[kRows * static_cast<Eigen::Index>(k) + row] * rows.axes.row(row);
    }
    return vector;
  }

  /// b = -(dJ/dt) u of one pivot.
  Vector3 neededAcceleration(const brick::Pivot& pivot) const {
    const Pose &poseA = motion_.poses[pivot.brickA], &poseB = motion_.poses[pivot.brickB];
    const Velocity& velocityA = motion_.velocities[pivot.brickA];
    const Velocity& velocityB = motion_.velocities[pivot.brickB];
    const Vector3 armA = poseA.rotation * pivot.pointA, armB = poseB.rotation * pivot.pointB;
    const Vector3 apart = centripetal(velocityB, armB) - centripetal(velocityA, armA);
    if (pivot.joinsPoints()) return apart;
    // For the distance d of two points: d'' = along . p'' + |p' across|^2 / d.
    const Vector3 along = between(pivot).normalized();
    const Vector3 moves = velocityA.linear + velocityA.angular.cross(armA) - velocityB.linear -
                          velocityB.angular.cross(armB);
    const double across = moves.squaredNorm() - std::pow(along.dot(moves), 2);
    return Vector3::UnitX() * (along.dot(apart) - across / pivot.distance);
  }

  Vector neededAccelerations() const {
    Vector needed(system_.jointRowCount());
    for (std::size_t k = 0; k < solved_.size(); ++k) {
      needed.segment<kRows>(kRows * static_cast<Eigen::Index>(k)) =
          neededAcceleration(pivot(k)).template head<kRows>();
    }
    return needed;
  }

  /// F, with zeros for pinned bricks.
  Vector appliedForces(std::span<const Vector6> applied) const {
    Vector forces = Vector::Zero(D * static_cast<Eigen::Index>(bricks_.size()));
    for (std::size_t i = 0; i < bricks_.size(); ++i) {
      if (pinned_[i]) continue;
      const Matrix3 R = motion_.poses[i].rotation.toRotationMatrix();
      const Vector3& turning = motion_.velocities[i].angular;
      Vector6 force = applied[i];
      force.template tail<3>() -= turning.cross(R * bricks_[i].inertia * (R.transpose() * turning));
      forces.template segment<D>(D * static_cast<Eigen::Index>(i)) = Space::restrict(force);
    }
    return forces;
  }

  /// r = M a - F: the joint forces on all bricks.
  Vector jointLoad(const Vector& applied) const {
    const Vector needed = neededAccelerations();
    Vector acceleration = Vector::Zero(applied.size());
    Vector multipliers = Vector::Zero(system_.jointRowCount());
    for (int round = 0; round < kAccelerationRounds; ++round) {
      Vector change = applied - system_.timesA(acceleration);
      const Vector missing = needed - system_.jointVelocity(acceleration);
      system_.addJointImpulse(1, multipliers + system_.kappa() * missing, change);
      system_.solveInPlace(change);
      acceleration += change;
      multipliers += system_.kappa() * (missing - system_.jointVelocity(change));
    }
    Vector load = system_.timesA(acceleration) - applied;
    for (std::size_t i = 0; i < bricks_.size(); ++i) {
      if (pinned_[i]) load.template segment<D>(D * static_cast<Eigen::Index>(i)).setZero();
    }
    return load;
  }

  /// J w with J^T J w = load, as nearly as possible. `rest` receives the residual of the load.
  Vector leastForces(const Vector& load, Vector& rest) const {
    Vector w = Vector::Zero(load.size());
    Vector forces = Vector::Zero(system_.jointRowCount());
    rest = load;
    double before = std::numeric_limits<double>::infinity();
    for (int round = 0; round < kForceRounds; ++round) {
      const double size = rest.template lpNorm<Eigen::Infinity>();
      if (size <= kForceRounding * load.template lpNorm<Eigen::Infinity>()) break;
      if (size > kWorthwhileRound * before) break;
      before = size;
      Vector change = system_.kappa() * rest;
      system_.solveInPlace(change);
      w += change;
      forces = system_.jointVelocity(w);
      rest = load;
      system_.addJointImpulse(-1, forces, rest);
    }
    return forces;
  }

  // The forces of exact joints, one row per joint direction. `imbalance`: the largest residual
  // force of joints and applied forces on any brick, newtons. Infinity if H could not be factored.
  Vector exactForces(std::span<const Vector6> applied, double& imbalance) {
    if (!system_.factor({})) {
      imbalance = std::numeric_limits<double>::infinity();
      return Vector::Zero(system_.jointRowCount());
    }
    Vector rest;
    const Vector forces = leastForces(jointLoad(appliedForces(applied)), rest);
    imbalance = 0;
    for (Eigen::Index i = 0; i < rest.size(); ++i) {
      if (!Space::isTurn(static_cast<int>(i % D))) {
        imbalance = std::max(imbalance, std::abs(rest[i]));
      }
    }
    return forces;
  }

  /// A random state of self-stress.
  Vector selfStress(std::mt19937& numbers) const {
    Vector stress(system_.jointRowCount());
    for (double& entry : stress) entry = static_cast<double>(numbers()) / 2147483647.5 - 1;
    for (std::size_t k = 0; k < solved_.size(); ++k) {
      // Other rows than the pivot's are zero and carry no force.
      const int count = pivot(k).rowCount(D == 3);
      stress.segment(kRows * static_cast<Eigen::Index>(k) + count, kRows - count).setZero();
    }
    Vector load = Vector::Zero(D * static_cast<Eigen::Index>(bricks_.size()));
    system_.addJointImpulse(1, stress, load);
    Vector rest;
    return stress - leastForces(load, rest);
  }

  /// The residual forces on the pinned bricks, which the pins hold.
  std::vector<Vector6> pinForces(std::span<const Vector6> applied,
                                 const std::vector<Vector3>& pivotForces) const {
    std::vector<Vector6> forces(bricks_.size(), Vector6::Zero());
    for (std::size_t i = 0; i < bricks_.size(); ++i) {
      if (pinned_[i]) forces[i] = -applied[i];
    }
    const auto push = [&](int brick, const Vector3& point, const Vector3& force) {
      if (!pinned_[static_cast<std::size_t>(brick)]) return;
      Vector6& pin = forces[static_cast<std::size_t>(brick)];
      pin.template head<3>() -= force;
      pin.template tail<3>() -= (motion_.poses[brick].rotation * point).cross(force);
    };
    for (std::size_t p = 0; p < pivots_.size(); ++p) {
      push(pivots_[p].brickA, pivots_[p].pointA, pivotForces[p]);
      push(pivots_[p].brickB, pivots_[p].pointB, -pivotForces[p]);
    }
    if constexpr (D == 3) {  // the plane itself supports the residual
      for (Vector6& force : forces)
        force = (Vector6() << force.head<2>(), 0, 0, 0, force[5]).finished();
    }
    return forces;
  }

  const std::vector<brick::Brick>& bricks_;
  std::span<const brick::Pivot> pivots_;
  std::vector<std::size_t> solved_;  // pivots of the system
  StepSystem<D> system_;             // at the state of the last solve
  Motion motion_;
  std::vector<bool> pinned_;
};

}  // namespace

std::unique_ptr<ReactionSolver> makeReactionSolver(const std::vector<brick::Brick>& bricks,
                                                   std::span<const brick::Pivot> pivots,
                                                   bool planar, double lengthScale) {
  if (planar) return std::make_unique<Reactor<3>>(bricks, pivots, lengthScale);
  return std::make_unique<Reactor<6>>(bricks, pivots, lengthScale);
}

}  // namespace kirireel::mechanics
