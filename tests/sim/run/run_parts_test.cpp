// Parts of a run: its clock, its present target, and its phases.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "sim/deploy/deployment.h"
#include "sim/generate/lattice.h"
#include "sim/run/run_drive.h"
#include "sim/run/run_motion.h"

namespace kirireel {
namespace {

using namespace scene::timeline;

/// A sheet of 2 x 2 squares, a path of which is guided for 1 s.
scene::Scene ledSheet() {
  scene::Scene scene;
  generate::TessellationShape shape;
  shape.columns = shape.rows = 2;
  shape.startAngle = 20 * kDegree;
  scene.model = generate::makeTessellation(shape);
  scene.path.kind = scene::PathKind::Guided;
  scene.path.guideTime = 1;
  return scene;
}

// ------------------------------------------------------------------------------------------------

TEST(StepClock, CountsChecksWithoutRoundingDrift) {
  run::StepClock clock(0.1);
  for (int k = 0; k < 1'000'000; ++k) {
    clock.beginStep(INFINITY);
    clock.endStep();
  }
  EXPECT_EQ(clock.time(), 100'000);  // a sum of tenths is off by 1.3e-6
}

TEST(StepClock, EndsAStepAtADueEventAndTheNextAtItsCheck) {
  run::StepClock clock(0.1);
  clock.beginStep(0.03);
  EXPECT_EQ(clock.length(), 0.03);
  clock.endStep();
  EXPECT_EQ(clock.time(), 0.03);
  clock.beginStep(INFINITY);
  EXPECT_EQ(clock.length(), 0.1 - 0.03);
  clock.endStep();
  EXPECT_EQ(clock.time(), 0.1);
}

TEST(StepClock, TreatsEventsDueAtACheckUpToRoundingAsDue) {
  run::StepClock clock(0.1);
  clock.beginStep(0.1 - 1e-9);
  EXPECT_EQ(clock.length(), 0.1);
  clock.endStep();
  EXPECT_TRUE(clock.isDue(0.1 + 1e-9));
  EXPECT_FALSE(clock.isDue(0.1 + 1e-6));
  EXPECT_TRUE(clock.isAhead(0.1 - 1e-9));
  EXPECT_FALSE(clock.isAhead(0.1 - 1e-6));
}

// ------------------------------------------------------------------------------------------------

TEST(CurrentTarget, IsTheModelsOwnUntilAnotherIsSet) {
  const scene::Scene scene = ledSheet();
  const run::SceneBricks bricks(scene);
  const Poses start = brick::startPoses(scene.model.tiles, bricks.bricks);
  run::CurrentTarget target(bricks, {.error = 0.125, .poses = {}, .restError = 0.25});
  EXPECT_EQ(target.tiles(), nullptr);
  EXPECT_EQ(target.error(start), 0);
  target.set(nullptr, start);
  EXPECT_EQ(target.tiles(), &*scene.model.target);
  EXPECT_EQ(target.nearestError(), 0.125);
  EXPECT_TRUE(target.isAtSpringEquilibrium(0.25));
  EXPECT_FALSE(target.isNearest(0.25));
  EXPECT_GT(target.startError(), 0.1);
  EXPECT_FALSE(target.hasArrived(start));
  target.set(&scene.model.tiles, start);
  EXPECT_LT(target.startError(), 1e-15);
  EXPECT_TRUE(target.hasArrived(start));
}

TEST(CurrentTarget, AFarErrorIsNoArrivalForAnyReason) {
  const scene::Scene scene = ledSheet();
  const run::SceneBricks bricks(scene);
  const Poses start = brick::startPoses(scene.model.tiles, bricks.bricks);
  run::CurrentTarget target(bricks, {.error = 100});
  target.set(nullptr, start);
  EXPECT_TRUE(target.isNearest(target.error(start)));
  EXPECT_FALSE(target.hasArrived(start));
}

// ------------------------------------------------------------------------------------------------

/// The phases of a drive in steps of 1/240 s, each with the time of its first step. The bricks do
/// not move.
std::vector<std::pair<run::Phase, double>> phasesOf(const scene::Scene& scene) {
  const run::SceneBricks bricks(scene);
  run::StepClock clock(run::RunMotion::checkIntervalOf(scene));
  run::RunMotion motion(bricks, clock);
  run::CurrentTarget target(bricks, {.error = 0});
  run::RunDrive drive(bricks, clock);
  target.set(nullptr, motion.poses());
  drive.startTowards(target, motion.poses());
  std::vector<std::pair<run::Phase, double>> phases;
  while (clock.time() < 4) {
    clock.beginStep(drive.nextMoment());
    const double begin = clock.time();
    drive.beginStep(target, motion.poses(), motion.solver());
    if (phases.empty() || phases.back().first != drive.phase()) {
      phases.push_back({drive.phase(), begin});
    }
    clock.endStep();
  }
  return phases;
}

TEST(RunDrive, AGuidedPathHasItsPhases) {
  scene::Scene scene = ledSheet();
  scene.path.openTime = 0.31;
  scene.path.jointRatio = 1e3;
  const auto phases = phasesOf(scene);
  ASSERT_EQ(phases.size(), 4U);
  const double step = 1.0 / 240;
  EXPECT_EQ(phases[0].first, run::Phase::Open);
  EXPECT_EQ(phases[1].first, run::Phase::Guide);
  EXPECT_NEAR(phases[1].second, 0.31, 1e-12) << "at its own time, however steps lie";
  EXPECT_EQ(phases[2].first, run::Phase::Close);
  EXPECT_NEAR(phases[2].second, 0.31 + 1 + 0.5, step);
  EXPECT_EQ(phases[3].first, run::Phase::Settle);
  EXPECT_NEAR(phases[3].second, 0.31 + 1 + 1, step);
}

TEST(RunDrive, ExactJointsNeedNotBeClosed) {
  const auto phases = phasesOf(ledSheet());
  ASSERT_EQ(phases.size(), 2U);
  EXPECT_EQ(phases[0].first, run::Phase::Guide);
  EXPECT_EQ(phases[1].first, run::Phase::Settle);
  EXPECT_NEAR(phases[1].second, 1.5, 1.0 / 240);
}

TEST(RunDrive, AStraightPullSettlesFromTheStart) {
  scene::Scene scene = ledSheet();
  scene.path.kind = scene::PathKind::Straight;
  const auto phases = phasesOf(scene);
  ASSERT_EQ(phases.size(), 1U);
  EXPECT_EQ(phases[0].first, run::Phase::Settle);
}

// The sample at the end of opening has the state after the expansion, before springs pull to the
// target.
TEST(RunDrive, SpringsHaveNoEnergyWhileASheetOpens) {
  scene::Scene scene = ledSheet();
  scene.environment.contacts = scene::ContactFilter::None;
  scene.path.openTime = 0.25;
  scene.stop.duration = 0.5;
  const run::DeploymentResult run = deploy::deploy(scene, 0.125, nullptr);
  ASSERT_EQ(run.trajectory.samples.size(), 5U);
  EXPECT_EQ(run.trajectory.samples[1].mechanics->energies.spring, 0);
  EXPECT_EQ(run.trajectory.samples[2].mechanics->energies.spring, 0);
  EXPECT_GT(run.trajectory.samples[3].mechanics->energies.spring, 0);
}

TEST(Timelines, AResetLeavesAnotherTargetBehind) {
  scene::Scene scene = ledSheet();
  scene.path.kind = scene::PathKind::Straight;
  scene.environment.contacts = scene::ContactFilter::None;
  const std::vector<model::Tile> other = *scene.model.target;
  scene.model.target.reset();
  scene.actuation.drive = scene::Drive::Target;
  scene.timeline = {{{}, GoTo{"other.txt", other}}, {{scene::Trigger::Kind::AtTime, 0.5}, Reset{}}};
  scene.stop.duration = 2;
  const run::DeploymentResult run = deploy::deploy(scene, 0.25, nullptr);
  const auto& samples = run.trajectory.samples;
  EXPECT_GT((samples[1].poses[0].position - samples[0].poses[0].position).norm(), 0.01);
  const Poses& end = samples.back().poses;
  // Only the perturbation, undamped.
  EXPECT_LT((end[0].position - samples[0].poses[0].position).norm(), 1e-4);  // measured 1e-5
}

}  // namespace
}  // namespace kirireel
