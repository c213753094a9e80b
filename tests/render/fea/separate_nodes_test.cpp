#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "render/fea/deck.h"
#include "tests/support/layouts.h"

namespace kirireel {
namespace {

double smallestDistance(const std::vector<Vector3>& nodes) {
  double least = 1;
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) least = std::min(least, (nodes[a] - nodes[b]).norm());
  }
  return least;
}

TEST(SeparatedNodes, MovesOnlyCoincidentNodes) {
  for (const fea::JointStyle style : {fea::JointStyle::Shared, fea::JointStyle::Equation}) {
    const test::Layout layout = test::hingedSquares(0);
    const fea::ElementMesh mesh = fea::makeElementMesh(
        layout.bricks, layout.joints, layout.poses, {.perEdge = 3, .through = 1, .joints = style});
    Eigen::AlignedBox3d box;
    for (const Vector3& node : mesh.nodes) box.extend(node);
    const double size = std::sqrt(8 + 0.02 * 0.02);  // 2 x 2 squares of 1 m
    EXPECT_LT(smallestDistance(mesh.nodes), 1e-15);
    const std::vector<Vector3> apart = fea::separatedNodes(mesh);
    EXPECT_GT(smallestDistance(apart), 1e-7 * size);  // 1.4e-7 at corners, 2e-7 at sides
    int moved = 0;
    for (std::size_t k = 0; k < apart.size(); ++k) {
      EXPECT_LT((apart[k] - mesh.nodes[k]).norm(), 1.0001e-7 * size);
      const Vector3 fromMiddle = mesh.nodes[k] - box.center();
      const bool isInside = std::min(std::abs(fromMiddle.x()), std::abs(fromMiddle.y())) > 1e-9;
      EXPECT_TRUE(!isInside || apart[k] == mesh.nodes[k]) << k;
      moved += apart[k] != mesh.nodes[k] ? 1 : 0;
    }
    EXPECT_GT(moved, 40);
  }
}

TEST(SeparatedNodes, LeavesOpenSheetsAsTheyAre) {
  const test::Layout layout = test::hingedSquares(0.7);
  const fea::ElementMesh mesh =
      fea::makeElementMesh(layout.bricks, layout.joints, layout.poses, {});
  EXPECT_EQ(fea::separatedNodes(mesh), mesh.nodes);
}

}  // namespace
}  // namespace kirireel
