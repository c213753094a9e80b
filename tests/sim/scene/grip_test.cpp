#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/geometry.h"
#include "sim/generate/lattice.h"
#include "sim/scene/conditions.h"
#include "sim/scene/scene_file.h"
#include "tests/support/files.h"
#include "tests/support/refusal.h"

namespace kirireel {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Reads grips from a scene file and numbers them as a sheet of 2 x 2 squares.
class Grips : public testing::Test {
 protected:
  std::vector<scene::GripSetting> read(const std::string& text) {
    std::ofstream(folder_ / "scene.toml", std::ios::binary) << text;
    std::vector<scene::GripSetting> grips = scene::readSceneFile(folder_ / "scene.toml").grips;
    generate::TessellationShape shape;
    shape.columns = shape.rows = 2;
    scene::numberAsModel(grips, generate::makeTessellation(shape));
    return grips;
  }

  std::string refusal(const std::string& lines) {
    return test::refusalOf([&] { read("[[grip]]\n" + lines); });
  }

  test::TemporaryFolder folder_;
};

TEST_F(Grips, HoldTilesVerticesAndEdges) {
  const std::vector<scene::GripSetting> grips = read(
      "[[grip]]\ntile = 0\nmove = {x = 0, y = 0, turn = 90}\n"
      "[[grip]]\ntiles = [1, 3]\nedge = [1, 2]\nforce = {x = 2.5}\n"
      "[[grip]]\ntile = 2\nvertex = 3\nmove = {y = -0.5}\n"
      "[[grip]]\nvertex = [2, 0]\ntiles = [3, 1]\nmove = {y = -0.5}\n");
  ASSERT_EQ(grips.size(), 4u);
  EXPECT_THAT(grips[0].tiles, ElementsAre(0));
  EXPECT_EQ(grips[0].x, 0);
  EXPECT_NEAR(*grips[0].turn, 90 * kDegree, 1e-15);
  EXPECT_FALSE(grips[0].isForce);
  EXPECT_TRUE(grips[1].isForce);
  EXPECT_EQ(grips[1].x, 2.5);
  EXPECT_FALSE(grips[1].y.has_value());
  EXPECT_THAT(grips[1].corners, ElementsAre(model::Corner{1, 1}, model::Corner{1, 2},
                                            model::Corner{3, 1}, model::Corner{3, 2}));
  EXPECT_THAT(grips[2].corners, ElementsAre(model::Corner{2, 3}));
  EXPECT_THAT(grips[3].corners, ElementsAre(model::Corner{3, 2}, model::Corner{1, 0}));
}

TEST_F(Grips, AreRefusedInOneLine) {
  EXPECT_THAT(
      refusal("tile = 4\nmove = {x = 1}\n"),
      HasSubstr("scene.toml:1:1: error: the model has tiles 0-3, not 4. Correct this grip"));
  EXPECT_THAT(refusal("tile = 1\nvertex = 4\nmove = {x = 1}\n"),
              HasSubstr("tile 1 has vertices 0-3, not 4. Correct this grip"));
  EXPECT_THAT(refusal("tiles = [1, 2]\nvertex = [0, 4]\nmove = {x = 1}\n"),
              HasSubstr("tile 2 has vertices 0-3, not 4. Correct this grip"));
  EXPECT_THAT(
      refusal("tiles = [1, 2]\nvertex = [0]\nmove = {x = 1}\n"),
      HasSubstr("a list of vertices needs one entry per tile, 2, not 1. Correct one of the lists"));
  EXPECT_THAT(refusal("tiles = [1, 2]\nvertex = [0, 1]\nmove = {turn = 1}\n"),
              HasSubstr("points do not rotate. Remove turn, or vertex and edge"));
  EXPECT_THAT(refusal("move = {x = 1}\n"),
              HasSubstr("a grip needs tiles. Set either tile = 3 or tiles = [3, 4]"));
  EXPECT_THAT(refusal("tile = 1\n"),
              HasSubstr("a grip either moves or pushes. Set either move = "));
  EXPECT_THAT(refusal("tile = 1\nmove = {x = 1}\nforce = {x = 1}\n"),
              HasSubstr("a grip either moves or pushes. Set either move = "));
  EXPECT_THAT(refusal("tile = 1\nvertex = 1\nmove = {turn = 1}\n"),
              HasSubstr("points do not rotate. Remove turn, or vertex and edge"));
  EXPECT_THAT(refusal("tile = 1\nedge = [1]\nmove = {x = 1}\n"),
              HasSubstr("give two vertex numbers, [0, 1]"));
  EXPECT_THAT(refusal("tile = 1\nmove = {}\n"), HasSubstr("give lengths and degrees, {x = 0.1"));
  EXPECT_THAT(refusal("tile = 1\nforce = {xx = 1}\n"),
              HasSubstr("unknown key of a grip's force xx, did you mean x?"));
  EXPECT_THAT(refusal("tile = -1\nmove = {x = 1}\n"), HasSubstr("give a tile number"));
  EXPECT_THAT(refusal("tyle = 1\nmove = {x = 1}\n"), HasSubstr("tile"));
}

}  // namespace
}  // namespace kirireel
