// Cut patterns read back: the sheet that they were drawn from, up to the order of its tiles.
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "render/writers/flat_sheet.h"
#include "sim/base/error.h"
#include "sim/formats/read_model.h"
#include "sim/generate/families.h"
#include "tests/render/writers/same_sheet.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

using test::TemporaryFolder;

double leastEdge(const model::Model& model) {
  double least = 1e9;
  for (const model::Tile& tile : model.tiles) {
    for (std::size_t k = 0; k < tile.vertices.size(); ++k) {
      const Vector3& next = tile.vertices[(k + 1) % tile.vertices.size()];
      least = std::min(least, (next - tile.vertices[k]).norm());
    }
  }
  return least;
}

class PatternOf : public testing::TestWithParam<const char*> {};

TEST_P(PatternOf, ReadsBackToTheSameModel) {
  for (const double start : {0.0, 25.0}) {
    const generate::Family& family = generate::familyNamed(GetParam());
    const bool opens = std::any_of(
        family.parameters.begin(), family.parameters.end(),
        [](const generate::FamilyParameter& parameter) { return parameter.name == "start-angle"; });
    if (start > 0 && !opens) continue;
    std::map<std::string, double> given;
    const bool isTriangular =
        std::string(GetParam()) == "triangles" || std::string(GetParam()) == "trefoils";
    if (opens && !isTriangular) given["start-angle"] = start;
    if (start > 0 && isTriangular) given["start-angle"] = 240 - start;
    const model::Model drawn = generate::generateModel(family, given);
    for (const double share : {0.02, 0.05, 0.1}) {
      const double width = share * leastEdge(drawn);
      const std::vector<writers::PatternLine> lines = writers::cutPattern(drawn, width);
      const TemporaryFolder folder;
      folder.write("sheet.svg", writers::patternSvg(lines));
      folder.write("sheet.dxf", writers::patternDxf(lines));
      for (const char* name : {"sheet.svg", "sheet.dxf"}) {
        std::vector<std::string> warnings;
        try {
          test::expectSameSheet(
              formats::readModel(folder.path() / name, std::nullopt, warnings), drawn,
              fmt::format("{} {} {} from {} degrees", GetParam(), name, share, start));
        } catch (const InputError& error) {
          ADD_FAILURE() << GetParam() << ' ' << share << ' ' << start << ": " << error.what();
        }
        EXPECT_TRUE(warnings.empty());
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Planar, PatternOf,
                         testing::Values("tessellation", "quads", "fan", "heart", "square-to-disk",
                                         "square-to-circle", "triangles", "hexagons", "nonrigid",
                                         "stars", "crosses", "islamic", "trefoils",
                                         "stampfli-chain", "stampfli-expansion", "penrose-chain",
                                         "penrose-removal", "penrose-expansion",
                                         "ammann-beenker-chain", "ammann-beenker-removal",
                                         "ammann-beenker-expansion"));

std::string refusalOf(const std::string& name, const std::string& text) {
  const TemporaryFolder folder;
  folder.write(name, text);
  std::vector<std::string> warnings;
  try {
    formats::readModel(folder.path() / name, std::nullopt, warnings);
    return "";
  } catch (const InputError& error) {
    return std::string(error.what()).substr(folder.path().string().size());
  }
}

TEST(Patterns, ThatAreBrokenAreRefused) {
  EXPECT_EQ(refusalOf("a.svg", "<svg><path d=\"M 0 0 L 1 1\"/></svg>"),
            "/a.svg: error: the outline is open: the line that ends at (0, 0) px leaves the sheet. "
            "Close the outline, or end the line at it");
  EXPECT_EQ(refusalOf("a.svg", "<g id=\"cuts\"><path d=\"M 0 0 C 1 1 2 2\"/></g>"),
            "/a.svg:1: error: a number is missing after 'M 0 0 C 1 1 2 2'. Complete the numbers");
  EXPECT_EQ(refusalOf("a.svg",
                      "<g id=\"cuts\"><path d=\"M 0 0 L 1000 0\"/><path d=\"M 1000 0 L 0 "
                      "1000\"/></g><g id=\"hinges\"><path d=\"M 500 100 L 500 200\"/></g>"),
            "/a.svg: error: the line that ends at (0, 0) px is not connected; give a cut pattern "
            "from `kirireel export`");
  EXPECT_EQ(refusalOf("a.dxf", "0\nLINE\n8\ncuts\n10\n0\n20\n0\n0\nEOF\n"),
            "/a.dxf:2: error: a LINE lacks an end (group 11); save the drawing again");
}

TEST(Patterns, TellOfHolesInTiles) {
  const auto square = [](double from, double to) {
    return fmt::format(
        "<path d=\"M {0} {0} L {1} {0}\"/><path d=\"M {1} {0} L {1} {1}\"/>"
        "<path d=\"M {1} {1} L {0} {1}\"/><path d=\"M {0} {1} L {0} {0}\"/>",
        from, to);
  };
  const TemporaryFolder folder;
  folder.write("a.svg", "<g id=\"cuts\">" + square(0, 1000) + square(300, 600) + "</g>");
  std::vector<std::string> warnings;
  EXPECT_EQ(formats::readModel(folder.path() / "a.svg", std::nullopt, warnings).tiles.size(), 1U);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(warnings[0].ends_with("; left out: 1 x hole in a tile")) << warnings[0];
  // Next to each other they are two tiles.
  EXPECT_EQ(refusalOf("a.svg", "<g id=\"cuts\">" + square(0, 1000) + square(1300, 1600) + "</g>"),
            "");
}

/// A pattern as an editor saves it: relative paths, groups with transforms, rounded.
std::string resaved(const std::vector<writers::PatternLine>& lines, int digits, double size) {
  const char* names[] = {"cuts", "slits", "hinges"};
  std::string text = fmt::format(
      "<?xml version='1.0'?><svg width='{0}mm' height='{0}mm' viewBox='-{1} -{1} {2} {2}'>"
      "<g transform='rotate(90)scale(0.5)' id='g1'>",
      1e3 * size, 0.5e3 * size, 1e3 * size);
  for (int layer = 0; layer < 3; ++layer) {
    text += fmt::format("<g inkscape:groupmode='layer' id='layer{}' inkscape:label='{}'>", layer,
                        names[layer]);
    for (const writers::PatternLine& line : lines) {
      if (static_cast<int>(line.layer) != layer) continue;
      // Turned back by 90 degrees, twice as large, y downwards.
      const Eigen::Vector2d from(-2e3 * line.from.y(), -2e3 * line.from.x());
      const Eigen::Vector2d to(-2e3 * line.to.y(), -2e3 * line.to.x());
      text += fmt::format("<path style='stroke:red' d='m{:.{}f},{:.{}f} {:.{}f},{:.{}f}'/>",
                          from.x(), digits, from.y(), digits, to.x() - from.x(), digits,
                          to.y() - from.y(), digits);
    }
    text += "</g>";
  }
  return text + "</g></svg>";
}

TEST(Patterns, ComeBackAfterAnEditor) {
  for (const char* name : {"tessellation", "fan", "heart", "hexagons", "triangles", "stars"}) {
    const model::Model drawn = generate::generateModel(generate::familyNamed(name), {});
    const double size = model::modelSize(drawn);
    const std::vector<writers::PatternLine> lines =
        writers::cutPattern(drawn, 0.05 * leastEdge(drawn));
    for (const int digits : {2, 3, 9}) {
      const TemporaryFolder folder;
      folder.write("a.svg", resaved(lines, digits, size));
      std::vector<std::string> warnings;
      try {
        const model::Model read =
            formats::readModel(folder.path() / "a.svg", std::nullopt, warnings);
        EXPECT_EQ(read.tiles.size(), drawn.tiles.size()) << name << digits;
        EXPECT_EQ(read.joints.size(), drawn.joints.size()) << name << digits;
        EXPECT_NEAR(model::modelSize(read), size, 1e-6 * size + 3e-3 * std::pow(10.0, -digits));
      } catch (const InputError& error) {
        ADD_FAILURE() << name << digits << ": " << error.what();
      }
    }
  }
}

}  // namespace
}  // namespace kirireel
