// Expansion, boundary springs and point springs, against closed forms and differences.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "sim/generate/lattice.h"
#include "sim/model/convex_parts.h"
#include "sim/model/model.h"
#include "sim/run/forces.h"

namespace kirireel {
namespace {

TEST(Expansion, PushesInProportionToTheDistanceFromTheCentre) {
  const model::Model model = generate::makeTessellation({});
  const std::vector<brick::Brick> bricks = brick::makeBricks(model.tiles, {});
  const Poses poses = brick::startPoses(model.tiles, bricks);
  scene::TargetSpringSettings settings = scene::paperSprings();
  settings.springStiffness = 3;
  Vector3 centre = Vector3::Zero();  // bricks of one mass
  for (const Pose& pose : poses) centre += pose.position / static_cast<double>(poses.size());
  const run::Expansion expansion(bricks, std::vector<int>(bricks.size()), settings);
  std::vector<brick::Load> loads(poses.size());
  expansion.addLoads(poses, loads);
  std::vector<Vector3> forces(poses.size(), Vector3::Zero());
  expansion.addFreeForces(poses, forces);
  Vector3 sum = Vector3::Zero();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const brick::Load& load = loads[i];
    const Vector3 expected = 3 * (poses[i].position - centre);
    EXPECT_LT((load.force.head<3>() - expected).norm(), 1e-14);
    EXPECT_EQ(Vector3(load.force.head<3>()), forces[i]);
    EXPECT_TRUE(load.force.tail<3>().isZero(0));
    EXPECT_TRUE(load.stiffness.isZero(0));
    EXPECT_EQ(load.damping(0, 0), 50);
    EXPECT_EQ(load.damping(5, 5), 2);
    sum += load.force.head<3>();
  }
  EXPECT_LT(sum.norm(), 1e-12);  // it moves no centre: measured 1e-14
}

TEST(Expansion, ByFrequencyMovesBricksOfAnyMassAndShapeEqually) {
  // A brick far from the centre of a triangle and two squares.
  std::vector<model::Tile> tiles = generate::makeTessellation({2, 1}).tiles;
  tiles.push_back({{{5, 0, 0}, {7, 0, 0}, {5, 2, 0}}});
  const std::vector<brick::Brick> bricks =
      brick::makeBricks(tiles, {0.1, brick::MassRule::Prism, 700});
  const Poses poses = brick::startPoses(tiles, bricks);
  std::vector<brick::Load> loads(poses.size());
  run::Expansion(bricks, std::vector<int>(bricks.size()), {}).addLoads(poses, loads);
  const double rate =
      std::pow(2 * std::numbers::pi * scene::TargetSpringSettings{}.frequency, 2) / 4;
  Vector3 centre = Vector3::Zero();
  double mass = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    centre += bricks[i].mass * poses[i].position;
    mass += bricks[i].mass;
  }
  centre /= mass;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Vector3 acceleration = loads[i].force.head<3>() / bricks[i].mass;
    EXPECT_LT((acceleration - rate * (poses[i].position - centre)).norm(), 1e-10);
  }
}

TEST(PointSpring, IsTheGradientOfItsEnergy) {
  // Force and torque against differences of k/2 |anchor - point|^2.
  const run::PointSpring spring = {Vector3(0.3, -0.2, 0.1), Vector3(1, 2, 3), 40, 0};
  Pose pose{Vector3(0.5, 0.1, -0.4), rotationFromVector(Vector3(0.4, -0.7, 0.2))};
  brick::Load load;
  run::addPointSpring(spring, pose, load);
  const auto energy = [&](const Vector6& move) {
    const Pose moved{pose.position + move.head<3>(),
                     rotationFromVector(move.tail<3>()) * pose.rotation};
    return 0.5 * spring.stiffness * (spring.anchor - moved.apply(spring.point)).squaredNorm();
  };
  for (int k = 0; k < 6; ++k) {
    const Vector6 move = 1e-5 * Vector6::Unit(k);
    const double slope = (energy(move) - energy(-move)) / 2e-5;
    EXPECT_NEAR(load.force[k], -slope, 1e-7);  // measured 4e-9
  }
  EXPECT_TRUE(load.stiffness.isApprox(load.stiffness.transpose(), 1e-15));
}

TEST(Outline, OfASheetIsItsConvexHull) {
  generate::TessellationShape shape;
  shape.columns = shape.rows = 3;
  const model::Model sheet = generate::makeTessellation(shape);  // closed: a square of side 3
  const std::vector<model::Corner> outline = model::outlineCorners(sheet.tiles);
  EXPECT_EQ(outline.size(), 12u);
  // Anticlockwise: the polygon's area is the sheet's.
  double area = 0;
  for (std::size_t k = 0; k < outline.size(); ++k) {
    const auto at = [&](std::size_t i) {
      const model::Corner& corner = outline[i % outline.size()];
      return sheet.tiles[corner.tile].vertices[corner.vertex];
    };
    area += 0.5 * at(k).cross(at(k + 1)).z();
  }
  EXPECT_NEAR(area, 9, 1e-12);
}

TEST(BoundarySprings, PullHullCornersToTheCurve) {
  generate::TessellationShape shape;
  shape.columns = shape.rows = 3;
  const model::Model sheet = generate::makeTessellation(shape);
  const std::vector<brick::Brick> bricks = brick::makeBricks(sheet.tiles, {});
  const Poses poses = brick::startPoses(sheet.tiles, bricks);
  scene::TargetSpringSettings settings;
  Vector3 middle = Vector3::Zero();  // of the middle tile
  for (const Vector3& vertex : sheet.tiles[4].vertices) middle += vertex / 4;
  const double radius = 1.5 * std::sqrt(2.0);
  const run::BoundarySprings circle(sheet, bricks, settings, {2, 1});
  const run::BoundarySprings oblong(sheet, bricks, settings, {2, 1.5});
  for (int k = 0; k < 12; ++k) {
    EXPECT_NEAR((circle.anchor(k) - middle).norm(), 2 * radius, 1e-12);
    const Vector3 arm = oblong.anchor(k) - middle;
    EXPECT_NEAR(std::hypot(arm.x() / (3 * radius), arm.y() / (2 * radius)), 1, 1e-12);
  }
  // The middle tile is not in the hull, a corner tile is pulled outwards along the diagonal.
  std::vector<brick::Load> loads(poses.size());
  circle.addLoads(poses, loads);
  EXPECT_TRUE(loads[4].force.isZero(0));
  const brick::Load& corner = loads[0];
  EXPECT_LT(corner.force[0], -1);
  EXPECT_NEAR(corner.force[0], corner.force[1], 1e-9);
}

TEST(BoundarySprings, FollowTheModelsHullIfItHasOne) {
  model::Model sheet = generate::makeTessellation({});
  sheet.hull = std::vector<model::Corner>{{0, 0}, {3, 1}, {15, 2}};
  const std::vector<brick::Brick> bricks = brick::makeBricks(sheet.tiles, {});
  const Poses poses = brick::startPoses(sheet.tiles, bricks);
  const run::BoundarySprings springs(sheet, bricks, {}, {2, 1});
  std::vector<brick::Load> loads(poses.size());
  springs.addLoads(poses, loads);
  EXPECT_FALSE(loads[15].force.isZero(0));
  EXPECT_TRUE(loads[12].force.isZero(0));
}

/// The selection between two equal sheets depends neither on the order of tiles nor on that of
/// their corners.
TEST(BoundarySprings, PullCornersAboveEachOtherEqually) {
  model::Model sheets = generate::makeTessellation({});
  const std::size_t count = sheets.tiles.size();
  for (std::size_t i = 0; i < count; ++i) {
    model::Tile above = sheets.tiles[i];
    for (Vector3& vertex : above.vertices) vertex.z() += 1;
    sheets.tiles.push_back(above);
  }
  sheets.target.reset();
  const std::vector<brick::Brick> bricks = brick::makeBricks(sheets.tiles, {});
  const Poses poses = brick::startPoses(sheets.tiles, bricks);
  std::vector<brick::Load> loads(poses.size());
  run::BoundarySprings(sheets, bricks, {}, {2, 1}).addLoads(poses, loads);
  EXPECT_GT(loads[0].force.norm(), 0.1);
  for (std::size_t i = 0; i < count; ++i) {
    EXPECT_NEAR((loads[i].force - loads[count + i].force).norm(), 0, 1e-12);  // measured: 0
  }
}

}  // namespace
}  // namespace kirireel
