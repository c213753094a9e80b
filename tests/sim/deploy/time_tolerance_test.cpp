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

/// Centres of the tiles of a tessellation relative to the first one, whose first edge is along x,
/// at an angle between neighbours. Tiles turn by 0 or by that angle relative to the first one.
std::vector<Vector3> centres(generate::TessellationShape shape, double angle) {
  shape.startAngle = angle;
  const model::Model model = generate::makeTessellation(shape);
  const Vector3 edge = model.tiles[0].vertices[1] - model.tiles[0].vertices[0];
  const Eigen::AngleAxisd back(-std::atan2(edge.y(), edge.x()), Vector3::UnitZ());
  std::vector<Vector3> places;
  for (const model::Tile& tile : model.tiles) {
    Vector3 centre = Vector3::Zero();
    for (const Vector3& vertex : tile.vertices) centre += vertex / 4;
    places.push_back(centre);
  }
  const Vector3 first = places[0];
  for (Vector3& place : places) place = back * (place - first);
  return places;
}

/// Acceleration of the angle between neighbours of a sheet of unit squares of 1 kg, whose first
/// tile is pinned, under gravity. Derivatives by differences.
double angleAcceleration(const generate::TessellationShape& shape, const Vector3& gravity,
                         double angle, double rate) {
  constexpr double kStep = 1e-4;
  const double from = std::max(angle - kStep, 0.0);
  const auto a = centres(shape, from), b = centres(shape, from + kStep),
             c = centres(shape, from + 2 * kStep);
  const double at = (angle - from) / kStep;
  double force = 0, mass = 0, change = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Vector3 bend = (a[i] - 2 * b[i] + c[i]) / (kStep * kStep);
    const Vector3 slope = (c[i] - a[i]) / (2 * kStep) + (at - 1) * kStep * bend;
    force += gravity.dot(slope);
    mass += slope.squaredNorm();
    change += slope.dot(bend);
    const std::size_t row = i % static_cast<std::size_t>(shape.columns);
    const std::size_t column = i / static_cast<std::size_t>(shape.columns);
    if ((row + column) % 2 == 1) mass += 1.0 / 6;
  }
  return (force - change * rate * rate) / mass;
}

TEST(TimeTolerance, AClosedSheetFollowsItsEquationOfMotion) {
  const Vector3 gravity(-1, 2, 0);
  for (const int side : {2, 4, 6, 10}) {
    generate::TessellationShape shape;
    shape.columns = shape.rows = side;
    double angle = 0, rate = 0;
    constexpr int kSteps = 400;
    constexpr double kStep = 1.0 / kSteps;
    for (int k = 0; k < kSteps; ++k) {  // Runge and Kutta
      const auto at = [&](double a, double r) { return angleAcceleration(shape, gravity, a, r); };
      const double r1 = rate, f1 = at(angle, r1), r2 = rate + kStep / 2 * f1,
                   f2 = at(angle + kStep / 2 * r1, r2), r3 = rate + kStep / 2 * f2,
                   f3 = at(angle + kStep / 2 * r2, r3), r4 = rate + kStep * f3,
                   f4 = at(angle + kStep * r3, r4);
      angle += kStep / 6 * (r1 + 2 * r2 + 2 * r3 + r4);
      rate += kStep / 6 * (f1 + 2 * f2 + 2 * f3 + f4);
    }
    const std::vector<Vector3> exact = centres(shape, angle);
    for (const double tolerance : {1e-3, 1e-5, 1e-7}) {
      for (const bool planar : {true, false}) {
        if (!planar && side > 6) continue;
        scene::Scene scene = openingSheet(tolerance);
        scene.model = generate::makeTessellation(shape);
        scene.actuation.drive = scene::Drive::None;
        scene.environment.gravity = gravity;
        scene.environment.linearDamping = scene.environment.angularDamping = 0;
        scene.solver.planar = planar;
        scene.timeline = {{{}, scene::timeline::Pin{{0}}}};
        scene.stop.duration = 1;
        const run::DeploymentResult run = deployed(scene, 60);
        const Poses& end = run.trajectory.samples.back().poses;
        ASSERT_NEAR(run.trajectory.samples.back().time, 1, 1e-9);
        double miss = 0;
        for (std::size_t i = 0; i < end.size(); ++i) {
          const Vector3 place = end[i].position - end[0].position;
          miss = std::max(miss, (place - exact[i]).norm());
        }
        // Measured 1.3e-8 to 2.2e-5; without the start along the path 0.01 to 0.2.
        EXPECT_LT(miss, 4e-5) << side << ' ' << tolerance << ' ' << planar;
      }
    }
  }
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
