// Cut patterns read back: the drawn sheet, up to the order of its tiles.
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <set>

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

double minEdge(const model::Model& model) {
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
      const double width = share * minEdge(drawn);
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
  ASSERT_EQ(warnings.size(), 2U);
  EXPECT_TRUE(warnings[0].ends_with(
      ": note: the drawing has no unit of length, so pixels are 1/96 inch. `unit` sets another"))
      << warnings[0];
  EXPECT_TRUE(warnings[1].ends_with("; left out: 1 x hole in a tile")) << warnings[1];
  // Next to each other they are two tiles.
  EXPECT_EQ(refusalOf("a.svg", "<g id=\"cuts\">" + square(0, 1000) + square(1300, 1600) + "</g>"),
            "");
}

/// A pattern saved by an editor: relative paths, groups with transforms, rounded.
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
        writers::cutPattern(drawn, 0.05 * minEdge(drawn));
    for (const int digits : {2, 3, 4, 5, 6, 9}) {
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

/// A joint by its position and the positions of its tiles, in units of 1e-4 of the sheet.
std::set<std::array<long, 6>> placesOf(const model::Model& model, double size) {
  const Vector3 middle = test::meanCorner(model.tiles);
  std::set<std::array<long, 6>> places;
  for (const model::Joint& joint : model.joints) {
    std::array<Vector3, 3> points = {model.tiles[joint.a.tile].vertices[joint.a.vertex],
                                     model::tileCentroid(model.tiles[joint.a.tile]),
                                     model::tileCentroid(model.tiles[joint.b.tile])};
    std::array<long, 6> place{};
    for (int k = 0; k < 3; ++k) {
      for (int axis = 0; axis < 2; ++axis) {
        place[2 * k + axis] = std::lround(1e4 * (points[k] - middle)[axis] / size);
      }
    }
    const auto isBefore = std::pair(place[4], place[5]) < std::pair(place[2], place[3]);
    if (isBefore) std::swap_ranges(place.begin() + 2, place.begin() + 4, place.begin() + 4);
    places.insert(place);
  }
  return places;
}

// Each line and hinge may run in either direction, and copies may be mirrored: start closed or
// open, with short rests of sides between wide necks.
TEST(Patterns, DoNotDependOnTheDirectionOfTheirLines) {
  std::mt19937 random(3);
  for (const char* name : {"tessellation", "fan", "heart", "hexagons", "crosses", "stampfli-chain",
                           "penrose-chain", "trefoils"}) {
    const generate::Family& family = generate::familyNamed(name);
    for (const double start : {0.0, 25.0}) {
      std::map<std::string, double> given;
      const bool opens =
          std::ranges::any_of(family.parameters, [](const generate::FamilyParameter& parameter) {
            return parameter.name == "start-angle";
          });
      if (start > 0 && (!opens || std::string(name) == "trefoils")) continue;
      if (start > 0) given["start-angle"] = start;
      const model::Model drawn = generate::generateModel(family, given);
      const double size = model::modelSize(drawn);
      for (const double width : {0.05, 0.4}) {
        std::vector<writers::PatternLine> lines =
            writers::cutPattern(drawn, width * minEdge(drawn));
        const TemporaryFolder folder;
        std::vector<std::string> warnings;
        const auto read = [&](double mirror) {
          for (writers::PatternLine& line : lines) {
            if (random() % 2) std::swap(line.from, line.to);
            for (Eigen::Vector2d* end : {&line.from, &line.to}) {
              // Five decimals of a millimetre on a sheet of about 150 mm.
              for (double& x : *end) x = 1e-8 * std::round(1e8 * x * (mirror ? 1 : 0.15 / size));
              end->x() *= mirror ? mirror : 1;
            }
          }
          folder.write("a.svg", writers::patternSvg(lines));
          return formats::readModel(folder / "a.svg", std::nullopt, warnings);
        };
        SCOPED_TRACE(fmt::format("{} from {} degrees, width {}", name, start, width));
        const model::Model plain = read(0);
        EXPECT_EQ(plain.tiles.size(), drawn.tiles.size());
        EXPECT_EQ(plain.joints.size(), drawn.joints.size());
        model::Model mirrored = read(-1);
        const auto expected = placesOf(plain, 0.15);
        for (model::Tile& tile : mirrored.tiles) {
          for (Vector3& vertex : tile.vertices) vertex.x() *= -1;
        }
        EXPECT_EQ(placesOf(mirrored, 0.15), expected);
      }
    }
  }
}

/// The text with other names of layers.
std::string renamed(std::string text) {
  for (const char* name : {"cuts", "slits", "hinges"}) {
    const std::string id = fmt::format("id=\"{}\"", name);
    text.replace(text.find(id), id.size(), "class=\"laser\"");
  }
  return text;
}

// Openings between tiles are wider than slots. Their tips stop short of other corners.
TEST(Patterns, OfOpenSheetsNeedNoNamesOfLayers) {
  for (const auto& [name, start] :
       std::vector<std::pair<const char*, double>>{{"tessellation", 20},
                                                   {"tessellation", 70},
                                                   {"quads", 40},
                                                   {"triangles", 220},
                                                   {"hexagons", 30},
                                                   {"stars", 30},
                                                   {"crosses", 30},
                                                   {"stampfli-removal", 0},
                                                   {"penrose-removal", 0},
                                                   {"ammann-beenker-removal", 0}}) {
    std::map<std::string, double> given;
    if (start > 0) given["start-angle"] = start;
    const model::Model drawn = generate::generateModel(generate::familyNamed(name), given);
    const double size = model::modelSize(drawn);
    for (const double width : {0.02, 0.05}) {
      const std::vector<writers::PatternLine> lines =
          writers::cutPattern(drawn, width * minEdge(drawn));
      const TemporaryFolder folder;
      folder.write("a.svg", renamed(writers::patternSvg(lines)));
      std::vector<std::string> warnings;
      SCOPED_TRACE(fmt::format("{} from {} degrees, width {}", name, start, width));
      const model::Model read = formats::readModel(folder / "a.svg", std::nullopt, warnings);
      EXPECT_EQ(read.tiles.size(), drawn.tiles.size());
      EXPECT_EQ(placesOf(read, size).size(), drawn.joints.size());
      EXPECT_EQ(placesOf(read, size), placesOf(drawn, size));
    }
  }
}

// The fallback without hinges must not join two tiles to one.
TEST(Patterns, KeepEachHingeOrAreRefused) {
  const std::string text =
      "<svg width='30mm' height='30mm' viewBox='0 0 30 30'><g id='cuts'><path d='M15.93 "
      "15.338V14.662'/><path d='M15 15L5 25H25L15.94 15.342L15.93 15.338'/><path d='M15.93 "
      "14.662L15.94 14.658L25 5H5L15 15'/>{}</g><g id='hinges'><path d='M15 15H15.93'/></g></svg>";
  const TemporaryFolder folder;
  folder.write("a.svg", fmt::format(fmt::runtime(text), ""));
  std::vector<std::string> warnings;
  const model::Model model = formats::readModel(folder / "a.svg", std::nullopt, warnings);
  EXPECT_EQ(model.tiles.size(), 2U);
  EXPECT_EQ(model.joints.size(), 1U);
  EXPECT_EQ(refusalOf("a.svg", fmt::format(fmt::runtime(text), "<path d='M5 5L3 2'/>")),
            "/a.svg: error: the line that ends at (3, 2) mm is not connected; give a cut pattern "
            "from `kirireel export`");
}

}  // namespace
}  // namespace kirireel
