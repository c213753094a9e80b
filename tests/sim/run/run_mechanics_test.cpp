// Energies and forces of whole runs, against mechanics and statics.
#include <cmath>

#include <gtest/gtest.h>

#include "sim/deploy/deployment.h"
#include "sim/generate/lattice.h"
#include "tests/sim/run/moving.h"
#include "tests/support/physics.h"

namespace kirireel {
namespace {

using namespace scene::timeline;

using test::kGravity;

/// A sheet of squares that opens under its springs, by dynamics.
scene::Scene openingSheet() {
  scene::Scene scene;
  generate::TessellationShape shape;
  shape.columns = shape.rows = 4;
  shape.startAngle = 20 * kDegree;
  scene.model = generate::makeTessellation(shape);
  scene.environment.contacts = scene::ContactFilter::None;
  scene.path.kind = scene::PathKind::Straight;
  scene.springs.adaptive = false;
  scene.stop.duration = 1;
  return scene;
}

/// Squares without joints, target and damping, `height` above a ground without friction.
scene::Scene fallingBricks(double height) {
  scene::Scene scene;
  scene.model.tiles = {{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}}};
  scene.brick.thickness = 0.2;
  scene.environment.contacts = scene::ContactFilter::All;
  scene.environment.linearDamping = scene.environment.angularDamping = 0;
  scene.environment.gravity = {0, 0, -kGravity};
  scene.environment.ground = scene::Ground{-height, 0};
  scene.actuation.drive = scene::Drive::None;
  scene.solver.planar = false;
  scene.stop.duration = 1;
  return scene;
}

std::vector<trajectory::Sample> samplesOf(const scene::Scene& scene, double interval = 1.0 / 30) {
  return deploy::deploy(scene, interval, nullptr).trajectory.samples;
}

/// The largest energy in any sample that the integrator has removed, over the whole work.
double worstBalance(const std::vector<trajectory::Sample>& samples) {
  double worst = 0;
  for (const trajectory::Sample& sample : samples) {
    const trajectory::Energies& energies = sample.mechanics->energies;
    worst = std::max(worst, std::abs(energies.integrated()) / energies.work);
  }
  return worst;
}

TEST(Energies, BalanceToTheTolerance) {
  for (const double damping : {1.0, 0.1}) {
    scene::Scene scene = openingSheet();
    scene.springs.dampingRatio = damping;
    for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
      scene.solver.tolerance = tolerance;
      const std::vector<trajectory::Sample> samples = samplesOf(scene, 1.0 / 97);
      // Measured: 0.24 to 1.2 times the tolerance, and 0.9 to 6.2 times with less damping.
      EXPECT_LT(worstBalance(samples), 10 * tolerance) << tolerance << " " << damping;
      // Most of the work is lost in dampers.
      const trajectory::Energies& end = samples.back().mechanics->energies;
      EXPECT_GT(end.damped, 0.5 * end.work);
    }
  }
}

// The guide starts at the tiles: its springs have no energy yet, and no work was done.
TEST(Energies, OfAGuidedRunBeginAtZero) {
  scene::Scene scene = openingSheet();
  scene.path.kind = scene::PathKind::Guided;
  const std::vector<trajectory::Sample> samples = samplesOf(scene);
  const trajectory::Energies& first = samples.front().mechanics->energies;
  EXPECT_LT(first.spring, 1e-20);
  EXPECT_LT(first.work - first.kinetic, 1e-20);
  for (std::size_t k = 1; k < samples.size(); ++k) {
    EXPECT_GE(samples[k].mechanics->energies.damped, samples[k - 1].mechanics->energies.damped);
  }
}

TEST(Energies, BalanceToFirstOrderInFixedSteps) {
  double before = 0;
  for (const double step : {1.0 / 240, 1.0 / 480, 1.0 / 960}) {
    scene::Scene scene = openingSheet();
    scene.solver.timestep = step;
    const double worst = worstBalance(samplesOf(scene));
    if (before > 0) {
      EXPECT_NEAR(worst / before, 0.5, 0.06);  // measured 0.549 and 0.527
    }
    before = worst;
  }
  EXPECT_LT(before, 0.02);  // measured 0.018
}

TEST(Energies, OfAFallAreThoseOfGravity) {
  scene::Scene scene = fallingBricks(10);
  scene.stop.duration = 0.5;
  for (const double tolerance : {0.0, 1e-6}) {
    scene.solver.tolerance = tolerance;
    const std::vector<trajectory::Sample> samples = samplesOf(scene);
    const trajectory::Sample &first = samples.front(), &last = samples.back();
    const double fallen = first.poses[0].position.z() - last.poses[0].position.z();
    const trajectory::Energies& end = last.mechanics->energies;
    EXPECT_NEAR(end.work, kGravity * fallen, 1e-9 * end.work);  // mass 1
    EXPECT_EQ(end.damped, 0);
    EXPECT_EQ(end.impacted, 0);
    EXPECT_NEAR(end.kinetic, end.work, (tolerance > 0 ? 1e-9 : 0.01) * end.work);
  }
}

TEST(Energies, AreLostInAnImpact) {
  scene::Scene scene = fallingBricks(0.5);
  const trajectory::Energies end = samplesOf(scene).back().mechanics->energies;
  // The bottom falls by half a metre, and all of that energy is lost.
  EXPECT_NEAR(end.work, 0.5 * kGravity, 1e-4);
  EXPECT_NEAR(end.kinetic, 0, 1e-9);
  EXPECT_NEAR(end.impacted, end.work, 1e-6 * end.work);  // measured 3e-9
}

/// Two squares of side 1 that share a corner and move with (1, 0.5) m/s, without forces.
scene::Scene movingSquares() {
  scene::Scene scene;
  scene.model.tiles = {{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}},
                       {{{1, 1, 0}, {2, 1, 0}, {2, 2, 0}, {1, 2, 0}}}};
  scene.model.joints = {{{0, 2}, {1, 0}}};
  scene.environment.contacts = scene::ContactFilter::None;
  scene.environment.linearDamping = scene.environment.angularDamping = 0;
  scene.actuation.drive = scene::Drive::None;
  scene.stop.duration = 0.2;
  scene::InitialVelocity velocity;
  velocity.linear = {1, 0.5, 0};
  scene.velocities = {velocity};
  return scene;
}

// One square stops. The other keeps its spin about the corner: with I = 2/3 m, L = -m/4, this is
// 3/80 of the energy before.
TEST(Energies, AreLostAtAPinAsInAnImpact) {
  scene::Scene scene = movingSquares();
  scene.timeline = {{{scene::Trigger::Kind::AtTime, 0.1}, Pin{{0}}, {}}};
  for (const double tolerance : {0.0, 1e-6}) {
    scene.solver.tolerance = tolerance;
    const std::vector<trajectory::Sample> samples = samplesOf(scene);
    const double before = samples.front().mechanics->energies.kinetic;
    const trajectory::Energies& end = samples.back().mechanics->energies;
    EXPECT_GT(before, 0);
    EXPECT_NEAR(end.impacted / before, 77.0 / 80, 1e-9) << tolerance;
    EXPECT_NEAR(end.work, before, 1e-9 * before);
    // Euler steps reduce the spin.
    EXPECT_NEAR(end.integrated() / before, 0, tolerance > 0 ? 1e-6 : 1e-3) << tolerance;
  }
}

// A tile at rest, or pinned again, loses nothing.
TEST(Energies, AreKeptAtAPinOfATileAtRest) {
  scene::Scene scene = movingSquares();
  scene.velocities.clear();
  scene.solver.tolerance = 1e-6;
  scene.timeline = {{{scene::Trigger::Kind::AtTime, 0.05}, Pin{{0}}, {}},
                    {{scene::Trigger::Kind::AtTime, 0.1}, Pin{{0}}, {}}};
  EXPECT_NEAR(samplesOf(scene).back().mechanics->energies.impacted, 0, 1e-12);  // measured 2e-13
}

TEST(Energies, CountTheWorkOfAGrip) {
  scene::Scene scene = openingSheet();
  scene.actuation.drive = scene::Drive::None;
  scene.timeline = {{scene::Trigger{}, Drag{.tile = 0, .path = {{-2, -1, 0}}, .seconds = 0.8}}};
  scene.solver.tolerance = 1e-5;
  const std::vector<trajectory::Sample> samples = samplesOf(scene, 1.0 / 60);
  // When the work is not negligible.
  const std::vector<trajectory::Sample> later(samples.begin() + 5, samples.end());
  EXPECT_LT(worstBalance(later), 1e-4);  // measured 2.8e-5
  // A grip pulls with the spring of its hold along the path.
  bool isGripped = false;
  for (const trajectory::Sample& sample : samples) {
    for (const trajectory::Hold& hold : sample.mechanics->holds) {
      EXPECT_EQ(hold.kind, trajectory::HoldKind::Grip);
      EXPECT_EQ(hold.tile, 0);
      isGripped = isGripped || hold.force.x() < 0;
    }
  }
  EXPECT_TRUE(isGripped);
}

TEST(Holds, CarryWhatRestsOnTheGround) {
  scene::Scene scene = fallingBricks(0);
  const trajectory::Mechanics end = *samplesOf(scene).back().mechanics;
  ASSERT_EQ(end.holds.size(), 1U);  // four corners, one resultant
  EXPECT_EQ(end.holds[0].kind, trajectory::HoldKind::Contact);
  EXPECT_EQ(end.holds[0].tile, 0);
  EXPECT_EQ(end.holds[0].other, trajectory::Hold::kGround);
  EXPECT_LT((end.holds[0].force - Vector3(0, 0, kGravity)).norm(), 1e-6);  // measured
  EXPECT_LT((end.holds[0].point - Vector3(0.5, 0.5, 0)).norm(), 1e-5);
  EXPECT_LT(end.holds[0].moment.norm(), 1e-6);
}

// A brick slides on the ground in its plane. The ground carries the weight and brakes with mu times
// the weight. Its pressure is farther in front, so that the brick does not tip: the moment about
// the centre of mass is 0.
TEST(Holds, OfAPlanarBrickIncludeTheWeight) {
  for (const double friction : {0.0, 0.3}) {
    scene::Scene scene = fallingBricks(0);
    scene.environment.ground->friction = friction;
    scene.solver.planar = true;
    scene.velocities = {{{}, {1, 0, 0}, {}}};
    scene.stop.duration = 0.2;
    const std::vector<trajectory::Sample> samples = samplesOf(scene);
    EXPECT_TRUE(samples.front().mechanics->holds.empty());
    for (std::size_t k = 1; k < samples.size(); ++k) {
      const std::vector<trajectory::Hold>& holds = samples[k].mechanics->holds;
      ASSERT_EQ(holds.size(), 1U) << k;
      const Vector3 force(-friction * kGravity, 0, kGravity);  // of 1 kg
      EXPECT_LT((holds[0].force - force).norm(), 1e-6) << holds[0].force.transpose();
      const Vector3 arm = holds[0].point - samples[k].poses[0].position;
      EXPECT_NEAR(arm.z(), -0.1, 1e-9);
      EXPECT_LT((arm.cross(holds[0].force) + holds[0].moment).norm(), 1e-9);
    }
  }
}

// A planar brick slides along a held one, which the force (5, -3) m presses it against. Forces and
// moments about its centre of mass are in balance with its constant acceleration.
TEST(Holds, OfAPlanarBrickAlongAnotherAreInBalance) {
  const double wall = 0.2, ground = 0.3;  // friction
  scene::Scene scene = fallingBricks(0);
  scene.model.tiles = {test::rectangle({-2, -0.5, 0}, 4, 0.5),
                       test::rectangle({-1, 0, 0}, 0.6, 0.4)};
  scene.environment.brickFriction = wall;
  scene.environment.ground->friction = ground;
  scene.environment.gravity = {5, -3, -kGravity};
  scene.solver.planar = true;
  scene.solver.tolerance = 1e-8;
  scene.timeline = {{scene::Trigger{}, Pin{{0}}}};
  scene.stop.duration = 0.2;
  const Vector3 acceleration(5 - 3 * wall - kGravity * ground, 0, 0);
  for (const trajectory::Sample& sample : samplesOf(scene)) {
    if (sample.time < 0.1) continue;  // the impact is over
    Vector3 force = scene.environment.gravity - acceleration, moment = Vector3::Zero();  // of 1 kg
    int count = 0;
    for (const trajectory::Hold& hold : sample.mechanics->holds) {
      if (hold.tile != 1 && hold.other != 1) continue;
      const double sign = hold.tile == 1 ? 1 : -1;
      force += sign * hold.force;
      moment += sign * ((hold.point - sample.poses[1].position).cross(hold.force) + hold.moment);
      ++count;
    }
    EXPECT_EQ(count, 2);
    EXPECT_LT(force.norm(), 1e-6) << force.transpose();
    EXPECT_LT(moment.norm(), 1e-6) << moment.transpose();
  }
}

/// Squares hung corner to corner between two pinned ones, by gravity along -y in the plane.
scene::Scene hangingChain(int count) {
  scene::Scene scene;
  const double r = std::sqrt(0.5);
  for (int i = 0; i < count; ++i) {
    const double x = 2 * r * i;
    scene.model.tiles.push_back({{{x, -r, 0}, {x + r, 0, 0}, {x, r, 0}, {x - r, 0, 0}}});
    if (i > 0) scene.model.joints.push_back({{i - 1, 1}, {i, 3}});
  }
  scene.environment.contacts = scene::ContactFilter::None;
  scene.environment.gravity = {0, -kGravity, 0};
  scene.environment.linearDamping = scene.environment.angularDamping = 0.95;
  scene.actuation.drive = scene::Drive::None;
  scene.stop.duration = 60;
  scene.stop.settleSpeed = 1e-8;
  scene.timeline = {{scene::Trigger{}, Pin{{0}}}};
  return scene;
}

TEST(Holds, OfAHangingChainCarryItsWeight) {
  const int count = 6;
  const scene::Scene scene = hangingChain(count);
  const run::DeploymentResult result = deploy::deploy(scene, 1.0, nullptr);
  const trajectory::Sample& end = result.trajectory.samples.back();
  ASSERT_EQ(end.mechanics->holds.size(), 1U);
  const trajectory::Hold& pin = end.mechanics->holds[0];
  EXPECT_EQ(pin.kind, trajectory::HoldKind::Pin);
  EXPECT_EQ(pin.tile, 0);
  const Vector3 weight(0, kGravity, 0);  // that a tile needs
  EXPECT_LT((pin.force - count * weight).norm(), 1e-6 * count * kGravity)
      << pin.force.transpose() << " " << result.reason;
  for (int j = 0; j + 1 < count; ++j) {
    // The joint nearer to the pin carries all tiles beyond it.
    EXPECT_LT((end.mechanics->jointForces[j] + (count - 1 - j) * weight).norm(),
              1e-6 * count * kGravity)
        << j;
  }
}

// Flush tiles jam on a pinned one, which carries their weight. Forces that do not balance are not
// stored.
TEST(Holds, OfTouchingBricksBalanceOrAreAbsent) {
  scene::Scene scene;
  generate::TessellationShape shape;
  shape.columns = 3;
  shape.rows = 2;
  shape.skew = 20 * kDegree;
  scene.model = generate::makeTessellation(shape);
  scene.environment.contacts = scene::ContactFilter::All;
  scene.environment.gravity = {0, -kGravity, 0};
  scene.environment.linearDamping = scene.environment.angularDamping = 0;
  scene.actuation.drive = scene::Drive::None;
  scene.timeline = {{scene::Trigger{}, Pin{{1}}, {}}};
  scene.solver.planar = true;
  scene.solver.tolerance = 1e-6;
  scene.stop.duration = 0.3;
  const Vector3 weight(0, -6 * kGravity, 0);  // of 1 kg each
  for (const trajectory::Sample& sample : samplesOf(scene)) {
    const trajectory::Mechanics& mechanics = *sample.mechanics;
    double largest = kGravity;
    for (const Vector3& force : mechanics.jointForces) largest = std::max(largest, force.norm());
    if (!mechanics.jointForces.front().allFinite()) {
      EXPECT_TRUE(mechanics.holds.empty()) << sample.time;
      continue;
    }
    Vector3 pin = Vector3::Zero();
    for (const trajectory::Hold& hold : mechanics.holds) {
      if (hold.kind == trajectory::HoldKind::Pin) pin += hold.force;
    }
    // Five free bricks, each balanced to 5% of the largest force.
    const bool isAtRest = mechanics.energies.kinetic < 1e-6;
    EXPECT_TRUE(!isAtRest || (pin + weight).norm() < 0.25 * largest) << sample.time;
  }
}

TEST(Mechanics, AreTheSameWithMoreSamples) {
  const scene::Scene scene = openingSheet();
  const std::vector<trajectory::Sample> coarse = samplesOf(scene, 1.0 / 24);
  const std::vector<trajectory::Sample> fine = samplesOf(scene, 1.0 / 240);
  // The last of each is the run's end.
  for (std::size_t k = 0; k + 1 < coarse.size(); ++k) {
    const trajectory::Sample& same = fine.at(10 * k);
    EXPECT_EQ(coarse[k].mechanics->energies.damped, same.mechanics->energies.damped);
    EXPECT_EQ(coarse[k].mechanics->jointForces, same.mechanics->jointForces);
  }
}

TEST(Mechanics, ArePartOfNoPathAndNoEngine) {
  scene::Scene scene = openingSheet();
  scene.path.kind = scene::PathKind::Continuation;
  scene.springs = {};
  for (const trajectory::Sample& sample : samplesOf(scene)) EXPECT_FALSE(sample.mechanics);
  scene = openingSheet();
  scene.solver.kind = scene::SolverKind::Bullet;
  scene.stop.duration = 0.1;
  for (const trajectory::Sample& sample : samplesOf(scene)) EXPECT_FALSE(sample.mechanics);
}

}  // namespace
}  // namespace kirireel
