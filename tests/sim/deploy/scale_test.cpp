// The unit of length changes nothing but lengths.
#include <cmath>

#include <gtest/gtest.h>

#include "sim/deploy/deployment.h"
#include "sim/generate/shells.h"
#include "sim/model/isometry.h"
#include "sim/model/lattice.h"

namespace kirireel {
namespace {

Scene scaled(Scene scene, double factor) {
  for (std::vector<Tile>* tiles : {&scene.model.tiles, &*scene.model.target}) {
    for (Tile& tile : *tiles) {
      for (Vector3& vertex : tile.vertices) vertex *= factor;
    }
  }
  scene.brick.thickness *= factor;
  return scene;
}

/// The largest distance between the bricks of two runs at any sample, the second's lengths divided
/// by `factor`, metres.
double difference(const DeploymentResult& run, const DeploymentResult& other, double factor) {
  double largest = 0;
  for (std::size_t k = 0; k < run.trajectory.samples.size(); ++k) {
    const Poses& poses = run.trajectory.samples[k].poses;
    const Poses& others = other.trajectory.samples[k].poses;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      largest = std::max(largest, (poses[i].position - others[i].position / factor).norm());
      const auto turn = poses[i].rotation.coeffs() - others[i].rotation.coeffs();
      largest = std::max(largest, turn.norm());
    }
  }
  return largest;
}

void expectSameAtScale(const Scene& scene, double factor, double tolerance) {
  const DeploymentResult run = deploy(scene, 1.0 / 60, nullptr);
  const DeploymentResult other = deploy(scaled(scene, factor), 1.0 / 60, nullptr);
  EXPECT_EQ(run.outcome, other.outcome) << factor;
  EXPECT_EQ(run.pathReason, other.pathReason) << factor;
  ASSERT_EQ(run.trajectory.samples.size(), other.trajectory.samples.size()) << factor;
  EXPECT_LE(difference(run, other, factor), tolerance) << factor;
}

Scene sheet() {
  Scene scene;
  scene.model = makeTessellation({});
  return scene;
}

/// Tiles of 0.6 m, in space.
Scene cap() {
  Scene scene;
  scene.model = makeSphericalCap({.size = 4});
  return scene;
}

TEST(Scale, PowersOfTwoChangeExponentsAlone) {
  for (const double factor : {std::ldexp(1, -10), std::ldexp(1, 10)}) {
    expectSameAtScale(sheet(), factor, 0);
    expectSameAtScale(cap(), factor, 0);
  }
}

TEST(Scale, MillimetresTakeTheSamePath) {
  // Rounding grows where a closed start opens: measured 1.1e-8 and 5.3e-8.
  expectSameAtScale(sheet(), 1e-3, 1e-6);
  expectSameAtScale(cap(), 1e-3, 1e-6);
}

/// Bricks may touch: those of the cap do on the way.
Scene amongBricks(Scene scene) {
  scene.environment.contacts = ContactFilter::All;
  return scene;
}

TEST(Scale, PowersOfTwoChangeExponentsAloneAmongBricks) {
  for (const double factor : {std::ldexp(1, -10), std::ldexp(1, 10)}) {
    expectSameAtScale(amongBricks(sheet()), factor, 0);
    expectSameAtScale(amongBricks(cap()), factor, 0);
  }
}

/// As the program has it, but for a path that is geometry.
Scene byDynamics(Scene scene) {
  const Model model = std::move(scene.model);
  scene = openScene();
  scene.model = model;
  scene.path.kind = PathKind::Dynamic;
  fillFromModel(scene);
  return scene;
}

TEST(Scale, StepsToAToleranceMoveAlike) {
  for (const Scene& scene : {byDynamics(sheet()), byDynamics(cap())}) {
    expectSameAtScale(scene, std::ldexp(1, -10), 0);
    expectSameAtScale(scene, std::ldexp(1, 10), 0);
    Scene through = scene;
    through.environment.contacts = ContactFilter::None;
    expectSameAtScale(through, 1e-3, 2e-9);  // measured 1.9e-10 and 7.1e-10
    expectSameAtScale(through, 1e3, 2e-9);   // measured 1.8e-10 and 5.7e-10
  }
}

Scene weighing(Scene scene, double density) {
  scene.brick.mass = MassRule::Prism;
  scene.brick.density = density;
  return scene;
}

void expectSameMotion(const Scene& scene, const Scene& other, double tolerance) {
  const DeploymentResult run = deploy(scene, 1.0 / 60, nullptr);
  const DeploymentResult same = deploy(other, 1.0 / 60, nullptr);
  EXPECT_EQ(run.pathReason, same.pathReason);
  ASSERT_EQ(run.trajectory.samples.size(), same.trajectory.samples.size());
  EXPECT_LE(difference(run, same, 1), tolerance);
}

TEST(Scale, HeavierBricksMoveAlikeByDefault) {
  for (const Scene& scene : {sheet(), cap(), amongBricks(cap())}) {
    // Square roots of masses change exponents alone where these change by a power of four.
    expectSameMotion(weighing(scene, 1000), weighing(scene, 4000), 0);
    expectSameAtScale(weighing(scene, 1000), 0.25, 0);
  }
  for (const Scene& scene : {sheet(), cap()}) {
    // Measured 4.3e-9 and 2.6e-8.
    expectSameMotion(weighing(scene, 1000), weighing(scene, 8000), 1e-6);
    expectSameAtScale(weighing(scene, 1000), 0.5, 1e-6);
  }
}

TEST(Scale, ThickerBricksMoveAlikeInThePlane) {
  Scene thick = weighing(sheet(), 300);
  thick.brick.thickness *= 3;
  DeploymentResult run = deploy(weighing(sheet(), 1000), 1.0 / 60, nullptr);
  DeploymentResult other = deploy(thick, 1.0 / 60, nullptr);
  ASSERT_EQ(run.trajectory.samples.size(), other.trajectory.samples.size());
  // Centres of mass are at half the thickness.
  for (Trajectory* trajectory : {&run.trajectory, &other.trajectory}) {
    for (Sample& sample : trajectory->samples) {
      for (Pose& pose : sample.poses) pose.position.z() = 0;
    }
  }
  EXPECT_LE(difference(run, other, 1), 1e-6);
}

TEST(Scale, SpringsInNewtonsMoveHeavierBricksLess) {
  Scene scene = weighing(sheet(), 1000);
  scene.springs = paperSprings();
  scene.stop.duration = 0.5;
  const double error = deploy(scene, 0.5, nullptr).accuracy.targetErrorEnd;
  scene.brick.density = 8000;
  EXPECT_GT(deploy(scene, 0.5, nullptr).accuracy.targetErrorEnd, error);
}

}  // namespace
}  // namespace kirireel
