#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/deploy/deployment.h"
#include "sim/generate/lattice.h"
#include "sim/model/isometry.h"
#include "sim/path/target_warnings.h"
#include "sim/scene/scene_needs.h"

namespace kirireel {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

scene::Scene sheet() {
  scene::Scene scene;
  scene.model = generate::makeTessellation({});
  model::alignStartToTarget(scene.model);
  return scene;
}

/// The sheet with the targets of its upper half moved away.
scene::Scene openTargetSheet(double distance) {
  scene::Scene scene = sheet();
  for (int i = 8; i < 16; ++i) {
    for (Vector3& vertex : (*scene.model.target)[i].vertices) vertex.x() += distance;
  }
  return scene;
}

/// The sheet with its target seen in a mirror, face down.
scene::Scene mirroredSheet() {
  scene::Scene scene;
  scene.model = generate::makeTessellation({});
  for (model::Tile& tile : *scene.model.target) {
    for (Vector3& vertex : tile.vertices) vertex.x() = -vertex.x();
  }
  model::alignStartToTarget(scene.model);
  return scene;
}

TEST(TargetWarnings, NoneIfTheTargetFits) {
  EXPECT_THAT(path::targetWarnings(sheet()), IsEmpty());
  EXPECT_EQ(path::reachWarning(sheet(), run::assembleAtTarget(sheet())), "");
}

TEST(TargetWarnings, ATargetWithOpenJointsIsReported) {
  EXPECT_THAT(
      path::targetWarnings(openTargetSheet(1)),
      ElementsAre("the target opens its joints by 1 m (1 tiles); closed joints cannot reach it"));
  EXPECT_THAT(path::targetWarnings(openTargetSheet(1e-4)), IsEmpty());
}

TEST(TargetWarnings, ATurnedOverTargetIsReportedAndLeavesThePlane) {
  const scene::Scene scene = mirroredSheet();
  EXPECT_THAT(
      path::targetWarnings(scene),
      ElementsAre("the target is turned over: 16 of 16 tiles face the opposite side there"));
  EXPECT_EQ(scene::sceneNeeds(scene).planar.reason, "tiles are turned over at the target");
  EXPECT_FALSE(scene::sceneNeeds(scene).planar.on);
}

TEST(TargetWarnings, ATurnedOverSheetArrivesThroughSpace) {
  const run::DeploymentResult result = deploy::deploy(mirroredSheet(), 1.0 / 60, nullptr);
  EXPECT_EQ(result.outcome, run::Outcome::Settled) << result.reason << result.pathReason;
  EXPECT_LT(result.accuracy.targetErrorEnd, 1e-6);  // measured 1.9e-9
}

TEST(TargetWarnings, TilesOfOtherShapesAreUnreachable) {
  scene::Scene scene = sheet();
  for (model::Tile& tile : *scene.model.target) {
    for (Vector3& vertex : tile.vertices) vertex *= 1.5;
  }
  // A square's corner lies sqrt(1/2) from its middle.
  EXPECT_THAT(path::targetWarnings(scene),
              Contains("the target is out of reach: its tiles have other shapes. Rigid tiles "
                       "cannot come nearer than 0.354 m (0.35 tiles)"));
}

TEST(TargetWarnings, AMovedStartIsReportedIfItsPositionMatters) {
  scene::Scene scene = sheet();
  scene.alignment.moved = 2;
  EXPECT_THAT(path::targetWarnings(scene), IsEmpty());
  scene.environment.ground = scene::Ground{};
  EXPECT_THAT(path::targetWarnings(scene),
              ElementsAre(StartsWith("the target was moved by up to 2 m")));
}

TEST(TargetWarnings, ARunToATargetWithOpenJointsWarnsAtItsStartAndDoesNotArrive) {
  std::vector<std::string> issued;
  const run::DeploymentResult result =
      deploy::deploy(openTargetSheet(1), 1.0 / 60, nullptr, [&issued](const run::SearchNews& news) {
        if (!news.warning.empty()) issued.push_back(news.warning);
        return true;
      });
  EXPECT_THAT(
      issued,
      ElementsAre(
          StartsWith("the target opens its joints"),
          StartsWith(
              "the target is out of reach: the nearest state found with closed joints is 0.5")));
  EXPECT_EQ(result.warnings, issued);
  EXPECT_EQ(result.outcome, run::Outcome::Locked);
  EXPECT_THAT(result.reason, HasSubstr("short of the target: no nearer state with closed joints"));
  EXPECT_THAT(result.pathReason, HasSubstr("reaches the nearest known state with closed joints"));
}

}  // namespace
}  // namespace kirireel
