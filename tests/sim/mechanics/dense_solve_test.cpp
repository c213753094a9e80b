#include <Eigen/QR>
#include <gtest/gtest.h>

#include "tests/sim/mechanics/joined_bricks.h"

namespace kirireel {
namespace {

using test::JoinedBricks;
using test::Numbers;

/// The matrices of one step, written out densely from their definitions:
/// min 1/2 u^T A u - f^T u with J u = 0.
struct DenseStep {
  Eigen::MatrixXd A, J;
  Eigen::VectorXd f;
};

/// Velocity of the world point at arm r from a brick's centre by its six velocities.
Eigen::MatrixXd pointRows(const Vector3& r) {
  Eigen::MatrixXd rows(3, 6);
  rows << Matrix3::Identity(), -crossMatrix(r);
  return rows;
}

DenseStep denseStep(const JoinedBricks& system, const std::vector<brick::Load>& loads, double h) {
  const auto n = static_cast<Eigen::Index>(system.bricks.size());
  DenseStep dense{Eigen::MatrixXd::Zero(6 * n, 6 * n),
                  Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(system.pivots.size()), 6 * n),
                  Eigen::VectorXd(6 * n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const Matrix3 R = system.motion.poses[i].rotation.toRotationMatrix();
    Matrix6 M = Matrix6::Identity();  // every mass is 1
    M.bottomRightCorner<3, 3>() = R * system.bricks[i].inertia * R.transpose();
    Vector6 u0;
    u0 << system.motion.velocities[i].linear, system.motion.velocities[i].angular;
    dense.A.block<6, 6>(6 * i, 6 * i) = M + h * loads[i].damping + h * h * loads[i].stiffness;
    dense.f.segment<6>(6 * i) = M * u0 + h * loads[i].force;
  }
  for (std::size_t p = 0; p < system.pivots.size(); ++p) {
    const brick::Pivot& pivot = system.pivots[p];
    const auto row = 3 * static_cast<Eigen::Index>(p);
    const Poses& poses = system.motion.poses;
    dense.J.block<3, 6>(row, 6 * pivot.brickA) =
        pointRows(poses[pivot.brickA].rotation * pivot.pointA);
    dense.J.block<3, 6>(row, 6 * pivot.brickB) =
        -pointRows(poses[pivot.brickB].rotation * pivot.pointB);
  }
  return dense;
}

/// Keeps x, y and the rotation about z: the unknowns of a planar step.
DenseStep planarPart(const DenseStep& dense) {
  const Eigen::Index n = dense.f.size() / 6;
  Eigen::MatrixXd keep = Eigen::MatrixXd::Zero(3 * n, 6 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    keep(3 * i, 6 * i) = keep(3 * i + 1, 6 * i + 1) = keep(3 * i + 2, 6 * i + 5) = 1;
  }
  return {keep * dense.A * keep.transpose(), dense.J * keep.transpose(), keep * dense.f};
}

/// The optimality system by a rank-revealing decomposition, which allows redundant rows.
Eigen::VectorXd denseVelocities(const DenseStep& dense) {
  const Eigen::Index n = dense.A.rows(), m = dense.J.rows();
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n + m, n + m);
  K.topLeftCorner(n, n) = dense.A;
  K.topRightCorner(n, m) = dense.J.transpose();
  K.bottomLeftCorner(m, n) = dense.J;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n + m);
  right.head(n) = dense.f;
  return Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>(K).solve(right).head(n);
}

/// The velocities in the step itself: the solver returns angular momentum, not velocity.
Eigen::VectorXd stepVelocities(const JoinedBricks& before, const Motion& after) {
  Eigen::VectorXd u(6 * static_cast<Eigen::Index>(before.bricks.size()));
  for (std::size_t i = 0; i < before.bricks.size(); ++i) {
    const Matrix3& inertia = before.bricks[i].inertia;
    const Quaternion& R0 = before.motion.poses[i].rotation;
    const Quaternion& R1 = after.poses[i].rotation;
    const Vector3 momentum = R1 * (inertia * (R1.conjugate() * after.velocities[i].angular));
    const Vector3 spin = R0 * (inertia.inverse() * (R0.conjugate() * momentum));
    u.segment<6>(6 * static_cast<Eigen::Index>(i)) << after.velocities[i].linear, spin;
  }
  return u;
}

/// Bricks at random poses, joined by random pivots: trees, loops, pairs with two or three pivots.
JoinedBricks randomSystem(unsigned seed, bool planar) {
  Numbers numbers(seed);
  JoinedBricks system(test::openSheet(3, 0.4), 0.2);
  system.pivots.clear();
  for (std::size_t i = 0; i < system.bricks.size(); ++i) {
    Pose& pose = system.motion.poses[i];
    Vector3 turn = 3 * numbers.vector();
    Vector3 place = numbers.vector();
    if (planar) turn.x() = turn.y() = place.z() = 0;
    pose = {place, rotationFromVector(turn)};
    system.motion.velocities[i] = {numbers.vector(), numbers.vector()};
    if (!planar) continue;
    Velocity& velocity = system.motion.velocities[i];
    velocity.linear.z() = velocity.angular.x() = velocity.angular.y() = 0;
  }
  const int count = 4 + static_cast<int>(3 * seed);
  for (int p = 0; p < count; ++p) {
    const int a = static_cast<int>(4.4 + 4.4 * numbers.next());
    const int b = (a + 1 + static_cast<int>(3.9 + 3.9 * numbers.next())) % 9;
    Vector3 point = numbers.vector();
    if (planar) point.z() = 0;
    const auto local = [&](int brick) -> Vector3 {
      const Pose& pose = system.motion.poses[brick];
      return pose.rotation.conjugate() * (point - pose.position);
    };
    system.pivots.push_back({a, b, local(a), local(b), p});
    if (p % 3 == 0) system.pivots.push_back({b, a, local(b), local(a), 1000 + p});
  }
  return system;
}

std::vector<brick::Load> randomLoads(std::size_t count, unsigned seed) {
  std::srand(seed);
  std::vector<brick::Load> loads(count);
  for (brick::Load& load : loads) {
    const Matrix6 B = Matrix6::Random(), C = Matrix6::Random();
    load = {10 * Vector6::Random(), 100 * B.transpose() * B, 10 * C.transpose() * C};
  }
  return loads;
}

/// Largest difference between the solver's velocities and the dense ones, relative to the latter.
double denseDifference(const JoinedBricks& system, unsigned seed, double h, bool planar) {
  const std::vector<brick::Load> loads = randomLoads(system.bricks.size(), seed);
  Motion motion = system.motion;
  const auto source = [&](const Poses&, std::vector<brick::Load>& out) { out = loads; };
  const StepReport report = system.solver(planar)->advance(motion, h, source, nullptr);
  EXPECT_EQ(report.steps, 1);
  EXPECT_EQ(report.unconverged, 0);
  DenseStep dense = denseStep(system, loads, h);
  Eigen::VectorXd found = stepVelocities(system, motion);
  if (planar) {
    dense = planarPart(dense);
    Eigen::VectorXd kept(found.size() / 2);
    for (Eigen::Index i = 0; i < kept.size() / 3; ++i) {
      kept.segment<3>(3 * i) << found[6 * i], found[6 * i + 1], found[6 * i + 5];
    }
    found = kept;
  }
  const Eigen::VectorXd expected = denseVelocities(dense);
  return (found - expected).lpNorm<Eigen::Infinity>() / expected.lpNorm<Eigen::Infinity>();
}

TEST(DenseSolve, AgreesInSpaceOnRandomRedundantSystems) {
  double worst = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    // In short steps only velocities matter: no gap is closed and no step is halved.
    worst = std::max(worst, denseDifference(randomSystem(seed, false), seed, 1e-4, false));
  }
  EXPECT_LT(worst, 1e-10);  // measured 1e-12
}

TEST(DenseSolve, AgreesInThePlaneOnRandomRedundantSystems) {
  double worst = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    worst = std::max(worst, denseDifference(randomSystem(seed, true), seed, 1e-4, true));
  }
  EXPECT_LT(worst, 1e-10);  // measured 2e-13
}

TEST(DenseSolve, AgreesOnSheets) {
  double worst = 0;
  for (const bool planar : {true, false}) {
    for (const double angle : {0.05, 0.5}) {
      const JoinedBricks sheet(test::openSheet(4, angle));
      worst = std::max(worst, denseDifference(sheet, 2, 1e-4, planar));
    }
  }
  EXPECT_LT(worst, 1e-10);  // measured 8e-12
}

}  // namespace
}  // namespace kirireel
