// Geometry of drawings: positions in closed form, for any spelling.
#include "sim/formats/drawing.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "tests/support/files.h"

namespace kirireel::formats {
namespace {

using test::TemporaryFolder;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pair;

Drawing drawn(const std::string& name, const std::string& text) {
  const TemporaryFolder folder;
  folder.write(name, text);
  return readDrawing(folder.path() / name);
}

std::string refusal(const std::string& name, const std::string& text) {
  try {
    drawn(name, text);
    return "";
  } catch (const InputError& error) {
    return error.what();
  }
}

/// Shapes on a page of 100 mm, on which a user unit is a millimetre.
Drawing shapes(const std::string& content) {
  return drawn("a.svg",
               "<svg width=\"100mm\" height=\"100mm\" viewBox=\"0 0 100 100\" fill=\"none\" "
               "stroke=\"#f00\">" +
                   content + "</svg>");
}

/// In millimetres, y downwards as in SVG.
std::vector<Vector2> points(const Drawing& drawing, std::size_t path = 0) {
  std::vector<Vector2> all;
  for (const Vector2& p : drawing.paths.at(path).points)
    all.emplace_back(1e3 * p.x(), -1e3 * p.y());
  return all;
}

void expectPoints(const Drawing& drawing, const std::vector<Vector2>& expected) {
  ASSERT_EQ(drawing.paths.size(), 1U);
  const std::vector<Vector2> found = points(drawing);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t k = 0; k < found.size(); ++k) {
    EXPECT_LT((found[k] - expected[k]).norm(), 1e-9) << k << ": " << found[k].transpose();
  }
}

const std::vector<Vector2> kCorner = {{10, 20}, {30, 20}, {30, 50}};

TEST(SvgDrawing, AllSpellingsOfLinesAreOne) {
  for (const std::string text :
       {"<path d=\"M 10 20 L 30 20 L 30 50\"/>", "<path d=\"M10,20H30V50\"/>",
        "<path d=\"m10 20 20 0 0 30\"/>", "<path d='M1e1+20h20v30'/>",
        "<path d='m10 20 20 1e-400 0 30'/>", "<path d=\"M10,20 30,20 30,50\"/>",
        "<polyline points=\"10,20 30,20 30,50\"/>",
        "<!-- <path d=\"M0 0L1 1\"/> --><path d=\"m10 20h20v30\"/>",
        "<svg x=\"10\" y=\"20\"><path d=\"M0 0H20V30\"/></svg>",
        "<svg x=\"10\" y=\"20\" width=\"10\" height=\"10\" viewBox=\"5 5 20 20\"><path d=\"M5 "
        "5h40v60\"/></svg>",
        "<defs><path id=\"a\" d=\"M0 0H20V30\"/></defs><use href=\"#a\" x=\"10\" y=\"20\"/>",
        "<symbol id=\"a\"><path d=\"M0 0H20V30\"/></symbol><use xlink:href=\"#a\" x=\"10\" "
        "y=\"20\"/>",
        "<symbol id=\"a\" viewBox=\"0 0 80 80\"><path d=\"M0 0H40V60\"/></symbol><use "
        "href=\"#a\" x=\"10\" y=\"20\" width=\"40\" height=\"40\"/>",
        "<defs><svg id=\"a\" width=\"7\" viewBox=\"5 5 80 80\"><path d=\"M5 "
        "5h40v60\"/></svg></defs>"
        "<use href=\"#a\" x=\"10\" y=\"20\" width=\"40\" height=\"40\"/>",
        "<svg x=\"10\" y=\"20\" width=\"40\" height=\"90\" viewBox=\"0 0 80 80\" "
        "preserveAspectRatio=\"xMinYMin meet\"><path d=\"M0 0H40V60\"/></svg>",
        "<svg x=\"10\" y=\"0\" width=\"40\" height=\"60\" viewBox=\"0 0 80 80\" "
        "preserveAspectRatio=\"xMidYMax\"><path d=\"M0 0H40V60\"/></svg>"}) {
    SCOPED_TRACE(text);
    expectPoints(shapes(text), kCorner);
  }
}

TEST(SvgDrawing, TransformsApplyFromTheInside) {
  for (const std::string text :
       {"<g transform=\"translate(10 20)\"><path d=\"M0 0H20V30\"/></g>",
        "<g transform=\"translate(10,20) scale(10)\"><g transform='scale(2,3)'><path d=\"M0 "
        "0H1V1\"/></g></g>",
        "<path transform=\"matrix(2 0 0 3 10 20)\" d=\"M0 0H10V10\"/>",
        "<path transform=\"rotate(90 10 20)\" d=\"M10 20V0H40\"/>",
        "<path transform=\"translate(10 20)skewX(45)\" d=\"M0 0H20L-10 30\"/>",
        "<g style=\"transform:translate(10,20)\"><path d=\"M0 0H20V30\"/></g>",
        "<g style=\"transform:translate(10px,20px) rotate(0.25turn)\"><path d=\"M0 "
        "0V-20H30\"/></g>",
        "<g style=\"transform:translateX(10%) translateY(20px) rotate(90deg)\"><path d=\"M0 "
        "0V-20H30\"/></g>",
        "<path transform=\"rotate(90)\" transform-origin=\"10 20\" d=\"M10 20V0H40\"/>",
        "<path style=\"transform:rotate(90deg);transform-origin:10% 20px\" d=\"M10 20V0H40\"/>",
        "<path transform=\"scale(-1)\" transform-origin=\"center\" d=\"M90 80H70V50\"/>",
        "<path transform=\"scale(-1 1)\" transform-origin=\"bottom right\" d=\"M190 "
        "20H170V50\"/>"}) {
    SCOPED_TRACE(text);
    expectPoints(shapes(text), kCorner);
  }
}

TEST(SvgDrawing, LengthsHaveTheirUnits) {
  const auto length = [](const std::string& svg) { return drawn("a.svg", svg).size(); };
  const std::string line = "<line x2=\"96\" stroke=\"red\"/></svg>";
  EXPECT_NEAR(length("<svg>" + line), 0.0254, 1e-15);
  EXPECT_NEAR(length("<svg width=\"10cm\" viewBox=\"0 0 960 960\">" + line), 0.01, 1e-15);
  EXPECT_NEAR(length("<svg width=\"2in\" height=\"4in\" viewBox=\"0 0 96 96\">" + line), 0.0508,
              1e-15);
  EXPECT_NEAR(length("<svg height=\"72pt\" viewBox=\"0 0 5 96\">" + line), 0.0254, 1e-15);
  EXPECT_NEAR(length("<svg width=\"90mm\" height=\"90mm\" viewBox=\"0 0 90 90\">" + line), 0.096,
              1e-15);
  EXPECT_NEAR(length("<svg width=\"100%\" viewBox=\"0 0 90 90\">" + line), 0.0254, 1e-15);
  EXPECT_NEAR(shapes("<line x2=\"1in\" y2=\"0\"/>").size(), 0.096, 1e-12);  // a unit is 1 px
  EXPECT_NEAR(shapes("<line x2=\"50%\"/>").size(), 0.05, 1e-15);
  EXPECT_NEAR(shapes("<line x2=\"50,5\"/>").size(), 0.0505, 1e-15);
}

TEST(SvgDrawing, CurvesStayWithinTheirTolerance) {
  // All of them go through these points: a circle of 40 mm round (50, 50).
  for (const std::string text :
       {"<circle cx=\"50\" cy=\"50\" r=\"40\"/>",
        "<ellipse cx=\"50\" cy=\"50\" rx=\"40\" ry=\"40\"/>",
        "<path d=\"M90 50A40 40 0 0 1 10 50A40 40 0 0 1 90 50Z\"/>",
        "<path d=\"M90 50a40 40 0 01-80 0a40 40 0 0180 0z\"/>",
        "<path d=\"M90 50A40 40 0 1 0 50 90\"/>",
        "<g transform=\"translate(50,50)scale(4)\"><circle r=\"10\"/></g>"}) {
    SCOPED_TRACE(text);
    const Drawing drawing = shapes(text);
    EXPECT_GT(drawing.flattening, 0);
    double most = 0, middle = 0;
    const std::vector<Vector2> p = points(drawing);
    for (std::size_t k = 0; k + 1 < p.size(); ++k) {
      most = std::max(most, std::abs((p[k] - Vector2(50, 50)).norm() - 40));
      middle = std::max(middle, 40 - (0.5 * (p[k] + p[k + 1]) - Vector2(50, 50)).norm());
    }
    EXPECT_LT(most, 1e-9);
    EXPECT_GT(middle, 0);
    EXPECT_LT(middle, 1.001e3 * drawing.flattening);
  }
}

TEST(SvgDrawing, BezierCurvesPassTheirOwnPoints) {
  // Half way, (a + 3 b + 3 c + d) / 8; quadratic ones (a + 2 b + c) / 4.
  const auto passes = [](const std::string& d, const Vector2& place) {
    double nearest = 1e9;
    for (const Vector2& p : points(shapes("<path d=\"" + d + "\"/>"))) {
      nearest = std::min(nearest, (p - place).norm());
    }
    return nearest;
  };
  EXPECT_LT(passes("M0 0C0 40 40 40 40 0", {20, 30}), 1e-9);
  EXPECT_LT(passes("M0 0c0 40 40 40 40 0", {20, 30}), 1e-9);
  EXPECT_LT(passes("M0 0Q20 40 40 0", {20, 20}), 1e-9);
  EXPECT_LT(passes("M0 0Q20 40 40 0T80 0", {60, -20}), 1e-9);
  EXPECT_LT(passes("M0 0C0 40 40 40 40 0S80 -40 80 0", {60, -30}), 1e-9);
}

TEST(SvgDrawing, RectanglesMayBeRounded) {
  EXPECT_EQ(points(shapes("<rect x=\"1\" y=\"2\" width=\"3\" height=\"4\"/>")).size(), 4U);
  const Drawing round = shapes("<rect width=\"30\" height=\"40\" rx=\"5\"/>");
  ASSERT_TRUE(round.paths[0].isClosed);
  double area = 0;
  const std::vector<Vector2> p = points(round);
  for (std::size_t k = 0; k < p.size(); ++k) {
    const Vector2& next = p[(k + 1) % p.size()];
    area += 0.5 * (p[k].x() * next.y() - next.x() * p[k].y());
  }
  EXPECT_NEAR(std::abs(area), 1200 - (4 - std::numbers::pi) * 25, 0.1);
}

TEST(SvgDrawing, StylesGiveColoursAndHide) {
  const Drawing drawing =
      drawn("a.svg",
            "<svg><style>.cls-1,.cls-2{fill:none;stroke:#0F0;} .cls-2{stroke:blue} /* x{} */ "
            "#hidden{display:none}</style>"
            "<g id=\"Layer_1\"><path class=\"cls-1\" d=\"M0 0H1\"/><path class=\"cls-2\" d=\"M0 "
            "0H1\"/></g>"
            "<path style=\"stroke:rgb(255, 0,0);stroke-dasharray:2 1\" id=\"Mark\" d=\"M0 0H1\"/>"
            "<path id=\"hidden\" stroke=\"red\" d=\"M0 0H1\"/><text>no line</text>"
            "<rect width=\"9\" height=\"9\" fill=\"white\"/></svg>");
  ASSERT_EQ(drawing.paths.size(), 3U);
  EXPECT_EQ(drawing.paths[0].colour, "#00ff00");
  EXPECT_EQ(drawing.paths[1].colour, "#0000ff");
  EXPECT_EQ(drawing.paths[2].colour, "#ff0000");
  EXPECT_EQ(drawing.paths[0].layer, "layer_1");
  EXPECT_THAT(drawing.paths[0].names, ElementsAre("layer_1", "cls-1"));
  EXPECT_THAT(drawing.paths[2].names, ElementsAre("mark"));
  EXPECT_TRUE(drawing.paths[2].isDashed);
  EXPECT_FALSE(drawing.paths[0].isDashed);
  EXPECT_THAT(drawing.ignored, ElementsAre(Pair("hidden element", 1),
                                           Pair("shape without a stroke", 1), Pair("text", 1)));
}

/// The colours of a drawing's lines.
std::vector<std::string> colours(const std::string& sheet, const std::string& content) {
  std::vector<std::string> found;
  const Drawing drawing =
      drawn("a.svg", "<svg stroke=\"red\"><style>" + sheet + "</style>" + content + "</svg>");
  for (const DrawnPath& path : drawing.paths) found.push_back(path.colour);
  return found;
}

TEST(SvgDrawing, StyleSheetsCascade) {
  const std::string line = "d=\"M0 0H1\"/>";
  const std::string green = "#008000", red = "#ff0000";
  for (const std::string sheet :
       {".cut path{stroke:green}", "g.cut > path.b{stroke:green}", "#Cut *{stroke:green}",
        "@import url(\"x;y.css\"); .b{stroke:green}", "@charset 'utf-8'; .b{stroke:green}",
        "@media print{.b{stroke:blue}} .b{stroke:green}", ".b{stroke:blue} .a{stroke:green}",
        "path.a{stroke:green} .b{stroke:blue}", ".a.b{stroke:green} g path{stroke:blue}",
        ".a{stroke:green!important} #p{stroke:blue}",
        "path:hover,.b[x]{stroke:blue} .b{stroke:green}", "svg g path{stroke:green}"}) {
    SCOPED_TRACE(sheet);
    EXPECT_THAT(colours(sheet, "<g id=\"Cut\" class=\"cut\"><path id=\"p\" class=\"b a\" " + line +
                                   "</g><path " + line),
                ElementsAre(green, red));
  }
  EXPECT_THAT(colours("svg > path{stroke:green} .cut > path{stroke:blue}",
                      "<g class=\"cut\"><g><path " + line + "</g></g><path " + line),
              ElementsAre(red, green));
  EXPECT_THAT(drawn("a.svg",
                    "<svg stroke=\"red\"><style>@import 'a.css'; path:hover{x:y} g + "
                    "path{x:y}</style><path " +
                        line + "</svg>")
                  .ignored,
              ElementsAre(Pair("style rule @import, which is not applied", 1),
                          Pair("style rule for 'g + path', which is not applied", 1),
                          Pair("style rule for 'path:hover', which is not applied", 1)));
}

TEST(SvgDrawing, EntitiesOfTheDocumentTypeAreReplaced) {
  const Drawing drawing =
      drawn("a.svg",
            "<!DOCTYPE svg PUBLIC \"-//W3C//DTD SVG 1.1//EN\" \"svg11.dtd\" [\n<!ENTITY st0 "
            "\"stroke:#00FF00;\">\n<!ENTITY st1 'stroke:#0000FF'>\n]>\n<svg><path style=\"&st0;\" "
            "d=\"M0 0H1\"/><path style=\"fill:none;&st1;\" d=\"M0 0H1\"/></svg>");
  ASSERT_EQ(drawing.paths.size(), 2U);
  EXPECT_EQ(drawing.paths[0].colour, "#00ff00");
  EXPECT_EQ(drawing.paths[1].colour, "#0000ff");
}

TEST(SvgDrawing, InvisibleLinesAreNotCut) {
  for (const std::string style : {"opacity=\"0\"", "style=\"opacity:0%\"", "stroke-width=\"0\"",
                                  "style=\"stroke-width:0px\"", "stroke-opacity=\"0.0\""}) {
    SCOPED_TRACE(style);
    const Drawing drawing = shapes("<path d=\"M10 20H30V50\"/><path " + style + " d=\"M0 0H1\"/>");
    expectPoints(drawing, kCorner);
    EXPECT_EQ(drawing.ignored.size(), 1U);
  }
  // A drawing of hairlines only.
  expectPoints(shapes("<path stroke-width=\"0\" d=\"M10 20H30V50\"/>"), kCorner);
  EXPECT_THAT(shapes("<g clip-path=\"url(#c)\"><path d=\"M0 0H1\"/></g>").ignored,
              ElementsAre(Pair("clip-path, which is not applied", 1)));
}

// Lines end at the border of their clip path, and those outside are omitted.
TEST(SvgDrawing, ClipPathsEndLines) {
  const auto clipped = [](const std::string& lines) {
    return shapes(
        "<defs><clipPath id=\"c\" transform=\"translate(5)\"><rect x=\"5\" y=\"10\" "
        "width=\"30\" height=\"40\" stroke=\"none\"/></clipPath></defs>"
        "<g style=\"clip-path:url(#c)\">" +
        lines + "</g>");
  };
  const Drawing parts = clipped("<path d=\"M0 20H30V90\"/><path d=\"M0 0H90M60 20V40\"/>");
  expectPoints(parts, kCorner);
  EXPECT_THAT(parts.ignored,
              ElementsAre(Pair("line outside its clip path, which is not cut there", 3)));
  // A line on the border is inside. A closed line stays closed.
  const Drawing border = clipped("<rect x=\"10\" y=\"10\" width=\"30\" height=\"40\"/>");
  ASSERT_EQ(border.paths.size(), 1U);
  EXPECT_TRUE(border.paths[0].isClosed);
  EXPECT_TRUE(border.ignored.empty());
  EXPECT_EQ(clipped("<rect x=\"20\" y=\"-5\" width=\"5\" height=\"90\"/>").paths.size(), 2U);
}

TEST(SvgDrawing, EncodingsAndLineEndsDoNotMatter) {
  const std::string text =
      "<svg width=\"100mm\" viewBox=\"0 0 100 100\">\r\n<path stroke=\"red\" "
      "d=\"M 10 20\r\n L 30 20 L 30 50\"/></svg>\r\n";
  expectPoints(drawn("a.svg", text), kCorner);
  expectPoints(drawn("a.svg", "\xef\xbb\xbf<?xml version=\"1.0\"?>" + text), kCorner);
  std::string wide = "\xff\xfe";
  for (const char letter : text) (wide += letter) += '\0';
  expectPoints(drawn("A.SVG", wide), kCorner);
}

TEST(SvgDrawing, ReportsWhatIsWrong) {
  EXPECT_THAT(refusal("a.svg", "<svg>\n<path d=\"M0 0\"</svg>"),
              HasSubstr("a.svg:2: error: this is not XML"));
  EXPECT_THAT(refusal("a.svg", "<svg><path d=\"M 0 x\"/></svg>"), HasSubstr("'x' is not a number"));
  EXPECT_THAT(refusal("a.svg", "<svg><path d=\"0 0 1 1\"/></svg>"), HasSubstr("begin it with M"));
  EXPECT_THAT(refusal("a.svg", "<svg><path d=\"M0 0 K 1\"/></svg>"),
              HasSubstr("'K' is not a command"));
  EXPECT_THAT(refusal("a.svg", "<svg><g id=\"a\"><use href=\"#a\"/></g></svg>"),
              HasSubstr("groups or uses are nested more than 200 deep"));
  EXPECT_THAT(refusal("a.svg", "<svg><use href=\"#b\"/></svg>"),
              HasSubstr("does not exist. Remove it"));
  EXPECT_THAT(refusal("a.svg", "<svg>\n\n<use href=\"b.svg#b\"/></svg>"),
              HasSubstr("a.svg:3: error: a 'use' names 'b.svg#b' in another file"));
  EXPECT_THAT(refusal("a.svg", "<svg>\n<path d=\"M0 0L1\"/></svg>"),
              HasSubstr("a.svg:2: error: a number is missing after 'M0 0L1'"));
  EXPECT_THAT(refusal("a.svg", "<svg>\n<line x1=\"NaN\"/></svg>"),
              HasSubstr("a.svg:2: error: the length 'NaN' is not a number"));
  EXPECT_THAT(
      refusal("a.svg", "<svg><g transform=\"scale(2) matrix(1 0 0 1)\"/></svg>"),
      HasSubstr("'matrix(1 0 0 1)' is not a transform of SVG. Allowed: matrix of 6 numbers"));
  EXPECT_THAT(refusal("a.svg", "<svg><g transform=\"rotate(30\"/></svg>"),
              HasSubstr("'rotate(30' is not a transform of SVG"));
  EXPECT_THAT(refusal("a.svg", "<svg><g style=\"transform:rotate(3em)\"/></svg>"),
              HasSubstr("the angle '3em' has an unknown unit. Use deg"));
  EXPECT_THAT(refusal("a.svg",
                      "<svg><g style=\"transform:rotate(3deg);transform-origin:1px;"
                      "transform-box:fill-box\"/></svg>"),
              HasSubstr("the transform-box 'fill-box' is not supported"));
  EXPECT_THAT(refusal("a.svg", "\x1f\x8b\x08"), HasSubstr("this drawing is compressed"));
  EXPECT_THAT(refusal("a.svg", "<svg><line x2=\"3 parsec\"/></svg>"),
              HasSubstr("has an unknown unit"));
  EXPECT_THAT(refusal("a.svg", "<svg><line x2=\"1e30\" stroke=\"red\"/></svg>"),
              HasSubstr("coordinates must be within 1e+15 m"));
}

// ------------------------------------------------------------------------------------------------

std::string section(const std::string& name, const std::string& content) {
  return "0\nSECTION\n2\n" + name + "\n" + content + "0\nENDSEC\n";
}

Drawing entities(const std::string& content, const std::string& before = "") {
  return drawn("a.dxf", section("HEADER", "9\n$INSUNITS\n70\n4\n") + before +
                            section("ENTITIES", content) + "0\nEOF\n");
}

std::vector<Vector2> upPoints(const Drawing& drawing, std::size_t path = 0) {
  std::vector<Vector2> all;
  for (const Vector2& p : drawing.paths.at(path).points) all.emplace_back(1e3 * p);
  return all;
}

void expectUpPoints(const Drawing& drawing, const std::vector<Vector2>& expected) {
  ASSERT_EQ(drawing.paths.size(), 1U);
  const std::vector<Vector2> found = upPoints(drawing);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t k = 0; k < found.size(); ++k)
    EXPECT_LT((found[k] - expected[k]).norm(), 1e-9) << k;
}

TEST(DxfDrawing, PolylinesOfAllReleasesAreOne) {
  expectUpPoints(
      entities(
          "0\nLWPOLYLINE\n8\na\n90\n3\n70\n0\n10\n10\n20\n20\n10\n30\n20\n20\n10\n30\n20\n50\n"),
      kCorner);
  expectUpPoints(
      entities(
          "0\nPOLYLINE\n8\na\n66\n1\n70\n0\n0\nVERTEX\n10\n10\n20\n20\n0\nVERTEX\n10\n30\n20\n20\n"
          "0\nVERTEX\n10\n30\n20\n50\n0\nSEQEND\n"),
      kCorner);
  expectUpPoints(
      entities(
          "0\nSPLINE\n71\n1\n40\n0\n40\n0\n40\n1\n40\n2\n40\n2\n10\n10\n20\n20\n10\n30\n20\n20\n"
          "10\n30\n20\n50\n"),
      kCorner);
}

TEST(DxfDrawing, BlocksArePlacedScaledAndTurned) {
  const std::string block = section(
      "BLOCKS",
      "0\nBLOCK\n2\nB\n10\n1\n20\n1\n0\nLINE\n8\n0\n10\n1\n20\n1\n11\n2\n21\n1\n0\nENDBLK\n");
  const Drawing drawing =
      entities("0\nINSERT\n8\nCuts\n2\nb\n10\n10\n20\n20\n41\n5\n42\n1\n50\n90\n", block);
  expectUpPoints(drawing, {{10, 20}, {10, 25}});
  EXPECT_EQ(drawing.paths[0].layer, "cuts");  // what is on layer 0 goes to the insert's
}

TEST(DxfDrawing, ArcsBulgesAndEllipsesLieOnTheirCurves) {
  // A circle of 40 mm round the origin, or half of it.
  for (const std::string text :
       {"0\nCIRCLE\n10\n0\n20\n0\n40\n40\n", "0\nARC\n10\n0\n20\n0\n40\n40\n50\n-30\n51\n100\n",
        "0\nLWPOLYLINE\n70\n1\n10\n40\n20\n0\n42\n1\n10\n-40\n20\n0\n42\n1\n",
        "0\nELLIPSE\n10\n0\n20\n0\n11\n40\n21\n0\n40\n1\n41\n0\n42\n6.283185307179586\n",
        // A rational quadratic of a quarter: weights 1, cos 45 degrees, 1.
        "0\nSPLINE\n71\n2\n40\n0\n40\n0\n40\n0\n40\n1\n40\n1\n40\n1\n41\n1\n41\n0."
        "7071067811865476\n41\n1\n"
        "10\n40\n20\n0\n10\n40\n20\n40\n10\n0\n20\n40\n"}) {
    SCOPED_TRACE(text);
    const Drawing drawing = entities(text);
    const std::vector<Vector2> p = upPoints(drawing);
    ASSERT_GT(p.size(), 20U);
    for (const Vector2& one : p) EXPECT_NEAR(one.norm(), 40, 1e-9);
    for (std::size_t k = 0; k + 1 < p.size(); ++k) {
      EXPECT_LT(40 - (0.5 * (p[k] + p[k + 1])).norm(), 1.01e3 * drawing.flattening);
    }
  }
}

TEST(DxfDrawing, UnitsLayersAndColours) {
  const std::string line = "0\nLINE\n8\nA\n10\n0\n20\n0\n11\n1\n21\n0\n";
  const auto size = [&](int unit) {
    return drawn("a.dxf", section("HEADER", fmt::format("9\n$INSUNITS\n70\n{}\n", unit)) +
                              section("ENTITIES", line) + "0\nEOF\n")
        .size();
  };
  EXPECT_EQ(size(6), 1);
  EXPECT_EQ(size(4), 1e-3);
  EXPECT_EQ(size(1), 0.0254);
  EXPECT_EQ(size(7), 1e3);
  EXPECT_EQ(size(10), 0.9144);
  EXPECT_EQ(size(12), 1e-9);
  EXPECT_EQ(size(0), 1e-3);
  EXPECT_DOUBLE_EQ(size(3), 1609.344);
  EXPECT_DOUBLE_EQ(size(11), 1e-10);
  EXPECT_DOUBLE_EQ(size(21), 1200.0 / 3937);
  EXPECT_THAT(drawn("a.dxf", section("HEADER", "9\n$INSUNITS\n70\n19\n") +
                                 section("ENTITIES", line) + "0\nEOF\n\x1a")
                  .ignored,
              ElementsAre(Pair("$INSUNITS 19, which is not supported (`unit` decides)", 1)));
  const std::string tables =
      section("TABLES",
              "0\nTABLE\n2\nLAYER\n0\nLAYER\n2\nA\n70\n0\n62\n3\n6\nDASHED\n"
              "0\nLAYER\n2\nOff\n70\n0\n62\n-1\n0\nLAYER\n2\nFrozen\n70\n1\n62\n1\n0\nENDTAB\n");
  const Drawing drawing =
      entities(line +
                   "0\nLINE\n8\nOFF\n10\n0\n20\n0\n11\n1\n21\n0\n0\nLINE\n8\nfrozen\n10\n0\n20\n0\n"
                   "11\n1\n21\n0\n"
                   "0\nLINE\n8\nB\n62\n1\n10\n0\n20\n0\n11\n1,5\n21\n0\n0\nMTEXT\n1\nhi\n",
               tables);
  ASSERT_EQ(drawing.paths.size(), 2U);
  EXPECT_EQ(drawing.paths[0].colour, "#00ff00");
  EXPECT_TRUE(drawing.paths[0].isDashed);
  EXPECT_EQ(drawing.paths[1].colour, "#ff0000");
  EXPECT_NEAR(upPoints(drawing, 1)[1].x(), 1.5, 1e-12);
  EXPECT_THAT(drawing.ignored,
              ElementsAre(Pair("line on a layer that is off", 2), Pair("mtext", 1)));
}

TEST(DxfDrawing, ReportsWhatIsWrong) {
  EXPECT_THAT(refusal("a.dxf", "0\nLINE\n8\ncuts\n10\n0\n20\n0\n0\nEOF\n"),
              HasSubstr("a.dxf:2: error: a LINE lacks an end"));
  EXPECT_THAT(refusal("a.dxf", "0\nLINE\n8\ncuts\n10\n0\n20\nx\n0\nEOF\n"),
              HasSubstr("a.dxf:8: error: "));
  EXPECT_THAT(refusal("a.dxf", "0\nSECTION\nx\n"),
              HasSubstr("a.dxf:3: error: 'x' is not a group code with a value after it. Save"));
  EXPECT_THAT(refusal("a.dxf", "AutoCAD Binary DXF\r\n"), HasSubstr("save it as ASCII DXF"));
  EXPECT_THAT(
      refusal("a.dxf", section("ENTITIES", "0\nINSERT\n2\nb\n10\n0\n20\n0\n")),
      HasSubstr("a.dxf:6: error: an INSERT names the block 'b', which does not exist in this "
                "file. Explode it"));
  const std::string loop = "0\nINSERT\n2\nb\n10\n0\n20\n0\n";
  EXPECT_THAT(refusal("a.dxf", section("BLOCKS", "0\nBLOCK\n2\nb\n" + loop + "0\nENDBLK\n") +
                                   section("ENTITIES", loop)),
              HasSubstr("which is more than 20 blocks deep, or contains itself. Explode it"));
}

TEST(Drawing, PlacesAreTheDrawingsOwn) {
  const Drawing drawing = shapes("<path d=\"M 10.25 20 H 30\"/>");
  EXPECT_EQ(drawing.place(drawing.paths[0].points[0]), "(10.25, 20) mm");
  EXPECT_NEAR(drawing.rounding, 1e-5, 1e-12);
}

// Found by a fuzzer.
TEST(Drawing, MessagesNameAFewOfManyThings) {
  EXPECT_EQ(listed({"a", "b", "c"}, 2), "a, b and 1 more");
  EXPECT_EQ(listed({"a", "b"}, 2), "a, b");
  std::string entities;
  for (int k = 0; k < 100; ++k) entities += fmt::format("0\n{}{}\n", k, std::string(100, 'x'));
  EXPECT_EQ(drawn("a.dxf", section("ENTITIES", entities))
                .ignored.count("10" + std::string(22, 'x') + "..."),
            1U);
}

// Windows programs write UTF-16, old Macintosh programs end lines with a carriage return.
TEST(DxfDrawing, ReadsTextOfAnySystem) {
  const std::string plain = section("ENTITIES", "0\nLINE\n10\n0\n20\n0\n11\n1\n21\n2\n");
  const std::vector<DrawnPath> paths = drawn("a.dxf", plain).paths;
  ASSERT_EQ(paths.size(), 1U);
  std::string macintosh = plain, wide = "\xFE\xFF";
  std::ranges::replace(macintosh, '\n', '\r');
  for (const char letter : plain) wide += {'\0', letter};
  for (const std::string& text : {macintosh, wide, "\xEF\xBB\xBF" + plain}) {
    const std::vector<DrawnPath> read = drawn("a.dxf", text).paths;
    ASSERT_EQ(read.size(), 1U);
    EXPECT_EQ(read[0].points, paths[0].points);
  }
}

// The finest place of more than a few numbers, not the most frequent one.
TEST(Drawing, TheLastDigitIsTheFinest) {
  const auto roundingOf = [](const std::string& fine, int share) {
    std::string lines;
    for (int k = 0; k < 10; ++k) {
      lines += fmt::format("<path d=\"M 10.0 20.50 L {} 40\"/>", 10 * k < share ? fine : "7.00");
    }
    return shapes(lines).rounding;
  };
  EXPECT_NEAR(roundingOf("7", 100), 1e-4, 1e-15);
  EXPECT_NEAR(roundingOf("7.125", 30), 1e-6, 1e-15);  // 3 of 40
  EXPECT_NEAR(roundingOf("7.125", 20), 1e-4, 1e-15);  // 2 of 40
  EXPECT_EQ(roundingOf("7.12345678", 30), 0);
  EXPECT_NEAR(shapes("<path d=\"M 10.0 20.0 L 7.0 40.00\"/>").rounding, 1e-3, 1e-15);
}

}  // namespace
}  // namespace kirireel::formats
