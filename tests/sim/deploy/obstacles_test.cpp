/// Bricks on fixed obstacles, against closed forms.
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/contacts/contact_finder.h"
#include "sim/deploy/deployment.h"
#include "sim/generate/lattice.h"
#include "sim/run/dynamics.h"
#include "sim/scene/scene_needs.h"
#include "tests/sim/run/moving.h"
#include "tests/support/physics.h"
#include "tests/support/refusal.h"

namespace kirireel {
namespace {

using test::Moving;
using ::testing::EndsWith;

using test::kGravity;
using test::kStep;
constexpr double kThickness = 0.1;

/// An upright rectangle about a point of its bottom.
model::Tile rectangle(const Vector3& middle, double length, double width) {
  const Vector3 half(0.5 * length, 0.5 * width, 0);
  const Vector3 across(0.5 * length, -0.5 * width, 0);
  return {{middle - half, middle + across, middle + half, middle - across}};
}

scene::Obstacle box(const Vector3& middle, const Vector3& size) {
  scene::Obstacle obstacle;
  obstacle.size = size;
  obstacle.pose.position = middle;
  return obstacle;
}

scene::Obstacle sphere(const Vector3& centre, double radius) {
  scene::Obstacle obstacle;
  obstacle.shape = scene::Obstacle::Shape::Sphere;
  obstacle.radius = radius;
  obstacle.pose.position = centre;
  return obstacle;
}

/// The faces of a unit cube with its middle at a point.
scene::Obstacle cubeMesh(const Vector3& middle) {
  scene::Obstacle obstacle;
  obstacle.shape = scene::Obstacle::Shape::Mesh;
  obstacle.mesh = scene::obstacleFaces(box(middle, Vector3::Ones()));
  return obstacle;
}

scene::Scene sceneOf(const std::vector<model::Tile>& tiles, const scene::Obstacle& obstacle) {
  scene::Scene scene;
  scene.model.tiles = tiles;
  scene.brick.thickness = kThickness;
  scene.environment.linearDamping = scene.environment.angularDamping = 0;
  scene.environment.gravity = Vector3(0, 0, -kGravity);
  scene.environment.obstacles = {obstacle};
  return scene;
}

const Vector3& place(const Moving& run) {
  return run.motion.poses.front().position;
}

TEST(Obstacles, ABrickFallsOntoABoxAndRests) {
  for (const bool isMesh : {false, true}) {
    const Vector3 middle(0.2, 0.1, -0.5);
    const scene::Obstacle under = isMesh ? cubeMesh(middle) : box(middle, Vector3::Ones());
    Moving run(sceneOf({rectangle({0, 0, 0.3}, 0.8, 0.6)}, under));
    run.advance(240);
    EXPECT_NEAR(place(run).z(), 0.5 * kThickness, 1e-9);  // measured 1.4e-17
    EXPECT_LT(run.motion.velocities.front().linear.norm(), 1e-9);
    EXPECT_EQ(run.unconverged, 0);
  }
}

TEST(Obstacles, CarryTheWeightOfBricksOnThem) {
  // A wide box holds the brick's corners with its face, a narrow one the brick's face with its own
  // corners.
  for (const double width : {2.0, 0.2}) {
    const scene::Obstacle under = box({0.02, 0.01, -0.5}, {width, width, 1});
    Moving run(sceneOf({rectangle({0, 0, 0}, 0.8, 0.6)}, under));
    run.advance(24);
    const std::vector<trajectory::Hold> holds = run.dynamics->contacts(run.motion.poses);
    ASSERT_EQ(holds.size(), 1U) << width;
    EXPECT_EQ(holds[0].tile, 0);
    EXPECT_EQ(holds[0].other, trajectory::Hold::kFirstObstacle);
    const Vector3 weight(0, 0, -kGravity * run.bricks[0].mass);
    EXPECT_LT((holds[0].force + weight).norm(), 1e-12 * weight.norm()) << width;  // measured 2e-16
    // About the middle of the brick the push has no moment.
    const Vector3 arm = holds[0].point - place(run);
    const Vector3 moment = holds[0].moment + arm.cross(holds[0].force);
    EXPECT_LT(moment.norm(), 1e-12 * weight.norm()) << width;  // measured 1e-16
    EXPECT_THAT(run.dynamics->loadedContacts(), ::testing::ElementsAre("tile 0 and obstacle 0"));
  }
}

// An obstacle is not a body of a solver: without contact every bit stays the same.
TEST(Obstacles, ChangeNothingWithoutContact) {
  generate::TessellationShape shape;
  shape.columns = shape.rows = 3;
  scene::Scene with = sceneOf(generate::makeTessellation(shape).tiles, box({0, 0, 50}, {1, 2, 3}));
  with.model = generate::makeTessellation(shape);
  with.model.target.reset();
  scene::Scene without = with;
  without.environment.obstacles.clear();
  without.environment.contacts = with.environment.contacts = scene::ContactFilter::All;
  Moving one(with), other(without);
  ASSERT_FALSE(scene::sceneNeeds(without).planar.on);
  one.advance(20, {0.3, 0.1, 0});
  other.advance(20, {0.3, 0.1, 0});
  for (std::size_t i = 0; i < one.bricks.size(); ++i) {
    EXPECT_EQ(one.motion.poses[i].position, other.motion.poses[i].position) << i;
    EXPECT_EQ(one.motion.poses[i].rotation.coeffs(), other.motion.poses[i].rotation.coeffs()) << i;
  }
}

TEST(Obstacles, ABrickTipsOverAnEdgeOnceItsMiddleIsBeyond) {
  for (const double middle : {0.48, 0.52}) {
    // The box ends at x = 0.5.
    Moving run(sceneOf({rectangle({middle, 0, 0}, 0.8, 0.6)}, box({0, 0, -0.5}, Vector3::Ones())));
    run.advance(240);
    const double drop = 0.5 * kThickness - place(run).z();
    if (middle < 0.5) {
      EXPECT_NEAR(drop, 0, 1e-9);
    } else {
      EXPECT_GT(drop, 0.2);
    }
    EXPECT_EQ(run.unconverged, 0);
  }
}

TEST(Obstacles, FrictionHoldsABrickOnASlopeUpToItsAngle) {
  const double angle = std::numbers::pi / 6;
  for (const double friction : {0.2, 0.7}) {
    scene::Obstacle slope = box(Vector3::Zero(), {4, 4, 1});
    slope.pose.rotation = rotationFromVector({0, angle, 0});
    slope.friction = friction;
    slope.pose.position = slope.pose.rotation * Vector3(0, 0, -0.5);
    model::Tile tile = rectangle(Vector3::Zero(), 0.4, 0.4);
    for (Vector3& vertex : tile.vertices) vertex = slope.pose.rotation * vertex;
    Moving run(sceneOf({tile}, slope));
    const Vector3 from = place(run);
    run.advance(96);
    const double time = 96 * kStep;
    const double pull = kGravity * (std::sin(angle) - friction * std::cos(angle));
    const double moved = pull > 0 ? 0.5 * pull * time * (time + kStep) : 0;
    EXPECT_NEAR((place(run) - from).norm(), moved, 1e-9) << friction;  // measured 1e-16
    EXPECT_EQ(run.unconverged, 0);
  }
}

TEST(Obstacles, ABrickRocksOnASphereWithTheClosedFormsPeriod) {
  // Rolling without slip: omega^2 = g (R - t / 2) / (t^2 / 4 + (L^2 + t^2) / 12).
  const double radius = 0.5;
  const double length = 0.8;
  scene::Obstacle round = sphere({0, 0, -radius}, radius);
  round.friction = 10;
  Moving run(sceneOf({rectangle(Vector3::Zero(), length, 0.3)}, round));
  const double tilt = 0.02;
  // Rolled by the tilt: the brick's middle moves along by R times it.
  const Quaternion turn = rotationFromVector({0, tilt, 0});
  const Vector3 touch = radius * Vector3(std::sin(tilt), 0, std::cos(tilt) - 1);
  run.motion.poses[0] = {touch + turn * Vector3(-radius * tilt, 0, 0.5 * kThickness), turn};
  const double arm =
      0.25 * kThickness * kThickness + (length * length + kThickness * kThickness) / 12;
  const double frequency = std::sqrt(kGravity * (radius - 0.5 * kThickness) / arm);
  const int halfPeriod = static_cast<int>(std::lround(std::numbers::pi / frequency / kStep));
  run.advance(halfPeriod);
  EXPECT_NEAR(run.motion.poses[0].rotation.y(), -0.5 * tilt, 1e-5);  // measured 1.2e-6
  run.advance(halfPeriod);
  EXPECT_NEAR(run.motion.poses[0].rotation.y(), 0.5 * tilt, 1e-5);  // measured 2.5e-7
  EXPECT_EQ(run.unconverged, 0);
}

TEST(Obstacles, NothingPassesThroughAThinFaceAtAnySpeed) {
  scene::Obstacle wall;
  wall.shape = scene::Obstacle::Shape::Mesh;
  wall.mesh = {rectangle({0, 0, -1}, 4, 4)};
  scene::Scene scene = sceneOf({rectangle(Vector3::Zero(), 0.5, 0.5)}, wall);
  Moving run(scene);
  run.motion.velocities[0].linear.z() = -500;  // 20 thicknesses a step
  run.advance(20);
  EXPECT_NEAR(place(run).z(), -1 + 0.5 * kThickness, 1e-9);  // measured 0
}

TEST(Obstacles, ASheetDrapesOverASphereWithoutEnteringIt) {
  scene::Scene scene;
  generate::TessellationShape shape;
  shape.columns = shape.rows = 4;
  shape.face = model::JointFace::Bottom;
  scene.model = generate::makeTessellation(shape);
  scene.model.target.reset();
  scene.environment.gravity = Vector3(0, 0, -kGravity);
  scene.environment.linearDamping = scene.environment.angularDamping = 0.9;
  const Vector3 middle =
      0.5 * (scene.model.tiles.front().vertices[0] + scene.model.tiles.back().vertices[2]);
  scene.environment.obstacles = {sphere(middle - Vector3(0, 0, 1.6), 1.5)};
  scene.stop.duration = 0.6;
  const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
  EXPECT_FALSE(result.needs.planar.on);
  EXPECT_EQ(result.needs.planar.reason, "obstacles push out of the plane");
  const Vector3 centre = scene.environment.obstacles[0].pose.position;
  const auto& bricks = result.trajectory.bricks;
  double deepest = 0;
  for (const trajectory::Sample& sample : result.trajectory.samples) {
    for (std::size_t i = 0; i < bricks.size(); ++i) {
      const Pose& pose = sample.poses[i];
      const Vector3 seen = pose.rotation.conjugate() * (centre - pose.position);
      deepest = std::max(deepest,
                         1.5 - contacts::nearestPoint(brick::brickFaces(bricks[i]), seen).distance);
    }
  }
  EXPECT_GT(deepest, -1e-6);  // they touch
  EXPECT_LT(deepest, 2e-5);   // measured 9.6e-6: overlaps up to 1e-5 of a tile count as none
  EXPECT_LT(result.accuracy.jointGapMax, 1e-10);
}

TEST(Obstacles, AreNamedIfTheyStopADeployment) {
  const model::Tile tile = rectangle({0, 0, 0}, 1, 1);
  for (const bool isMesh : {false, true}) {
    const Vector3 middle(2, 0, 0);
    scene::Scene scene = sceneOf({tile}, isMesh ? cubeMesh(middle) : box(middle, Vector3::Ones()));
    scene.environment.gravity.setZero();
    scene.model.target = {rectangle({3, 0, 0}, 1, 1)};
    scene.path.kind = scene::PathKind::Straight;
    const run::DeploymentResult result = deploy::deploy(scene, 0.1, nullptr);
    EXPECT_EQ(result.outcome, run::Outcome::Locked);
    EXPECT_THAT(result.reason, EndsWith("of the target: contact stops tile 0 and obstacle 0"));
  }
}

std::string refusal(const scene::Scene& scene) {
  return test::refusalOf([&] { deploy::deploy(scene, 0.1, nullptr); });
}

TEST(Obstacles, MayNotOverlapABrickAtTheStart) {
  EXPECT_EQ(refusal(sceneOf({rectangle({0, 0, 0}, 1, 1)}, box({0, 0, -0.45}, Vector3::Ones()))),
            "error: tile 0 overlaps obstacle 0 by 0.05 m at the start. Move the obstacle");
  EXPECT_EQ(refusal(sceneOf({rectangle({0, 0, 0}, 1, 1)}, sphere({0, 0, -0.45}, 0.5))),
            "error: tile 0 overlaps obstacle 0 by 0.05 m at the start. Move the obstacle");
}

TEST(Obstacles, TilesAreNumberedAsInTheModelsFile) {
  scene::Scene scene = sceneOf({rectangle({0, 0, 0}, 1, 1)}, box({0, 0, -0.45}, Vector3::Ones()));
  scene.model.fileOrder.countsFrom = 1;
  EXPECT_EQ(refusal(scene),
            "error: tile 1 overlaps obstacle 0 by 0.05 m at the start. Move the obstacle");
}

TEST(Obstacles, AreRefusedIfTheyHaveNoEffect) {
  scene::Scene scene = sceneOf({rectangle({0, 0, 0}, 1, 1)}, box({0, 0, -2}, Vector3::Ones()));
  scene.solver.planar = true;
  EXPECT_EQ(
      refusal(scene),
      "error: obstacles work only with bricks in space. Remove `planar = on` or the obstacles");
  scene.solver.planar.reset();
  scene.solver.kind = scene::SolverKind::Bullet;
  EXPECT_EQ(refusal(scene),
            "error: `solver = bullet` does not support obstacles. Use `solver = direct`");
}

}  // namespace
}  // namespace kirireel
