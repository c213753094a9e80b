// Springs to a target, with the derivatives that an implicit step needs.
//
// With p_k the bottom vertices and t_k their targets in world axes, primes for differences from
// their means, n vertices, s the arm from the centre of mass x to the mean of the p_k, and g = mean
// t - x - s:
//   F = k_f n g                                          N
//   T = k_tau sum p'_k x t'_k + s x F                    N m about x
// Both follow from the energy E = k_f n |g|^2 / 2 + k_tau / 2 sum |p'_k - t'_k|^2. A turn dtheta
// moves p'_k by dtheta x p'_k; the second derivative of -sum p'_k . t'_k by dtheta is tr(C) 1 - (C
// + C^T) / 2 with C = sum p'_k t'_k^T, and the arm s, pulled by F, contributes in the same way with
// C = k_f n s g^T. The stiffness by (dx, dtheta) is then
//   [ k_f n 1        -k_f n [s]x                      ]
//   [ k_f n [s]x      k_f n [s]x^T [s]x + tr(C) 1 - sym(C) ]
// The last term becomes indefinite where a tile is turned by more than 90 degrees from its target,
// so that only its positive semidefinite part is kept (the eigenvalues below 0 are set to 0). With
// it no step length diverges; the force itself is exact.
//
// Jiang and Choi's PyKirigami holds the same forces constant over a step, which needs many short
// steps when k is large.
#include "sim/actuation/target_springs.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

namespace kirireel {
namespace {

// The paper's 60 steps of 1/240 s, as a time, so that the length of steps does not matter.
constexpr double kStallTime = 60.0 / 240.0;  // seconds without improvement
constexpr double kSameTime = 1e-9;           // seconds
constexpr double kLargestFactor = 16;        // of the stiffness
constexpr double kImprovement = 1 - 0.005;   // of the error, to count as one

bool isPositiveDefinite(const Matrix3& K) {
  // Sylvester's criterion: the leading minors are positive. It spares most steps the eigenvalues.
  return K(0, 0) > 0 && K(0, 0) * K(1, 1) - K(0, 1) * K(0, 1) > 0 && K.determinant() > 0;
}

/// The nearest positive semidefinite matrix; springs far from their target lose the part that would
/// drive an implicit step away from it.
Matrix3 positivePart(const Matrix3& K) {
  if (isPositiveDefinite(K)) return K;
  const Eigen::SelfAdjointEigenSolver<Matrix3> solver(K);
  return solver.eigenvectors() * solver.eigenvalues().cwiseMax(0.0).asDiagonal() *
         solver.eigenvectors().transpose();
}

/// Minus the second derivative of sum_k p_k . t_k by a rotation of the p_k: tr(C) 1 - sym(C) for
/// C = sum_k p_k t_k^T.
Matrix3 rotationalStiffness(const Matrix3& C) {
  return C.trace() * Matrix3::Identity() - 0.5 * (C + C.transpose());
}

/// sum_k p_k x t_k for C = sum_k p_k t_k^T.
Vector3 crossSum(const Matrix3& C) {
  return {C(1, 2) - C(2, 1), C(2, 0) - C(0, 2), C(0, 1) - C(1, 0)};
}

}  // namespace

TargetSprings::TargetSprings(const std::vector<Brick>& bricks, const std::vector<Tile>& target,
                             const std::optional<std::vector<int>>& pulled,
                             const TargetSpringSettings& settings)
    : bricks_(bricks), springs_(bricks.size()), settings_(settings) {
  setTarget(target);
  if (!pulled) return;
  for (Spring& spring : springs_) spring.pulled = false;
  for (const int brick : *pulled) springs_[brick].pulled = true;
}

void TargetSprings::setTarget(const std::vector<Tile>& target) {
  for (std::size_t i = 0; i < springs_.size(); ++i) {
    const std::vector<Vector3>& bottom = bricks_[i].bottom;
    Spring& spring = springs_[i];
    spring.vertexCount = static_cast<int>(bottom.size());
    spring.bottomMean = meanPoint(bottom);
    spring.targetMean = meanPoint(target[i].vertices);
    spring.moment.setZero();
    spring.spread = 0;
    for (std::size_t k = 0; k < bottom.size(); ++k) {
      const Vector3 p = bottom[k] - spring.bottomMean;
      const Vector3 t = target[i].vertices[k] - spring.targetMean;
      // The sum over the vertices is taken once: in each step one product with the rotation gives
      // C.
      spring.moment += p * t.transpose();
      spring.spread += p.squaredNorm() + t.squaredNorm();
    }
  }
}

Load TargetSprings::load(int brick, const Pose& pose, double stiffening) const {
  Load load;
  load.damping.diagonal() << Vector3::Constant(settings_.forceDamping),
      Vector3::Constant(settings_.torqueDamping);
  const Spring& spring = springs_[brick];
  if (!spring.pulled) return load;

  // The force at the mean of the bottom, seen from the centre of mass through the arm s.
  const Matrix3 R = pose.rotation.toRotationMatrix();
  const double kf = stiffening * settings_.springStiffness * spring.vertexCount;
  const double kt = stiffening * settings_.torqueStiffness;
  const Vector3 s = R * spring.bottomMean;
  const Vector3 gap = spring.targetMean - pose.position - s;
  const Matrix3 S = crossMatrix(s);

  // Both the torque springs and the turning arm have the same kind of second derivative.
  const Matrix3 C = kt * R * spring.moment + kf * s * gap.transpose();
  load.force << kf * gap, crossSum(C);
  load.stiffness.topLeftCorner<3, 3>().diagonal().setConstant(kf);
  load.stiffness.topRightCorner<3, 3>() = -kf * S;
  load.stiffness.bottomLeftCorner<3, 3>() = kf * S;
  load.stiffness.bottomRightCorner<3, 3>() =
      kf * S.transpose() * S + positivePart(rotationalStiffness(C));
  return load;
}

double TargetSprings::energy(const Poses& poses, double stiffening) const {
  double sum = 0;
  for (std::size_t i = 0; i < springs_.size(); ++i) {
    const Spring& spring = springs_[i];
    if (!spring.pulled) continue;
    const Vector3 gap = spring.targetMean - poses[i].apply(spring.bottomMean);
    // sum |p' - t'|^2 = sum |p'|^2 + |t'|^2 - 2 sum p' . t'.
    const double turned = (poses[i].rotation.toRotationMatrix() * spring.moment).trace();
    sum += 0.5 * settings_.springStiffness * spring.vertexCount * gap.squaredNorm() +
           0.5 * settings_.torqueStiffness * (spring.spread - 2 * turned);
  }
  return stiffening * sum;
}

// An error e improves on the best one, b, where it passes 0.995 b. While it falls steadily it
// passes b 0.995^k, k = 1, 2, ...; the last of these before the step's end is the new best, and the
// moment of passing it is taken as if log e were linear in the step.
bool AdaptiveStiffness::observe(double targetError, double time, double step) {
  const double from = time - step;
  const bool isFirst = bestError_ < 0;
  if (isFirst) {
    bestError_ = lastError_ = targetError;
    improvedAt_ = time;
  } else {
    improvedAt_ += from - lastTime_;
  }
  if (targetError > 0 && targetError < kImprovement * bestError_) {
    const double passed = std::floor(std::log(targetError / bestError_) / std::log(kImprovement));
    bestError_ *= std::pow(kImprovement, passed);
    const double share = std::log(bestError_ / targetError) / std::log(lastError_ / targetError);
    improvedAt_ = time - std::clamp(share, 0.0, 1.0) * step;
  }
  lastError_ = targetError;
  lastTime_ = time;
  if (time < nextMoment() - kSameTime) return false;
  stiffen();
  return true;
}

double AdaptiveStiffness::nextMoment() const {
  if (exhausted() || bestError_ < 0) return std::numeric_limits<double>::infinity();
  return improvedAt_ + kStallTime;
}

bool AdaptiveStiffness::exhausted() const {
  return !enabled_ || factor_ >= kLargestFactor;
}

void AdaptiveStiffness::stiffen() {
  improvedAt_ = lastTime_;
  if (!exhausted()) factor_ *= 2;
}

}  // namespace kirireel
