/// Contacts and friction against closed forms.
#include <numbers>

#include <gtest/gtest.h>

#include "sim/formats/read_model.h"
#include "sim/generate/lattice.h"
#include "sim/run/dynamics.h"
#include "sim/study/stepped_scene.h"
#include "sim/trajectory/measures.h"
#include "tests/sim/run/moving.h"
#include "tests/support/physics.h"

namespace kirireel {
namespace {

using test::Moving;

using test::kGravity;
using test::kStep;
using test::rectangle;

/// Bricks without joints, targets or damping in free flight.
scene::Scene looseBricks(const std::vector<model::Tile>& tiles, double thickness) {
  scene::Scene scene;
  scene.model.tiles = tiles;
  scene.brick.thickness = thickness;
  scene.environment.contacts = scene::ContactFilter::All;
  scene.environment.linearDamping = scene.environment.angularDamping = 0;
  scene.solver.timestep = kStep;
  return scene;
}

/// A block on a slope of the given angle: the plane stays level, gravity is tilted.
scene::Scene blockOnSlope(double angle, double friction) {
  scene::Scene scene = looseBricks({rectangle({0, 0, 0}, 1, 1)}, 0.2);
  scene.environment.gravity = {kGravity * std::sin(angle), 0, -kGravity * std::cos(angle)};
  scene.environment.ground = scene::Ground{0, friction};
  scene.solver.planar = false;
  return scene;
}

// The bricks given to a solver may be destroyed or changed after it is made.
TEST(DirectDynamics, KeepsItsOwnBricks) {
  const scene::Scene scene = looseBricks({rectangle({0, 0, 0}, 1, 1)}, 0.2);
  Moving kept(scene), changed(scene);
  for (brick::Brick& brick : changed.bricks) brick.mass *= 100;
  kept.advance(10, {1, 0, 0});
  changed.advance(10, {1, 0, 0});
  EXPECT_EQ(kept.motion.poses[0].position, changed.motion.poses[0].position);
}

TEST(Slope, HoldsABlockBelowTheAngleOfFriction) {
  for (const double friction : {0.2, 0.5, 0.8}) {
    for (const double part : {0.5, 0.9, 0.99}) {
      SCOPED_TRACE(friction);
      const double angle = part * std::atan(friction);
      Moving block(blockOnSlope(angle, friction));
      const Vector3 start = block.motion.poses[0].position;
      block.advance(240);
      EXPECT_LT((block.motion.poses[0].position - start).norm(), 1e-9);  // measured 1e-15
      EXPECT_LT(block.motion.velocities[0].linear.norm(), 1e-9);         // measured 2e-23
      EXPECT_EQ(block.unconverged, 0);
    }
  }
}

TEST(Slope, LetsABlockSlideAboveTheAngleOfFriction) {
  for (const double friction : {0.0, 0.2, 0.5}) {
    for (const double more : {0.05, 0.2}) {
      SCOPED_TRACE(friction);
      const double angle = std::atan(friction) + more;
      Moving block(blockOnSlope(angle, friction));
      block.advance(24);
      const double before = block.motion.velocities[0].linear.x();
      block.advance(240);
      const double acceleration = block.motion.velocities[0].linear.x() - before;
      const double expected = kGravity * (std::sin(angle) - friction * std::cos(angle));
      EXPECT_NEAR(acceleration, expected, 0.01 * expected);         // measured 3e-15
      EXPECT_NEAR(block.motion.velocities[0].linear.y(), 0, 1e-9);  // measured 2e-18
      EXPECT_GT(block.lowest, -1e-4);                               // measured 0
      EXPECT_EQ(block.unconverged, 0);
    }
  }
}

TEST(Slope, BrakesASlidingBlock) {
  // Friction decelerates by mu g at most, then holds.
  const double friction = 0.4;
  Moving block(blockOnSlope(0, friction));
  block.motion.velocities[0].linear = {1.2, 1.6, 0};
  double speed = 2;
  for (int step = 0; step < 240; ++step) {
    block.advance(1);
    const double now = block.motion.velocities[0].linear.norm();
    EXPECT_LT(speed - now, 1.0001 * friction * kGravity * kStep);
    speed = now;
  }
  const Vector3 slid = block.motion.poses[0].position - Vector3(0.5, 0.5, 0.1);
  const double expected = 2 * 2 / (2 * friction * kGravity);
  EXPECT_NEAR(slid.head<2>().norm(), expected, 0.01 * expected);  // measured 4e-3: the step
  EXPECT_NEAR(slid.y() / slid.x(), 4.0 / 3, 1e-9);                // measured 4e-15
  EXPECT_LT(speed, 1e-9);                                         // measured 2e-41
}

TEST(Slope, FrictionKeepsItsBoundWhenTheStepChanges) {
  const double friction = 0.4;
  Moving block(blockOnSlope(0, friction));
  block.motion.velocities[0].linear.x() = 5;
  for (const double part : {1.0, 1.0, 1.0, 0.1, 0.1, 2.0, 2.0}) {
    block.scene.solver.timestep = part * kStep;
    const double before = block.motion.velocities[0].linear.x();
    block.advance(1);
    const double braked = before - block.motion.velocities[0].linear.x();
    EXPECT_LT(braked, 1.0001 * friction * kGravity * part * kStep);
  }
}

TEST(Slope, TipsABlockOnASteepSlope) {
  // Twice as high as wide: it tips over its edge beyond atan(1/2), for any friction.
  for (const double angle : {0.44, 0.49}) {
    scene::Scene scene = blockOnSlope(angle, 5);
    scene.brick.thickness = 2;
    Moving block(scene);
    block.advance(120);
    const double tilt = 2 * block.motion.poses[0].rotation.vec().norm();
    if (angle < std::atan(0.5)) {
      EXPECT_LT(tilt, 1e-9);  // measured 2e-16
    } else {
      EXPECT_GT(tilt, 0.02);  // measured 0.025
    }
  }
}

/// Two bricks that collide along x at the middle of their sides.
scene::Scene headOn(double widthA, double widthB) {
  scene::Scene scene = looseBricks(
      {rectangle({0, -0.5 * widthA, 0}, 1, widthA), rectangle({1.5, -0.5 * widthB, 0}, 1, widthB)},
      0.1);
  scene.brick.mass = brick::MassRule::Prism;
  return scene;
}

TEST(HeadOn, BricksContinueTogetherWithTheirMomentum) {
  for (const bool planar : {true, false}) {
    for (const double speed : {0.1, 2.0, 40.0}) {
      SCOPED_TRACE(speed);
      scene::Scene scene = headOn(1, 0.4);
      scene.solver.planar = planar;
      Moving pair(scene);
      pair.motion.velocities[0].linear.x() = speed;
      pair.motion.velocities[1].linear.x() = -0.5 * speed;
      const double massA = pair.bricks[0].mass, massB = pair.bricks[1].mass;
      pair.advance(static_cast<int>(1.5 * 0.5 / (1.5 * speed) / kStep) + 20);
      const double common = speed * (massA - 0.5 * massB) / (massA + massB);
      for (const Velocity& velocity : pair.motion.velocities) {
        EXPECT_NEAR(velocity.linear.x(), common, 1e-9 * speed);  // measured 4e-12
        EXPECT_NEAR(velocity.linear.y(), 0, 1e-6 * speed);       // measured 0
        EXPECT_NEAR(velocity.angular.norm(), 0, 1e-6 * speed);   // measured 0
      }
      const double momentum = massA * pair.motion.velocities[0].linear.x() +
                              massB * pair.motion.velocities[1].linear.x();
      EXPECT_NEAR(momentum, speed * (massA - 0.5 * massB), 1e-9 * speed * massA);  // measured 0
      EXPECT_LT(pair.deepest, 1e-5);                                               // measured 0
      EXPECT_EQ(pair.unconverged, 0);
    }
  }
}

TEST(HeadOn, FrictionlessBricksKeepTheirSpeedAlongTheSide) {
  scene::Scene scene = headOn(1, 1);
  scene.solver.planar = false;
  Moving pair(scene);
  pair.motion.velocities[0].linear = {2, 0.3, 0.01};
  pair.motion.velocities[1].linear = {-2, -0.1, 0};
  pair.advance(60);
  const Vector3 a = pair.motion.velocities[0].linear, b = pair.motion.velocities[1].linear;
  EXPECT_LT((a + b - Vector3(0, 0.2, 0.01)).norm(), 1e-12);  // measured 7e-17
  EXPECT_LT(pair.deepest, 1e-5);                             // measured 0
  EXPECT_EQ(pair.unconverged, 0);
}

TEST(HeadOn, ACornerOnASideTurnsBothBricksByTheImpulse) {
  scene::Scene scene = headOn(1, 1);
  scene.solver.planar = true;
  Moving pair(scene);
  pair.motion.poses[1].position.y() -= 0.2;
  pair.motion.poses[1].rotation = rotationFromVector({0, 0, 0.3});
  pair.motion.velocities[0].linear.x() = 3;
  Poses before;
  do {
    before = pair.motion.poses;
    pair.advance(1);
  } while (pair.motion.velocities[1].linear.x() < 1e-9 && pair.motion.poses[0].position.x() < 3);
  // One impulse along x at the corner nearest to A.
  const double mass = pair.bricks[0].mass, inertia = pair.bricks[0].inertia(2, 2);
  const double impulse = mass * pair.motion.velocities[1].linear.x();
  EXPECT_GT(impulse, 0.01 * mass);
  EXPECT_NEAR(3 - pair.motion.velocities[0].linear.x(), impulse / mass, 1e-9);  // measured 2e-16
  Vector3 corner = before[1].position;
  for (const Vector3& point : pair.bricks[1].bottom) {
    if (before[1].apply(point).x() < corner.x()) corner = before[1].apply(point);
  }
  const double armA = corner.y() - before[0].position.y();
  const double armB = corner.y() - before[1].position.y();
  EXPECT_NEAR(pair.motion.velocities[0].angular.z(), impulse * armA / inertia,
              1e-8);  // measured 3e-18
  EXPECT_NEAR(pair.motion.velocities[1].angular.z(), -impulse * armB / inertia,
              1e-8);  // measured 0
}

TEST(Stack, RestsForTenSeconds) {
  scene::Scene scene = looseBricks({rectangle({0, 0, 0}, 1, 1), rectangle({0.1, 0.05, 0.2}, 1, 1),
                                    rectangle({-0.05, 0, 0.4}, 1, 1)},
                                   0.2);
  scene.environment.gravity = {0, 0, -kGravity};
  scene.environment.ground = scene::Ground{0, 0.5};
  Moving stack(scene);
  const Poses start = stack.motion.poses;
  stack.advance(2400);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_LT((stack.motion.poses[i].position - start[i].position).norm(), 1e-6);  // measured 0
    EXPECT_LT(stack.motion.poses[i].rotation.vec().norm(), 1e-9);                  // measured 8e-16
  }
  EXPECT_LT(stack.deepest, 1e-5);  // measured 6e-17
  EXPECT_EQ(stack.unconverged, 0);
}

TEST(Heap, FallsWithoutOverlap) {
  std::vector<model::Tile> tiles;
  for (int i = 0; i < 8; ++i) tiles.push_back(rectangle({2.0 * i, 0, 0}, 1, 1));
  for (const double thickness : {0.001, 0.02, 0.2}) {
    SCOPED_TRACE(thickness);
    scene::Scene scene = looseBricks(tiles, thickness);
    scene.environment.gravity = {0, 0, -kGravity};
    scene.environment.ground = scene::Ground{0, 0.5};
    scene.solver.planar = false;
    Moving heap(scene);
    for (int i = 0; i < 8; ++i) {
      Pose& pose = heap.motion.poses[i];
      pose.position = {0.3 * std::sin(7 * i), 0.3 * std::cos(5 * i), 0.5 + i};
      pose.rotation = rotationFromVector({0.3 * std::cos(3 * i), 0.3 * std::sin(4 * i), 1.0 * i});
    }
    heap.advance(360);
    EXPECT_GT(heap.deepest, 0);
    EXPECT_LT(heap.deepest, 1e-4);  // measured 4e-5
    EXPECT_LT(heap.lowest, 1e-4);
    EXPECT_GT(heap.lowest, -1e-4);  // measured -9e-6
    EXPECT_EQ(heap.unconverged, 0);
  }
}

/// The relative angular velocity of two joined free squares after some steps, from 1.4 rad open and
/// opening.
double turnRate(bool planar, scene::ContactFilter contacts, int steps) {
  generate::TessellationShape shape;
  shape.columns = 2;
  shape.rows = 1;
  shape.startAngle = 1.4;
  const model::Model model = generate::makeTessellation(shape);
  scene::Scene scene = looseBricks(model.tiles, 0.02);
  scene.model.joints = model.joints;
  scene.solver.planar = planar;
  scene.environment.contacts = contacts;
  Moving pair(scene);
  pair.motion.velocities[0].angular.z() = -3;
  pair.motion.velocities[1].angular.z() = 3;
  pair.advance(steps);
  return pair.motion.velocities[1].angular.z() - pair.motion.velocities[0].angular.z();
}

TEST(JoinedSquares, TurnPastNinetyDegreesUnhindered) {
  for (const bool planar : {true, false}) {
    const double free = turnRate(planar, scene::ContactFilter::None, 20);
    EXPECT_GT(free, 5);  // about 25 degrees from 80
    EXPECT_NEAR(turnRate(planar, scene::ContactFilter::All, 20), free, 1e-9);
  }
}

/// A brick of 1 mm that falls at 5 m/s, 20 times its thickness in a step, turned by `tilt`.
scene::Scene thinBricks(int count) {
  std::vector<model::Tile> tiles;
  for (int i = 0; i < count; ++i) tiles.push_back(rectangle({0.1 * i, 0.07 * i, 0.05 * i}, 1, 1));
  scene::Scene scene = looseBricks(tiles, 0.001);
  scene.environment.gravity = {0, 0, -kGravity};
  scene.environment.ground = scene::Ground{0, 0.5};
  scene.solver.planar = false;
  return scene;
}

TEST(ThinBrick, DoesNotFallThroughTheGround) {
  for (const double tilt : {0.0, 0.02, 0.4}) {
    SCOPED_TRACE(tilt);
    Moving brick(thinBricks(1));
    brick.motion.poses[0].position.z() += 0.3;
    brick.motion.poses[0].rotation = rotationFromVector({tilt, 0.3 * tilt, 0});
    brick.motion.velocities[0].linear.z() = -5;
    brick.advance(240);
    EXPECT_LT(brick.lowest, 1e-4);
    EXPECT_GT(brick.lowest, -1e-4);                             // measured -6e-9
    EXPECT_LT(brick.motion.velocities[0].linear.norm(), 1e-3);  // measured 4e-14
    EXPECT_EQ(brick.unconverged, 0);
  }
}

TEST(ThinBrick, DoesNotFallThroughAnother) {
  for (const double tilt : {0.0, 0.02, 0.4}) {
    SCOPED_TRACE(tilt);
    Moving pair(thinBricks(2));
    pair.motion.poses[1].position.z() += 0.3;
    pair.motion.poses[1].rotation = rotationFromVector({tilt, 0.3 * tilt, 0});
    pair.motion.velocities[1].linear.z() = -5;
    // The upper brick slides without friction. It tips over the lower one's edge after 3.1 s.
    pair.advance(180);
    EXPECT_LT(pair.deepest, 1e-4);  // measured 2e-7
    EXPECT_GT(pair.lowest, -1e-4);  // measured -5e-10
    EXPECT_GT(pair.motion.poses[1].position.z(), pair.motion.poses[0].position.z() + 0.9e-3);
    EXPECT_EQ(pair.unconverged, 0);
  }
}

TEST(BrickFriction, BrakesABrickOnAnother) {
  scene::Scene scene = looseBricks({rectangle({0, 0, 0}, 4, 1), rectangle({1, 0, 0.2}, 1, 1)}, 0.2);
  scene.environment.gravity = {0, 0, -kGravity};
  scene.environment.ground = scene::Ground{0, 100};  // holds the lower one
  scene.environment.brickFriction = 0.3;
  Moving pair(scene);
  pair.advance(10);
  const Vector3 before = pair.motion.poses[1].position;
  pair.motion.velocities[1].linear.x() = 1.5;
  pair.advance(240);
  const double expected = 1.5 * 1.5 / (2 * 0.3 * kGravity);
  EXPECT_NEAR(pair.motion.poses[1].position.x() - before.x(), expected,
              0.01 * expected);                              // measured 3e-3: the step
  EXPECT_LT(pair.motion.velocities[1].linear.norm(), 1e-9);  // measured 3e-24
  EXPECT_EQ(pair.unconverged, 0);
}

/// An unreachable target, with the strongest springs.
struct Squeeze {
  double penetration = 0;  ///< largest, in tile sizes
  double gap = 0;          ///< largest of a joint, in model sizes
  int unconverged = 0;
  double speed = 0;  ///< at the end
};

Squeeze squeeze(scene::Scene scene, int steps) {
  scene.environment.contacts = scene::ContactFilter::All;
  scene.springs.springStiffness = scene.springs.torqueStiffness = 2000;
  study::SteppedScene run(scene);
  Squeeze result;
  const double tile = model::tileSize(scene.model), size = model::modelSize(scene.model);
  for (int step = 0; step < steps; ++step) {
    run.advance();
    const double depth = trajectory::deepestPenetration(run.bricks(), run.motion().poses).depth;
    result.penetration = std::max(result.penetration, depth / tile);
    result.gap = std::max(result.gap, run.gap() / size);
  }
  result.unconverged = run.report().unconverged;
  for (const Velocity& velocity : run.motion().velocities) {
    result.speed = std::max(result.speed, velocity.linear.norm());
  }
  return result;
}

void expectHeld(const Squeeze& result) {
  EXPECT_LT(result.penetration, 1e-4);  // measured 8e-11
  EXPECT_LT(result.gap, 1e-10);         // measured 1.2e-11
  EXPECT_EQ(result.unconverged, 0);
  EXPECT_LT(result.speed, 1e-3);  // measured 5e-14
}

TEST(UnreachableTarget, ContactsStopSquaresThatWouldTurnThroughEachOther) {
  generate::TessellationShape shape;
  for (const bool planar : {true, false}) {
    for (const double start : {0.0, 0.5}) {
      SCOPED_TRACE(start);
      scene::Scene scene;
      shape.startAngle = start;
      scene.model = generate::makeTessellation(shape);
      scene.model.target = generate::tessellationTiles(shape, -0.4);
      scene.solver.planar = planar;
      expectHeld(squeeze(scene, 120));
    }
  }
}

TEST(UnreachableTarget, ContactsStopTilesThatWouldOverlap) {
  const std::filesystem::path folder =
      std::filesystem::path(KIRIREEL_SOURCE_DIR) / "data/tessellation_4x4";
  for (const bool planar : {true, false}) {
    scene::Scene scene;
    std::vector<std::string> warnings;
    scene.model = formats::readModelFolder(folder, warnings);
    scene.model.target = scene.model.tiles;
    for (model::Tile& tile : *scene.model.target) {
      const Vector3 shift = -0.3 * model::tileCentroid(tile);
      for (Vector3& vertex : tile.vertices) vertex += shift;
    }
    scene.solver.planar = planar;
    expectHeld(squeeze(scene, 120));
  }
}

/// A planar sheet on the ground, loose from targets.
scene::Scene sheetOnGround(double friction) {
  generate::TessellationShape shape;
  shape.startAngle = 0.6;
  scene::Scene scene;
  scene.model = generate::makeTessellation(shape);
  scene.model.target.reset();
  scene.environment.linearDamping = scene.environment.angularDamping = 0;
  scene.environment.gravity = {0, 0, -kGravity};
  scene.environment.ground = scene::Ground{0, friction};
  scene.solver.timestep = kStep;
  return scene;
}

TEST(PlanarGround, BrakesASlidingSheet) {
  const double friction = 0.4;
  Moving sheet(sheetOnGround(friction));
  const Poses start = sheet.motion.poses;
  for (Velocity& velocity : sheet.motion.velocities) velocity.linear = {1.2, 1.6, 0};
  sheet.advance(24);
  const double speed = 2 - friction * kGravity * 0.1;
  EXPECT_NEAR(sheet.motion.velocities[0].linear.norm(), speed, 1e-9);  // measured 1e-13
  sheet.advance(216);
  const double expected = 2 * 2 / (2 * friction * kGravity);
  for (std::size_t i = 0; i < start.size(); ++i) {
    const Vector3 slid = sheet.motion.poses[i].position - start[i].position;
    EXPECT_NEAR(slid.norm(), expected, 0.01 * expected);        // measured 4e-3: the step
    EXPECT_LT(sheet.motion.velocities[i].linear.norm(), 1e-9);  // measured 2e-28
  }
  EXPECT_EQ(sheet.unconverged, 0);
}

TEST(PlanarGround, HoldsASheetBelowTheBoundOnly) {
  const double friction = 0.4;
  for (const double part : {0.5, 0.99, 1.1, 2.0}) {
    SCOPED_TRACE(part);
    Moving sheet(sheetOnGround(friction));
    const Poses start = sheet.motion.poses;
    const double bound = friction * kGravity;  // every brick weighs 1 kg
    sheet.advance(240, {0.6 * part * bound, -0.8 * part * bound, 0});
    const double speed = sheet.motion.velocities[5].linear.norm();
    const double moved = (sheet.motion.poses[5].position - start[5].position).norm();
    if (part < 1) {
      EXPECT_LT(speed, 1e-9);  // measured 5e-25
      EXPECT_LT(moved, 1e-9);  // measured 4e-16
    } else {
      EXPECT_NEAR(speed, (part - 1) * bound, 0.01 * (part - 1) * bound);  // measured 5e-12
    }
    EXPECT_EQ(sheet.unconverged, 0);
  }
}

TEST(PlanarGround, BrakesATurningTile) {
  // Under an even pressure the mean arm of a square is (sqrt 2 + asinh 1) / 6; its inertia is m/6.
  scene::Scene scene = sheetOnGround(0.4);
  scene.model.tiles = {rectangle({0, 0, 0}, 1, 1)};
  scene.model.joints.clear();
  Moving tile(scene);
  tile.motion.velocities[0].angular.z() = 10;
  tile.advance(72);
  const double braking = 0.4 * kGravity * (std::numbers::sqrt2 + std::asinh(1.0));
  EXPECT_NEAR(tile.motion.velocities[0].angular.z(), 10 - 0.3 * braking,
              0.01 * 0.3 * braking);  // measured 2e-14
  EXPECT_LT(tile.motion.velocities[0].linear.norm(), 1e-9);
  tile.advance(240);
  EXPECT_NEAR(tile.motion.velocities[0].angular.z(), 0, 1e-9);  // measured 3e-29
}

}  // namespace
}  // namespace kirireel
