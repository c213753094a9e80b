// Whole deployments under timelines, pins, drags and drives other than a target.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/deploy/deployment.h"
#include "sim/generate/lattice.h"

namespace kirireel {
namespace {

using namespace scene::timeline;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kPi = 3.14159265358979323846;

/// A 3 x 3 sheet that opens by 90 degrees.
scene::Scene sheetScene(double startAngle = 0.3) {
  scene::Scene scene;
  generate::TessellationShape shape;
  shape.columns = shape.rows = 3;
  shape.startAngle = startAngle;
  scene.model = generate::makeTessellation(shape);
  return scene;
}

double turnOf(const Pose& pose) {
  return 2 * std::atan2(pose.rotation.z(), pose.rotation.w());
}

double largestMove(const Poses& a, const Poses& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    largest = std::max(largest, (a[i].position - b[i].position).norm());
  }
  return largest;
}

TEST(Drives, ExpansionOpensASheetToItsGeometricLimit) {
  // Rotating squares are widest at half of their range, each tile turned by 45 degrees from closed.
  for (const std::optional<bool> planar : {std::optional<bool>{}, std::optional<bool>{false}}) {
    scene::Scene scene = sheetScene();
    scene.model.target.reset();
    scene.actuation.drive = scene::Drive::Expansion;
    scene.solver.planar = planar;
    const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
    EXPECT_EQ(result.outcome, run::Outcome::Settled) << result.reason;
    const Poses& end = result.trajectory.samples.back().poses;
    const double between = turnOf(end[1]) - turnOf(end[0]);
    EXPECT_NEAR(std::abs(between) + 0.3, kPi / 2, 1e-4);  // measured below
    for (std::size_t i = 0; i < end.size(); ++i) {
      const double start = result.trajectory.samples.front().poses[i].position.z();
      EXPECT_NEAR(end[i].position.z(), start, 1e-5);
    }
  }
}

TEST(Drives, BoundarySpringsOpenASheet) {
  scene::Scene scene = sheetScene();
  scene.model.target.reset();
  scene.actuation.drive = scene::Drive::Boundary;
  const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
  EXPECT_EQ(result.outcome, run::Outcome::Settled) << result.reason;
  const Poses& end = result.trajectory.samples.back().poses;
  // Springs to points end before the sheet's limit of 1.57.
  EXPECT_GT(std::abs(turnOf(end[1]) - turnOf(end[0])) + 0.3, 1.3);  // measured 1.380
}

TEST(Drives, NoneDoesNotMoveTheSheet) {
  scene::Scene scene = sheetScene();
  scene.actuation.drive = scene::Drive::None;
  scene.stop.duration = 1;
  const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
  const auto& samples = result.trajectory.samples;
  EXPECT_LT(largestMove(samples.front().poses, samples.back().poses), 1e-4);  // the perturbation
  EXPECT_EQ(result.outcome, run::Outcome::Settled);
}

TEST(Timelines, PinnedTilesStayAndAreFreedAgain) {
  scene::Scene scene = sheetScene();
  scene.timeline = {{{}, Pin{{0, 8}}}, {{scene::Trigger::Kind::AtTime, 1}, Unpin{{8}}}};
  scene.stop.duration = 1.5;
  const run::DeploymentResult result = deploy::deploy(scene, 0.05, nullptr);
  const auto& samples = result.trajectory.samples;
  EXPECT_THAT(samples[1].pinned, ElementsAre(0, 8));
  EXPECT_THAT(samples.back().pinned, ElementsAre(0));
  EXPECT_EQ(samples[19].poses[8].position, samples[0].poses[8].position);
  EXPECT_EQ(samples.back().poses[0].position, samples[0].poses[0].position);
  EXPECT_GT((samples.back().poses[8].position - samples[0].poses[8].position).norm(), 0.1);
  ASSERT_EQ(result.trajectory.events.size(), 3u);  // and the end
  EXPECT_EQ(result.trajectory.events[1].text, "unpin tiles 8");
  EXPECT_NEAR(result.trajectory.events[1].time, 1, 1e-9);
}

TEST(Timelines, APauseHoldsTheSheetAndThenContinues) {
  scene::Scene scene = sheetScene();
  scene.timeline = {{{scene::Trigger::Kind::AtTime, 0.5}, Pause{0.5}}};
  scene.stop.duration = 2;
  const run::DeploymentResult paused = deploy::deploy(scene, 0.05, nullptr);
  scene.timeline.clear();
  const run::DeploymentResult whole = deploy::deploy(scene, 0.05, nullptr);
  const auto& a = paused.trajectory.samples;
  const auto& b = whole.trajectory.samples;
  EXPECT_EQ(largestMove(a[10].poses, a[20].poses), 0);
  // The same motion, half a second later.
  EXPECT_EQ(largestMove(a[25].poses, b[15].poses), 0);
}

TEST(Timelines, WaypointsEndAtTheEndOfTheDirectPath) {
  scene::Scene scene = sheetScene(0.05);
  const run::DeploymentResult direct = deploy::deploy(scene, 1.0 / 60, nullptr);
  const scene::Scene half = sheetScene(0.8);
  scene.timeline = {{{}, GoTo{"half", half.model.tiles}},
                    {{scene::Trigger::Kind::AtTarget}, GoTo{}}};
  scene.stop.duration = 60;
  const run::DeploymentResult chain = deploy::deploy(scene, 1.0 / 60, nullptr);
  EXPECT_EQ(chain.outcome, run::Outcome::Settled) << chain.reason;
  ASSERT_EQ(chain.trajectory.events.size(), 3u);  // and the end
  EXPECT_LT(chain.accuracy.targetErrorEnd,
            1e-6 * model::modelSize(scene.model));  // measured 1.1e-6
  EXPECT_LT(
      largestMove(direct.trajectory.samples.back().poses, chain.trajectory.samples.back().poses),
      1e-6 * model::modelSize(scene.model));
}

TEST(Timelines, ForcesOffAndOnAgain) {
  scene::Scene scene = sheetScene();
  scene.timeline = {{{}, Forces{false}}, {{scene::Trigger::Kind::AtTime, 1}, Forces{true}}};
  const run::DeploymentResult result = deploy::deploy(scene, 0.1, nullptr);
  const auto& samples = result.trajectory.samples;
  EXPECT_LT(largestMove(samples[0].poses, samples[9].poses), 1e-4);
  EXPECT_LT(result.accuracy.targetErrorEnd, 1e-6);
  EXPECT_EQ(result.outcome, run::Outcome::Settled);
}

TEST(Timelines, ADragBringsItsTileToThePathsEnd) {
  scene::Scene scene = sheetScene();
  scene.model.target.reset();
  const std::vector<brick::Brick> bricks = brick::makeBricks(scene.model.tiles, scene.brick);
  const Vector3 goal =
      brick::startPoses(scene.model.tiles, bricks)[8].position + Vector3(0.5, 0.2, 0);
  scene.timeline = {{{}, Drag{8, {}, {goal}, 1, 1e4, 50}},
                    {{scene::Trigger::Kind::AtTime, 0.99}, Drag{8, {}, {goal}, 1, 1e4, 50}}};
  scene.stop.duration = 1.9;
  const run::DeploymentResult result = deploy::deploy(scene, 0.1, nullptr);
  const auto& samples = result.trajectory.samples;
  EXPECT_TRUE(result.needs.planar.on) << result.needs.planar.reason;
  EXPECT_LT((samples.back().poses[8].position - goal).norm(), 0.01);
  EXPECT_LT(result.accuracy.jointGapMax, 1e-11);
}

TEST(Timelines, ResetGoesBackToTheStart) {
  scene::Scene scene = sheetScene();
  scene.timeline = {{{scene::Trigger::Kind::AtTime, 1}, Pin{{0}}},
                    {{scene::Trigger::Kind::AtTime, 1}, Reset{}},
                    {{scene::Trigger::Kind::AtTime, 2}, Quit{}}};
  const run::DeploymentResult result = deploy::deploy(scene, 0.1, nullptr);
  const auto& samples = result.trajectory.samples;
  EXPECT_EQ(result.outcome, run::Outcome::OutOfTime);
  EXPECT_THAT(result.reason, HasSubstr("the timeline ended the run at 2 s"));
  ASSERT_EQ(samples.size(), 21u);
  // After the reset all repeats, to the bit.
  EXPECT_EQ(largestMove(samples[5].poses, samples[15].poses), 0);
  EXPECT_TRUE(samples[15].pinned.empty());
}

TEST(Timelines, EntriesActAtTheirOwnTimeForAnySteps) {
  scene::Scene scene = sheetScene();
  scene.solver.tolerance = 1e-6;
  scene.timeline = {{{scene::Trigger::Kind::AtTime, 0.21}, Forces{false}},
                    {{scene::Trigger::Kind::After, 0.0123}, Pause{0.1}},
                    {{scene::Trigger::Kind::AtTime, 0.43}, Forces{true}}};
  scene.stop.duration = 0.5;
  std::vector<run::DeploymentResult> runs;
  for (const double timestep : {1.0 / 240, 1.0 / 80}) {
    scene.solver.timestep = timestep;
    runs.push_back(deploy::deploy(scene, 0.05, nullptr));
    const std::vector<trajectory::Event>& events = runs.back().trajectory.events;
    ASSERT_EQ(events.size(), 4u);  // and the end
    EXPECT_NEAR(events[0].time, 0.21, 1e-12);
    EXPECT_NEAR(events[1].time, 0.2223, 1e-12);
    EXPECT_NEAR(events[2].time, 0.43, 1e-12);
  }
  const auto& a = runs[0].trajectory.samples;
  const auto& b = runs[1].trajectory.samples;
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_LT(largestMove(a[i].poses, b[i].poses), 1e-5) << a[i].time;
  }
}

TEST(Deploy, ComesToRestAtATimeThatStepsDoNotMove) {
  scene::Scene scene = sheetScene();
  scene.springs.adaptive = false;
  scene.solver.tolerance = 1e-6;
  scene.stop.settleSpeed = 1e-3;  // far above the effect of the tolerance on speeds
  std::vector<double> ends;
  for (const double timestep : {1.0 / 480, 1.0 / 240, 1.0 / 80}) {
    scene.solver.timestep = timestep;
    const run::DeploymentResult result = deploy::deploy(scene, 0.05, nullptr);
    EXPECT_EQ(result.outcome, run::Outcome::Settled) << result.reason;
    ends.push_back(result.trajectory.samples.back().time);
  }
  // Measured 1.1e-3 s apart; the run is checked every 1/120 to 1/20 s.
  for (const double end : ends) EXPECT_NEAR(end, ends.front(), 3e-3);
}

TEST(Timelines, AnEntryJustBeforeTheEndDoesNotShortenTheRun) {
  scene::Scene scene = sheetScene();
  scene.timeline = {{{scene::Trigger::Kind::AtTime, 0.495}, Forces{false}}};
  scene.stop.duration = 0.5;
  const run::DeploymentResult result = deploy::deploy(scene, 0.05, nullptr);
  EXPECT_NEAR(result.trajectory.samples.back().time, 0.5, 1e-12);
  EXPECT_NEAR(result.trajectory.events.front().time, 0.495, 1e-12);
}

TEST(Timelines, AConditionThatIsNeverMetEndsTheRun) {
  scene::Scene scene = sheetScene();
  scene.timeline = {{{scene::Trigger::Kind::ErrorBelow, 0}, Quit{}}};
  const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
  EXPECT_EQ(result.outcome, run::Outcome::Locked);
  EXPECT_EQ(result.reason,
            "came to rest, but the timeline still waits for an error below 0 m to quit");
}

TEST(Timelines, AnEntryAfterTheEndIsRefused) {
  scene::Scene scene = sheetScene();
  scene.timeline = {{{scene::Trigger::Kind::AtTime, 30}, Quit{}, {"scene.toml", 3, 1}}};
  try {
    deploy::deploy(scene, 0.1, nullptr);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "scene.toml:3:1: error: this entry is at 30 s, but the run lasts at most 20 s. "
                 "Raise `duration`");
  }
}

/// Two opposite corners pinned hold a mechanism of one degree of freedom; but its closed state is
/// singular, and to first order it could move.
TEST(Timelines, PinsThatHoldTheMechanismLockItSoon) {
  scene::Scene scene;
  scene.model = generate::makeTessellation({});
  scene.timeline = {{{}, Pin{{0, 15}}}};
  const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
  EXPECT_EQ(result.outcome, run::Outcome::Locked);
  EXPECT_THAT(result.reason,
              HasSubstr("no further step keeps the joints closed, with pinned tiles 0, 15"));
  EXPECT_LT(result.trajectory.samples.back().time, 2);  // measured 0.78 s
}

TEST(Timelines, BulletRefusesPins) {
  scene::Scene scene = sheetScene();
  scene.solver.kind = scene::SolverKind::Bullet;
  scene.timeline = {{{}, Pin{{0}}}};
  EXPECT_THROW(deploy::deploy(scene, 0.1, nullptr), InputError);
}

}  // namespace
}  // namespace kirireel
