/// Effects of stiffness, damping and thickness on a deployment, and the end of expansion.
#include <gtest/gtest.h>

#include "sim/deploy/deployment.h"
#include "sim/formats/read_model.h"
#include "sim/generate/lattice.h"

namespace kirireel {
namespace {

scene::Scene shipped(const std::string& name) {
  scene::Scene scene;
  std::vector<std::string> warnings;
  scene.model = formats::readModelFolder(std::filesystem::path(KIRIREEL_SOURCE_DIR) / "data" / name,
                                         warnings);
  scene.springs = scene::paperSprings();
  return scene;
}

scene::Scene capScene() {
  scene::Scene scene = shipped("cap");
  scene.springs.adaptive = false;
  scene.path.kind = scene::PathKind::Straight;
  return scene;
}

/// Time at which the error is halved, seconds.
double halfTime(const run::DeploymentResult& result) {
  for (const trajectory::Sample& sample : result.trajectory.samples) {
    if (sample.targetError <= 0.5 * result.accuracy.targetErrorStart) return sample.time;
  }
  return result.trajectory.samples.back().time;
}

void expectArrived(const run::DeploymentResult& result) {
  EXPECT_EQ(result.outcome, run::Outcome::Settled) << result.reason;
  EXPECT_LT(result.accuracy.targetErrorEnd, 1e-4);
  EXPECT_LT(result.accuracy.jointGapMax, 1e-10);
}

TEST(Sensitivity, DampingSlowsADeploymentAndKeepsItsEnd) {
  double before = 0;
  for (const double damping : {10, 50, 250}) {
    scene::Scene scene = capScene();
    scene.springs.forceDamping = damping;
    const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 240, nullptr);
    expectArrived(result);
    EXPECT_GT(halfTime(result), before);
    before = halfTime(result);
  }
}

TEST(Sensitivity, StiffnessSpeedsUpADeploymentAndKeepsItsEnd) {
  double before = 100;
  for (const double stiffness : {25, 100, 400}) {
    scene::Scene scene = capScene();
    scene.springs.springStiffness = scene.springs.torqueStiffness = stiffness;
    const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 240, nullptr);
    expectArrived(result);
    EXPECT_LT(halfTime(result), before);
    before = halfTime(result);
  }
}

TEST(Sensitivity, ThicknessKeepsTheEndIfBricksMayOverlap) {
  for (const double thickness : {0.005, 0.02, 0.1}) {
    scene::Scene scene = capScene();
    scene.brick.thickness = thickness;
    expectArrived(deploy::deploy(scene, 1.0 / 60, nullptr));
  }
}

/// The sum of all bricks' squared distances from their middle: what expansion raises.
double spread(const Poses& poses) {
  Vector3 middle = Vector3::Zero();
  for (const Pose& pose : poses) middle += pose.position / static_cast<double>(poses.size());
  double sum = 0;
  for (const Pose& pose : poses) sum += (pose.position - middle).squaredNorm();
  return sum;
}

class Expansion : public testing::TestWithParam<const char*> {};

TEST_P(Expansion, EndsAtTheSheetsLimitForAnyStrengthAndInItsPlane) {
  std::vector<double> ends;
  for (const double stiffness : {25, 100}) {
    for (const std::optional<bool> planar : {std::optional<bool>{}, std::optional<bool>{false}}) {
      scene::Scene scene = shipped(GetParam());
      scene.actuation.drive = scene::Drive::Expansion;
      scene.springs.springStiffness = stiffness;
      scene.solver.planar = planar;
      const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
      EXPECT_EQ(result.outcome, run::Outcome::Settled) << result.reason;
      const auto& samples = result.trajectory.samples;
      ends.push_back(spread(samples.back().poses));
      EXPECT_GT(ends.back(), 1.5 * spread(samples.front().poses));
      for (const trajectory::Sample& sample : samples) {
        for (std::size_t i = 0; i < sample.poses.size(); ++i) {
          const double start = samples.front().poses[i].position.z();
          EXPECT_NEAR(sample.poses[i].position.z(), start,
                      1e-6);  // measured 6e-8: the perturbation
        }
      }
    }
  }
  // A limit of the mechanism, the same from every side.
  for (const double end : ends) EXPECT_NEAR(end, ends.front(), 1e-6 * ends.front());
}

INSTANTIATE_TEST_SUITE_P(Shipped, Expansion, testing::Values("square_to_circle", "stampfli_24"));

}  // namespace
}  // namespace kirireel
