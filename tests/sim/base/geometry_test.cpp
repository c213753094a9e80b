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
    const Quaternion expected(Eigen::AngleAxisd(angle, axis));
    EXPECT_LT((found.coeffs() - expected.coeffs()).norm(), 1e-15) << angle;  // measured 2e-16
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

/// The matrix of the first difference, n x (n + 1): times its transpose it is the second
/// difference. Its singular values are therefore 2 sin(pi k / (2 (n + 1))).
TEST(SingularValuesOf, FindsThoseOfTheFirstDifference) {
  for (const int n : {1, 2, 6, 40}) {
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(n, n + 1);
    for (int j = 0; j < n; ++j) {
      matrix(j, j) = -1;
      matrix(j, j + 1) = 1;
    }
    for (const Eigen::MatrixXd& each : {matrix, Eigen::MatrixXd(matrix.transpose())}) {
      const Eigen::VectorXd found = singularValuesOf(each);
      ASSERT_EQ(found.size(), n);
      for (int k = 0; k < n; ++k) {
        const double expected = 2 * std::sin(std::numbers::pi * (n - k) / (2 * (n + 1)));
        EXPECT_NEAR(found[k], expected, 2e-14) << n;  // measured: 3.4e-15
      }
    }
  }
}

TEST(SingularValuesOf, LeavesZerosWhereRowsDependOnEachOther) {
  // The two that are not zero are the roots of those of [14 28; 28 56] and of the third row.
  Eigen::MatrixXd matrix(3, 4);
  matrix << 1, 2, 3, 0, 2, 4, 6, 0, 0, 0, 0, 5;
  const Eigen::VectorXd found = singularValuesOf(matrix);
  EXPECT_NEAR(found[0], std::sqrt(70.0), 1e-14);  // measured: 1.8e-15
  EXPECT_NEAR(found[1], 5, 1e-14);                // measured: 0
  EXPECT_NEAR(found[2], 0, 1e-14);                // measured: 2.1e-17
  EXPECT_GE(found[2], 0);
}

TEST(WithoutNegativePart, KeepsOnlyThePositivePart) {
  // In rotated axes no entry is a stretch itself.
  const Matrix3 axes = rotationFromVector({0.3, -0.4, 0.5}).toRotationMatrix();
  const Matrix3 matrix = axes * Vector3(2, -3, 0.5).asDiagonal() * axes.transpose();
  const Matrix3 expected = axes * Vector3(2, 0, 0.5).asDiagonal() * axes.transpose();
  EXPECT_LT((withoutNegativePart(matrix) - expected).norm(), 2e-14);    // measured: 3.5e-15
  EXPECT_LT((withoutNegativePart(expected) - expected).norm(), 2e-14);  // measured: 8.8e-16
  EXPECT_EQ(withoutNegativePart(-Matrix3::Identity()), Eigen::MatrixXd::Zero(3, 3));
}

TEST(Pose, TurnsThenMoves) {
  const Pose pose{{1, 2, 3}, rotationFromVector({0, 0, 1.5707963267948966})};
  EXPECT_LT((pose.apply({1, 0, 0}) - Vector3(1, 3, 3)).norm(), 1e-15);
}

}  // namespace
}  // namespace kirireel
