// When a run succeeds: it arrives without overlaps, and the budget did not end its search.
#include "sim/run/arrival.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/deploy/deployment.h"
#include "sim/generate/families.h"
#include "sim/model/isometry.h"
#include "sim/trajectory/measures.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

scene::Scene sceneOf(model::Model model) {
  scene::Scene scene = scene::openScene();
  scene.model = std::move(model);
  model::alignStartToTarget(scene.model);
  scene::fillFromModel(scene);
  return scene;
}

model::Model familyOf(const char* name, const std::map<std::string, double>& values = {}) {
  return generate::generateModel(generate::familyNamed(name), values);
}

TEST(Arrival, IsWithinAFactorOfTheLeastErrorAndAMillionthOfATile) {
  model::Model model = familyOf("tessellation");
  const double tile = model::tileSize(model);
  EXPECT_TRUE(run::hasArrived(model, 0.9e-6 * tile, 0));
  EXPECT_FALSE(run::hasArrived(model, 1.1e-6 * tile, 0));
  EXPECT_TRUE(run::hasArrived(model, 0.0104 * tile, 0.01 * tile));
  EXPECT_FALSE(run::hasArrived(model, 0.0106 * tile, 0.01 * tile));
  // Nothing nearer is known, yet the target is out of reach.
  EXPECT_TRUE(run::isNearest(model, 0.2 * tile, 0.2 * tile));
  EXPECT_FALSE(run::hasArrived(model, 0.2 * tile, 0.2 * tile));
}

// Tiles with four decimals reach their closed target only to a few last digits.
TEST(Arrival, IsWithinTheRoundingOfTheCoordinates) {
  model::Model model = familyOf("quads", {{"columns", 4}, {"rows", 4}});
  for (auto* tiles : {&model.tiles, &*model.target}) {
    for (model::Tile& tile : *tiles) {
      for (Vector3& vertex : tile.vertices) vertex = 1e-4 * (1e4 * vertex).array().round();
    }
  }
  model.rounding = 1e-4;
  const run::DeploymentResult run = deploy::deploy(sceneOf(model), 1, nullptr);
  EXPECT_EQ(run.atTarget, true);
  EXPECT_EQ(run.outcome, run::Outcome::Settled);
  EXPECT_THAT(run.shortfall, IsEmpty());
  // Measured: 1.7 digits; 1.0 without contacts.
  EXPECT_LT(run.accuracy.targetErrorEnd, 5 * model.rounding);
}

/// `at_target` by the definition, from figures that the run reports.
bool isAtTarget(const scene::Scene& scene, const run::DeploymentResult& run) {
  const double tile = model::tileSize(scene.model), error = run.accuracy.targetErrorEnd;
  return error <= 1.05 * run.assembledError + 1e-6 * tile && error <= 0.1 * tile;
}

// The thickness of a strip that rolls up keeps it from its target.
TEST(Arrival, ASheetThatItsThicknessKeepsShortIsNotAtItsTarget) {
  scene::Scene scene = sceneOf(familyOf("sphere-to-saddle"));
  scene.environment.contacts = scene::ContactFilter::All;
  const run::DeploymentResult run = deploy::deploy(scene, 1, nullptr);
  EXPECT_EQ(run.atTarget, isAtTarget(scene, run));
  EXPECT_EQ(run.atTarget, false);
  EXPECT_EQ(run.outcome, run::Outcome::Locked);
  EXPECT_THAT(run.reason, HasSubstr("short of the target"));
  EXPECT_THAT(run.shortfall, HasSubstr("short of the target"));
}

TEST(Arrival, OverlapsAreAShortfallUnlessContactsAreSwitchedOff) {
  scene::Scene scene = sceneOf(familyOf("stampfli-removal"));
  const run::DeploymentResult open = deploy::deploy(scene, 1, nullptr);
  const double tile = model::tileSize(scene.model);
  ASSERT_GT(open.accuracy.penetrationGrownMax, 0.1 * tile);  // measured: 0.84 tiles
  EXPECT_EQ(open.outcome, run::Outcome::Settled);
  EXPECT_THAT(open.shortfall, HasSubstr("bricks overlap by up to "));
  EXPECT_THAT(open.reason, HasSubstr(open.shortfall));
  EXPECT_THAT(open.trajectory.events.back().text, HasSubstr(open.shortfall));
  scene.environment.contacts = scene::ContactFilter::None;
  const run::DeploymentResult none = deploy::deploy(scene, 1, nullptr);
  ASSERT_GT(none.accuracy.penetrationGrownMax, 0.1 * tile);
  EXPECT_THAT(none.shortfall, IsEmpty());
}

// Overlaps count only for pairs that have contacts.
TEST(Arrival, OverlapsOfJoinedPairsDoNotCountIfOnlyUnjoinedOnesTouch) {
  // Two squares close about a common corner, and overlap beyond it.
  scene::Scene scene = sceneOf(familyOf(
      "tessellation", {{"columns", 2}, {"rows", 2}, {"start-angle", 0}, {"target-angle", 90}}));
  std::swap(scene.model.tiles, *scene.model.target);
  scene.environment.contacts = scene::ContactFilter::Unjoined;
  const run::DeploymentResult run = deploy::deploy(scene, 1, nullptr);
  EXPECT_EQ(run.atTarget, true) << run.reason;
  EXPECT_THAT(run.shortfall, IsEmpty());
}

TEST(Arrival, ASearchThatItsBudgetEndsIsAShortfall) {
  scene::Scene scene = sceneOf(familyOf("cap", {{"half-size", 3}}));
  EXPECT_THAT(deploy::deploy(scene, 1, nullptr).shortfall, IsEmpty());
  scene.path.searchEffort = 0;
  const run::DeploymentResult run = deploy::deploy(scene, 1, nullptr);
  EXPECT_THAT(run.shortfall,
              HasSubstr("the search for a path spent its budget. Raise `search_effort`"));
  EXPECT_THAT(run.warnings, testing::Contains(HasSubstr("spent its budget")));
}

scene::Scene sceneOnRoughGround(const char* family, double gravity,
                                const std::map<std::string, double>& values = {}) {
  scene::Scene scene = sceneOf(familyOf(family, values));
  scene.environment.ground = scene::Ground{};
  scene.environment.ground->height = scene::lowestPoint(scene);
  scene.environment.gravity = {0, 0, -gravity};
  scene.path.kind = scene::PathKind::Straight;
  scene.stop.duration = 4;
  return scene;
}

// Bricks on the ground, pulled by less than their friction.
TEST(Arrival, FrictionThatHoldsASheetIsReported) {
  const scene::Scene scene = sceneOnRoughGround("tessellation", 1e4, {{"columns", 2}, {"rows", 2}});
  const run::DeploymentResult run = deploy::deploy(scene, 1, nullptr);
  EXPECT_EQ(run.atTarget, false);
  EXPECT_THAT(run.shortfall, HasSubstr("friction on the ground holds the tiles: the drive pulls "
                                       "each with at most "));
  // mu m g = 0.5 * 1 kg * 1e4 m/s2.
  EXPECT_THAT(run.shortfall, HasSubstr("friction holds up to mu m g = 5e+03 N"));
}

// The pull on single tiles is larger than their friction, but joints share it among all tiles.
TEST(Arrival, FrictionThatHoldsASheetWithAPinIsReported) {
  scene::Scene scene = sceneOnRoughGround("tessellation", 9000, {{"columns", 4}, {"rows", 4}});
  scene.timeline = {{{}, scene::timeline::Pin{{15}}, {}}};
  const run::DeploymentResult run = deploy::deploy(scene, 1, nullptr);
  EXPECT_EQ(run.atTarget, false);
  EXPECT_THAT(run.shortfall, HasSubstr("in equilibrium with friction on the ground, the pins of "));
}

// Springs that guide are critically damped, so they take energy from a scene without any damping.
TEST(Arrival, DampingOfGuidesIsReportedInAnUndampedScene) {
  scene::Scene scene = sceneOf(familyOf("tessellation", {{"columns", 2}, {"rows", 2}}));
  scene.path.kind = scene::PathKind::Guided;
  const auto isAboutDamping = HasSubstr("the springs that guide the tiles are critically damped");
  EXPECT_THAT(deploy::deploy(scene, 1, nullptr).warnings, Not(testing::Contains(isAboutDamping)));
  scene.springs.dampingRatio = 0;
  EXPECT_THAT(deploy::deploy(scene, 1, nullptr).warnings, testing::Contains(isAboutDamping));
}

}  // namespace
}  // namespace kirireel
