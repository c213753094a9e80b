// Cut patterns read back: the sheet that they were drawn from, up to the order of its tiles.
#include <cmath>
#include <map>
#include <set>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "render/writers/flat_sheet.h"
#include "sim/base/error.h"
#include "sim/generate/families.h"
#include "sim/model/read_model.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

using test::TemporaryFolder;
using CornerPair = std::pair<std::pair<int, int>, std::pair<int, int>>;

Vector3 meanCorner(const std::vector<model::Tile>& tiles) {
  Vector3 sum = Vector3::Zero();
  int count = 0;
  for (const model::Tile& tile : tiles) {
    for (const Vector3& v : tile.vertices) {
      sum += v;
      ++count;
    }
  }
  return sum / count;
}

/// The corner of `tiles` at a corner's place, of the tile round the same centroid.
std::pair<int, int> cornerLike(const model::Model& model, const model::Corner& corner,
                               const std::vector<model::Tile>& tiles, const Vector3& moved,
                               double tolerance) {
  const Vector3 centre = model::tileCentroid(model.tiles[corner.tile]) + moved;
  const Vector3 place = model.tiles[corner.tile].vertices[corner.vertex] + moved;
  for (int t = 0; t < std::ssize(tiles); ++t) {
    if ((model::tileCentroid(tiles[t]) - centre).norm() > tolerance) continue;
    for (int k = 0; k < std::ssize(tiles[t].vertices); ++k) {
      if ((tiles[t].vertices[k] - place).norm() <= tolerance) return {t, k};
    }
  }
  return {-1, -1};
}

CornerPair sorted(std::pair<int, int> a, std::pair<int, int> b) {
  return a < b ? CornerPair{a, b} : CornerPair{b, a};
}

void expectSameSheet(const model::Model& read, const model::Model& drawn, const std::string& what) {
  ASSERT_EQ(read.tiles.size(), drawn.tiles.size()) << what;
  ASSERT_EQ(read.joints.size(), drawn.joints.size()) << what;
  const Vector3 moved = meanCorner(read.tiles) - meanCorner(drawn.tiles);
  // A pattern draws sides that nearly coincide (1e-4 of a tile) once: the kinks of this one's
  // slits.
  const double share = drawn.name == "square-to-circle" ? 2e-4 : 1e-9;  // measured 3e-13
  const double tolerance = share * model::tileSize(drawn);
  std::set<std::pair<int, int>> found;
  for (int t = 0; t < std::ssize(drawn.tiles); ++t) {
    for (int k = 0; k < std::ssize(drawn.tiles[t].vertices); ++k) {
      found.insert(cornerLike(drawn, {t, k}, read.tiles, moved, tolerance));
    }
  }
  std::size_t corners = 0;
  for (const model::Tile& tile : read.tiles) corners += tile.vertices.size();
  EXPECT_EQ(found.size(), corners) << what;
  EXPECT_FALSE(found.contains({-1, -1})) << what;
  std::set<CornerPair> expected, got;
  for (const model::Joint& joint : drawn.joints) {
    expected.insert(sorted(cornerLike(drawn, joint.a, read.tiles, moved, tolerance),
                           cornerLike(drawn, joint.b, read.tiles, moved, tolerance)));
  }
  for (const model::Joint& joint : read.joints) {
    EXPECT_EQ(joint.face, model::JointFace::Both);
    got.insert(sorted({joint.a.tile, joint.a.vertex}, {joint.b.tile, joint.b.vertex}));
  }
  EXPECT_EQ(got, expected) << what;
}

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
          expectSameSheet(model::readModel(folder.path() / name, std::nullopt, warnings), drawn,
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
    model::readModel(folder.path() / name, std::nullopt, warnings);
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
  EXPECT_EQ(model::readModel(folder.path() / "a.svg", std::nullopt, warnings).tiles.size(), 1U);
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
        const model::Model read = model::readModel(folder.path() / "a.svg", std::nullopt, warnings);
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
