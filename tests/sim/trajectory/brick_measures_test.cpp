#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "sim/generate/lattice.h"
#include "sim/trajectory/measures.h"
#include "sim/trajectory/run_curves.h"

namespace kirireel {
namespace {

double largest(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end());
}

/// A tessellation in which every brick has its own displacement and rotation.
struct ScatteredTiles {
  model::Model model = generate::makeTessellation({});
  std::vector<brick::Brick> bricks = brick::makeBricks(model.tiles, {});
  Poses start = brick::startPoses(model.tiles, bricks);
  Poses poses = start;

  ScatteredTiles() {
    for (std::size_t k = 0; k < poses.size(); ++k) {
      poses[k].position += Vector3(0.1 * k, 0, -0.05 * k);
      poses[k].rotation = rotationFromVector(0.2 * k * Vector3(0.6, 0, 0.8));
    }
  }
};

TEST(BrickMeasures, HaveTheWholeRunsMeasuresAsTheirLargest) {
  const ScatteredTiles tiles;
  const std::vector<brick::Pivot> pivots = brick::makePivots(tiles.model.joints, tiles.bricks);
  EXPECT_EQ(largest(trajectory::brickTargetErrors(*tiles.model.target, tiles.bricks, tiles.poses)),
            trajectory::targetError(*tiles.model.target, tiles.bricks, tiles.poses));
  EXPECT_EQ(largest(trajectory::brickJointGaps(pivots, tiles.poses)),
            trajectory::jointGap(pivots, tiles.poses).max);
}

TEST(BrickMeasures, HaveDisplacementAndRotationOfEachBrick) {
  const ScatteredTiles tiles;
  const std::vector<double> moved = trajectory::brickDisplacements(tiles.start, tiles.poses);
  const std::vector<double> turned = trajectory::brickRotations(tiles.start, tiles.poses);
  for (std::size_t k = 0; k < tiles.poses.size(); ++k) {
    EXPECT_NEAR(moved[k], std::hypot(0.1, 0.05) * k, 1e-12);
    EXPECT_NEAR(turned[k], std::min(0.2 * k, 2 * M_PI - 0.2 * k), 1e-7);  // measured 3e-8
  }
}

TEST(BrickMeasures, AreZeroForABrickWithoutJoints) {
  const ScatteredTiles tiles;
  EXPECT_EQ(largest(trajectory::brickJointGaps({}, tiles.poses)), 0);
}

}  // namespace
}  // namespace kirireel
