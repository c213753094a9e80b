#include <gtest/gtest.h>

#include "sim/run/forces.h"

namespace kirireel {
namespace {

brick::Brick flatBrick() {
  return brick::makeBrick({{{0, 0, 0}, {3, 0, 0}, {3, 1, 0}, {0, 1, 0}}},
                          {0.5, brick::MassRule::Prism, 2});
}

/// The load of the environment on a brick.
brick::Load added(const scene::Environment& environment, const brick::Brick& brick,
                  const Pose& pose, const brick::Load& before = {}) {
  std::vector<brick::Load> loads = {before};
  run::addEnvironmentLoads(environment, {&brick, 1}, {pose}, loads);
  return loads.front();
}

TEST(EnvironmentLoad, GravityPullsByMass) {
  scene::Environment environment;
  environment.gravity = {1, 2, -10};
  brick::Load pushed;
  pushed.force.setOnes();
  const brick::Load load = added(environment, flatBrick(), {}, pushed);
  Vector6 expected;
  expected << 4, 7, -29, 1, 1, 1;  // 3 kg
  EXPECT_LT((load.force - expected).norm(), 1e-12);
  EXPECT_EQ(load.stiffness, Matrix6::Zero());
}

TEST(EnvironmentLoad, DampingLosesItsFractionPerSecond) {
  // M u' = -D u has the solution exp(-M^-1 D t) u, which must be (1 - damping)^t u.
  scene::Environment environment;
  environment.linearDamping = 0.3;
  environment.angularDamping = 0.6;
  const brick::Brick brick = flatBrick();
  const Pose pose{Vector3(1, 2, 3), rotationFromVector({0.4, -1, 0.3})};
  const brick::Load load = added(environment, brick, pose);
  const Matrix3 R = pose.rotation.toRotationMatrix();
  Matrix6 mass = Matrix6::Zero();
  mass.topLeftCorner<3, 3>().diagonal().setConstant(brick.mass);
  mass.bottomRightCorner<3, 3>() = R * brick.inertia * R.transpose();
  const Matrix6 rate = mass.inverse() * load.damping;
  Vector6 expected;
  expected << Vector3::Constant(std::log(1 / 0.7)), Vector3::Constant(std::log(1 / 0.4));
  EXPECT_LT((rate - Matrix6(expected.asDiagonal())).norm(), 1e-13);  // measured 1e-15
}

TEST(EnvironmentLoad, NoEnvironmentHasNoLoad) {
  scene::Environment environment;
  environment.linearDamping = environment.angularDamping = 0;
  const brick::Load load = added(environment, flatBrick(), {});
  EXPECT_EQ(load.force, Vector6::Zero());
  EXPECT_EQ(load.damping, Matrix6::Zero());
}

}  // namespace
}  // namespace kirireel
