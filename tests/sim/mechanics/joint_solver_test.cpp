#include "sim/mechanics/joint_solver.h"

#include <gtest/gtest.h>

#include "sim/trajectory/measures.h"
#include "tests/sim/mechanics/joined_bricks.h"

namespace kirireel {
namespace {

using test::JoinedBricks;

/// Two hinged bricks that tumble freely. Their velocities fit the joint.
JoinedBricks tumblingPair() {
  generate::TessellationShape shape;
  shape.columns = 2;
  shape.rows = 1;
  shape.startAngle = 0.5;
  JoinedBricks pair(generate::makeTessellation(shape), 0.3);
  const Vector3 turn(0.7, -0.4, 1.1);
  for (std::size_t i = 0; i < 2; ++i) {
    pair.motion.velocities[i] = {Vector3(0.2, 0.1, 3) + turn.cross(pair.motion.poses[i].position),
                                 turn};
  }
  return pair;
}

Vector3 massCentre(const JoinedBricks& pair) {
  Vector3 sum = Vector3::Zero();
  for (const Pose& pose : pair.motion.poses) sum += pose.position;
  return sum / static_cast<double>(pair.bricks.size());  // every mass is 1
}

Vector3 linearMomentum(const JoinedBricks& pair) {
  Vector3 sum = Vector3::Zero();
  for (const Velocity& velocity : pair.motion.velocities) sum += velocity.linear;
  return sum;
}

Vector3 spin(const JoinedBricks& pair) {
  Vector3 sum = Vector3::Zero();
  const Vector3 centre = massCentre(pair);
  for (std::size_t i = 0; i < pair.bricks.size(); ++i) {
    const Pose& pose = pair.motion.poses[i];
    const Velocity& velocity = pair.motion.velocities[i];
    sum +=
        (pose.position - centre).cross(velocity.linear) +
        pose.rotation * (pair.bricks[i].inertia * (pose.rotation.conjugate() * velocity.angular));
  }
  return sum;
}

void advance(JoinedBricks& sheet, mechanics::JointSolver& solver, double step, int steps,
             const mechanics::LoadSource& loads) {
  for (int i = 0; i < steps; ++i) solver.advance(sheet.motion, step, loads, nullptr);
}

TEST(JointSolver, KeepsTheLinearMomentumOfFreeBricks) {
  JoinedBricks pair = tumblingPair();
  const Vector3 before = linearMomentum(pair);
  const Vector3 start = massCentre(pair);
  advance(pair, *pair.solver(false), 1.0 / 240, 480, test::noLoads);
  EXPECT_LT((linearMomentum(pair) - before).norm(), 1e-10);  // measured 6e-12
  // Closing moves the bricks by the rounding of an ill-conditioned solve: measured 6e-9.
  EXPECT_LT((massCentre(pair) - start - 2 * before / 2).norm(), 1e-7);
  EXPECT_LT(trajectory::jointGap(pair.pivots, pair.motion.poses).max, 1e-11);
}

TEST(JointSolver, AngularMomentumErrsInProportionToTheStep) {
  double lost[2];
  for (const int k : {0, 1}) {
    JoinedBricks pair = tumblingPair();
    const Vector3 before = spin(pair);
    const int steps = 240 << (2 * k);
    advance(pair, *pair.solver(false), 1.0 / steps, steps, test::noLoads);
    lost[k] = (spin(pair) - before).norm() / before.norm();
  }
  EXPECT_LT(lost[0], 0.01);           // measured 1.6e-3
  EXPECT_LT(lost[1], 0.3 * lost[0]);  // a quarter of the step: measured 0.251
}

TEST(JointSolver, FreeFallIsTheSumOverSteps) {
  // Implicit Euler falls by g h^2 n (n + 1) / 2, for any rotation.
  JoinedBricks pair = tumblingPair();
  const Vector3 start = massCentre(pair);
  const Vector3 speed = linearMomentum(pair) / 2;
  const mechanics::LoadSource gravity = [](const Poses&, std::vector<brick::Load>& loads) {
    for (brick::Load& load : loads) {
      load = {};
      load.force[2] = -10;
    }
  };
  const double h = 1.0 / 240;
  advance(pair, *pair.solver(false), h, 240, gravity);
  const Vector3 fall(0, 0, -10 * h * h * 240 * 241 / 2);
  EXPECT_LT((massCentre(pair) - start - speed - fall).norm(), 1e-7);  // measured 3e-9, of closing
}

TEST(JointSolver, ClosesTheJointsOfOpeningSheetsAfterEveryStep) {
  for (const bool planar : {true, false}) {
    for (const int side : {2, 4, 10}) {
      JoinedBricks sheet(test::openSheet(side, 0));
      const run::TargetSprings springs(sheet.bricks, *sheet.model.target, {}, {});
      const Poses start = sheet.motion.poses;
      const auto solver = sheet.solver(planar);
      test::Numbers numbers(1);
      for (Velocity& velocity : sheet.motion.velocities) velocity.linear = 1e-6 * numbers.vector();
      double largest = 0;
      for (int step = 0; step < 120; ++step) {
        const StepReport report = solver->advance(sheet.motion, 1.0 / 240,
                                                  test::springLoads(sheet, springs, {}), nullptr);
        EXPECT_EQ(report.unconverged, 0);
        largest = std::max(largest, trajectory::jointGap(sheet.pivots, sheet.motion.poses).max);
      }
      // measured 1e-12 of 14
      EXPECT_LT(largest, 1e-10 * model::modelSize(sheet.model))
          << side << (planar ? " planar" : "");
      const double error =
          trajectory::targetError(*sheet.model.target, sheet.bricks, sheet.motion.poses);
      EXPECT_LT(error, 0.9 * trajectory::targetError(*sheet.model.target, sheet.bricks, start));
    }
  }
}

TEST(JointSolver, ClosesTheJointsOfSheetsThatFlyApart) {
  // Speeds that violate all joints, on a sheet at an angle to all axes.
  JoinedBricks sheet(test::openSheet(4, 0.7), 0.1);
  test::Numbers numbers(7);
  for (Velocity& velocity : sheet.motion.velocities) {
    velocity = {10 * numbers.vector(), 10 * numbers.vector()};
  }
  const auto solver = sheet.solver(false);
  for (int step = 0; step < 240; ++step) {
    solver->advance(sheet.motion, 1.0 / 60, test::noLoads, nullptr);
    EXPECT_LT(trajectory::jointGap(sheet.pivots, sheet.motion.poses).max, 1e-10);  // measured 1e-12
  }
}

TEST(JointSolver, AssemblesAnOpenStart) {
  for (const bool planar : {true, false}) {
    JoinedBricks sheet(test::openSheet(5, 0.6));
    test::Numbers numbers(3);
    for (Pose& pose : sheet.motion.poses) {
      Vector3 move = numbers.vector(), turn = numbers.vector();
      if (planar) move.z() = turn.x() = turn.y() = 0;
      pose.position += 0.02 * move;
      pose.rotation = rotationFromVector(0.02 * turn) * pose.rotation;
    }
    EXPECT_GT(trajectory::jointGap(sheet.pivots, sheet.motion.poses).max, 0.01);
    const double left = sheet.solver(planar)->assemble(sheet.motion.poses);
    EXPECT_LT(left, 1e-12);  // measured 2e-15
    // The solver's rows are compared one by one, the measure takes the distance.
    EXPECT_LT(trajectory::jointGap(sheet.pivots, sheet.motion.poses).max, 2e-12);
  }
}

TEST(JointSolver, AssemblyKeepsAClosedStart) {
  JoinedBricks sheet(test::openSheet(3, 0.6));
  const Poses before = sheet.motion.poses;
  EXPECT_LT(sheet.solver(false)->assemble(sheet.motion.poses), 1e-12);
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(sheet.motion.poses[i].position, before[i].position);
  }
}

TEST(JointSolver, MovesASingleBrickWithoutJoints) {
  JoinedBricks brick(test::openSheet(1, 0));
  brick.motion.velocities[0] = {Vector3(1, 2, 3), Vector3(0, 0, 2)};
  const Vector3 start = brick.motion.poses[0].position;
  advance(brick, *brick.solver(false), 0.01, 100, test::noLoads);
  EXPECT_LT((brick.motion.poses[0].position - start - Vector3(1, 2, 3)).norm(), 1e-13);
  const Quaternion turned = rotationFromVector({0, 0, 2});
  EXPECT_LT(turned.angularDistance(brick.motion.poses[0].rotation), 1e-13);
}

TEST(StepReport, AddsUp) {
  StepReport sum{1, 2, 3, 4};
  sum += StepReport{10, 20, 30, 40};
  EXPECT_EQ(sum.steps, 11);
  EXPECT_EQ(sum.halved, 22);
  EXPECT_EQ(sum.unconverged, 33);
  EXPECT_EQ(sum.factorizations, 44);
}

TEST(JointSolver, CompliantJointsStretchByTheirLoad) {
  generate::TessellationShape shape;
  shape.columns = 2;
  shape.rows = 1;
  JoinedBricks pair(generate::makeTessellation(shape));
  ASSERT_EQ(pair.pivots.size(), 2U);
  constexpr double kForce = 3;
  constexpr double kStiffness = 1e4;
  // The bricks are pulled at the point half way between the pivots of their joint.
  const auto pull = [&](const Poses& poses, std::vector<brick::Load>& loads) {
    const brick::Pivot& low = pair.pivots[0];
    const brick::Pivot& high = pair.pivots[1];
    const auto set = [&](int brick, const Vector3& point, const Vector3& force) {
      const Vector3 arm = poses[brick].rotation * point;
      loads[brick] = {};
      loads[brick].force << force, arm.cross(force);
      loads[brick].damping.diagonal().setConstant(20);
    };
    set(low.brickA, 0.5 * (low.pointA + high.pointA), Vector3(-kForce, 0, 0));
    set(low.brickB, 0.5 * (low.pointB + high.pointB), Vector3(kForce, 0, 0));
  };
  const std::unique_ptr<mechanics::JointSolver> solver = pair.solver(false);
  solver->setJointStiffness(kStiffness);
  advance(pair, *solver, 1.0 / 60, 600, pull);
  const double gap = trajectory::jointGap(pair.pivots, pair.motion.poses).max;
  EXPECT_NEAR(gap, kForce / (2 * kStiffness), 1e-9);  // measured 1e-13

  solver->setJointStiffness(std::numeric_limits<double>::infinity());
  solver->assemble(pair.motion.poses);
  advance(pair, *solver, 1.0 / 60, 10, pull);
  EXPECT_LT(trajectory::jointGap(pair.pivots, pair.motion.poses).max, 1e-12);
}

}  // namespace
}  // namespace kirireel
