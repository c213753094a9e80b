// Gmsh as the judge of its own format: skipped where it is not installed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/fea/gmsh.h"
#include "sim/base/pending_file.h"
#include "tests/render/fea/read_deck.h"
#include "tests/support/files.h"
#include "tests/support/layouts.h"
#include "tests/support/program.h"

namespace kirireel {
namespace {

/// The mesh as a deck that Gmsh wrote.
test::Deck throughGmsh(const ElementMesh& mesh) {
  const test::TemporaryFolder folder;
  writeTextFile(folder / "x.msh", gmshMesh(mesh));
  test::outputOf("cd '" + folder.path().string() +
                 "' && gmsh x.msh -save -setnumber Mesh.SaveGroupsOfNodes 1 -o x.inp");
  return test::readDeck(test::bytesOf(folder / "x.inp"));
}

class GmshProgram : public testing::TestWithParam<bool> {};

TEST_P(GmshProgram, KeepsSetsAndElements) {
  if (!test::hasProgram("gmsh")) GTEST_SKIP() << "install gmsh to judge its meshes by it";
  const test::Layout layout = test::hingedSquares();
  const ElementMesh mesh = makeElementMesh(layout.bricks, layout.joints, layout.poses,
                                           {.perEdge = 2, .quadratic = GetParam()});
  const test::Deck deck = throughGmsh(mesh);
  EXPECT_EQ(deck.nodes.size(), mesh.nodes.size());
  for (int t = 0; t < 4; ++t) {
    const std::string name = "TILE_0000" + std::to_string(t);
    EXPECT_EQ(deck.nodeSets.at(name).size(), mesh.tiles[t].nodes.size());
    EXPECT_EQ(deck.nodeSets.at(name + "_SBOT").size(), mesh.tiles[t].bottom.size());
    EXPECT_EQ(deck.nodeSets.at(name + "_STOP").size(), mesh.tiles[t].top.size());
    // Gmsh writes 14 digits. Measured: below 1e-12.
    EXPECT_NEAR(volumeOf(deck, name) / layout.bricks[t].volume, 1, 1e-12);
    if (!GetParam()) continue;
    for (const int k : deck.elementSets.at(name)) {
      EXPECT_LT(largestMiddleMiss(deck, deck.elements.at(k)), 1e-13);  // measured: 5.0e-14
    }
  }
  for (int j = 0; j < 4; ++j) {
    for (const char* side : {"_A", "_B"}) {
      EXPECT_EQ(deck.nodeSets.at("JOINT_0000" + std::to_string(j) + side).size(),
                GetParam() ? 3U : 2U);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Orders, GmshProgram, testing::Bool());

}  // namespace
}  // namespace kirireel
