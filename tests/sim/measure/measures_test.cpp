#include "sim/measure/measures.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "sim/model/tessellation.h"

namespace kirireel {
namespace {

struct Sheet {
  Model model = makeTessellation({});
  std::vector<Brick> bricks = makeBricks(model.tiles, {});
  std::vector<Pivot> pivots = makePivots(model.joints, bricks);
  Poses poses = startPoses(model.tiles, bricks);
};

TEST(JointGap, ClosedSheetHasNone) {
  const Sheet sheet;
  EXPECT_LT(jointGap(sheet.pivots, sheet.poses).max, 1e-14);  // measured 0
}

TEST(JointGap, OneMovedBrickOpensItsJoints) {
  Sheet sheet;
  sheet.poses[0].position += Vector3(0.03, 0, 0.04);
  const JointGap gap = jointGap(sheet.pivots, sheet.poses);
  EXPECT_NEAR(gap.max, 0.05, 1e-15);
  // A corner tile has two joints on both faces: four pivots of 48.
  EXPECT_NEAR(gap.mean, 4 * 0.05 / 48, 1e-15);
}

TEST(JointGap, ZeroWithoutJoints) {
  EXPECT_EQ(jointGap({}, {}).max, 0);
  EXPECT_EQ(jointGap({}, {}).mean, 0);
}

TEST(JointGap, PosesThatAreNoNumbersAreNoSmallGap) {
  Sheet sheet;
  sheet.poses[0].position.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(jointGap(sheet.pivots, sheet.poses).max));
  EXPECT_TRUE(std::isnan(targetError(sheet.model.tiles, sheet.bricks, sheet.poses)));
}

TEST(TargetError, IsTheLargestVertexDistance) {
  Sheet sheet;
  EXPECT_LT(targetError(sheet.model.tiles, sheet.bricks, sheet.poses), 1e-14);
  // A unit square turned by 60 degrees about its middle: each corner moves by sqrt(1/2).
  const double half = 0.5 * sheet.bricks[5].thickness;
  sheet.poses[5].rotation = rotationFromVector({0, 0, 1.0471975511965976});
  EXPECT_NEAR(targetError(sheet.model.tiles, sheet.bricks, sheet.poses), std::sqrt(0.5), 1e-14);
  sheet.poses[5] = {{0, 0, half}, Quaternion::Identity()};
  sheet.poses[5].position = sheet.poses[5].position + Vector3(-0.5, -0.5, 2);
  EXPECT_NEAR(targetError(sheet.model.tiles, sheet.bricks, sheet.poses), 2, 1e-14);
}

TEST(RigidFloor, IsZeroForMovedTiles) {
  const Sheet sheet;
  EXPECT_LT(rigidFloor(sheet.model.tiles, *sheet.model.target), 1e-14);  // measured 5e-16
}

TEST(RigidFloor, OfAStretchedTileIsHalfTheStretch) {
  const std::vector<Tile> square{{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}}};
  const std::vector<Tile> longer{{{{3, 0, 0}, {3, 1.2, 0}, {2, 1.2, 0}, {2, 0, 0}}}};
  EXPECT_NEAR(rigidFloor(square, longer), 0.1, 1e-15);
}

TEST(KineticEnergy, OfABoxHasTheClosedForm) {
  BrickRule rule;
  rule.thickness = 0.2;
  const std::vector<Brick> bricks{makeBrick({{{0, 0, 0}, {3, 0, 0}, {3, 2, 0}, {0, 2, 0}}}, rule)};
  Motion motion{Poses(1), std::vector<Velocity>(1)};
  motion.velocities[0].linear = {1, -2, 2};
  EXPECT_NEAR(kineticEnergy(bricks, motion), 4.5, 1e-14);
  // Standing upright, the brick's z axis points along the world's -y.
  motion.poses[0].rotation = rotationFromVector({1.5707963267948966, 0, 0});
  motion.velocities[0].angular = {0, 4, 0};
  EXPECT_NEAR(kineticEnergy(bricks, motion), 4.5 + 0.5 * (9 + 4) / 12.0 * 16, 1e-13);
}

}  // namespace
}  // namespace kirireel
