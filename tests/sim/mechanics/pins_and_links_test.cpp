// Pinned bricks, links and fixed joints, against rigid-body mechanics.
#include <gtest/gtest.h>

#include "sim/trajectory/measures.h"
#include "tests/sim/mechanics/joined_bricks.h"
#include "tests/support/physics.h"

namespace kirireel {
namespace {

using test::JoinedBricks;

using test::kStep;

/// Two unit squares next to each other, with these joints.
model::Model pairOfSquares(const std::vector<model::Joint>& joints) {
  model::Model model;
  for (const double x : {0.0, 1.5}) {
    model.tiles.push_back({{{x, 0, 0}, {x + 1, 0, 0}, {x + 1, 1, 0}, {x, 1, 0}}});
  }
  model.joints = joints;
  return model;
}

JoinedBricks linkedPair() {
  model::Model model = pairOfSquares({});
  model.joints = {model::makeLink(model.tiles, {0, 1}, {1, 3})};
  return JoinedBricks(model, 0.3);
}

JoinedBricks fixedPair() {
  model::Model model = pairOfSquares({});
  model.joints = {model::makeFixedJoint(model.tiles, 0, 1)};
  return JoinedBricks(model, 0.3);
}

void spin(JoinedBricks& bricks) {
  bricks.motion.velocities = {{Vector3(0.2, -1, 0.5), Vector3(0.4, 0.3, 2)},
                              {Vector3(0.1, 1, -0.3), Vector3(-0.2, 0.6, -1)}};
}

TEST(PinnedBricks, StayWhereTheyAre) {
  JoinedBricks pair(test::openSheet(2, 0.5));
  const auto solver = pair.solver(false);
  solver->setPinned({true, false, false, false});
  const Pose before = pair.motion.poses[0];
  const auto push = [](const Poses&, std::vector<brick::Load>& loads) {
    for (brick::Load& load : loads) load.force << 3, -2, 1, 0.5, 0.1, 1;
  };
  for (int i = 0; i < 100; ++i) solver->advance(pair.motion, kStep, push, nullptr);
  EXPECT_EQ(pair.motion.poses[0].position, before.position);
  EXPECT_EQ(pair.motion.poses[0].rotation.coeffs(), before.rotation.coeffs());
  EXPECT_EQ(pair.motion.velocities[0].linear, Vector3::Zero());
  EXPECT_GT((pair.motion.poses[3].position - before.position).norm(), 0.1);
  EXPECT_LT(trajectory::jointGap(pair.pivots, pair.motion.poses).max, 1e-11);  // measured 4e-16
}

TEST(PinnedBricks, AreThePivotOfAPendulum) {
  // A square that turns about its joint to a pinned one keeps its speed.
  model::Model model = pairOfSquares({{{0, 2}, {1, 0}}});
  for (Vector3& vertex : model.tiles[1].vertices) vertex += Vector3(-0.5, 1, 0);
  JoinedBricks pendulum(model);
  const double turn = 1.25;
  pendulum.motion.velocities[1] = {turn * Vector3::UnitZ().cross(Vector3(0.5, 0.5, 0)),
                                   Vector3(0, 0, turn)};
  const auto solver = pendulum.solver(true);
  solver->setPinned({true, false});
  for (int i = 0; i < 240; ++i) solver->advance(pendulum.motion, kStep, test::noLoads, nullptr);
  const Vector3 arm = pendulum.motion.poses[1].position - Vector3(1, 1, 0);
  EXPECT_NEAR(arm.head<2>().norm(), std::sqrt(0.5), 1e-11);  // measured 6e-16
  const double angle = std::atan2(arm.y(), arm.x()) - std::atan2(0.5, 0.5);
  EXPECT_NEAR(angle, turn, 0.01 * turn);
  EXPECT_NEAR(pendulum.motion.velocities[1].angular.z(), turn, 0.01 * turn);
}

TEST(PinnedBricks, AreFreeAgainOnceUnpinned) {
  JoinedBricks pair(test::openSheet(2, 0.5));
  const auto solver = pair.solver(false);
  const auto push = [](const Poses&, std::vector<brick::Load>& loads) {
    for (brick::Load& load : loads) load.force << 1, 0, 0, 0, 0, 0;
  };
  solver->setPinned({true, true, true, true});
  solver->advance(pair.motion, kStep, push, nullptr);
  solver->setPinned({false, false, false, false});
  for (int i = 0; i < 10; ++i) solver->advance(pair.motion, kStep, push, nullptr);
  for (const Velocity& velocity : pair.motion.velocities) {
    EXPECT_NEAR(velocity.linear.x(), 10 * kStep, 1e-11);  // force over mass 1: measured 4e-13
  }
}

TEST(Links, KeepTheirLengthAndTheMomentum) {
  JoinedBricks pair = linkedPair();
  const double length = std::hypot(0.5, 1);
  EXPECT_NEAR(pair.pivots[0].distance, length, 1e-15);
  spin(pair);
  const Vector3 before = pair.motion.velocities[0].linear + pair.motion.velocities[1].linear;
  const auto solver = pair.solver(false);
  double gap = 0;
  for (int i = 0; i < 480; ++i) {
    solver->advance(pair.motion, kStep, test::noLoads, nullptr);
    gap = std::max(gap, trajectory::jointGap(pair.pivots, pair.motion.poses).max);
  }
  EXPECT_LT(gap, 1e-11);  // measured 1e-12
  const Vector3 after = pair.motion.velocities[0].linear + pair.motion.velocities[1].linear;
  EXPECT_LT((after - before).norm(), 1e-10);  // measured 1e-12
  // Only the link holds them, so they have rotated against each other.
  EXPECT_GT(pair.motion.poses[0].rotation.angularDistance(pair.motion.poses[1].rotation), 0.5);
}

TEST(Links, HoldInThePlane) {
  JoinedBricks pair = linkedPair();
  pair.motion.velocities = {{Vector3(-1, 0, 0), Vector3(0, 0, 1)},
                            {Vector3(1, 0.5, 0), Vector3(0, 0, -2)}};
  const auto solver = pair.solver(true);
  for (int i = 0; i < 240; ++i) solver->advance(pair.motion, kStep, test::noLoads, nullptr);
  EXPECT_LT(trajectory::jointGap(pair.pivots, pair.motion.poses).max, 1e-11);  // measured 4e-16
}

TEST(FixedJoints, MakeOneBodyOfTwo) {
  for (const bool planar : {false, true}) {
    JoinedBricks pair = fixedPair();
    const Vector3 between = pair.motion.poses[1].position - pair.motion.poses[0].position;
    // A force at the middle of the second brick: the pair turns as one about its common centre,
    // with both inertias and twice m (1.5 / 2)^2.
    const auto push = [](const Poses&, std::vector<brick::Load>& loads) {
      loads[0] = loads[1] = {};
      loads[1].force[1] = 6;
    };
    const auto solver = pair.solver(planar);
    solver->advance(pair.motion, kStep, push, nullptr);
    const double inertia = 2 * pair.bricks[0].inertia(2, 2) + 2 * 0.75 * 0.75;
    EXPECT_NEAR(pair.motion.velocities[0].angular.z(), kStep * 6 * 0.75 / inertia, 1e-15);
    for (int i = 0; i < 240; ++i) solver->advance(pair.motion, kStep, push, nullptr);
    const Pose& a = pair.motion.poses[0];
    const Pose& b = pair.motion.poses[1];
    EXPECT_LT(a.rotation.angularDistance(b.rotation), 1e-11);  // measured 1e-16
    EXPECT_LT((a.rotation.conjugate() * (b.position - a.position) - between).norm(),
              1e-11);  // 9e-14
  }
}

}  // namespace
}  // namespace kirireel
