#include "render/fea/gmsh.h"

#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/layouts.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;

TEST(Gmsh, NamesItsGroupsAndKeepsEveryDouble) {
  test::Layout layout = test::hingedSquares();
  for (Pose& pose : layout.poses) pose.position.x() += 1.0 / 3;
  const ElementMesh mesh = makeElementMesh(layout.bricks, layout.joints, layout.poses, {});
  const std::string text = gmshMesh(mesh);
  EXPECT_THAT(text, HasSubstr("$MeshFormat\n2.2 0 8\n"));
  EXPECT_THAT(text, HasSubstr("$PhysicalNames\n20\n3 1 \"TILE_00000\"\n2 2 \"TILE_00000_SBOT\"\n"));
  EXPECT_THAT(text, HasSubstr("0 20 \"JOINT_00003_B\"\n"));
  std::istringstream nodes(text.substr(text.find("$Nodes\n") + 7));
  std::size_t count = 0;
  nodes >> count;
  ASSERT_EQ(count, mesh.nodes.size());
  for (const Vector3& node : mesh.nodes) {
    std::string number, x, y, z;
    nodes >> number >> x >> y >> z;
    EXPECT_EQ(Vector3(std::stod(x), std::stod(y), std::stod(z)), node);
  }
}

}  // namespace
}  // namespace kirireel
