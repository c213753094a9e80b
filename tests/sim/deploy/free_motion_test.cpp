// Free motions against their closed forms or equations of motion.
#include <cmath>

#include <gtest/gtest.h>

#include "sim/brick/brick.h"
#include "sim/deploy/deployment.h"
#include "sim/generate/shells.h"
#include "tests/support/physics.h"

namespace kirireel {
namespace {

using test::kGravity;

/// Bricks moved only by gravity, without damping.
scene::Scene undriven(model::Model model, double duration) {
  scene::Scene scene;
  scene.model = std::move(model);
  scene.actuation.drive = scene::Drive::None;
  scene.environment.linearDamping = scene.environment.angularDamping = 0;
  scene.solver.tolerance = scene::kDefaultTolerance;
  scene.stop.duration = duration;
  return scene;
}

Vector3 massCentre(const std::vector<brick::Brick>& bricks, const Poses& poses) {
  Vector3 sum = Vector3::Zero();
  double mass = 0;
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    sum += bricks[i].mass * poses[i].position;
    mass += bricks[i].mass;
  }
  return sum / mass;
}

/// The largest distance of the mass centre from v t + g t^2 / 2, metres.
double farthestFromParabola(const run::DeploymentResult& run, const Vector3& speed) {
  const std::vector<brick::Brick>& bricks = run.trajectory.bricks;
  const Vector3 start = massCentre(bricks, run.trajectory.samples.front().poses);
  double farthest = 0;
  for (const trajectory::Sample& sample : run.trajectory.samples) {
    const double t = sample.time;
    const Vector3 expected = start + t * speed - Vector3(0, 0, 0.5 * kGravity * t * t);
    farthest = std::max(farthest, (massCentre(bricks, sample.poses) - expected).norm());
  }
  return farthest;
}

// Closing the joints of these models pushes bricks into each other.
TEST(FreeMotion, ClosedBricksFall) {
  for (const scene::ContactFilter contacts :
       {scene::ContactFilter::All, scene::ContactFilter::Unjoined}) {
    scene::Scene scene = undriven(generate::makeSphereToSaddle({.columns = 4, .rows = 4}), 0.3);
    scene.environment.gravity = {0, 0, -kGravity};
    scene.environment.contacts = contacts;
    const run::DeploymentResult run = deploy::deploy(scene, 1.0 / 30, nullptr);
    EXPECT_NEAR(run.trajectory.samples.back().time, 0.3, 1e-9);
    EXPECT_LT(farthestFromParabola(run, Vector3::Zero()), 1e-9);
  }
}

TEST(FreeMotion, ClosedBricksFlyWithTheirFirstVelocity) {
  scene::Scene scene = undriven(generate::makeSphereToSaddle({.columns = 4, .rows = 4}), 0.3);
  scene.environment.gravity = {0, 0, -kGravity};
  scene.environment.contacts = scene::ContactFilter::All;
  const Vector3 speed(0.3, -0.2, 1);
  scene.velocities.resize(1);  // of all tiles
  scene.velocities[0].linear = speed;
  const run::DeploymentResult run = deploy::deploy(scene, 1.0 / 30, nullptr);
  EXPECT_LT(farthestFromParabola(run, speed), 1e-9);
}

/// Two unit squares hinged at a corner in the plane; the first is pinned.
scene::Scene pendulum(double duration) {
  model::Model model;
  model.tiles = {{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}},
                 {{{1, 1, 0}, {2, 1, 0}, {2, 2, 0}, {1, 2, 0}}}};
  model.joints = {{{0, 2}, {1, 0}, model::JointFace::Both}};
  scene::Scene scene = undriven(std::move(model), duration);
  scene.environment.gravity = {0, -kGravity, 0};
  scene.environment.contacts = scene::ContactFilter::None;
  scene.timeline = {{scene::Trigger{}, scene::timeline::Pin{{0}}, {}}};
  scene.solver.planar = true;
  return scene;
}

/// The pendulum's angle at a time, from rest: (I + m l^2) a'' = -m g l cos(a + 45 deg), by the
/// classical Runge-Kutta method in steps of 1e-4 s, error below 1e-12.
double pendulumAngle(double time) {
  const double arm = std::sqrt(0.5);
  const auto acceleration = [&](double angle) {
    return -kGravity * arm * std::cos(angle + 0.25 * M_PI) / (1.0 / 6 + 0.5);
  };
  const int steps = static_cast<int>(std::ceil(time / 1e-4));
  const double h = steps > 0 ? time / steps : 0;
  double a = 0, w = 0;
  for (int k = 0; k < steps; ++k) {
    const double a1 = w, w1 = acceleration(a);
    const double a2 = w + 0.5 * h * w1, w2 = acceleration(a + 0.5 * h * a1);
    const double a3 = w + 0.5 * h * w2, w3 = acceleration(a + 0.5 * h * a2);
    const double a4 = w + h * w3, w4 = acceleration(a + h * a3);
    a += h * (a1 + 2 * a2 + 2 * a3 + a4) / 6;
    w += h * (w1 + 2 * w2 + 2 * w3 + w4) / 6;
  }
  return a;
}

double farthestFromPendulum(const run::DeploymentResult& run) {
  const brick::Brick& brick = run.trajectory.bricks[1];
  double farthest = 0;
  for (const trajectory::Sample& sample : run.trajectory.samples) {
    const Eigen::AngleAxisd turn(pendulumAngle(sample.time), Vector3::UnitZ());
    for (const Vector3& corner : brick.bottom) {
      const Vector3 from = run.trajectory.samples.front().poses[1].apply(corner);
      const Vector3 hinge(1, 1, from.z());
      const Vector3 expected = hinge + turn * (from - hinge);
      farthest = std::max(farthest, (sample.poses[1].apply(corner) - expected).norm());
    }
  }
  return farthest;
}

TEST(FreeMotion, APendulumStartsAtRest) {
  const run::DeploymentResult run = deploy::deploy(pendulum(0.1), 1.0 / 60, nullptr);
  ASSERT_TRUE(run.trajectory.samples.front().mechanics);
  EXPECT_EQ(run.trajectory.samples.front().mechanics->energies.kinetic, 0);
}

TEST(FreeMotion, TheMeasuredErrorIsThatOfThePendulum) {
  for (const double tolerance : {1e-3, 1e-5, 1e-7}) {
    scene::Scene scene = pendulum(2);
    scene.solver.tolerance = tolerance;
    scene.solver.measuresTimeError = true;
    const run::DeploymentResult run = deploy::deploy(scene, 1.0 / 60, nullptr);
    ASSERT_TRUE(run.timeError);
    const double error = farthestFromPendulum(run);  // tiles have edges of 1 m
    EXPECT_GT(*run.timeError, 0.3 * error) << tolerance;
    EXPECT_LT(*run.timeError, 3 * error) << tolerance;
  }
}

/// Two tiles with a common edge and different rates, which tumble for 3 s.
scene::Scene tumblingPair(double tolerance) {
  model::Model model;
  model.tiles = {{{{-1, -0.5, 0}, {0, -0.5, 0}, {0, 0.5, 0}, {-1, 0.5, 0}}},
                 {{{0, -0.5, 0}, {1, -0.5, 0}, {1, 0.5, 0}, {0, 0.5, 0}}}};
  model.joints = {{{0, 2}, {1, 3}, model::JointFace::Both}};
  scene::Scene scene = undriven(std::move(model), 3);
  scene.brick.thickness = 0.02;
  scene.environment.contacts = scene::ContactFilter::None;
  scene.velocities.resize(2);
  scene.velocities[0].tiles = {0};
  scene.velocities[0].linear = {-0.24, -0.40, -0.07};
  scene.velocities[0].angular = {-0.55, -0.78, 0.75};
  scene.velocities[1].tiles = {1};
  scene.velocities[1].linear = {0.13, 0.34, 0.03};
  scene.velocities[1].angular = {1.63, 0.27, -1.23};
  scene.solver.tolerance = tolerance;
  return scene;
}

/// The farthest distance of a vertex between two runs, metres.
double farthestApart(const run::DeploymentResult& a, const run::DeploymentResult& b) {
  double farthest = 0;
  for (std::size_t k = 0; k < a.trajectory.samples.size(); ++k) {
    for (std::size_t i = 0; i < a.trajectory.bricks.size(); ++i) {
      for (const Vector3& corner : a.trajectory.bricks[i].bottom) {
        farthest = std::max(farthest, (a.trajectory.samples[k].poses[i].apply(corner) -
                                       b.trajectory.samples[k].poses[i].apply(corner))
                                          .norm());
      }
    }
  }
  return farthest;
}

// Steps of 1e-3 and 1e-4 both end at the samples and are the same. Measured over error: 0.92 to
// 1.43.
TEST(FreeMotion, TheMeasuredErrorIsThatOfTumblingTiles) {
  const run::DeploymentResult exact = deploy::deploy(tumblingPair(1e-12), 1.0 / 60, nullptr);
  for (const double tolerance : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8}) {
    scene::Scene scene = tumblingPair(tolerance);
    scene.solver.measuresTimeError = true;
    const run::DeploymentResult run = deploy::deploy(scene, 1.0 / 60, nullptr);
    ASSERT_TRUE(run.timeError);
    const double error = farthestApart(run, exact);  // tiles have edges of 1 m
    EXPECT_GT(*run.timeError, 0.5 * error) << tolerance << ", " << error;
    EXPECT_LT(*run.timeError, 3 * error) << tolerance << ", " << error;
  }
}

TEST(FreeMotion, OnlyMeasuredErrorsAreReported) {
  EXPECT_FALSE(deploy::deploy(pendulum(0.1), 1.0 / 60, nullptr).timeError);
}

TEST(FreeMotion, StepsThatAddEnergyHaveAWarning) {
  // A long tile spins about its middle axis, which is unstable.
  model::Model model;
  model.tiles = {{{{0, 0, 0}, {3, 0, 0}, {3, 1, 0}, {0, 1, 0}}}};
  scene::Scene scene = undriven(std::move(model), 60);
  scene.brick.thickness = 0.3;
  scene.velocities.resize(1);
  scene.velocities[0].linear = {0.1, 0, 0};
  scene.velocities[0].angular = {0.3, 2, 0.2};
  scene.solver.tolerance = 0;
  const run::DeploymentResult run = deploy::deploy(scene, 1, nullptr);
  ASSERT_EQ(run.warnings.size(), 1U);
  EXPECT_TRUE(run.warnings[0].starts_with("energy grows by 9.")) << run.warnings[0];
  EXPECT_NE(run.warnings[0].find("Use a smaller `timestep`"), std::string::npos);
  scene.solver.tolerance = 1e-6;
  EXPECT_TRUE(deploy::deploy(scene, 1, nullptr).warnings.empty());
}

}  // namespace
}  // namespace kirireel
