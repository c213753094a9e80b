// Scenes with grips: equilibria in place of a deployment.
#include "sim/deploy/loading.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/measure/measures.h"
#include "sim/model/tessellation.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;

/// Four squares with springs, open by 20 degrees: one is held, its neighbour turned by 40 degrees.
Scene turnedUnit() {
  Scene scene;
  TessellationShape shape;
  shape.columns = shape.rows = 2;
  shape.startAngle = 20 * kDegree;
  scene.model = makeTessellation(shape);
  scene.environment.contacts = ContactFilter::Auto;
  scene.path.kind = PathKind::Auto;
  scene.hinges.stiffness = 3;
  GripSetting held, turned;
  held.tiles = {0};
  held.x = held.y = held.turn = 0;
  turned.tiles = {1};
  turned.turn = 40 * kDegree;
  scene.grips = {held, turned};
  return scene;
}

TEST(Loading, IsSampledAsAWalkWithItsLoadCurve) {
  const DeploymentResult run = deploy(turnedUnit(), 0.5, nullptr);
  EXPECT_EQ(run.outcome, Outcome::Settled) << run.reason;
  ASSERT_TRUE(run.loadCurve.has_value());
  EXPECT_EQ(run.loadCurve->leading, 3u);
  const Equilibrium& last = run.loadCurve->states.back();
  const double turn = 40 * kDegree;
  EXPECT_EQ(last.load, 1);
  EXPECT_NEAR(last.forces[3], 12 * turn, 1e-9);  // 4 k t, as in the tests of equilibrium
  EXPECT_NEAR(run.elasticity->energyEnd, 6 * turn * turn, 1e-9);
  EXPECT_EQ(run.trajectory.samples.size(), 13u);
  for (const Sample& sample : run.trajectory.samples) EXPECT_LT(sample.jointGap, 1e-11);
  const std::vector<HingeSpring>& springs = run.trajectory.hingeSprings;
  EXPECT_NEAR(elasticEnergy(springs, run.trajectory.samples.back().poses), last.energy, 1e-12);
}

TEST(Loading, KeepsAStateForEachFigure) {
  const DeploymentResult run = deploy(turnedUnit(), 0.5, nullptr);
  EXPECT_FALSE(run.trajectory.figureStates.empty());
  for (const FigureState& state : run.trajectory.figureStates) {
    EXPECT_EQ(state.poses.size(), 4u) << state.figure;
  }
}

TEST(Loading, LeavesATable) {
  const DeploymentResult run = deploy(turnedUnit(), 0.5, nullptr);
  const std::string table = loadTable(*run.loadCurve);
  EXPECT_THAT(table, testing::StartsWith(
                         "load,energy_J,stiffness,unstable_modes,turning,grip_1_x_m,"
                         "grip_1_x_force_N,grip_1_y_m,grip_1_y_force_N,grip_1_turn_rad,"
                         "grip_1_turn_moment_N_m,grip_2_turn_rad,grip_2_turn_moment_N_m\n0,"));
  EXPECT_EQ(static_cast<std::size_t>(std::count(table.begin(), table.end(), '\n')),
            run.loadCurve->states.size() + 1);
}

TEST(Loading, GivesTheSameEveryTime) {
  EXPECT_EQ(loadTable(*deploy(turnedUnit(), 0.5, nullptr).loadCurve),
            loadTable(*deploy(turnedUnit(), 0.1, nullptr).loadCurve));
}

TEST(Loading, NecksGiveWhereTheyAreLigaments) {
  Scene scene = turnedUnit();
  scene.hinges.stiffness = 0;
  scene.hinges.neck = HingeNeck{0.02, 0.1, 1e6, 0.3};
  const DeploymentResult pinned = deploy(scene, 0.5, nullptr);
  scene.hinges.areLigaments = true;
  const DeploymentResult ligaments = deploy(scene, 0.5, nullptr);
  EXPECT_EQ(ligaments.outcome, Outcome::Settled) << ligaments.reason;
  const double exact = pinned.loadCurve->states.back().forces[3];
  const double soft = ligaments.loadCurve->states.back().forces[3];
  EXPECT_GT(soft, 0);
  EXPECT_LT(soft, exact);
  EXPECT_GT(ligaments.accuracy.jointOpeningMax, 1e-6);
  EXPECT_LT(pinned.accuracy.jointGapMax, 1e-11);
  EXPECT_EQ(pinned.accuracy.jointOpeningMax, 0);
}

std::string refusalOf(const Scene& scene) {
  try {
    deploy(scene, 1, nullptr);
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Loading, RefusesWhatEquilibriaDoNotKnow) {
  Scene scene = turnedUnit();
  scene.environment.contacts = ContactFilter::All;
  EXPECT_THAT(refusalOf(scene), HasSubstr("equilibria under grips are without contacts"));
  scene = turnedUnit();
  scene.environment.gravity = {0, 0, -9.81};
  EXPECT_THAT(refusalOf(scene), HasSubstr("but there is gravity; leave that away, or the grips"));
  scene = turnedUnit();
  scene.solver.planar = false;
  EXPECT_THAT(refusalOf(scene), HasSubstr("grips load rigid tiles in the plane alone, but asked for"));
  scene = turnedUnit();
  scene.grips[1].turn = 0;
  EXPECT_THAT(refusalOf(scene), HasSubstr("no grip moves or pushes anything"));
  scene = turnedUnit();
  scene.grips.erase(scene.grips.begin());
  EXPECT_THAT(refusalOf(scene), HasSubstr("the sheet can move without resistance"));
  scene = turnedUnit();
  scene.hinges.stiffness = 0;
  scene.grips[1].isForce = true;
  EXPECT_THAT(refusalOf(scene), HasSubstr("the sheet can move without resistance"));
  scene = turnedUnit();
  scene.hinges.neck = HingeNeck{0.02, 0.1, 1e6, 0.3};
  scene.hinges.areLigaments = true;
  scene.grips.clear();
  EXPECT_THAT(refusalOf(scene), HasSubstr("--ligaments needs grips"));
}

}  // namespace
}  // namespace kirireel
