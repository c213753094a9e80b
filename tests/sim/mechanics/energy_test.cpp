#include <gtest/gtest.h>

#include "sim/trajectory/measures.h"
#include "tests/sim/mechanics/joined_bricks.h"

namespace kirireel {
namespace {

using test::JoinedBricks;

/// A sheet under target springs, with speeds that its joints do not allow in the beginning.
struct Case {
  double startAngle = 0.3;
  double step = 1.0 / 240;
  double stiffness = 100;
  double forceDamping = 0;
  bool planar = true;
};

/// The largest growth of kinetic plus spring energy in any one step, relative to the energy put in.
double largestGrowth(const Case& c) {
  JoinedBricks sheet(test::openSheet(4, c.startAngle));
  scene::TargetSpringSettings settings;
  settings.springStiffness = settings.torqueStiffness = c.stiffness;
  settings.forceDamping = c.forceDamping;
  settings.torqueDamping = 0;
  const run::TargetSprings springs(sheet.bricks, *sheet.model.target, {}, settings);
  test::Numbers numbers(2);
  for (Velocity& velocity : sheet.motion.velocities) {
    velocity.linear = numbers.vector();
    velocity.angular.z() = numbers.next();
    if (c.planar) velocity.linear.z() = 0;
  }
  const auto energy = [&] {
    return trajectory::kineticEnergy(sheet.bricks, sheet.motion) +
           springs.energy(sheet.motion.poses, 1);
  };
  const auto solver = sheet.solver(c.planar);
  const double start = energy();
  double before = start;
  double growth = -start;
  for (int step = 0; step < 240; ++step) {
    solver->advance(sheet.motion, c.step, test::springLoads(sheet, springs, {}), nullptr);
    const double after = energy();
    growth = std::max(growth, after - before);
    before = after;
  }
  return growth / start;
}

TEST(Energy, NeverGrowsWithoutWork) {
  for (const bool planar : {true, false}) {
    for (const double step : {1.0 / 960, 1.0 / 240, 1.0 / 60, 1.0 / 30}) {
      for (const double stiffness : {1.0, 100.0, 2000.0}) {
        for (const double damping : {0.0, 50.0}) {
          const Case c{0.3, step, stiffness, damping, planar};
          EXPECT_LT(largestGrowth(c), 1e-12)  // measured 2e-16
              << (planar ? "planar" : "space") << ", step 1/" << 1 / step << ", stiffness "
              << stiffness << ", damping " << damping;
        }
      }
    }
  }
}

TEST(Energy, NeverGrowsAsACompactSheetOpens) {
  for (const double stiffness : {1.0, 100.0, 2000.0}) {
    EXPECT_LT(largestGrowth({0, 1.0 / 240, stiffness, 0, true}), 1e-12);  // measured 1e-16
  }
}

TEST(Energy, OfATumblingBrickKeepsToItsMomentum) {
  // Three unequal axes, where explicit gyroscopic terms blow up. The momentum is exact, so the
  // energy stays below the bound for this momentum: L^2 / 2 times 1 / inertia.
  JoinedBricks brick(generate::makeTessellation({1, 1, 3, 1}), 0.2);
  brick.motion.velocities[0].angular = {0.1, 9, 0.1};
  const Matrix3& inertia = brick.bricks[0].inertia;
  const double momentum = (inertia * brick.motion.velocities[0].angular).norm();
  const auto solver = brick.solver(false);
  for (int step = 0; step < 2000; ++step) {
    solver->advance(brick.motion, 1.0 / 240, test::noLoads, nullptr);
    const Quaternion& R = brick.motion.poses[0].rotation;
    const Vector3 spin = R.conjugate() * brick.motion.velocities[0].angular;
    EXPECT_NEAR((inertia * spin).norm(), momentum, 1e-11 * momentum);
    EXPECT_LT(trajectory::kineticEnergy(brick.bricks, brick.motion),
              0.5 * momentum * momentum / inertia.diagonal().minCoeff());
  }
}

}  // namespace
}  // namespace kirireel
