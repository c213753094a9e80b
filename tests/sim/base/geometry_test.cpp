#include "sim/base/geometry.h"

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

TEST(Pose, TurnsThenMoves) {
  const Pose pose{{1, 2, 3}, rotationFromVector({0, 0, 1.5707963267948966})};
  EXPECT_LT((pose.apply({1, 0, 0}) - Vector3(1, 3, 3)).norm(), 1e-15);
}

}  // namespace
}  // namespace kirireel
