#include "sim/engines/bullet_world.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace kirireel {
namespace {

constexpr double kStep = 1.0 / 4800;
constexpr int kIterations = 50;

/// A unit square with its bottom at height z, one corner at (x, y).
model::Tile squareAt(double x, double y, double z) {
  model::Tile tile;
  tile.vertices = {{x, y, z}, {x + 1, y, z}, {x + 1, y + 1, z}, {x, y + 1, z}};
  return tile;
}

/// Bricks of unit mass and 0.1 m thickness, their start and their pivots.
struct Layout {
  std::vector<brick::Brick> bricks;
  Poses poses;
  std::vector<brick::Pivot> pivots;
};

Layout makeLayout(const std::vector<model::Tile>& tiles,
                  const std::vector<model::Joint>& joints = {}) {
  brick::BrickRule rule;
  rule.thickness = 0.1;
  Layout layout;
  layout.bricks = brick::makeBricks(tiles, rule);
  layout.poses = brick::startPoses(tiles, layout.bricks);
  layout.pivots = brick::makePivots(joints, layout.bricks);
  return layout;
}

engines::BulletWorld makeWorld(const Layout& layout, const scene::Environment& environment) {
  return engines::BulletWorld(layout.bricks, layout.poses, layout.pivots, environment,
                              {.iterations = kIterations});
}

/// No gravity, no damping, no contacts.
scene::Environment emptySpace() {
  scene::Environment environment;
  environment.contacts = scene::ContactFilter::None;
  environment.linearDamping = 0;
  environment.angularDamping = 0;
  return environment;
}

Motion motionOf(const engines::BulletWorld& world) {
  Motion motion;
  world.readMotion(motion);
  return motion;
}

void advance(engines::BulletWorld& world, int steps) {
  for (int k = 0; k < steps; ++k) world.advance(kStep);
}

double largestGap(const Layout& layout, const Poses& poses) {
  double gap = 0;
  for (const brick::Pivot& pivot : layout.pivots) {
    const Vector3 a = poses[pivot.brickA].apply(pivot.pointA);
    const Vector3 b = poses[pivot.brickB].apply(pivot.pointB);
    gap = std::max(gap, (a - b).norm());
  }
  return gap;
}

bool sameBits(const Motion& a, const Motion& b) {
  const auto samePose = [](const Pose& p, const Pose& q) {
    return p.position == q.position && p.rotation.coeffs() == q.rotation.coeffs();
  };
  const auto sameVelocity = [](const Velocity& v, const Velocity& w) {
    return v.linear == w.linear && v.angular == w.angular;
  };
  return std::ranges::equal(a.poses, b.poses, samePose) &&
         std::ranges::equal(a.velocities, b.velocities, sameVelocity);
}

TEST(BulletWorld, FallsByTheIntegratorsClosedForm) {
  const Layout layout = makeLayout({squareAt(0, 0, 0)});
  scene::Environment environment;
  environment.gravity = {0, 0, -9.81};
  environment.linearDamping = 0.05;
  engines::BulletWorld world = makeWorld(layout, environment);
  const int n = 4800;
  advance(world, n);
  // v' = a v + h g with a = (1 - damping)^h, then x' = x + h v'.
  const double a = std::pow(1 - 0.05, kStep);
  const double sum = (1 - std::pow(a, n)) / (1 - a);
  const double speed = -9.81 * kStep * sum;
  const double fall = -9.81 * kStep * kStep * (n - a * sum) / (1 - a);
  const Motion motion = motionOf(world);
  // Measured: 8e-13 and 4e-13.
  EXPECT_NEAR(motion.velocities[0].linear.z(), speed, 1e-11);
  EXPECT_NEAR(motion.poses[0].position.z() - layout.poses[0].position.z(), fall, 1e-11);
  EXPECT_EQ(motion.velocities[0].angular, Vector3::Zero());
}

TEST(BulletWorld, TurnsByTheWholeInertia) {
  model::Tile tile;
  // A tilted sliver: its inertia has products in brick axes.
  tile.vertices = {{0, 0, 0}, {2, 0.3, 1}, {2.2, 1, 1.2}};
  const Layout layout = makeLayout({tile});
  engines::BulletWorld world = makeWorld(layout, emptySpace());
  const Vector3 torque(0.3, -0.2, 0.5);
  world.applyLoad(0, Vector3::Zero(), torque);
  world.advance(kStep);
  const Vector3 expected = kStep * layout.bricks[0].inertia.inverse() * torque;
  // Measured: 1e-14 of it.
  EXPECT_LT((motionOf(world).velocities[0].angular - expected).norm(), 1e-11 * expected.norm());
}

TEST(BulletWorld, AppliesALoadForOneStepOnly) {
  const Layout layout = makeLayout({squareAt(0, 0, 0)});
  engines::BulletWorld world = makeWorld(layout, emptySpace());
  world.applyLoad(0, {2, 0, 0}, Vector3::Zero());
  advance(world, 3);
  EXPECT_DOUBLE_EQ(motionOf(world).velocities[0].linear.x(), 2 * kStep);
}

TEST(BulletWorld, LeavesABrickAtRestOnTheGround) {
  const Layout layout = makeLayout({squareAt(0, 0, 0.25)});
  scene::Environment environment;
  environment.gravity = {0, 0, -9.81};
  environment.ground = scene::Ground{0.25, 0.5};
  engines::BulletWorld world = makeWorld(layout, environment);
  advance(world, 4800);
  const Motion motion = motionOf(world);
  // Measured: 2e-8 m and 9e-9 m/s.
  EXPECT_LT((motion.poses[0].position - layout.poses[0].position).norm(), 1e-6);
  EXPECT_LT(motion.velocities[0].linear.norm(), 1e-6);
}

TEST(BulletWorld, SlidesOnTheGroundByCoulombsLaw) {
  const Layout layout = makeLayout({squareAt(0, 0, 0)});
  scene::Environment environment = emptySpace();
  environment.ground = scene::Ground{0, 0.5};
  // Below the cone's edge the brick sticks; beyond it, it gains the excess.
  for (const auto& [pull, gain] : {std::pair{0.3, 0.0}, std::pair{0.7, 0.2}}) {
    environment.gravity = {pull * 9.81, 0, -9.81};
    engines::BulletWorld world = makeWorld(layout, environment);
    advance(world, 2400);
    // Measured: 1.2e-3 m/s.
    EXPECT_NEAR(motionOf(world).velocities[0].linear.x(), gain * 9.81 * 0.5, 0.01);
  }
}

TEST(BulletWorld, KeepsPivotsTogetherWhileSwinging) {
  // Three bricks in a chain, joined at corners; the first is heavily loaded against the others.
  const std::vector<model::Tile> tiles = {squareAt(0, 0, 0), squareAt(1, 1, 0), squareAt(2, 2, 0)};
  const std::vector<model::Joint> joints = {{{0, 2}, {1, 0}, model::JointFace::Bottom},
                                            {{1, 2}, {2, 0}, model::JointFace::Both}};
  const Layout layout = makeLayout(tiles, joints);
  scene::Environment environment;
  environment.gravity = {0, 0, -9.81};
  engines::BulletWorld world = makeWorld(layout, environment);
  double gap = 0;
  for (int k = 0; k < 9600; ++k) {
    world.applyLoad(0, {0, 0, 3 * 9.81}, {0, 0, 5});
    world.advance(kStep);
    gap = std::max(gap, largestGap(layout, motionOf(world).poses));
  }
  EXPECT_GT((motionOf(world).poses[2].position - layout.poses[2].position).norm(), 0.5);
  EXPECT_LT(gap, 1e-3);  // measured: 2.3e-4
}

TEST(BulletWorld, KeepsOverlapsWithoutContacts) {
  const Layout layout = makeLayout({squareAt(0, 0, 0), squareAt(0.5, 0, 0.03)});
  engines::BulletWorld world = makeWorld(layout, emptySpace());
  advance(world, 100);
  EXPECT_EQ(motionOf(world).poses[1].position, layout.poses[1].position);
}

TEST(BulletWorld, AllowsOverlapsIfOnlyTheGroundCollides) {
  const Layout layout = makeLayout({squareAt(0, 0, 0), squareAt(0.5, 0, 0.03)});
  scene::Environment environment = emptySpace();
  environment.ground = scene::Ground{-1, 0.5};
  engines::BulletWorld world = makeWorld(layout, environment);
  advance(world, 100);
  EXPECT_EQ(motionOf(world).poses[1].position, layout.poses[1].position);
}

TEST(BulletWorld, PushesOverlappingBricksApart) {
  const Layout layout = makeLayout({squareAt(0, 0, 0), squareAt(0.5, 0, 0.08)});
  scene::Environment environment = emptySpace();
  environment.contacts = scene::ContactFilter::All;
  engines::BulletWorld world = makeWorld(layout, environment);
  advance(world, 400);
  const Poses poses = motionOf(world).poses;
  EXPECT_GT(poses[1].position.z() - poses[0].position.z(), 0.095);
}

TEST(BulletWorld, PassesJoinedBricksThroughWhenOnlyUnjoinedOnesTouch) {
  const std::vector<model::Tile> tiles = {squareAt(0, 0, 0), squareAt(0.5, 0, 0.08),
                                          squareAt(0.5, 3, 0), squareAt(0.8, 3.2, 0.08)};
  Layout layout = makeLayout(tiles);
  // The first two are joined in the middle of their overlap.
  const Vector3 middle(0.75, 0.5, 0.09);
  layout.pivots.push_back(
      {0, 1, middle - layout.poses[0].position, middle - layout.poses[1].position, 0});
  scene::Environment environment = emptySpace();
  environment.contacts = scene::ContactFilter::Unjoined;
  engines::BulletWorld world = makeWorld(layout, environment);
  advance(world, 400);
  const Poses poses = motionOf(world).poses;
  EXPECT_LT((poses[1].position - layout.poses[1].position).norm(), 1e-12);
  EXPECT_GT(poses[3].position.z() - poses[2].position.z(), 0.095);
}

TEST(BulletWorld, DoesNotPryCompactTilesApart) {
  std::vector<model::Tile> tiles = {squareAt(0, 0, 0), squareAt(1, 0, 0), squareAt(0, 1, 0),
                                    squareAt(1, 1, 0)};
  // Rotated, so touching faces are apart or overlap by a rounding error.
  const Quaternion turn = rotationFromVector({0.3, -0.2, 0.7});
  for (model::Tile& tile : tiles) {
    for (Vector3& vertex : tile.vertices) vertex = turn * vertex;
  }
  const std::vector<model::Joint> joints = {{{0, 1}, {1, 0}, model::JointFace::Both},
                                            {{0, 2}, {2, 1}, model::JointFace::Both},
                                            {{1, 2}, {3, 1}, model::JointFace::Both}};
  const Layout layout = makeLayout(tiles, joints);
  engines::BulletWorld world = makeWorld(layout, scene::Environment{});
  advance(world, 2400);
  const Motion motion = motionOf(world);
  for (std::size_t k = 0; k < tiles.size(); ++k) {
    // Measured: 2e-13.
    EXPECT_LT((motion.poses[k].position - layout.poses[k].position).norm(), 1e-9);
  }
}

TEST(BulletWorld, ReadsBackWhatWasWritten) {
  const Layout layout = makeLayout({squareAt(0, 0, 0), squareAt(3, 0, 0)});
  engines::BulletWorld world = makeWorld(layout, scene::Environment{});
  EXPECT_EQ(motionOf(world).poses[1].position, layout.poses[1].position);
  Motion motion = motionOf(world);
  motion.poses[1] = {{0.1, 7, 0.3}, rotationFromVector({0.1, 2, 0.7})};
  motion.velocities[1] = {{1, 2, 3}, {0.1, -0.2, 0.3}};
  world.writeMotion(motion);
  EXPECT_TRUE(sameBits(motionOf(world), motion));
  // The bodies have the poses and velocities: one step moves them by the velocities.
  world.advance(kStep);
  const Vector3 moved = motionOf(world).poses[1].position - motion.poses[1].position;
  EXPECT_LT((moved - kStep * Vector3(1, 2, 3)).norm(), 1e-7);
}

TEST(BulletWorld, RepeatsItselfToTheBit) {
  const std::vector<model::Tile> tiles = {squareAt(0, 0, 0.2), squareAt(1, 1, 0.2),
                                          squareAt(2, 2, 0.2)};
  const std::vector<model::Joint> joints = {{{0, 2}, {1, 0}, model::JointFace::Bottom},
                                            {{1, 2}, {2, 0}, model::JointFace::Both}};
  const Layout layout = makeLayout(tiles, joints);
  scene::Environment environment;
  environment.gravity = {0.1, 0, -9.81};
  environment.ground = scene::Ground{0, 0.5};
  engines::BulletWorld first = makeWorld(layout, environment);
  advance(first, 2400);
  engines::BulletWorld second = makeWorld(layout, environment);
  advance(second, 2400);
  EXPECT_TRUE(sameBits(motionOf(first), motionOf(second)));
}

}  // namespace
}  // namespace kirireel
