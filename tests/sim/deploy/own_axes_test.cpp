// Planar motion in any plane is the same as in a horizontal one, which is the oracle.
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/deploy/deployment.h"
#include "sim/generate/lattice.h"
#include "sim/scene/scene_needs.h"
#include "sim/trajectory/trajectory_file.h"
#include "tests/support/files.h"
#include "tests/support/refusal.h"
#include "tests/support/trajectories.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;

const Matrix3 kTurn = Eigen::AngleAxisd(2.1, Vector3(0.3, -1, 0.5).normalized()).toRotationMatrix();
const Vector3 kMove(0.4, -3, 2);

std::vector<model::Tile> turned(std::vector<model::Tile> tiles) {
  for (model::Tile& tile : tiles) {
    for (Vector3& vertex : tile.vertices) vertex = kTurn * vertex + kMove;
  }
  return tiles;
}

/// The scene turned in space, with its grips and its gravity.
scene::Scene turned(scene::Scene scene) {
  Vector3& gravity = scene.environment.gravity;
  if (!gravity.isZero(0)) gravity = kTurn * gravity;  // no -0, which is not the default
  scene.model.tiles = turned(scene.model.tiles);
  if (scene.model.target) scene.model.target = turned(*scene.model.target);
  for (scene::GripSetting& grip : scene.grips) {
    const Vector3 amounts(grip.x.value_or(0), grip.y.value_or(0), 0);
    if (!grip.x) continue;
    grip.x = (kTurn * amounts).x();
    grip.y = (kTurn * amounts).y();
    grip.z = (kTurn * amounts).z();
  }
  return scene;
}

scene::Scene halfOpenSheet() {
  scene::Scene scene;
  generate::TessellationShape shape;
  shape.columns = shape.rows = 2;
  shape.startAngle = 20 * kDegree;
  scene.model = generate::makeTessellation(shape);
  scene.environment.contacts = scene::ContactFilter::Auto;
  scene.path.kind = scene::PathKind::Auto;
  return scene;
}

/// The same with compliant necks.
scene::Scene withLigaments() {
  scene::Scene scene = halfOpenSheet();
  scene.hinges.neck = scene::HingeNeck{0.02, 0.1, 1e6, 0.3};
  scene.hinges.areLigaments = true;
  scene.environment.contacts = scene::ContactFilter::None;
  scene.stop.duration = 0.2;
  return scene;
}

/// The largest distance of a vertex between two runs, of which the second is turned, metres.
double farthest(const run::DeploymentResult& level, const run::DeploymentResult& tilted) {
  double largest = 0;
  for (std::size_t k = 0; k < level.trajectory.samples.size(); ++k) {
    const std::vector<model::Tile> expected =
        turned(brick::bottomTiles(level.trajectory.bricks, level.trajectory.samples[k].poses));
    const std::vector<model::Tile> found =
        brick::bottomTiles(tilted.trajectory.bricks, tilted.trajectory.samples[k].poses);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      for (std::size_t v = 0; v < expected[i].vertices.size(); ++v) {
        largest = std::max(largest, (expected[i].vertices[v] - found[i].vertices[v]).norm());
      }
    }
  }
  return largest;
}

/// The sheet and a target that is farther open.
scene::Scene openingSheet() {
  scene::Scene scene = halfOpenSheet();
  generate::TessellationShape shape;
  shape.columns = shape.rows = 2;
  shape.startAngle = 80 * kDegree;
  scene.model.target = generate::makeTessellation(shape).tiles;
  return scene;
}

TEST(OwnAxes, APathInAnyPlaneIsTheHorizontalOne) {
  const scene::Scene scene = openingSheet();
  const run::DeploymentResult level = deploy::deploy(scene, 0.5, nullptr);
  const run::DeploymentResult tilted = deploy::deploy(turned(scene), 0.5, nullptr);
  EXPECT_EQ(level.needs.planar.reason, "start and target lie in horizontal planes");
  EXPECT_TRUE(tilted.needs.planar.on);
  EXPECT_EQ(tilted.needs.planar.reason, "start and target lie in one plane");
  EXPECT_EQ(level.outcome, tilted.outcome);
  ASSERT_EQ(level.trajectory.samples.size(), tilted.trajectory.samples.size());
  EXPECT_LT(farthest(level, tilted), 1e-9);  // measured 1.2e-10
}

// Gravity makes the scene spatial. The search for a path ignores gravity, and is planar.
TEST(OwnAxes, ASearchWithoutGravityIsPlanarInAnyPlane) {
  scene::Scene scene = openingSheet();
  scene.environment.gravity = {0.3, -0.2, -1};
  scene.stop.duration = 0.2;
  const run::DeploymentResult level = deploy::deploy(scene, 0.1, nullptr);
  const run::DeploymentResult tilted = deploy::deploy(turned(scene), 0.1, nullptr);
  EXPECT_THAT(level.pathReason, HasSubstr("arrives without gravity"));
  EXPECT_EQ(tilted.pathReason, level.pathReason);
  EXPECT_EQ(tilted.needs.contacts.on, level.needs.contacts.on);
  ASSERT_EQ(level.trajectory.samples.size(), tilted.trajectory.samples.size());
  EXPECT_LT(farthest(level, tilted), 1e-7);  // measured 1.3e-8
}

TEST(OwnAxes, LigamentsWorkInAnyPlane) {
  const run::DeploymentResult level = deploy::deploy(withLigaments(), 0.1, nullptr);
  const run::DeploymentResult tilted = deploy::deploy(turned(withLigaments()), 0.1, nullptr);
  ASSERT_EQ(level.trajectory.samples.size(), tilted.trajectory.samples.size());
  EXPECT_LT(farthest(level, tilted), 1e-9);
  ASSERT_TRUE(tilted.elasticity.has_value());
  EXPECT_NEAR(tilted.elasticity->energyEnd, level.elasticity->energyEnd,
              1e-8 * level.elasticity->energyEnd);  // measured 1.4e-9
  // Energies are computed from poses in the world's axes.
  const test::TemporaryFolder folder;
  test::writeTrajectory(tilted.trajectory, folder / "run.h5");
  const trajectory::Trajectory read = test::readTrajectory(folder / "run.h5");
  const Poses& last = read.samples.back().poses;
  EXPECT_NEAR(read.pairForces.energy(last), tilted.elasticity->energyEnd,
              1e-9 * tilted.elasticity->energyEnd);
  const brick::Elasticity again =
      brick::elasticityOf(read.pairForces, read.samples.front().poses, last);
  EXPECT_NEAR(again.momentEnd, level.elasticity->momentEnd, 1e-8 * level.elasticity->momentEnd);
}

// Forces of joints and pins are turned back with the poses.
TEST(OwnAxes, ForcesAreInTheWorldsAxes) {
  scene::Scene scene = withLigaments();
  scene.hinges = {};
  scene.timeline.push_back({scene::Trigger{}, scene::timeline::Pin{{0}}, {}});
  const run::DeploymentResult level = deploy::deploy(scene, 0.1, nullptr);
  const run::DeploymentResult tilted = deploy::deploy(turned(scene), 0.1, nullptr);
  const trajectory::Mechanics& a = *level.trajectory.samples.back().mechanics;
  const trajectory::Mechanics& b = *tilted.trajectory.samples.back().mechanics;
  ASSERT_EQ(a.holds.size(), 1u);
  ASSERT_EQ(b.holds.size(), 1u);
  const double scale = a.holds[0].force.norm();
  EXPECT_GT(scale, 0);
  EXPECT_LT((kTurn * a.holds[0].force - b.holds[0].force).norm(), 1e-7 * scale);
  EXPECT_LT((kTurn * a.holds[0].moment - b.holds[0].moment).norm(), 1e-7 * scale);
  EXPECT_LT((kTurn * a.holds[0].point + kMove - b.holds[0].point).norm(), 1e-9);
}

/// Held at a tile, moved at another, pushed at a third.
scene::Scene gripped() {
  scene::Scene scene = withLigaments();
  scene::GripSetting held, moved, pushed;
  held.tiles = {0};
  held.x = held.y = held.turn = 0;
  moved.tiles = {3};
  moved.x = 0.05;
  moved.y = 0.03;
  pushed.tiles = {1};
  pushed.isForce = true;
  pushed.x = 0.1;
  pushed.y = -0.2;
  scene.grips = {held, moved, pushed};
  return scene;
}

TEST(OwnAxes, GripsActInAnyPlane) {
  const run::DeploymentResult level = deploy::deploy(gripped(), 0.5, nullptr);
  const run::DeploymentResult tilted = deploy::deploy(turned(gripped()), 0.5, nullptr);
  ASSERT_EQ(level.trajectory.samples.size(), tilted.trajectory.samples.size());
  EXPECT_LT(farthest(level, tilted), 1e-9);
  // Of the grip that moves: its forces along x, y and z are those of the horizontal sheet, turned.
  const mechanics::Equilibrium& a = level.loadCurve->states.back();
  const mechanics::Equilibrium& b = tilted.loadCurve->states.back();
  EXPECT_EQ(tilted.loadCurve->grips[4].name, "grip 2 x");
  const Vector3 expected = kTurn * Vector3(a.forces[3], a.forces[4], 0);
  const Vector3 found(b.forces[4], b.forces[5], b.forces[6]);
  EXPECT_GT(expected.norm(), 0);
  EXPECT_LT((expected - found).norm(), 1e-8 * expected.norm());
  const Vector3 move = kTurn * Vector3(0.05, 0.03, 0);
  EXPECT_NEAR(b.displacements[4], move.x(), 1e-12);
  EXPECT_NEAR(b.displacements[6], move.z(), 1e-12);
}

std::string refusalOf(const scene::Scene& scene) {
  return test::refusalOf([&] { deploy::deploy(scene, 0.5, nullptr); });
}

TEST(OwnAxes, RefuseGripsThatLeaveThePlane) {
  scene::Scene scene = turned(gripped());
  *scene.grips[1].z += 0.01;
  EXPECT_THAT(refusalOf(scene),
              HasSubstr("this grip moves out of the plane of the sheet. Set x, y and z"));
  scene = turned(gripped());
  scene.grips[2].z.reset();
  EXPECT_THAT(refusalOf(scene), HasSubstr("this grip moves out of the plane of the sheet"));
}

TEST(OwnAxes, PlanarMotionNeedsAHorizontalSheetOnlyForTheGround) {
  scene::Scene scene = turned(halfOpenSheet());
  scene.solver.planar = true;
  EXPECT_TRUE(deploy::deploy(scene, 0.5, nullptr).needs.planar.on);
  scene.environment.ground = scene::Ground{-10};
  EXPECT_THAT(refusalOf(scene),
              HasSubstr("with a ground needs a horizontal sheet. Remove one of them"));
  scene.solver.planar.reset();
  EXPECT_EQ(scene::sceneNeeds(scene).planar.reason, "the sheet does not lie on the ground");
  scene.environment.ground.reset();
  scene.environment.gravity = Vector3(0, 0, -1);
  EXPECT_EQ(scene::sceneNeeds(scene).planar.reason,
            "there is gravity and the sheet is not horizontal");
}

}  // namespace
}  // namespace kirireel
