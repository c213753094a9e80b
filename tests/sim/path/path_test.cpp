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
#include "sim/path/path_choice.h"
#include "sim/run/assembled_state.h"
#include "sim/run/forces.h"

namespace kirireel {
namespace {

using ::testing::Contains;
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

/// A target whose nearest state is so many metres away.
path::TargetFindings roomAt(double error, bool isBlocked) {
  path::TargetFindings atTarget;
  atTarget.nearest.error = atTarget.nearest.restError = error;
  atTarget.isBlocked = isBlocked;
  return atTarget;
}

/// A path, with enough budget for any search here.
path::PathChoice choose(const scene::Scene& scene, const path::TargetFindings& atTarget,
                        const run::TrialObserver& observer, std::vector<run::TrialEnd>& trials) {
  run::SearchBudget budget(1e15);
  return path::choosePath(scene, atTarget, budget, observer, trials);
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
  EXPECT_THAT(tried, SizeIs(2));
  EXPECT_THAT(guided.pathReason, HasSubstr("exact joints arrives"));
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

TEST(Path, PathsAreTriedWithContactsIfBricksOverlap) {
  std::vector<std::string> tried;
  const scene::Scene scene = flatToCap();
  const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr, noteOnce(tried));
  ASSERT_FALSE(tried.empty());
  EXPECT_EQ(tried.front(), "straight pull");
  EXPECT_THAT(tried.back(), HasSubstr("with contacts"));
  EXPECT_THAT(result.pathReason, HasSubstr("with contacts arrives"));
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

/// The end of a path with contacts.
run::TrialEnd endAmongBricks(double error, bool isCollisionFree) {
  run::TrialEnd end;
  end.isCollisionFree = isCollisionFree;
  end.error = error;
  return end;
}

TEST(Path, TakesTheNearestPathIfBricksBlock) {
  const scene::Scene scene = flatToCap();
  // As if the third trial had arrived with compliant joints, and the next six had not. The fourth
  // of these fails by overlaps.
  std::vector<run::TrialEnd> trials(3);
  trials.back().arrives = true;
  for (const auto& [error, isCollisionFree] : {std::pair(0.5, true),
                                               {0.3, true},
                                               {0.2, true},
                                               {0.1, false},
                                               {0.1999, true},
                                               {0.4, true}}) {
    trials.push_back(endAmongBricks(error, isCollisionFree));
  }
  const path::PathChoice choice = choose(scene, roomAt(0, true), {}, trials);
  EXPECT_THAT(trials, SizeIs(9));
  EXPECT_EQ(choice.path.openTime, 0);
  EXPECT_FALSE(choice.path.jointsAreCompliant());
  EXPECT_EQ(choice.reason,
            "guided for 3.75 s, joint ratio 100000 arrives with overlaps; guided for 3.75 s, exact "
            "joints comes nearest with contacts");
}

TEST(Path, ReportsButDoesNotTakeWideOpenJoints) {
  const scene::Scene scene = flatToCap();
  const double tile = model::tileSize(scene.model);
  // As if one trial with contacts had arrived and another had come near, but none with thinner
  // bricks.
  std::vector<run::TrialEnd> trials(13);
  trials.front().arrives = true;
  trials[4] = endAmongBricks(0, true);
  trials[4].arrives = true;
  trials[4].opening = 0.02 * tile;
  trials[5] = endAmongBricks(0.3, true);
  trials[5].opening = 0.009 * tile;
  const path::PathChoice near = choose(scene, roomAt(0, false), {}, trials);
  EXPECT_EQ(near.path.jointRatio, 1e4);
  EXPECT_EQ(near.reason,
            "straight pull arrives with overlaps; no tried path arrives with contacts; guided for "
            "3.75 s, joint ratio 100000 arrives, but joints open by 0.012 m; guided for 3.75 s, "
            "joint ratio 10000 comes nearest with contacts");
  trials[5].arrives = true;
  const path::PathChoice found = choose(scene, roomAt(0, false), {}, trials);
  EXPECT_EQ(found.reason, "guided for 3.75 s, joint ratio 10000 with contacts arrives");
  EXPECT_THAT(trials, SizeIs(13));
}

TEST(Path, KeepsExactJointsIfBricksBlockAnyway) {
  // As above, but all trials have overlaps.
  std::vector<run::TrialEnd> trials(9);
  trials[2].arrives = true;
  const path::PathChoice choice = choose(flatToCap(), roomAt(0, true), {}, trials);
  EXPECT_THAT(trials, SizeIs(9));
  EXPECT_EQ(choice.path.kind, scene::PathKind::Straight);
  EXPECT_EQ(choice.reason, "guided for 3.75 s, joint ratio 100000 arrives with overlaps");
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
  // As if all trials with exact joints had jammed.
  std::vector<run::TrialEnd> trials(4);
  trials.front().arrives = true;
  const path::PathChoice choice = choose(scene, roomAt(0, false), {}, trials);
  EXPECT_EQ(choice.reason, "guided for 3.75 s, joint ratio 100000 with contacts arrives");
  scene::Scene chosen = scene;
  chosen.path = choice.path;
  const run::DeploymentResult result = deploy::deploy(chosen, 1.0 / 60, nullptr);
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
  std::vector<run::TrialEnd> trials;
  scene::Scene bullet = closedToClosed();
  bullet.solver.kind = scene::SolverKind::Bullet;
  EXPECT_EQ(choose(bullet, roomAt(0, false), unasked, trials).reason,
            "the baseline tries no other paths");
  scene::Scene aimless = closedToClosed();
  aimless.model.target.reset();
  EXPECT_EQ(choose(aimless, {}, unasked, trials).reason, "there is no target");
  scene::Scene asked = closedToClosed();
  asked.path.kind = scene::PathKind::Guided;
  EXPECT_EQ(choose(asked, roomAt(0, false), unasked, trials).reason, "requested");
}

TEST(Path, ASearchThatIsEndedEndsTheRun) {
  const run::DeploymentResult result = deploy::deploy(closedToClosed(), 1.0 / 60, nullptr,
                                                      [](const run::SearchNews&) { return false; });
  EXPECT_EQ(result.outcome, run::Outcome::Interrupted);
  EXPECT_THAT(result.trajectory.samples, SizeIs(1));
}

TEST(Path, ATrialThatTheBudgetEndsHasNotFailed) {
  scene::Scene scene = closedToClosed();
  std::vector<run::TrialEnd> trials;
  run::SearchBudget budget(8e6);
  const path::PathChoice choice = path::choosePath(scene, roomAt(0, false), budget, {}, trials);
  ASSERT_FALSE(trials.empty());
  EXPECT_TRUE(std::ranges::any_of(trials, &run::TrialEnd::cutShort));
  EXPECT_EQ(choice.path.kind, scene::PathKind::Straight);
  EXPECT_THAT(choice.reason, HasSubstr("stopped"));
  EXPECT_THAT(choice.reason, HasSubstr(": search budget spent; raise `search_effort`)"));
  // The work is the same for any load of the machine.
  std::vector<run::TrialEnd> again;
  run::SearchBudget same(8e6);
  path::choosePath(scene, roomAt(0, false), same, {}, again);
  ASSERT_EQ(again.size(), trials.size());
  for (std::size_t i = 0; i < trials.size(); ++i) EXPECT_EQ(again[i].work, trials[i].work);
  EXPECT_EQ(same.spent(), budget.spent());
  // The last step may exceed the budget of a trial.
  EXPECT_LT(budget.spent(), 16e6);
}

TEST(Path, WithoutEffortOnlyTheFirstIsTried) {
  scene::Scene scene = closedToClosed();
  scene.path.searchEffort = 0;
  const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
  EXPECT_EQ(result.path.kind, scene::PathKind::Straight);
  EXPECT_EQ(
      result.pathReason,
      "no tried path arrives (others not started: search budget spent; raise `search_effort`)");
  EXPECT_EQ(result.cost.searchLimit, result.cost.searchWork);
}

TEST(Path, ASearchCanBeStopped) {
  std::vector<run::TrialEnd> trials;
  const path::PathChoice choice = choose(
      closedToClosed(), roomAt(0, false), [](const run::SearchNews&) { return false; }, trials);
  EXPECT_EQ(choice.path.kind, scene::PathKind::Straight);
  EXPECT_EQ(choice.reason, "no path was tried");
}

}  // namespace
}  // namespace kirireel
