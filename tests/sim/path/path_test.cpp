#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/deploy/deployment.h"
#include "sim/generate/lattice.h"
#include "sim/generate/shells.h"
#include "sim/model/isometry.h"
#include "sim/path/dynamic_path.h"
#include "sim/run/assembled_state.h"
#include "sim/run/forces.h"

namespace kirireel {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;
using ::testing::StartsWith;

/// From one closed state of the rotating squares to the other: every tile returns to its initial
/// height, so a straight pull must first move away from the target.
scene::Scene closedToClosed() {
  scene::Scene scene;
  generate::TessellationShape shape;
  shape.columns = shape.rows = 3;
  shape.targetAngle = 3.14159265358979323846;
  scene.model = generate::makeTessellation(shape);
  scene.springs.springStiffness = 400;  // distances outweigh rotations
  scene.springs.torqueStiffness = 10;
  return scene;
}

/// Two squares side by side, joined at a corner, whose targets are pulled apart by `distance`.
scene::Scene pulledApart(double distance) {
  scene::Scene scene;
  generate::TessellationShape shape;
  shape.columns = 2;
  shape.rows = 1;
  scene.model = generate::makeTessellation(shape);
  const Vector3 away(0.5 * distance, 0, 0);
  scene.model.target = scene.model.tiles;
  for (Vector3& vertex : (*scene.model.target)[0].vertices) vertex -= away;
  for (Vector3& vertex : (*scene.model.target)[1].vertices) vertex += away;
  return scene;
}

TEST(AssembledError, IsZeroIfTheTargetCloses) {
  EXPECT_LT(run::assembleAtTarget(closedToClosed()).error, 1e-12);  // measured 3e-15
}

TEST(AssembledError, SharesTheDistanceOfTargetsThatDoNotMeet) {
  // At the start both are off by half of the distance. The springs turn them a little about the
  // joint, which is at a corner. This reduces the mean square, but increases the largest distance.
  scene::Scene scene = pulledApart(0.1);
  const run::AssembledState nearest = run::assembleAtTarget(scene);
  EXPECT_NEAR(nearest.error, 0.05, 1e-12);  // measured 4e-17
  EXPECT_GT(nearest.restError, 0.05);
  EXPECT_LT(nearest.restError, 0.06);  // measured 0.053
  const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
  EXPECT_NEAR(result.accuracy.targetErrorEnd, nearest.restError, 1e-4 * nearest.restError);  // 4e-7
}

TEST(AssembledError, OfATargetWithOpenJointsIsNotAboveTheRunsEnd) {
  // Half of the sheet's tiles are 1 m off at the target. The state of rest distributes this in the
  // mean square. The tiles next to the gap are farther off than the others.
  scene::Scene scene;
  scene.model = generate::makeTessellation({});
  model::alignStartToTarget(scene.model);
  for (int i = 8; i < 16; ++i) {
    for (Vector3& vertex : (*scene.model.target)[i].vertices) vertex.x() += 1;
  }
  const run::AssembledState nearest = run::assembleAtTarget(scene);
  EXPECT_LE(nearest.error, nearest.restError);
  // The two halves' vertices at the gap are 1 m apart: one of them stays half of that away.
  EXPECT_GE(nearest.error, 0.5 - 1e-9);
  EXPECT_LT(nearest.error, 0.95 * nearest.restError);  // measured 0.546 of 0.597
  const std::vector<brick::Brick> bricks = brick::makeBricks(scene.model.tiles, scene.brick);
  EXPECT_DOUBLE_EQ(trajectory::targetError(*scene.model.target, bricks, nearest.poses),
                   nearest.error);
  const std::vector<brick::Pivot> pivots = brick::makePivots(scene.model.joints, bricks);
  EXPECT_LT(trajectory::jointGap(pivots, nearest.poses).max, 1e-9);
}

TEST(AssembledError, OfTilesThatDoNotFitHasClosedJoints) {
  // A closed shell is singular. If its tiles do not quite fit, long steps cannot close its joints.
  scene::Scene scene;
  scene.model = generate::makeCubeToSphere({.size = 6});
  std::mt19937 random(1);
  std::normal_distribution<double> error(0, 1e-4 * model::tileSize(scene.model));
  for (std::vector<model::Tile>* tiles : {&scene.model.tiles, &*scene.model.target}) {
    for (model::Tile& tile : *tiles) {
      const Vector3 by(error(random), error(random), error(random));
      for (Vector3& vertex : tile.vertices) vertex += by;
    }
  }
  const run::AssembledState nearest = run::assembleAtTarget(scene);
  const std::vector<brick::Brick> bricks = brick::makeBricks(scene.model.tiles, scene.brick);
  const std::vector<brick::Pivot> pivots = brick::makePivots(scene.model.joints, bricks);
  EXPECT_LT(trajectory::jointGap(pivots, nearest.poses).max, 1e-9);
}

TEST(AssembledError, IsNegativeWithoutTarget) {
  scene::Scene scene = closedToClosed();
  scene.model.target.reset();
  EXPECT_LT(run::assembleAtTarget(scene).error, 0);
}

TEST(Path, AStraightPullIsKeptIfItArrives) {
  scene::Scene scene;
  scene.model = generate::makeTessellation({});
  const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
  EXPECT_EQ(result.path.kind, scene::PathKind::Straight);
  EXPECT_EQ(result.pathReason, "straight pull arrives");
  EXPECT_EQ(result.accuracy.jointOpeningMax, 0);
}

/// The path of a scene whose target closes exactly.
path::DynamicPath choose(const scene::Scene& scene, const run::TrialObserver& observer) {
  run::SearchBudget budget;
  std::optional<run::TrialEnd> straightPull;
  return path::chooseDynamicPath(scene, run::assembleAtTarget(scene), budget, observer,
                                 straightPull);
}

/// Records the tried paths, each once.
run::TrialObserver noteOnce(std::vector<std::string>& tried) {
  return [&tried](const run::SearchNews& news) {
    const bool isPath = news.what != "the state nearest to the target";
    if (isPath && (tried.empty() || tried.back() != news.what)) tried.push_back(news.what);
    return true;
  };
}

TEST(Path, ALockedModelIsGuidedWithExactJoints) {
  scene::Scene straight = closedToClosed();
  straight.path.kind = scene::PathKind::Straight;
  const run::DeploymentResult locked = deploy::deploy(straight, 1.0 / 60, nullptr);
  EXPECT_EQ(locked.outcome, run::Outcome::Locked) << locked.reason;
  EXPECT_THAT(locked.reason, HasSubstr("short of the target: stuck in a local energy minimum"));

  std::vector<std::string> tried;
  const run::DeploymentResult guided =
      deploy::deploy(closedToClosed(), 1.0 / 60, nullptr, noteOnce(tried));
  EXPECT_EQ(guided.outcome, run::Outcome::Settled) << guided.reason;
  EXPECT_EQ(guided.path.kind, scene::PathKind::Guided);
  EXPECT_THAT(tried,
              ElementsAre("straight pull", "motion of each tile, contacts off, exact joints"));
  EXPECT_EQ(guided.pathReason, "springs guide the tiles along a kinematic path");
  EXPECT_EQ(guided.candidates.front().candidate, tried[1]);
  EXPECT_LT(guided.accuracy.targetErrorEnd, 1e-6);  // measured 1e-9
  EXPECT_LT(guided.accuracy.jointGapMax, 1e-10);    // measured 1e-12
  EXPECT_EQ(guided.accuracy.jointOpeningMax, 0);
}

TEST(Path, ATrialThatArrivesArrivesInTheRun) {
  // The steps decide in which local minimum a straight pull ends.
  scene::Scene scene;
  scene.model = generate::makeSphereToSaddle({.columns = 6, .rows = 6});
  scene.brick.thickness = 0.001;
  const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
  EXPECT_EQ(result.outcome, run::Outcome::Settled) << result.reason;
  EXPECT_LT(result.accuracy.targetErrorEnd, 1e-6);  // measured 4.4e-9
}

TEST(Path, CompliantJointsCloseAgain) {
  scene::Scene scene = closedToClosed();
  scene.path.kind = scene::PathKind::Guided;
  double before = 1;
  for (const double ratio : {1e2, 1e4, 1e6}) {
    scene.path.jointRatio = ratio;
    const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
    EXPECT_EQ(result.outcome, run::Outcome::Settled) << result.reason;
    EXPECT_LT(result.accuracy.jointGapEnd, 1e-10);  // measured 1e-13
    EXPECT_GT(result.accuracy.jointOpeningMax, 0);
    EXPECT_LT(result.accuracy.jointOpeningMax, before);  // stiffer joints open less
    before = result.accuracy.jointOpeningMax;
  }
}

TEST(Path, EqualJointRatiosOpenJointsEquallyForAnyMass) {
  const auto openingOf = [](double density) {
    scene::Scene scene = closedToClosed();
    scene.springs = {};
    scene.brick.mass = brick::MassRule::Prism;
    scene.brick.density = density;
    scene.environment.contacts = scene::ContactFilter::None;
    scene.path.kind = scene::PathKind::Guided;
    scene.path.jointRatio = 100;
    const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
    EXPECT_TRUE(result.shortfall.empty()) << result.shortfall;
    return result.accuracy.jointOpeningMax / model::tileSize(scene.model);
  };
  const double opening = openingOf(1);
  EXPECT_GT(opening, 1e-6);
  EXPECT_NEAR(openingOf(1000) / opening, 1, 1e-6);
}

TEST(Path, AKinematicPathHasTheJointRatioOfItsScene) {
  scene::Scene scene = closedToClosed();
  scene.springs = {};
  scene.environment.contacts = scene::ContactFilter::None;
  scene.path.kind = scene::PathKind::Continuation;
  double before = 1;
  for (const double ratio : {1, 100, 10000}) {
    scene.path.jointRatio = ratio;
    const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
    EXPECT_EQ(result.candidates.front().candidate,
              fmt::format("motion of each tile, contacts off, joint ratio {:g}", ratio));
    const double opening = result.candidates.front().opening;
    EXPECT_GT(opening, 0);
    EXPECT_LT(opening, 0.5 * before);
    before = opening;
  }
}

/// A flat sheet that deploys into part of a sphere, whose bricks touch on the path.
scene::Scene flatToCap() {
  scene::Scene scene;
  scene.model = generate::makeSphericalCap({.size = 6});
  scene.environment.contacts = scene::ContactFilter::All;
  return scene;
}

TEST(Path, ThePlannersPathGuidesTilesIfBricksOverlap) {
  std::vector<std::string> tried;
  const scene::Scene scene = flatToCap();
  const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr, noteOnce(tried));
  ASSERT_FALSE(tried.empty());
  EXPECT_EQ(tried.front(), "straight pull");
  EXPECT_THAT(result.pathReason, StartsWith("springs guide the tiles along a kinematic path with"));
  EXPECT_LT(result.accuracy.targetErrorEnd, 1e-6);  // measured 2e-10
  // In metres; a tile is 0.6. Measured 1.5e-5.
  EXPECT_LT(result.accuracy.penetrationOutsidePivotsMax, 1e-4 * model::tileSize(scene.model));
}

TEST(Path, OpeningFirstSeparatesFlushBricks) {
  scene::Scene scene = flatToCap();
  scene.path = {.kind = scene::PathKind::Guided, .openTime = 1, .guideTime = 2};
  const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
  EXPECT_EQ(result.outcome, run::Outcome::Settled) << result.reason;
  EXPECT_LT(result.accuracy.targetErrorEnd, 1e-6);  // measured 7.4e-10
  EXPECT_LT(result.accuracy.penetrationOutsidePivotsMax, 1e-4 * model::tileSize(scene.model));
}

TEST(Path, OverlapsOfJoinedBricksAreAllowedIfTheseCannotTouch) {
  scene::Scene scene = flatToCap();
  scene.environment.contacts = scene::ContactFilter::Unjoined;
  const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
  EXPECT_EQ(result.pathReason, "straight pull arrives");
  EXPECT_LT(result.accuracy.targetErrorEnd, 1e-6);  // measured 3e-11
  EXPECT_GT(result.accuracy.penetrationGrownMax, 1e-3 * model::tileSize(scene.model));
}

/// A cube of flush bricks, which exact joints can hardly leave.
scene::Scene cubeToSphere() {
  scene::Scene scene;
  scene.model = generate::makeCubeToSphere({.size = 4});
  scene.environment.contacts = scene::ContactFilter::All;
  return scene;
}

TEST(Path, TakesCompliantJointsIfBricksJam) {
  const scene::Scene scene = cubeToSphere();
  const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
  EXPECT_TRUE(result.path.jointsAreCompliant());
  const double tile = model::tileSize(scene.model);
  EXPECT_EQ(result.outcome, run::Outcome::Settled) << result.reason;
  // Measured 2.5e-14, 9.0e-15, 3.6e-4 and 1.3e-5.
  EXPECT_LT(result.accuracy.targetErrorEnd, 1e-6 * tile);
  EXPECT_LT(result.accuracy.jointGapEnd, 1e-10 * tile);
  EXPECT_LT(result.accuracy.jointOpeningMax, 1e-2 * tile);
  EXPECT_LT(result.accuracy.penetrationGrownMax, 1e-4 * tile);
  EXPECT_EQ(result.cost.took.unconverged, 0);
}

/// Two squares side by side, 0.1 apart, that are joined at their right corners: closing the joint
/// pushes one into the other.
scene::Scene joinedThroughEachOther() {
  scene::Scene scene = pulledApart(0);
  for (Vector3& vertex : scene.model.tiles[1].vertices) vertex.x() += 0.1;
  scene.model.joints = {{.a = {0, 1}, .b = {1, 1}}};
  return scene;
}

TEST(Path, BlockedBricksKeepCompliantJointsOpen) {
  scene::Scene scene = joinedThroughEachOther();
  // On the straight path they finally pass each other.
  for (Vector3& vertex : scene.model.tiles[1].vertices) vertex.y() += 0.05;
  scene.environment.contacts = scene::ContactFilter::All;
  scene.springs.frequency = 1.6;
  scene.path = {.kind = scene::PathKind::Guided, .guideTime = 1, .jointRatio = 50};
  const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
  EXPECT_THAT(result.pathReason, HasSubstr("contacts prevent closed joints"));
  // Of a tile of 1 m. Measured 8.0e-5 after steps, 1.42e-4 between samples, and 1.9.
  EXPECT_LT(result.accuracy.penetrationGrownMax, 1.5e-4);
  EXPECT_GT(result.accuracy.jointGapEnd, 1e-10);
}

TEST(Path, OverlapsByClosingTheStartCount) {
  scene::Scene scene = joinedThroughEachOther();
  scene.path.kind = scene::PathKind::Straight;
  scene.environment.contacts = scene::ContactFilter::All;
  const run::DeploymentResult closed = deploy::deploy(scene, 1.0 / 60, nullptr);
  EXPECT_THAT(closed.pathReason,
              HasSubstr("closing the joints at the start makes bricks overlap by 0.67 m"));
  EXPECT_GT(closed.accuracy.penetrationGrownMax, 0.01);  // measured 0.02
}

TEST(Path, ClosingTheStartReportsOverlaps) {
  scene::Scene scene = joinedThroughEachOther();
  scene.path.kind = scene::PathKind::Continuation;
  scene.environment.contacts = scene::ContactFilter::Auto;
  const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
  EXPECT_THAT(result.warnings,
              Contains(StartsWith("the joints are open by up to 1.1 m at the start. Closing them "
                                  "makes bricks overlap by 1 m (1 tiles)")));
  scene.environment.contacts = scene::ContactFilter::None;
  EXPECT_THAT(deploy::deploy(scene, 1.0 / 60, nullptr).warnings,
              Not(Contains(StartsWith("closing"))));
}

TEST(Path, CompliantJointsAreNotClosedFirst) {
  scene::Scene scene = joinedThroughEachOther();
  scene.path = {.kind = scene::PathKind::Guided, .jointRatio = 1e2};
  const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
  EXPECT_EQ(result.accuracy.assemblyMove, 0);
  EXPECT_GT(result.accuracy.jointOpeningMax, 0.5);  // measured 0.76
  EXPECT_LT(result.accuracy.jointGapEnd, 1e-10);    // measured 1.0e-12
}

/// Moves every vertex by up to `size` along x, by `move` of -1 to 1.
void disturb(std::vector<model::Tile>& tiles, double size,
             const std::function<double(const Vector3&)>& move) {
  for (model::Tile& tile : tiles) {
    for (Vector3& vertex : tile.vertices) vertex.x() += size * move(vertex);
  }
}

TEST(Path, JointsAreCompliantIfTilesFitInNoOpenState) {
  scene::Scene scene;
  scene.model = generate::makeTessellation({});
  scene.model.target.reset();
  scene.actuation.drive = scene::Drive::Expansion;
  EXPECT_EQ(deploy::deploy(scene, 1.0 / 60, nullptr).pathReason, "there is no target");
  // Points where tiles meet move together: the start still fits. But lengths that differ in the
  // sixth digit make the redundant joints of the sheet a truss.
  disturb(scene.model.tiles, 5e-7,
          [](const Vector3& point) { return std::sin(37 * point.x() + 91 * point.y()); });
  const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
  EXPECT_THAT(result.pathReason, HasSubstr("exact joints jam"));
  EXPECT_EQ(result.outcome, run::Outcome::Settled) << result.reason;
  EXPECT_GT(result.accuracy.jointOpeningMax, 0);
  EXPECT_LT(result.accuracy.jointOpeningMax, 1e-2);  // of a tile of 1 m
  EXPECT_LT(10 * result.cost.took.halved, result.cost.took.steps);
}

TEST(Path, TilesWithASmallMisfitStillDeploy) {
  for (const double size : {1e-7, 1e-5, 1e-3}) {
    scene::Scene scene;
    scene.model = generate::makeTessellation({});
    std::mt19937 generator(1);
    const auto random = [&](const Vector3&) {
      return static_cast<double>(generator()) / 2147483648.0 - 1.0;
    };
    disturb(scene.model.tiles, size, random);
    disturb(*scene.model.target, size, random);
    const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
    EXPECT_THAT(result.pathReason, HasSubstr("do not fit each other exactly"));
    EXPECT_EQ(result.outcome, run::Outcome::Settled) << result.reason;
    EXPECT_LT(result.accuracy.targetErrorEnd, 10 * size);  // measured 4.3 times
    EXPECT_LT(result.accuracy.jointGapEnd, 2 * size);      // measured 1.0 times
    EXPECT_LT(result.accuracy.jointGapMax, 1e-3 + size);   // measured 3.7e-4, 1.0e-3
    EXPECT_LT(10 * result.cost.took.halved, result.cost.took.steps);
  }
}

TEST(Path, TriesNothingWithoutAlternatives) {
  const run::TrialObserver unasked = [](const run::SearchNews& news) {
    ADD_FAILURE() << news.what;
    return true;
  };
  scene::Scene bullet = closedToClosed();
  bullet.solver.kind = scene::SolverKind::Bullet;
  EXPECT_EQ(choose(bullet, unasked).reason, "the baseline tries no other paths");
  scene::Scene aimless = closedToClosed();
  aimless.model.target.reset();
  EXPECT_EQ(choose(aimless, unasked).reason, "there is no target");
  scene::Scene asked = closedToClosed();
  asked.path.kind = scene::PathKind::Guided;
  EXPECT_EQ(choose(asked, unasked).reason, "requested");
}

TEST(Path, ASearchThatIsEndedEndsTheRun) {
  const run::DeploymentResult result = deploy::deploy(closedToClosed(), 1.0 / 60, nullptr,
                                                      [](const run::SearchNews&) { return false; });
  EXPECT_EQ(result.outcome, run::Outcome::Interrupted);
  EXPECT_THAT(result.trajectory.samples, SizeIs(1));
}

TEST(Path, WithoutEffortOnlyTheFirstIsTried) {
  scene::Scene scene = cubeToSphere();
  scene.path.searchEffort = 0;
  const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
  EXPECT_THAT(result.candidates, SizeIs(1));
  EXPECT_EQ(result.cost.searchLimit, result.cost.searchWork);
  EXPECT_THAT(result.reason, HasSubstr("Raise `search_effort`"));
}

TEST(Path, ASearchCanBeStopped) {
  const path::DynamicPath choice =
      choose(closedToClosed(), [](const run::SearchNews&) { return false; });
  EXPECT_EQ(choice.path.kind, scene::PathKind::Straight);
  EXPECT_EQ(choice.reason, "the search was interrupted");
}

/// The same motion in any place: a turned scene has the turned path.
TEST(Path, TheGuideTurnsWithTheScene) {
  const scene::Scene scene = closedToClosed();
  const Quaternion turn = rotationFromVector(Vector3(0.3, 1.1, -0.4));
  scene::Scene turned = scene;
  for (auto* tiles : {&turned.model.tiles, &*turned.model.target}) {
    for (model::Tile& tile : *tiles) {
      for (Vector3& vertex : tile.vertices) vertex = turn * vertex;
    }
  }
  const auto own = choose(scene, {}), other = choose(turned, {});
  const run::MechanismPath& a = own.guide.path->path;
  const run::MechanismPath& b = other.guide.path->path;
  for (const double share : {0.0, 0.3, 0.7, 1.0}) {
    const Poses from = a.at(share), to = b.at(share);
    for (std::size_t i = 0; i < from.size(); ++i) {
      // Measured 2e-15.
      EXPECT_LT((turn * from[i].position - to[i].position).norm(), 1e-12);
    }
  }
}

}  // namespace
}  // namespace kirireel
