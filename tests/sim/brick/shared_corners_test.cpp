#include <gtest/gtest.h>

#include "sim/brick/contact.h"
#include "sim/generate/lattice.h"

namespace kirireel {
namespace {

brick::Brick unitPlate() {
  return brick::makeBrick({{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}}, {});
}

TEST(WithoutCorners, CutsEachEdgeByTheLength) {
  const brick::Brick plate = unitPlate();
  const brick::Brick cut = brick::withoutCorners(plate, {2}, 0.1);
  ASSERT_EQ(cut.bottom.size(), 5u);
  EXPECT_EQ(cut.bottom[1], plate.bottom[1]);
  EXPECT_LT((cut.bottom[2] - plate.bottom[2] - Vector3(0, -0.1, 0)).norm(), 1e-15);
  EXPECT_LT((cut.bottom[3] - plate.bottom[2] - Vector3(-0.1, 0, 0)).norm(), 1e-15);
  EXPECT_EQ(cut.bottom[4], plate.bottom[3]);
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_LT((cut.top[k] - cut.bottom[k] - plate.thickness * plate.normal).norm(), 1e-15);
  }
  EXPECT_EQ(cut.mass, plate.mass);
}

TEST(WithoutCorners, LeavesAFifthOfAnEdgeWithoutBothEnds) {
  const brick::Brick cut = brick::withoutCorners(unitPlate(), {0, 1}, 0.7);
  ASSERT_EQ(cut.bottom.size(), 6u);
  EXPECT_NEAR((cut.bottom[2] - cut.bottom[1]).norm(), 0.2, 1e-15);
}

TEST(WithoutCorners, WithoutCutsIsTheBrick) {
  const brick::Brick plate = unitPlate();
  EXPECT_EQ(brick::withoutCorners(plate, {}, 0.1).bottom, plate.bottom);
}

TEST(SharedCorners, AreThoseOfTheJoints) {
  generate::TessellationShape shape;
  shape.columns = shape.rows = 3;
  const model::Model model = generate::makeTessellation(shape);
  const auto shared =
      brick::sharedCorners(brick::makePivots(model.joints, brick::makeBricks(model.tiles, {})));
  EXPECT_EQ(shared.size(), model.joints.size());  // a sheet's neighbours share one corner
  for (const model::Joint& joint : model.joints) {
    const bool swapped = joint.b.tile < joint.a.tile;
    const brick::SharedCorners& corners = shared.at(std::minmax(joint.a.tile, joint.b.tile));
    EXPECT_EQ(swapped ? corners.ofB : corners.ofA, std::vector<int>{joint.a.vertex});
    EXPECT_EQ(swapped ? corners.ofA : corners.ofB, std::vector<int>{joint.b.vertex});
  }
}

TEST(SharedCorners, CutByAPartOfTheMeanEdge) {
  const brick::Brick plate = unitPlate();
  const double length = brick::cutLength(plate, plate, 0.05);
  const brick::Brick a = brick::withoutCorners(plate, {0}, length);
  const brick::Brick b = brick::withoutCorners(plate, {2}, length);
  EXPECT_NEAR((a.bottom[0] - plate.bottom[0]).norm(), 0.05, 1e-15);
  EXPECT_NEAR((b.bottom[2] - plate.bottom[2]).norm(), 0.05, 1e-15);
}

}  // namespace
}  // namespace kirireel
