#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/fea/deck.h"
#include "tests/support/layouts.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;

TEST(Gmsh, NamesItsGroupsAndKeepsEveryDouble) {
  test::Layout layout = test::hingedSquares();
  for (Pose& pose : layout.poses) pose.position.x() += 1.0 / 3;
  const fea::ElementMesh mesh =
      fea::makeElementMesh(layout.bricks, layout.joints, layout.poses, {});
  const std::string text = fea::gmshMesh(mesh);
  EXPECT_THAT(text, HasSubstr("$MeshFormat\n4.1 0 8\n"));
  EXPECT_THAT(text, HasSubstr("$PhysicalNames\n4\n3 1 \"TILES\"\n2 1 \"BOTTOM\"\n2 2 \"TOP\"\n"
                              "0 1 \"JOINTS\"\n"));
  EXPECT_THAT(fea::gmshMesh(mesh, fea::SetChoice::All), HasSubstr("3 5 \"TILE_00003\"\n"));
  std::istringstream nodes(text.substr(text.find("$Nodes\n") + 7));
  std::size_t blocks = 0, count = 0, first = 0, last = 0;
  nodes >> blocks >> count >> first >> last;
  ASSERT_EQ(count, mesh.nodes.size());
  std::size_t seen = 0;
  for (std::size_t b = 0; b < blocks; ++b) {
    int dimension = 0, entity = 0, parametric = 0;
    std::size_t size = 0;
    nodes >> dimension >> entity >> parametric >> size;
    std::vector<std::size_t> numbers(size);
    for (std::size_t& number : numbers) nodes >> number;
    for (const std::size_t number : numbers) {
      std::string x, y, z;
      nodes >> x >> y >> z;
      EXPECT_EQ(Vector3(std::stod(x), std::stod(y), std::stod(z)), mesh.nodes[number - 1]);
      ++seen;
    }
  }
  EXPECT_EQ(seen, count);
}

}  // namespace
}  // namespace kirireel
