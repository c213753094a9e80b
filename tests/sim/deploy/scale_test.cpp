// The unit of length changes only lengths.
#include <cmath>

#include <gtest/gtest.h>

#include "sim/deploy/deployment.h"
#include "sim/generate/lattice.h"
#include "sim/generate/shells.h"
#include "sim/model/isometry.h"

namespace kirireel {
namespace {

scene::Scene scaled(scene::Scene scene, double factor) {
  for (std::vector<model::Tile>* tiles : {&scene.model.tiles, &*scene.model.target}) {
    for (model::Tile& tile : *tiles) {
      for (Vector3& vertex : tile.vertices) vertex *= factor;
    }
  }
  scene.brick.thickness *= factor;
  return scene;
}

/// The largest distance between the bricks of two runs at any sample, the second's lengths divided
/// by `factor`, metres.
double difference(const run::DeploymentResult& run, const run::DeploymentResult& other,
                  double factor) {
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

void expectSameAtScale(const scene::Scene& scene, double factor, double tolerance) {
  const run::DeploymentResult run = deploy::deploy(scene, 1.0 / 60, nullptr);
  const run::DeploymentResult other = deploy::deploy(scaled(scene, factor), 1.0 / 60, nullptr);
  EXPECT_EQ(run.outcome, other.outcome) << factor;
  EXPECT_EQ(run.pathReason, other.pathReason) << factor;
  ASSERT_EQ(run.trajectory.samples.size(), other.trajectory.samples.size()) << factor;
  EXPECT_LE(difference(run, other, factor), tolerance) << factor;
}

scene::Scene tessellation() {
  scene::Scene scene;
  scene.model = generate::makeTessellation({});
  return scene;
}

/// Tiles of 0.6 m, in space.
scene::Scene cap() {
  scene::Scene scene;
  scene.model = generate::makeSphericalCap({.size = 4});
  return scene;
}

TEST(Scale, PowersOfTwoChangeOnlyExponents) {
  for (const double factor : {std::ldexp(1, -10), std::ldexp(1, 10)}) {
    expectSameAtScale(tessellation(), factor, 0);
    expectSameAtScale(cap(), factor, 0);
  }
}

TEST(Scale, MillimetresGiveTheSamePath) {
  // Rounding grows where a closed start opens: measured 1.1e-8 and 5.3e-8.
  expectSameAtScale(tessellation(), 1e-3, 1e-6);
  expectSameAtScale(cap(), 1e-3, 1e-6);
}

/// Bricks may touch: the tiles of the cap do on the path.
scene::Scene amongBricks(scene::Scene scene) {
  scene.environment.contacts = scene::ContactFilter::All;
  return scene;
}

TEST(Scale, PowersOfTwoChangeOnlyExponentsWithContacts) {
  for (const double factor : {std::ldexp(1, -10), std::ldexp(1, 10)}) {
    expectSameAtScale(amongBricks(tessellation()), factor, 0);
    expectSameAtScale(amongBricks(cap()), factor, 0);
  }
}

/// As in the program, but not for a kinematic path.
scene::Scene byDynamics(scene::Scene scene) {
  const model::Model model = std::move(scene.model);
  scene = scene::openScene();
  scene.model = model;
  scene.path.kind = scene::PathKind::Dynamic;
  scene::fillFromModel(scene);
  return scene;
}

TEST(Scale, StepsToAToleranceMoveEqually) {
  for (const scene::Scene& scene : {byDynamics(tessellation()), byDynamics(cap())}) {
    expectSameAtScale(scene, std::ldexp(1, -10), 0);
    expectSameAtScale(scene, std::ldexp(1, 10), 0);
    scene::Scene through = scene;
    through.environment.contacts = scene::ContactFilter::None;
    expectSameAtScale(through, 1e-3, 2e-9);  // measured 1.9e-10 and 7.1e-10
    expectSameAtScale(through, 1e3, 2e-9);   // measured 1.8e-10 and 5.7e-10
  }
}

scene::Scene weighing(scene::Scene scene, double density) {
  scene.brick.mass = brick::MassRule::Prism;
  scene.brick.density = density;
  return scene;
}

void expectSameMotion(const scene::Scene& scene, const scene::Scene& other, double tolerance) {
  const run::DeploymentResult run = deploy::deploy(scene, 1.0 / 60, nullptr);
  const run::DeploymentResult same = deploy::deploy(other, 1.0 / 60, nullptr);
  EXPECT_EQ(run.pathReason, same.pathReason);
  ASSERT_EQ(run.trajectory.samples.size(), same.trajectory.samples.size());
  EXPECT_LE(difference(run, same, 1), tolerance);
}

TEST(Scale, HeavierBricksMoveEquallyByDefault) {
  for (const scene::Scene& scene : {tessellation(), cap(), amongBricks(cap())}) {
    // Square roots of masses change only exponents if the masses change by a power of four.
    expectSameMotion(weighing(scene, 1000), weighing(scene, 4000), 0);
    expectSameAtScale(weighing(scene, 1000), 0.25, 0);
  }
  for (const scene::Scene& scene : {tessellation(), cap()}) {
    // Measured 4.3e-9 and 2.6e-8.
    expectSameMotion(weighing(scene, 1000), weighing(scene, 8000), 1e-6);
    expectSameAtScale(weighing(scene, 1000), 0.5, 1e-6);
  }
}

TEST(Scale, ThickerBricksMoveEquallyInThePlane) {
  scene::Scene thick = weighing(tessellation(), 300);
  thick.brick.thickness *= 3;
  run::DeploymentResult run = deploy::deploy(weighing(tessellation(), 1000), 1.0 / 60, nullptr);
  run::DeploymentResult other = deploy::deploy(thick, 1.0 / 60, nullptr);
  ASSERT_EQ(run.trajectory.samples.size(), other.trajectory.samples.size());
  // Centres of mass are at half the thickness.
  for (trajectory::Trajectory* trajectory : {&run.trajectory, &other.trajectory}) {
    for (trajectory::Sample& sample : trajectory->samples) {
      for (Pose& pose : sample.poses) pose.position.z() = 0;
    }
  }
  EXPECT_LE(difference(run, other, 1), 1e-6);
}

TEST(Scale, SpringsInNewtonsMoveHeavierBricksLess) {
  scene::Scene scene = weighing(tessellation(), 1000);
  scene.springs = scene::paperSprings();
  scene.stop.duration = 0.5;
  const double error = deploy::deploy(scene, 0.5, nullptr).accuracy.targetErrorEnd;
  scene.brick.density = 8000;
  EXPECT_GT(deploy::deploy(scene, 0.5, nullptr).accuracy.targetErrorEnd, error);
}

}  // namespace
}  // namespace kirireel
