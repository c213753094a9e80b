#include "sim/trajectory/exact_motion.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "sim/generate/families.h"
#include "sim/generate/lattice.h"
#include "tests/support/layouts.h"

namespace kirireel {
namespace {

constexpr double kExactTolerance = 1e-12;  // metres

model::Model generated(const char* family) {
  return generate::generateModel(generate::familyNamed(family), {});
}

double largestGap(const std::vector<model::Joint>& joints, const std::vector<model::Tile>& tiles) {
  double gap = 0;
  for (const auto& [a, b, face, kind, apart, isWithinTile, neck] : joints) {
    gap =
        std::max(gap, (tiles[a.tile].vertices[a.vertex] - tiles[b.tile].vertices[b.vertex]).norm());
  }
  return gap;
}

// Second form: lattice.h.
TEST(ExactMotion, IsThatOfRotatingSquares) {
  for (const double start : {0.0, 0.4}) {
    model::Model model = test::turned(generate::makeTessellation(test::squares(5, 4, start)), 33);
    const auto motion = trajectory::ExactMotion::find(model);
    ASSERT_TRUE(motion);
    for (const double angle : {0.0, 0.4, 0.9, 1.5}) {
      const auto tiles = generate::tessellationTiles(test::squares(5, 4, 0), angle);
      const auto found = motion->nearest(std::abs(angle - start), tiles);
      EXPECT_LT(trajectory::vertexDistance(found, tiles).largest,
                kExactTolerance);  // measured 1e-14
    }
  }
}

// Two states of these families are designed to be closed.
TEST(ExactMotion, LeadsFromStartToTarget) {
  for (const char* family : {"square-to-disk", "heart"}) {
    const model::Model model = generated(family);
    const auto motion = trajectory::ExactMotion::find(model);
    ASSERT_TRUE(motion) << family;
    const auto end = motion->nearest(std::numbers::pi, *model.target);
    EXPECT_LT(trajectory::vertexDistance(end, *model.target).largest, kExactTolerance) << family;
    for (const double opening : {0.3, 1.0, 2.0, 3.0}) {
      const auto tiles = motion->nearest(opening, model.tiles);
      EXPECT_LT(largestGap(model.joints, tiles), kExactTolerance);
      for (std::size_t i = 0; i < tiles.size(); ++i) {
        EXPECT_NEAR(model::tileArea(tiles[i]), model::tileArea(model.tiles[i]), kExactTolerance);
      }
    }
  }
}

TEST(ExactMotion, IsInThePlaneOfTheSheet) {
  const model::Model flat = generate::makeTessellation(test::squares(3, 3, 0));
  model::Model tilted = flat;
  const Quaternion turn = rotationFromVector({0.8, 0.2, 0});
  for (model::Tile& tile : tilted.tiles) {
    for (Vector3& vertex : tile.vertices) vertex = turn * vertex + Vector3(1, 2, 3);
  }
  auto tiles = generate::tessellationTiles(test::squares(3, 3, 0), 0.7);
  for (model::Tile& tile : tiles) {
    for (Vector3& vertex : tile.vertices) vertex = turn * vertex;
  }
  const auto motion = trajectory::ExactMotion::find(tilted);
  ASSERT_TRUE(motion);
  EXPECT_LT(trajectory::vertexDistance(motion->nearest(0.7, tiles), tiles).largest,
            kExactTolerance);
}

TEST(ExactMotion, IsAbsentWithoutSuchAMotion) {
  // A start in space, a bent slit, and a chain with other motions.
  for (const char* family : {"cylinder", "nonrigid", "stampfli-chain"}) {
    EXPECT_FALSE(trajectory::ExactMotion::find(generated(family))) << family;
  }
  const model::Model squares = generate::makeTessellation(test::squares(3, 3, 0));
  model::Model model = squares;
  model.joints.clear();
  EXPECT_FALSE(trajectory::ExactMotion::find(model));
  model = squares;
  std::erase_if(model.joints, [](const model::Joint& j) { return j.a.tile == 0 || j.b.tile == 0; });
  EXPECT_FALSE(trajectory::ExactMotion::find(model));  // tile 0 is not joined
  model = squares;
  model.joints[0].kind = model::JointKind::Link;
  EXPECT_FALSE(trajectory::ExactMotion::find(model));
  // Tiles 0 and 4 rotate in the same direction.
  model = squares;
  for (int a = 0; a < 4; ++a) {
    for (int b = 0; b < 4; ++b) {
      const Vector3 apart = model.tiles[0].vertices[a] - model.tiles[4].vertices[b];
      if (apart.norm() < 1e-12) model.joints.push_back({{0, a}, {4, b}});
    }
  }
  ASSERT_EQ(model.joints.size(), squares.joints.size() + 1);
  EXPECT_FALSE(trajectory::ExactMotion::find(model));
  // The void around a displaced joint is no parallelogram.
  model = squares;
  const model::Joint& joint = model.joints[5];
  for (const model::Corner& corner : {joint.a, joint.b}) {
    model.tiles[corner.tile].vertices[corner.vertex].x() += 1e-3;
  }
  EXPECT_FALSE(trajectory::ExactMotion::find(model));
}

}  // namespace
}  // namespace kirireel
