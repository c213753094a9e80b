#include <map>
#include <numbers>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "render/writers/flat_sheet.h"
#include "sim/base/error.h"
#include "sim/generate/lattice.h"
#include "tests/support/refusal.h"

namespace kirireel {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::StartsWith;

generate::TessellationShape shapeOf(int columns, int rows, double angle) {
  generate::TessellationShape shape;
  shape.columns = columns;
  shape.rows = rows;
  shape.startAngle = angle;
  return shape;
}

/// PyKirigami's rules for reading a planar OBJ back: "v" rows are vertices, "f" rows are tiles in
/// order, numbers count from 1 and end at a slash, all else is passed over.
std::vector<model::Tile> readAsPyKirigamiDoes(const std::string& text) {
  std::vector<Vector3> vertices;
  std::vector<model::Tile> tiles;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream row(line);
    std::string key;
    row >> key;
    if (key == "v") {
      std::string x, y, z;
      row >> x >> y >> z;
      vertices.emplace_back(std::stod(x), std::stod(y), std::stod(z));
    }
    if (key != "f") continue;
    model::Tile& tile = tiles.emplace_back();
    for (std::string corner; row >> corner;) {
      tile.vertices.push_back(vertices.at(std::stoi(corner.substr(0, corner.find('/'))) - 1));
    }
  }
  return tiles;
}

/// In its own plane the sheet is seen from above, for any initial side. Rotated back it is
/// unchanged.
TEST(FlatSheet, FacesUpAndTurnsBackFromAnyPlane) {
  const model::Model flat = generate::makeTessellation(shapeOf(3, 2, 0.4));
  for (const Vector3& turn :
       {Vector3(0, 0, 0), Vector3(0.3, -1, 0.2), Vector3(std::numbers::pi, 0, 0),
        Vector3(0, std::numbers::pi, 0), Vector3(0, std::numbers::pi - 1e-9, 0)}) {
    model::Model model = flat;
    for (model::Tile& tile : model.tiles) {
      for (Vector3& vertex : tile.vertices) vertex = rotationFromVector(turn) * vertex;
    }
    const writers::FlatSheet sheet = writers::flatSheet(model);
    const Vector3 normal = sheet.turn * rotationFromVector(turn) * Vector3::UnitZ();
    // Measured: 1.4e-16; 5e-16 for the corners.
    EXPECT_LT((normal - Vector3::UnitZ()).norm(), 1e-14) << turn.transpose();
    for (std::size_t i = 0; i < model.tiles.size(); ++i) {
      for (std::size_t k = 0; k < model.tiles[i].vertices.size(); ++k) {
        const auto& place = sheet.tiles[i][k];
        const Vector3 back = sheet.turn.conjugate() * Vector3(place.x(), place.y(), sheet.height);
        EXPECT_LT((back - model.tiles[i].vertices[k]).norm(), 1e-14) << turn.transpose();
      }
    }
  }
}

TEST(PlanarObj, IsReadBackToTheSameTarget) {
  const std::vector<model::Tile> tiles = generate::tessellationTiles(shapeOf(3, 2, 0), 1.0 / 3);
  const std::string text = writers::planarObjText(tiles);
  EXPECT_THAT(text, StartsWith("# 24 vertices 6 faces\nv "));
  EXPECT_THAT(text, testing::EndsWith("\n\nf 1 2 3 4\nf 5 6 7 8\nf 9 10 11 12\nf 13 14 15 16\n"
                                      "f 17 18 19 20\nf 21 22 23 24\n"));
  const std::vector<model::Tile> read = readAsPyKirigamiDoes(text);
  ASSERT_EQ(read.size(), tiles.size());
  for (std::size_t t = 0; t < tiles.size(); ++t) EXPECT_EQ(read[t].vertices, tiles[t].vertices);
}

std::map<writers::PatternLayer, double> lengths(const std::vector<writers::PatternLine>& lines) {
  std::map<writers::PatternLayer, double> sums;
  for (const writers::PatternLine& line : lines) sums[line.layer] += (line.to - line.from).norm();
  return sums;
}

TEST(CutPattern, KeepsANeckOfTheChosenWidthAtEachJoint) {
  // 2 x 2 closed unit squares: an outline of 8, four inner edges, four joints on them.
  const double width = 0.05;
  const std::vector<writers::PatternLine> lines =
      writers::cutPattern(generate::makeTessellation(shapeOf(2, 2, 0)), width);
  std::map<writers::PatternLayer, double> sums = lengths(lines);
  EXPECT_NEAR(sums[writers::PatternLayer::Cuts], 8, 1e-12);
  EXPECT_NEAR(sums[writers::PatternLayer::Slits], 4 - 4 * width, 1e-12);
  EXPECT_NEAR(sums[writers::PatternLayer::Hinges], 4 * width, 1e-12);
}

TEST(CutPattern, KeepsTheNecksOfTheModel) {
  model::Model model = generate::makeTessellation(shapeOf(2, 2, 0));
  double sum = 0;
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    model.joints[j].neck.width = 0.02 + 0.01 * static_cast<double>(j);
    sum += model.joints[j].neck.width;
  }
  std::map<writers::PatternLayer, double> sums = lengths(writers::cutPattern(model, std::nullopt));
  EXPECT_NEAR(sums[writers::PatternLayer::Hinges], sum, 1e-12);
  EXPECT_NEAR(sums[writers::PatternLayer::Slits], 4 - sum, 1e-12);
  // Without necks a twentieth of the tile size, and the user's value has priority.
  model.joints[0].neck = {};
  sums = lengths(writers::cutPattern(model, std::nullopt));
  EXPECT_NEAR(sums[writers::PatternLayer::Hinges], sum - 0.02 + 0.05, 1e-12);
  sums = lengths(writers::cutPattern(model, 0.07));
  EXPECT_NEAR(sums[writers::PatternLayer::Hinges], 4 * 0.07, 1e-12);
}

TEST(NeckOutlines, HaveTheNecksOfTheModel) {
  model::Model model = generate::makeTessellation(shapeOf(2, 2, 0));
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    model.joints[j].neck = {0.02 + 0.01 * static_cast<double>(j), 0.01, 0.01};
  }
  const auto areaOf = [](const writers::NeckOutline& outline, const std::vector<int>& loop) {
    double area = 0;
    for (std::size_t k = 0; k < loop.size(); ++k) {
      const writers::Vector2& a = outline.points[loop[k]];
      const writers::Vector2& b = outline.points[loop[(k + 1) % loop.size()]];
      area += 0.5 * (a.x() * b.y() - a.y() * b.x());
    }
    return area;
  };
  const writers::NeckOutline outline = writers::neckOutline(model, {});
  ASSERT_EQ(outline.necks.size(), model.joints.size());
  EXPECT_NEAR(outline.neckWidth, 0.015, 1e-15);
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    EXPECT_NEAR(std::abs(areaOf(outline, outline.necks[j])),
                0.01 * (model.joints[j].neck.width - 0.005), 1e-12);
  }
  // The user's value has priority: one width for all, their lengths stay.
  const writers::NeckOutline wide = writers::neckOutline(model, {.width = 0.1});
  for (const std::vector<int>& neck : wide.necks) {
    EXPECT_NEAR(std::abs(areaOf(wide, neck)), 0.01 * 0.1, 1e-12);
  }
  // A kerf of 0 closes the model's slots: the area is that of four squares.
  const auto areaWithout = [&] {
    const writers::NeckOutline shut = writers::neckOutline(model, {.width = 0.1, .kerf = 0});
    double area = 0;
    for (const std::vector<int>& tile : shut.tiles) area += areaOf(shut, tile);
    for (const std::vector<int>& neck : shut.necks) area += std::abs(areaOf(shut, neck));
    return std::pair{shut.necks.size(), area};
  };
  EXPECT_THAT(areaWithout(), testing::Pair(0U, testing::DoubleNear(4, 1e-12)));
  // Necks that are longer than the slots are wide keep their length, unless that is 0, too.
  for (model::Joint& joint : model.joints) joint.neck.length = 0.2;
  EXPECT_EQ(areaWithout().first, 4U);
  EXPECT_LT(areaWithout().second, 3.99);
  EXPECT_EQ(writers::neckOutline(model, {.length = 0, .kerf = 0}).necks.size(), 0U);
  // Without a neck and a width there is none.
  model.joints[2].neck = {};
  try {
    writers::neckOutline(model, {});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "error: necks cannot be 0 m wide; give a positive --neck-width, or the sheet "
                 "falls apart");
  }
}

TEST(NeckOutlines, SharedCornersNeedClosedSlits) {
  // Three of four squares round a corner that joins them all, with slots in the model.
  const auto square = [](double x, double y) {
    return model::Tile{{{x, y, 0}, {x + 1, y, 0}, {x + 1, y + 1, 0}, {x, y + 1, 0}}};
  };
  model::Model model;
  model.tiles = {square(0, 0), square(-1, 0), square(-1, -1)};
  model.joints = {{{0, 0}, {1, 1}, model::JointFace::Both},
                  {{1, 1}, {2, 2}, model::JointFace::Both}};
  for (model::Joint& joint : model.joints) joint.neck = {0.1, 0.02, 0.02};
  const auto refusal = [&](const writers::NeckShape& shape) {
    return test::refusalOf([&] { writers::neckOutline(model, shape); });
  };
  EXPECT_THAT(refusal({}), testing::HasSubstr("would cross; give --neck-length 0 and --kerf 0"));
  EXPECT_EQ(refusal({.length = 0, .kerf = 0}), "accepted");
}

TEST(CutPattern, ClosesOpenGapsWithALine) {
  // Opened by theta, each joint's gap ends where its chord is the width away from the joint.
  const double theta = 0.4;
  const double width = 0.05;
  const model::Model model = generate::makeTessellation(shapeOf(2, 1, theta));
  std::map<writers::PatternLayer, double> sums = lengths(writers::cutPattern(model, width));
  EXPECT_EQ(sums.count(writers::PatternLayer::Slits), 0U);
  EXPECT_NEAR(sums[writers::PatternLayer::Hinges], width, 1e-12);
  const double cut = 8 - 2 * width / std::cos(theta / 2) + 2 * width * std::tan(theta / 2);
  EXPECT_NEAR(sums[writers::PatternLayer::Cuts], cut, 1e-12);
}

std::string refusal(const model::Model& model, double width) {
  return test::refusalOf([&] { writers::cutPattern(model, width); });
}

TEST(CutPattern, ReportsModelsWithoutPattern) {
  model::Model model = generate::makeTessellation(shapeOf(2, 2, 0));
  EXPECT_EQ(refusal(model, 0),
            "error: hinges cannot be 0 m wide; give a positive --hinge-width, "
            "or the sheet falls apart");
  EXPECT_EQ(refusal(model, 1.5),
            "error: hinges 1.5 m wide leave nothing to cut of edge 1 of tile 0, 1 m long; choose a "
            "smaller --hinge-width");
  model::Model raised = model;
  raised.tiles[3].vertices[2].z() = 0.5;
  EXPECT_EQ(refusal(raised, 0.1),
            "error: the start is not flat: tile 3 reaches 0.5 m out of the plane of tile 0; only "
            "planar models have a cut pattern");
  model::Model turned = model;
  std::reverse(turned.tiles[2].vertices.begin(), turned.tiles[2].vertices.end());
  EXPECT_EQ(refusal(turned, 0.1),
            "error: tile 2 faces the other way than tile 0; a cut pattern needs all tiles on one "
            "side: reverse its vertices");
  model.joints[1].kind = model::JointKind::Link;
  EXPECT_EQ(refusal(model, 0.1),
            "error: joint 1 does not join two corners; a cut pattern has hinges only at corners");
}

TEST(CutPattern, NumbersTilesAsTheModelsFileDoes) {
  model::Model model = generate::makeTessellation(shapeOf(2, 2, 0));
  model.fileOrder.countsFrom = 1;
  EXPECT_EQ(refusal(model, 1.5),
            "error: hinges 1.5 m wide leave nothing to cut of edge 2 of tile 1, 1 m long; choose a "
            "smaller --hinge-width");
  model::Model raised = model;
  raised.tiles[3].vertices[2].z() = 0.5;
  EXPECT_EQ(refusal(raised, 0.1),
            "error: the start is not flat: tile 4 reaches 0.5 m out of the plane of tile 1; only "
            "planar models have a cut pattern");
  model::Model turned = model;
  std::reverse(turned.tiles[2].vertices.begin(), turned.tiles[2].vertices.end());
  EXPECT_EQ(refusal(turned, 0.1),
            "error: tile 3 faces the other way than tile 1; a cut pattern needs all tiles on one "
            "side: reverse its vertices");
  model.joints[1].kind = model::JointKind::Link;
  EXPECT_EQ(refusal(model, 0.1),
            "error: joint 2 does not join two corners; a cut pattern has hinges only at corners");
}

TEST(CutPattern, DrawsLayersInSvgAndDxf) {
  const std::vector<writers::PatternLine> lines = {
      {writers::PatternLayer::Cuts, {0, 0}, {0.1, 0}},
      {writers::PatternLayer::Slits, {0, 0}, {0, 0.2}},
      {writers::PatternLayer::Hinges, {0, 0.2}, {0, 0.25}}};
  const std::string svg = writers::patternSvg(lines);
  EXPECT_THAT(svg, HasSubstr("width=\"110mm\" height=\"260mm\" viewBox=\"0 0 110 260\""));
  EXPECT_THAT(svg, HasSubstr("<g id=\"cuts\" fill=\"none\" stroke-width=\"0.13\" "
                             "stroke=\"#d00000\">\n<path d=\"M 5 255 L 105 255\"/>\n</g>"));
  EXPECT_THAT(svg, HasSubstr("<g id=\"slits\""));
  const std::string dxf = writers::patternDxf(lines);
  EXPECT_THAT(dxf, HasSubstr("0\nLINE\n8\nslits\n10\n0\n20\n0\n11\n0\n21\n200\n"));
  EXPECT_THAT(dxf, HasSubstr("0\nLINE\n8\nhinges\n10\n0\n20\n200\n11\n0\n21\n250\n"));
  EXPECT_THAT(dxf, testing::EndsWith("0\nENDSEC\n0\nEOF\n"));
}

}  // namespace
}  // namespace kirireel
