// Runs to a tolerance in time.
#include <algorithm>

#include <gtest/gtest.h>

#include "sim/deploy/deployment.h"
#include "sim/generate/families.h"
#include "sim/generate/lattice.h"
#include "sim/trajectory/measures.h"

namespace kirireel {
namespace {

/// A sheet of squares that opens under its springs.
scene::Scene openingSheet(double tolerance) {
  scene::Scene scene;
  generate::TessellationShape shape;
  shape.columns = shape.rows = 4;
  shape.startAngle = 5 * kDegree;
  scene.model = generate::makeTessellation(shape);
  scene.environment.contacts = scene::ContactFilter::None;
  scene.path.kind = scene::PathKind::Straight;
  scene.solver.tolerance = tolerance;
  scene.stop.duration = 0.5;
  return scene;
}

run::DeploymentResult deployed(const scene::Scene& scene, double rate) {
  return deploy::deploy(scene, 1 / rate, nullptr);
}

/// The largest distance of a vertex between two runs at a common time.
double largestDifference(const run::DeploymentResult& a, const run::DeploymentResult& b) {
  double largest = 0;
  const std::vector<brick::Brick>& bricks = a.trajectory.bricks;
  for (const trajectory::Sample& sample : a.trajectory.samples) {
    const auto same = std::ranges::find_if(
        b.trajectory.samples,
        [&](const trajectory::Sample& other) { return std::abs(other.time - sample.time) < 1e-9; });
    if (same == b.trajectory.samples.end()) continue;
    const std::vector<model::Tile> here = brick::bottomTiles(bricks, sample.poses);
    const std::vector<model::Tile> there = brick::bottomTiles(bricks, same->poses);
    for (std::size_t i = 0; i < here.size(); ++i) {
      for (std::size_t k = 0; k < here[i].vertices.size(); ++k) {
        largest = std::max(largest, (here[i].vertices[k] - there[i].vertices[k]).norm());
      }
    }
  }
  return largest;
}

TEST(TimeTolerance, SamplesBetweenStepsFollowBothSides) {
  // The same times are between the steps of one run and at the steps of the other.
  const double tolerance = 1e-5;
  scene::Scene aligned = openingSheet(tolerance);
  aligned.solver.timestep = 1.0 / (4 * 97);
  const double difference =
      largestDifference(deployed(openingSheet(tolerance), 97), deployed(aligned, 97));
  EXPECT_GT(difference, 0);
  // Cubics through the ends of a step of 1/60 s, of fourth order.
  EXPECT_LT(difference, 2e-4);  // measured 9.5e-5
}

TEST(TimeTolerance, IsKeptBySteps) {
  const run::DeploymentResult exact = deployed(openingSheet(1e-7), 60);
  for (const double tolerance : {1e-3, 1e-5}) {
    const run::DeploymentResult run = deployed(openingSheet(tolerance), 60);
    EXPECT_LT(largestDifference(run, exact), 10 * tolerance)
        << tolerance;  // measured 0.3 and 0.9 times
    EXPECT_EQ(run.cost.took.touchingTime, 0);
    EXPECT_EQ(run.cost.took.singularTime, 0);
    for (const trajectory::Sample& sample : run.trajectory.samples)
      EXPECT_LT(sample.jointGap, 1e-9);
  }
}

TEST(TimeTolerance, FixedStepsAreFarFromIt) {
  const run::DeploymentResult exact = deployed(openingSheet(1e-6), 60);
  EXPECT_GT(largestDifference(deployed(openingSheet(0), 60), exact), 1e-3);  // measured 0.04
}

TEST(TimeTolerance, SamplesDependOnNoOtherSample) {
  const run::DeploymentResult sparse = deployed(openingSheet(1e-4), 30);
  const run::DeploymentResult dense = deployed(openingSheet(1e-4), 120);
  EXPECT_EQ(largestDifference(sparse, dense), 0);
  EXPECT_EQ(sparse.cost.took.steps, dense.cost.took.steps);
}

TEST(TimeTolerance, IsKeptThroughAFallOnTheGround) {
  // A brick falls by 0.2 m to the ground and rests there.
  scene::Scene scene;
  scene.model.tiles = {{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}}};
  scene.brick.thickness = 0.1;
  scene.environment.gravity = {0, 0, -10};
  scene.environment.ground = scene::Ground{-0.2, 0.5};
  scene.environment.linearDamping = scene.environment.angularDamping = 0;
  scene.actuation.drive = scene::Drive::None;
  scene.solver.tolerance = 1e-4;
  scene.stop.duration = 1;
  const run::DeploymentResult run = deployed(scene, 60);
  EXPECT_EQ(run.outcome, run::Outcome::Settled) << run.reason;
  for (const trajectory::Sample& sample : run.trajectory.samples) {
    const double fallen = std::min(0.2, 5 * sample.time * sample.time);
    EXPECT_NEAR(sample.poses[0].position.z(), 0.05 - fallen, 1e-6);  // measured 5e-8
  }
  EXPECT_EQ(run.cost.took.touchingTime, 0);
  EXPECT_EQ(run.cost.took.singularTime, 0);
}

TEST(TimeTolerance, ReportsForHowLongContactsWereTooMany) {
  // Weights fall on a heap. Their corners touch one after the other, and slide.
  scene::Scene scene;
  for (int layer = 0; layer < 6; ++layer) {
    const double x = 0.3 * layer, z = 0.15 * layer;
    scene.model.tiles.push_back({{{x, 0, z}, {x + 1, 0, z}, {x + 1, 1, z}, {x, 1, z}}});
  }
  scene.brick.thickness = 0.1;
  scene.environment.contacts = scene::ContactFilter::All;
  scene.environment.gravity = {0, 0, -10};
  scene.environment.ground = scene::Ground{-0.2, 0.5};
  scene.environment.brickFriction = 0.5;
  scene.actuation.drive = scene::Drive::None;
  scene.solver.tolerance = 1e-4;
  scene.stop.duration = 1;
  const run::DeploymentResult run = deployed(scene, 60);
  EXPECT_GT(run.cost.took.touchingTime, 0);
  EXPECT_LT(run.cost.took.touchingTime, run.trajectory.samples.back().time - 0.15);
  EXPECT_LT(run.accuracy.penetrationGrownMax, 1e-4);
}

TEST(TimeTolerance, ContinuesThroughSingularStarts) {
  scene::Scene scene = openingSheet(1e-4);
  generate::TessellationShape shape;
  shape.columns = shape.rows = 4;
  scene.model = generate::makeTessellation(shape);  // closed
  scene.stop.duration = 5;
  const run::DeploymentResult run = deployed(scene, 60);
  EXPECT_EQ(run.outcome, run::Outcome::Settled) << run.reason;
  EXPECT_LT(run.accuracy.targetErrorEnd, 1e-5);
  EXPECT_LT(run.accuracy.jointGapMax, 1e-10);
}

}  // namespace
}  // namespace kirireel
