#include <gtest/gtest.h>

#include "sim/engines/bullet_world.h"

namespace kirireel {
namespace {

/// A plate of 1 m x 1 m x 0.5 m about the origin: its margin is 0.02 m, so zones reach 0.08 m.
brick::Brick plate() {
  model::Tile tile;
  tile.vertices = {{-0.5, -0.5, 0}, {0.5, -0.5, 0}, {0.5, 0.5, 0}, {-0.5, 0.5, 0}};
  brick::BrickRule rule;
  rule.thickness = 0.5;
  return brick::makeBrick(tile, rule);
}

/// Two plates side by side that meet at x = 0.5; the joint at y = 0.5.
const std::vector<brick::Brick> kBricks = {plate(), plate()};
const Poses kPoses = {Pose{}, Pose{{1, 0, 0}, Quaternion::Identity()}};
const brick::Pivot kBottom = {0, 1, {0.5, 0.5, -0.25}, {-0.5, 0.5, -0.25}, 0};
const brick::Pivot kTop = {0, 1, {0.5, 0.5, 0.25}, {-0.5, 0.5, 0.25}, 0};

TEST(PivotZones, ReachFourMarginsRoundAPivot) {
  const engines::PivotZones zones(kBricks, std::vector<brick::Pivot>{kBottom});
  EXPECT_TRUE(zones.contains(0, 1, kPoses, {0.5, 0.421, -0.25}));
  EXPECT_FALSE(zones.contains(0, 1, kPoses, {0.5, 0.419, -0.25}));
  EXPECT_FALSE(zones.contains(0, 1, kPoses, {0.5, 0.5, 0}));
}

TEST(PivotZones, ReachAlongAHinge) {
  const engines::PivotZones zones(kBricks, std::vector<brick::Pivot>{kBottom, kTop});
  EXPECT_TRUE(zones.contains(0, 1, kPoses, {0.5, 0.5, 0}));
  EXPECT_TRUE(zones.contains(0, 1, kPoses, {0.5, 0.421, 0.1}));
  EXPECT_FALSE(zones.contains(0, 1, kPoses, {0.5, 0, 0}));
}

TEST(PivotZones, AreTheSameInEitherOrderOfBricks) {
  const brick::Pivot swapped = {1, 0, kBottom.pointB, kBottom.pointA, 0};
  for (const brick::Pivot& pivot : {kBottom, swapped}) {
    const engines::PivotZones zones(kBricks, std::vector<brick::Pivot>{pivot});
    EXPECT_TRUE(zones.contains(0, 1, kPoses, {0.5, 0.45, -0.25}));
    EXPECT_TRUE(zones.contains(1, 0, kPoses, {0.5, 0.45, -0.25}));
    EXPECT_FALSE(zones.contains(1, 0, kPoses, {0.5, -0.5, -0.25}));
  }
}

TEST(PivotZones, MoveWithTheBricks) {
  const engines::PivotZones zones(kBricks, std::vector<brick::Pivot>{kBottom});
  const Pose motion{{3, -2, 1}, rotationFromVector({0.3, 0.7, -1.1})};
  Poses moved;
  for (const Pose& pose : kPoses) {
    moved.push_back({motion.apply(pose.position), motion.rotation * pose.rotation});
  }
  EXPECT_TRUE(zones.contains(0, 1, moved, motion.apply({0.5, 0.421, -0.25})));
  EXPECT_FALSE(zones.contains(0, 1, moved, motion.apply({0.5, 0.419, -0.25})));
}

TEST(PivotZones, AreEmptyBetweenBricksWithoutAJoint) {
  const engines::PivotZones zones(kBricks, {});
  EXPECT_FALSE(zones.contains(0, 1, kPoses, {0.5, 0.5, -0.25}));
}

}  // namespace
}  // namespace kirireel
