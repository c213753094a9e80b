// Concave bricks in motion: contacts are checked by distances of polygons, brute force over sides.
#include <gtest/gtest.h>

#include "sim/deploy/deployment.h"
#include "sim/generate/families.h"
#include "sim/model/convex_parts.h"
#include "sim/model/isometry.h"
#include "tests/sim/run/moving.h"
#include "tests/support/polygons.h"

namespace kirireel {
namespace {

using test::Moving;

/// Loose bricks in their plane, without friction or damping.
scene::Scene looseTiles(const std::vector<model::Tile>& tiles) {
  scene::Scene scene;
  scene.model.tiles = tiles;
  scene.brick.thickness = 0.1;
  scene.brick.mass = brick::MassRule::Prism;
  scene.environment.contacts = scene::ContactFilter::All;
  scene.environment.linearDamping = scene.environment.angularDamping = 0;
  scene.environment.pivotZone = 0;
  scene.solver.planar = true;
  scene.solver.timestep = 1.0 / 240;
  return scene;
}

struct Watched {
  double deepest = 0;    ///< corner of one polygon in the other, metres
  double nearest = 1e9;  ///< distance of the outlines
  double energyGrowth = 0;
};

double kineticEnergy(const Moving& bricks) {
  double energy = 0;
  for (std::size_t i = 0; i < bricks.bricks.size(); ++i) {
    const Velocity& v = bricks.motion.velocities[i];
    const brick::Brick& brick = bricks.bricks[i];
    const Matrix3 turn = bricks.motion.poses[i].rotation.toRotationMatrix();
    energy += 0.5 * brick.mass * v.linear.squaredNorm() +
              0.5 * v.angular.dot(turn * brick.inertia * turn.transpose() * v.angular);
  }
  return energy;
}

/// Lets two bricks fly for some steps and checks each.
Watched fly(Moving& bricks, int steps) {
  Watched seen;
  double energy = kineticEnergy(bricks);
  for (int step = 0; step < steps; ++step) {
    bricks.advance(1);
    const std::vector<model::Tile> tiles = brick::bottomTiles(bricks.bricks, bricks.motion.poses);
    seen.deepest = std::max(seen.deepest, test::cornerDepth(tiles[0], tiles[1]));
    seen.nearest = std::min(seen.nearest, test::outlineDistance(tiles[0], tiles[1]));
    const double now = kineticEnergy(bricks);
    seen.energyGrowth = std::max(seen.energyGrowth, now - energy);
    energy = now;
  }
  return seen;
}

TEST(ConcaveBricks, TwoLShapesTouchAtTheirSides) {
  // One in the notch of the other, with 40 initial motions.
  std::mt19937 random(4);
  std::uniform_real_distribution<double> speed(-1, 1);
  int met = 0;
  for (int round = 0; round < 40; ++round) {
    Moving bricks(looseTiles({test::lShape(3, 1), test::lShape(3, 1, 1.25, 1.2)}));
    ASSERT_EQ(bricks.bricks[0].parts.size(), 2U);
    for (Velocity& v : bricks.motion.velocities) {
      v.linear = {speed(random), speed(random), 0};
      v.angular = {0, 0, speed(random)};
    }
    const Watched seen = fly(bricks, 360);
    EXPECT_LE(seen.deepest, 3e-5) << round;
    EXPECT_LE(seen.energyGrowth, 1e-6);
    EXPECT_EQ(bricks.unconverged, 0);
    met += seen.nearest < 1e-4 ? 1 : 0;
  }
  EXPECT_GE(met, 20);
}

TEST(ConcaveBricks, AStarTouchesTheNotchThatItFallsInto) {
  const model::Tile vice = {{{-3, 0, 0}, {3, 0, 0}, {3, 2, 0}, {0, 0.8, 0}, {-3, 2, 0}}};
  std::mt19937 random(9);
  std::uniform_real_distribution<double> share(-1, 1);
  for (int round = 0; round < 20; ++round) {
    const model::Tile star =
        test::starShape(5, 0.8, 0.35, 0.2 * share(random), 2.6, std::numbers::pi * share(random));
    Moving bricks(looseTiles({vice, star}));
    bricks.motion.velocities[1].linear = {0.2 * share(random), -2, 0};
    bricks.motion.velocities[1].angular = {0, 0, 2 * share(random)};
    const Watched seen = fly(bricks, 360);
    EXPECT_LE(seen.nearest, 1e-4) << round;
    EXPECT_LE(seen.deepest, 3e-5) << round;
    EXPECT_EQ(bricks.unconverged, 0);
  }
}

TEST(ConcaveBricks, PartsOfOneBrickNeverCollide) {
  Moving star(looseTiles({test::starShape(7, 2, 0.5), {{{9, 9, 0}, {10, 9, 0}, {9, 10, 0}}}}));
  star.motion.velocities[0].linear = {1, 0.5, 0};
  star.motion.velocities[0].angular = {0, 0, 3};
  star.advance(48);
  EXPECT_NEAR(star.motion.velocities[0].linear.x(), 1, 1e-12);
  EXPECT_NEAR(star.motion.velocities[0].angular.z(), 3, 1e-12);
  EXPECT_EQ(star.deepest, 0);
}

class ConcaveFamily : public testing::TestWithParam<const char*> {};

TEST_P(ConcaveFamily, DeploysToItsLeastError) {
  scene::Scene scene = scene::openScene();
  scene.model = generate::generateModel(generate::familyNamed(GetParam()), {});
  model::alignStartToTarget(scene.model);
  scene::fillFromModel(scene);
  const run::DeploymentResult run = deploy::deploy(scene, 0.1, nullptr);
  const double tile = model::tileSize(scene.model);
  EXPECT_EQ(run.outcome, run::Outcome::Settled) << run.reason;
  EXPECT_EQ(run.atTarget, true);
  EXPECT_LE(run.accuracy.targetErrorEnd, run.assembledError + 1e-9 * tile);
  EXPECT_LE(run.accuracy.targetErrorEnd, 1e-9 * tile);
  EXPECT_LE(run.accuracy.jointGapMax, 1e-9 * tile);
  EXPECT_LE(run.accuracy.penetrationGrownMax, 1e-4 * tile);
}

INSTANTIATE_TEST_SUITE_P(Of, ConcaveFamily,
                         testing::Values("stars", "crosses", "islamic", "trefoils"));

TEST(ConcaveBricks, FamiliesDeployAmongContactsToo) {
  scene::Scene scene = scene::openScene();
  scene.model =
      generate::generateModel(generate::familyNamed("stars"), {{"columns", 3}, {"rows", 3}});
  model::alignStartToTarget(scene.model);
  scene::fillFromModel(scene);
  scene.environment.contacts = scene::ContactFilter::All;
  const run::DeploymentResult run = deploy::deploy(scene, 0.1, nullptr);
  const double tile = model::tileSize(scene.model);
  EXPECT_EQ(run.atTarget, true) << run.reason;
  EXPECT_LE(run.accuracy.targetErrorEnd, 1e-6 * tile);
  EXPECT_LE(run.accuracy.penetrationGrownMax, 1e-4 * tile);
}

TEST(ConcaveBricks, SplitStarsDeploy) {
  scene::Scene scene = scene::openScene();
  scene.model = model::splitTiles(
      generate::generateModel(generate::familyNamed("stars"), {{"columns", 2}, {"rows", 2}}), {1});
  model::alignStartToTarget(scene.model);
  scene::fillFromModel(scene);
  const run::DeploymentResult run = deploy::deploy(scene, 0.1, nullptr);
  EXPECT_EQ(run.atTarget, true) << run.reason;
  EXPECT_LE(run.accuracy.targetErrorEnd, 1e-6 * model::tileSize(scene.model));
}

}  // namespace
}  // namespace kirireel
