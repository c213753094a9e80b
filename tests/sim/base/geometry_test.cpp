#include "sim/base/geometry.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace kirireel {
namespace {

TEST(RotationFromVector, TurnsAboutTheVectorByItsLength) {
  for (const double angle : {1e-12, 1e-6, 0.99e-4, 1.01e-4, 0.5, 3.0, 6.0}) {
    const Vector3 axis = Vector3(1, -2, 2) / 3;
    const Quaternion found = rotationFromVector(angle * axis);
    const Quaternion wanted(Eigen::AngleAxisd(angle, axis));
    EXPECT_LT((found.coeffs() - wanted.coeffs()).norm(), 1e-15) << angle;  // measured 2e-16
    EXPECT_NEAR(found.norm(), 1, 1e-15);
  }
  EXPECT_EQ(rotationFromVector(Vector3::Zero()).coeffs(), Quaternion::Identity().coeffs());
}

TEST(CrossMatrix, GivesTheCrossProduct) {
  const Vector3 a(1, 2, 3), b(-4, 5, 6);
  EXPECT_EQ(crossMatrix(a) * b, a.cross(b));
}

/// The matrix of the second difference, whose eigenvalues and eigenvectors are known:
/// 2 - 2 cos(pi k / (n + 1)) and sin(pi j k / (n + 1)).
TEST(EigenOf, FindsThoseOfTheSecondDifference) {
  for (const int n : {1, 2, 6, 12}) {
    Eigen::MatrixXd matrix = 2 * Eigen::MatrixXd::Identity(n, n);
    for (int j = 0; j + 1 < n; ++j) matrix(j, j + 1) = matrix(j + 1, j) = -1;
    const SymmetricEigen found = eigenOf(matrix);
    for (int k = 0; k < n; ++k) {
      const double angle = std::numbers::pi * (k + 1) / (n + 1);
      EXPECT_NEAR(found.values[k], 2 - 2 * std::cos(angle), 2e-14) << n;  // measured: 4.9e-15
      Eigen::VectorXd wave(n);
      for (int j = 0; j < n; ++j) wave[j] = std::sin(angle * (j + 1));
      // The sign of an eigenvector is free.
      EXPECT_NEAR(std::abs(wave.normalized().dot(found.vectors.col(k))), 1, 2e-14) << n;
    }
  }
}

TEST(Pose, TurnsThenMoves) {
  const Pose pose{{1, 2, 3}, rotationFromVector({0, 0, 1.5707963267948966})};
  EXPECT_LT((pose.apply({1, 0, 0}) - Vector3(1, 3, 3)).norm(), 1e-15);
}

}  // namespace
}  // namespace kirireel
