// The second compact state of sheets, without their targets.
#include "sim/path/closing.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/deploy/deployment.h"
#include "sim/generate/families.h"
#include "sim/generate/lattice.h"
#include "sim/scene/scene_parts.h"
#include "tests/support/refusal.h"

namespace kirireel {
namespace {

using testing::HasSubstr;

scene::Scene closing(model::Model model) {
  scene::Scene scene = scene::openScene();
  scene.model = std::move(model);
  scene.path.to = scene::Destination::Closed;
  std::vector<std::string> warnings;
  scene::completeScene({}, scene, warnings);
  scene::fillFromModel(scene);
  return scene;
}

model::Model familyModel(const std::string& name) {
  return generate::generateModel(generate::familyNamed(name), {});
}

/// The largest distance of a vertex from its target after the best rigid motion, metres.
double distanceAtBest(const std::vector<model::Tile>& tiles,
                      const std::vector<model::Tile>& target) {
  std::vector<Vector3> from, to;
  for (const model::Tile& tile : tiles)
    from.insert(from.end(), tile.vertices.begin(), tile.vertices.end());
  for (const model::Tile& tile : target)
    to.insert(to.end(), tile.vertices.begin(), tile.vertices.end());
  Eigen::Matrix3Xd a(3, from.size()), b(3, to.size());
  for (std::size_t k = 0; k < from.size(); ++k) {
    a.col(static_cast<Eigen::Index>(k)) = from[k];
    b.col(static_cast<Eigen::Index>(k)) = to[k];
  }
  const Eigen::Matrix4d best = Eigen::umeyama(a, b, false);
  return ((best.topLeftCorner<3, 3>() * a).colwise() + best.topRightCorner<3, 1>() - b)
      .colwise()
      .norm()
      .maxCoeff();
}

TEST(Closing, EndsAtTheOtherCompactStateOfTheDesign) {
  for (const char* family : {"square-to-disk", "fan", "quads", "heart"}) {
    const model::Model model = familyModel(family);
    const scene::Scene scene = closing(model);
    EXPECT_FALSE(scene.model.target.has_value());
    const run::DeploymentResult run = deploy::deploy(scene, 1.0 / 20, nullptr);
    const double tile = model::tileSize(model);
    EXPECT_EQ(run.outcome, run::Outcome::Settled) << run.reason;
    EXPECT_THAT(run.reason, HasSubstr("the path ends when the tiles meet again: "));
    const std::vector<model::Tile> end =
        brick::bottomTiles(run.trajectory.bricks, run.trajectory.samples.back().poses);
    EXPECT_LE(distanceAtBest(end, *model.target), 1e-6 * tile) << model.name;
    EXPECT_LE(run.accuracy.jointGapMax, 1e-10 * tile) << model.name;
    EXPECT_LE(run.accuracy.penetrationGrownMax, 1e-9 * tile) << model.name;
  }
}

// Compact states are singular: corners with errors of r leave hinges open by the root of r.
TEST(Closing, CountsTheHingesOfRoundedTilesAsClosed) {
  for (const double rounding : {1e-10, 1e-8}) {  // of a tile
    for (const char* family : {"tessellation", "fan"}) {
      model::Model model =
          generate::generateModel(generate::familyNamed(family), {{"start-angle", 40}});
      std::mt19937 random(3);
      std::uniform_real_distribution<double> error(-0.5, 0.5);
      model.rounding = rounding * model::tileSize(model);
      for (model::Tile& tile : model.tiles) {
        for (Vector3& vertex : tile.vertices)
          vertex += model.rounding * Vector3(error(random), error(random), 0);
      }
      const run::DeploymentResult run = deploy::deploy(closing(model), 1.0 / 20, nullptr);
      const std::size_t hinges = model.joints.size();
      EXPECT_THAT(run.reason, HasSubstr(fmt::format("{} of {} hinges are closed", hinges, hinges)))
          << family << rounding;
    }
  }
}

// Far from the middle of a large sheet, positions change more per degree than in a small one.
TEST(Closing, FollowsLargeSheets) {
  for (const int columns : {10, 20}) {
    generate::TessellationShape shape;
    shape.columns = columns;
    shape.rows = 10;
    shape.targetAngle = std::numbers::pi;
    const model::Model model = generate::makeTessellation(shape);
    const run::DeploymentResult run = deploy::deploy(closing(model), 1.0 / 20, nullptr);
    const std::vector<model::Tile> end =
        brick::bottomTiles(run.trajectory.bricks, run.trajectory.samples.back().poses);
    EXPECT_LE(distanceAtBest(end, *model.target), 1e-6) << columns;  // measured: 7e-10
  }
}

std::string refusal(const scene::Scene& scene) {
  return test::refusalOf([&] { deploy::deploy(scene, 0.5, nullptr); });
}

TEST(Closing, RefusesSheetsWithoutOneMotion) {
  model::Model chain = generate::makeTessellation({});
  chain.joints.resize(chain.joints.size() - 3);
  EXPECT_THAT(refusal(closing(chain)),
              HasSubstr("error: `to = closed` needs a sheet with one motion, but this sheet has "));
  model::Model loose = generate::makeTessellation({});
  loose.joints.clear();
  EXPECT_THAT(refusal(closing(loose)), HasSubstr("error: `to = closed`"));
}

TEST(Closing, RefusesUnsupportedScenes) {
  scene::Scene falling = closing(generate::makeTessellation({}));
  falling.environment.gravity = {0, 0, -9.81};
  EXPECT_THAT(
      refusal(falling),
      HasSubstr(
          "error: `to = closed` supports kinematic scenes only, but there is gravity. Remove it"));
  scene::Scene dynamic = closing(generate::makeTessellation({}));
  dynamic.path.kind = scene::PathKind::Dynamic;
  EXPECT_EQ(
      refusal(dynamic),
      "error: `to = closed` needs a kinematic path. Remove `path` or use `path = continuation`");
  scene::SceneParts parts;
  parts.targets = {"other"};
  scene::Scene scene = scene::openScene();
  scene.path.to = scene::Destination::Closed;
  scene.model = generate::makeTessellation({});
  std::vector<std::string> warnings;
  EXPECT_THAT([&] { scene::completeScene(parts, scene, warnings); },
              testing::ThrowsMessage<InputError>(
                  "error: `to = closed` and `target` define different ends. Use only one"));
}

}  // namespace
}  // namespace kirireel
