#include "sim/deploy/deployment.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/formats/read_model.h"
#include "sim/generate/lattice.h"
#include "sim/run/state_interpolator.h"
#include "tests/support/refusal.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

/// A 3 x 3 sheet without contacts: the fastest complete run.
scene::Scene smallScene() {
  scene::Scene scene;
  generate::TessellationShape shape;
  shape.columns = shape.rows = 3;
  scene.model = generate::makeTessellation(shape);
  scene.environment.contacts = scene::ContactFilter::None;
  return scene;
}

scene::Scene shippedScene(const char* name = "tessellation_4x4") {
  scene::Scene scene;
  std::vector<std::string> warnings;
  scene.model = formats::readModelFolder(std::filesystem::path(KIRIREEL_SOURCE_DIR) / "data" / name,
                                         warnings);
  return scene;
}

TEST(Deploy, TheShippedSheetSettlesAtItsTarget) {
  const run::DeploymentResult result = deploy::deploy(shippedScene(), 1.0 / 60, nullptr);
  EXPECT_EQ(result.outcome, run::Outcome::Settled) << result.reason;
  EXPECT_THAT(result.reason, HasSubstr("from the target"));
  EXPECT_LT(result.accuracy.jointGapMax, 1e-10);    // measured 1e-12
  EXPECT_LT(result.accuracy.targetErrorEnd, 1e-3);  // measured 7e-7
  EXPECT_LT(result.accuracy.penetrationMax, 1e-6);  // measured 1e-13
  EXPECT_EQ(result.cost.took.unconverged, 0);
  EXPECT_TRUE(result.needs.planar.on);
}

/// Joints allow a rotation by the square root of their gap there.
TEST(Deploy, AClosedSingularTargetIsReached) {
  for (const scene::ContactFilter contacts :
       {scene::ContactFilter::None, scene::ContactFilter::All}) {
    scene::Scene scene = shippedScene("heart");
    scene.environment.contacts = contacts;
    const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
    EXPECT_EQ(result.outcome, run::Outcome::Settled) << result.reason;
    EXPECT_LT(result.accuracy.targetErrorEnd, 1e-6);  // measured 5e-13
  }
}

TEST(Deploy, BulletSettlesItToo) {
  scene::Scene scene = shippedScene();
  scene.solver.kind = scene::SolverKind::Bullet;
  scene.environment.contacts = scene::ContactFilter::None;
  const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
  EXPECT_EQ(result.outcome, run::Outcome::Settled) << result.reason;
  EXPECT_LT(result.accuracy.jointGapMax, 1e-3);     // measured 9e-5
  EXPECT_LT(result.accuracy.targetErrorEnd, 1e-2);  // measured 1e-6
}

TEST(Deploy, AccuracyDescribesTheSamples) {
  const run::DeploymentResult result = deploy::deploy(smallScene(), 1.0 / 60, nullptr);
  const std::vector<trajectory::Sample>& samples = result.trajectory.samples;
  const run::Accuracy& accuracy = result.accuracy;
  EXPECT_EQ(accuracy.targetErrorStart, samples.front().targetError);
  EXPECT_EQ(accuracy.targetErrorEnd, samples.back().targetError);
  EXPECT_EQ(accuracy.jointGapEnd, samples.back().jointGap);
  EXPECT_LE(accuracy.targetErrorMin, samples.back().targetError);
  EXPECT_LE(accuracy.jointGapMean, accuracy.jointGapMax);
  EXPECT_LE(samples.back().jointGap, accuracy.jointGapMax);
  EXPECT_LT(accuracy.rigidBound, 1e-14);
  EXPECT_EQ(result.trajectory.bricks.size(), 9U);
  for (const trajectory::Sample& sample : samples) EXPECT_EQ(sample.poses.size(), 9U);
  EXPECT_GT(result.cost.cpuSeconds, 0);
}

/// The end of a run and all its figures, except counts of samples, as numbers.
std::vector<double> figuresOf(run::DeploymentResult& result) {
  StateTape tape;
  for (const auto largest : {&run::Accuracy::jointGapMax, &run::Accuracy::jointOpeningMax,
                             &run::Accuracy::targetErrorMin, &run::Accuracy::penetrationMax,
                             &run::Accuracy::penetrationOutsidePivotsMax}) {
    std::erase_if(result.trajectory.figureStates, [&](const trajectory::FigureState& state) {
      return state.figure == nameOfField(largest);
    });
    result.accuracy.*largest = 0;
  }
  tape.transfer(result.outcome, result.reason, result.accuracy, result.assembledError, result.cost,
                result.path.kind, result.trajectory.events, result.trajectory.figureStates,
                result.trajectory.samples.back().poses);
  return tape.numbers();
}

// Metamorphic: the rate of samples changes neither steps nor figures, except counts of samples.
TEST(Deploy, OnlySamplesDependOnTheirRate) {
  scene::Scene scene = smallScene();
  scene.environment.contacts = scene::ContactFilter::All;
  scene.environment.gravity = Vector3(0, 0, -9.81);
  run::DeploymentResult reference = deploy::deploy(scene, 1.0 / 60, nullptr);
  const std::vector<double> figures = figuresOf(reference);
  std::vector<double> firstTimes;
  for (const double rate : {1.0, 7.0, 24.0, 25.0, 30.0, 50.0, 240.0, 1000.0}) {
    run::DeploymentResult result = deploy::deploy(scene, 1 / rate, nullptr);
    EXPECT_EQ(figuresOf(result), figures) << rate;
    std::vector<double> times;
    for (const trajectory::Sample& sample : result.trajectory.samples) {
      for (const trajectory::StepRecord& step : sample.steps) times.push_back(step.time);
    }
    if (firstTimes.empty()) firstTimes = times;
    EXPECT_EQ(times, firstTimes) << rate;
    EXPECT_EQ(times.front(), 0);
    EXPECT_EQ(std::ranges::adjacent_find(times, std::greater_equal<>()), times.end());
    EXPECT_EQ(times.back(), result.trajectory.samples.back().time);
  }
}

TEST(Deploy, SamplesAreEquallySpacedUpToTheLast) {
  for (const double rate : {60.0, 25.0, 7.0, 1000.0}) {
    scene::Scene scene = smallScene();
    scene.stop.duration = 0.5;
    const std::vector<trajectory::Sample> samples =
        deploy::deploy(scene, 1 / rate, nullptr).trajectory.samples;
    ASSERT_EQ(samples.size(), 1 + static_cast<std::size_t>(std::ceil(0.5 * rate))) << rate;
    for (std::size_t i = 0; i + 1 < samples.size(); ++i) {
      EXPECT_NEAR(samples[i].time, static_cast<double>(i) / rate, 1e-13);
    }
    EXPECT_NEAR(samples.back().time, 0.5, 1e-13);
  }
}

TEST(Deploy, SamplesBetweenStepsHaveClosedJoints) {
  const std::vector<trajectory::Sample> steps =
      deploy::deploy(smallScene(), 1.0 / 240, nullptr).trajectory.samples;
  const std::vector<trajectory::Sample> samples =
      deploy::deploy(smallScene(), 1.0 / 700, nullptr).trajectory.samples;
  for (const trajectory::Sample& sample : samples) {
    EXPECT_LT(sample.jointGap, 1e-11) << sample.time;  // measured 4e-13
    const auto after =
        std::min(steps.size() - 1, static_cast<std::size_t>(std::ceil(sample.time * 240 - 1e-6)));
    const auto before = std::max<std::size_t>(after, 1) - 1;
    const double share = sample.time * 240 - static_cast<double>(before);
    for (std::size_t i = 0; i < sample.poses.size(); ++i) {
      const Vector3& from = steps[before].poses[i].position;
      const Vector3 move = steps[after].poses[i].position - from;
      // Closing the joints moves bricks little off the straight line between two steps.
      const double aside = (sample.poses[i].position - from - share * move).norm();
      EXPECT_LT(aside, 5e-4) << sample.time;  // edges of 1 m; measured 1.8e-4
    }
  }
}

TEST(Deploy, EachFigureOfAStateCanBeComputedFromIt) {
  scene::Scene scene = smallScene();
  scene.model.target->front().vertices.front().x() += 0.1;
  const run::DeploymentResult result = deploy::deploy(scene, 0.1, nullptr);
  const std::vector<brick::Brick>& bricks = result.trajectory.bricks;
  const std::vector<brick::Pivot> pivots = brick::makePivots(scene.model.joints, bricks);
  const auto poses = [&](const char* name) {
    const auto& states = result.trajectory.figureStates;
    const auto state = std::ranges::find(states, name, &trajectory::FigureState::figure);
    EXPECT_NE(state, states.end()) << name;
    return state->poses;
  };
  const run::Accuracy& accuracy = result.accuracy;
  EXPECT_EQ(trajectory::jointGap(pivots, poses("joint_gap_max")).max, accuracy.jointGapMax);
  EXPECT_EQ(trajectory::deepestPenetration(bricks, poses("penetration_max")).depth,
            accuracy.penetrationMax);
  const std::vector<model::Tile>& target = *scene.model.target;
  EXPECT_EQ(trajectory::targetError(target, bricks, poses("target_error_min")),
            accuracy.targetErrorMin);
  EXPECT_EQ(trajectory::targetError(target, bricks, poses("assembled_error")),
            result.assembledError);
  EXPECT_LE(result.assembledError, accuracy.targetErrorEnd);
}

// Bricks that pass through each other.
scene::Scene overlappingScene(scene::PathKind kind) {
  scene::Scene scene = smallScene();
  scene.path.kind = kind;
  scene.environment.contacts = scene::ContactFilter::None;
  scene.model.tiles.push_back({{{0.1, 0.1, -0.3}, {0.9, 0.2, 0.4}, {0.5, 0.7, 0.3}}});
  scene.model.target->push_back(scene.model.tiles.back());
  scene.solver.planar = false;
  return scene;
}

// On a path of few states and in a run of long steps, at any frame rate.
TEST(Deploy, LargestFiguresCoverSamplesAndMomentsBetween) {
  for (const scene::PathKind kind : {scene::PathKind::Continuation, scene::PathKind::Straight}) {
    for (const double interval : {1.0 / 240, 1.0 / 24, 1.0 / 7}) {
      const run::DeploymentResult result =
          deploy::deploy(overlappingScene(kind), interval, nullptr);
      const std::vector<trajectory::Sample>& samples = result.trajectory.samples;
      run::StateInterpolator interpolator(result.trajectory);
      double deepest = 0, gap = 0;
      for (std::size_t k = 0; k < samples.size(); ++k) {
        deepest = std::max(deepest, samples[k].penetration);
        gap = std::max(gap, samples[k].jointGap);
        if (k == 0) continue;
        for (const Poses& poses :
             interpolator.momentsBetween(samples[k - 1].poses, samples[k].poses)) {
          deepest = std::max(deepest,
                             trajectory::deepestPenetration(result.trajectory.bricks, poses).depth);
        }
      }
      EXPECT_GT(deepest, 0.01);
      EXPECT_GE(result.accuracy.penetrationMax, deepest);
      EXPECT_LE(result.accuracy.penetrationMax, 1.1 * deepest + 1e-6) << interval;
      EXPECT_GE(result.accuracy.jointGapMax, gap);
    }
  }
}

// The figure that decides the exit code is that of the path.
TEST(Deploy, HowFarOverlapsGrowDoesNotDependOnTheFrameRate) {
  for (const scene::PathKind kind : {scene::PathKind::Continuation, scene::PathKind::Straight}) {
    const scene::Scene scene = overlappingScene(kind);
    const run::DeploymentResult often = deploy::deploy(scene, 1.0 / 240, nullptr);
    double deepest = 0;
    const std::vector<brick::Brick>& bricks = often.trajectory.bricks;
    trajectory::PenetrationMeter meter(bricks, brick::makePivots(scene.model.joints, bricks),
                                       scene.environment.pivotZone,
                                       brick::startPoses(scene.model.tiles, bricks),
                                       trajectory::kRoundingOverlap * model::tileSize(scene.model));
    for (const trajectory::Sample& sample : often.trajectory.samples) {
      deepest = std::max(deepest, meter.at(sample.poses).grown);
    }
    EXPECT_GT(deepest, 0.01);
    EXPECT_NEAR(often.accuracy.penetrationGrownMax / deepest, 1, 0.02);
    for (const double interval : {1.0 / 60, 1.0 / 7}) {
      EXPECT_EQ(deploy::deploy(scene, interval, nullptr).accuracy.penetrationGrownMax,
                often.accuracy.penetrationGrownMax);
    }
  }
}

TEST(Deploy, ARunThatDivergesEndsWithItsLastStepInBounds) {
  scene::Scene scene = smallScene();
  scene.solver.kind = scene::SolverKind::Bullet;
  scene.springs.springStiffness = scene.springs.torqueStiffness = 1e9;
  const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
  ASSERT_EQ(result.outcome, run::Outcome::Diverged);
  const trajectory::Sample& last = result.trajectory.samples.back();
  EXPECT_EQ(last.time, result.trajectory.events.back().time);
  EXPECT_EQ(last.targetError, result.accuracy.targetErrorEnd);
  for (const Pose& pose : last.poses) EXPECT_TRUE(pose.position.allFinite());
}

TEST(Deploy, RunsForItsDuration) {
  scene::Scene scene = smallScene();
  scene.stop.duration = 0.2;
  const run::DeploymentResult result = deploy::deploy(scene, 0.05, nullptr);
  EXPECT_EQ(result.outcome, run::Outcome::OutOfTime);
  EXPECT_THAT(result.reason, StartsWith("still moving after 0.2 s, at "));
  EXPECT_NEAR(result.trajectory.samples.back().time, 0.2, 1e-12);
}

TEST(Deploy, AnUnreachableTargetIsReachedAsNearAsJointsAllow) {
  scene::Scene scene = smallScene();
  for (model::Tile& tile : *scene.model.target) {
    for (Vector3& vertex : tile.vertices) vertex *= 1.2;  // the tiles do not grow with it
  }
  const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
  // A run that ends half a tile away has not arrived.
  EXPECT_EQ(result.outcome, run::Outcome::Locked);
  EXPECT_THAT(result.reason, HasSubstr("no nearer state with closed joints was found"));
  EXPECT_GT(result.accuracy.targetErrorEnd, result.accuracy.rigidBound);
  EXPECT_NEAR(result.accuracy.targetErrorEnd / result.assembledError, 1, 1e-3);  // measured 1e-5
}

TEST(Deploy, WithoutTargetItSettlesAtTheStart) {
  scene::Scene scene = smallScene();
  scene.model.target.reset();
  const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
  EXPECT_EQ(result.outcome, run::Outcome::Settled);
  EXPECT_EQ(result.reason, "came to rest; there is no target");
  EXPECT_EQ(result.accuracy.targetErrorEnd, 0);
}

TEST(Deploy, TheObserverSeesEverySampleAndCanEndTheRun) {
  std::size_t seen = 0;
  const run::DeploymentResult result =
      deploy::deploy(smallScene(), 1.0 / 60, [&](const trajectory::Sample&) { return ++seen < 5; });
  EXPECT_EQ(result.outcome, run::Outcome::Interrupted);
  EXPECT_EQ(result.reason, "ended early by the caller");
  EXPECT_EQ(seen, 5U);
  EXPECT_EQ(result.trajectory.samples.size(), 5U);
}

TEST(Deploy, ExplicitJointsUnderAbsurdStiffnessDiverge) {
  scene::Scene scene = smallScene();
  scene.solver.kind = scene::SolverKind::Bullet;
  scene.springs.springStiffness = scene.springs.torqueStiffness = 1e9;
  const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
  EXPECT_EQ(result.outcome, run::Outcome::Diverged);
  EXPECT_THAT(result.reason, HasSubstr("a brick left all bounds at "));
  EXPECT_THAT(result.reason, HasSubstr(". Try a shorter `timestep` or more damping"));
}

TEST(Deploy, ExactJointsAreStableAtTheSameStiffness) {
  scene::Scene scene = smallScene();
  scene.springs.springStiffness = scene.springs.torqueStiffness = 1e9;
  const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
  EXPECT_EQ(result.outcome, run::Outcome::Settled) << result.reason;
  EXPECT_LT(result.accuracy.jointGapMax, 1e-10);  // measured 4e-13
}

TEST(Deploy, ClosesAnOpenStartAndReportsHowFar) {
  scene::Scene scene = smallScene();
  for (Vector3& vertex : scene.model.tiles[4].vertices) vertex.x() += 1e-3;
  const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
  EXPECT_GT(result.accuracy.assemblyMove, 1e-4);
  EXPECT_LT(result.accuracy.assemblyMove, 2e-3);
  EXPECT_LT(result.trajectory.samples.front().jointGap, 1e-10);
  EXPECT_EQ(deploy::deploy(smallScene(), 1.0 / 60, nullptr).accuracy.assemblyMove, 0);
}

std::string errorOf(const scene::Scene& scene, double interval) {
  return test::refusalOf([&] { deploy::deploy(scene, interval, nullptr); });
}

TEST(Deploy, RefusesInvalidTimes) {
  EXPECT_EQ(errorOf(smallScene(), 0),
            "the time between samples is 0 s, but must be finite and > 0");
  scene::Scene scene = smallScene();
  scene.solver.timestep = -0.5;
  EXPECT_EQ(errorOf(scene, 0.1),
            "error: timestep: '-0.5' is not allowed; give a number from 1e-07 to 1");
  scene = smallScene();
  scene.stop.duration = NAN;
  EXPECT_EQ(errorOf(scene, 0.1),
            "error: duration: 'nan' is not allowed; give a number from 1e-06 to 1e+06");
}

TEST(Deploy, RefusesDampingOfOne) {
  scene::Scene scene = smallScene();
  scene.environment.linearDamping = 1;
  EXPECT_EQ(errorOf(scene, 0.1),
            "error: linear_damping: '1' is not allowed; give a number from 0 to less than 1");
  scene = smallScene();
  scene.environment.angularDamping = -0.1;
  EXPECT_EQ(errorOf(scene, 0.1),
            "error: angular_damping: '-0.1' is not allowed; give a number from 0 to less than 1");
}

TEST(Deploy, RefusesAModelWithoutTiles) {
  EXPECT_EQ(errorOf({}, 0.1), "the model has no tiles; add one to vertices.txt");
}

/// Three triangles round a hole, each joined to both others: a truss in the plane.
scene::Scene truss() {
  scene::Scene scene = scene::openScene();
  scene.model.tiles = {{{{0, 0, 0}, {0.5, -0.8, 0}, {1, 0, 0}}},
                       {{{1, 0, 0}, {1.3, 0.8, 0}, {0.5, 0.866, 0}}},
                       {{{0.5, 0.866, 0}, {-0.3, 0.8, 0}, {0, 0, 0}}}};
  scene.model.joints = {
      {.a = {0, 2}, .b = {1, 0}}, {.a = {1, 2}, .b = {2, 0}}, {.a = {2, 2}, .b = {0, 0}}};
  return scene;
}

TEST(Deploy, RefusesAModelThatNothingCanDrive) {
  scene::Scene single = truss();
  single.model.tiles.resize(1);
  single.model.joints.clear();
  // Ball joints let the truss fold out of its plane.
  EXPECT_THAT(
      [] { deploy::deploy(truss(), 0.1, nullptr); },
      testing::ThrowsMessage<InputError>(
          "error: this sheet has no motion in its plane, but 3 out of it. Set a target, "
          "a load or springs at folds (`target`, `gravity`, `hinge_stiffness`, [[timeline]] "
          "or [[velocity]] in scene.toml)"));
  scene::Scene inPlane = truss();
  inPlane.solver.planar = true;
  for (scene::Scene scene : {inPlane, single}) {
    EXPECT_THAT(
        [&] { deploy::deploy(scene, 0.1, nullptr); },
        testing::ThrowsMessage<InputError>(
            "error: nothing can drive this model. It has no target, and its joints allow only "
            "rigid motions of the whole sheet. Set `target`, other joints (`joints_file`), or a "
            "load (`gravity`, [[timeline]] or [[velocity]] in scene.toml)"));
    scene.solver.planar.reset();
    scene::Scene falling = scene;
    falling.environment.gravity = {0, 0, -9.81};
    falling.stop.duration = 0.1;
    EXPECT_NO_THROW(deploy::deploy(falling, 0.1, nullptr));
  }
  // A sheet that is at full extension could go back.
  scene::Scene extended = truss();
  extended.model.joints.pop_back();
  EXPECT_NO_THROW(deploy::deploy(extended, 0.1, nullptr));
}

// A locked sheet leaves its plane in every kind of run, if a load moves it.
TEST(Deploy, LeavesAPlaneThatLocksTheSheet) {
  scene::Scene scene = truss();
  scene.stop.duration = 0.1;
  scene.path.kind = scene::PathKind::Dynamic;
  EXPECT_THAT(errorOf(scene, 0.1),
              testing::HasSubstr("no motion in its plane, but 3 out of it. Set"));
  scene.velocities = {{.tiles = {}, .linear = {1, 0, 0}, .angular = {}, .where = {}}};
  const run::DeploymentResult inSpace = deploy::deploy(scene, 0.1, nullptr);
  EXPECT_FALSE(inSpace.needs.planar.on);
  EXPECT_EQ(inSpace.needs.planar.reason, "no motion in its plane, 3 out of it");
  scene.solver.planar = true;
  EXPECT_TRUE(deploy::deploy(scene, 0.1, nullptr).needs.planar.on);
  // Without its last joint the truss is a chain that moves in its plane.
  scene.solver.planar.reset();
  scene.model.joints.pop_back();
  EXPECT_TRUE(deploy::deploy(scene, 0.1, nullptr).needs.planar.on);
}

TEST(Outcome, HasAName) {
  EXPECT_EQ(run::toString(run::Outcome::Settled), "settled");
  EXPECT_EQ(run::toString(run::Outcome::Locked), "locked");
  EXPECT_EQ(run::toString(run::Outcome::OutOfTime), "out_of_time");
  EXPECT_EQ(run::toString(run::Outcome::Diverged), "diverged");
  EXPECT_EQ(run::toString(run::Outcome::Interrupted), "interrupted");
}

}  // namespace
}  // namespace kirireel
