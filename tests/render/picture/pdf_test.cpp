#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/picture/canvas.h"
#include "sim/base/files.h"
#include "tests/support/files.h"
#include "tests/support/program.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;

/// A page of 180 x 90 mm at 300 dots an inch, with its font at 7 points.
const picture::PageSettings kPage = {.size = {2126, 1063},
                                     .pixelsPerInch = 300,
                                     .outlines = {.colour = {38, 50, 66}},
                                     .fontFamily = "DejaVu Sans",
                                     .description = "Kirireel 0.1.0, model fan & co"};
constexpr int kEm = 29;  // 7 pt * 300 / 72

void drawOn(picture::Canvas& page) {
  page.begin("pictures");
  page.beginWithin("picture_01", 100, 100, 800, 800);
  page.begin("shadow", 0.5);
  page.polygon({{120, 130}, {620, 130}, {620, 630}}, {200, 200, 200});
  page.end();
  page.polygon({{100, 100}, {600, 100}, {600, 600}}, {128, 174, 220});
  page.outlines({{{100, 100}, {600, 100}, {600, 600}, {100, 100}}, {{700, 700}, {750, 750}}},
                picture::Canvas::Line::Slit);
  page.end();
  page.end();
  page.box(100, 950, 300, 10, {0, 0, 0});
  page.text("Größe α = 90° < 1", 100, 1000, kEm, {0, 0, 0});
  page.text("بيت", 900, 1000, kEm, {0, 0, 0});
  page.text("שלום abc", 1200, 1000, kEm, {0, 0, 0});
}

std::string pdf() {
  const std::unique_ptr<picture::Canvas> page =
      picture::makeCanvas(picture::PageFormat::Pdf, kPage);
  drawOn(*page);
  return page->finish();
}

class PdfInPoppler : public testing::Test {
 protected:
  void SetUp() override {
    if (!test::hasProgram("pdftotext")) {
      GTEST_SKIP() << "no pdftotext here; scripts/setup --with-tools installs poppler-utils";
    }
    writeTextFile(folder_ / "page.pdf", pdf());
  }

  std::string output(const std::string& program, const std::string& more = "") const {
    return test::outputOf(fmt::format("{} {} {}", program, (folder_ / "page.pdf").string(), more));
  }

  test::TemporaryFolder folder_;
};

TEST_F(PdfInPoppler, TextIsText) {
  EXPECT_THAT(output("pdftotext", "-"), HasSubstr("Größe α = 90° < 1"));
}

TEST_F(PdfInPoppler, ShapedTextIsInReadingOrder) {
  const std::string text = output("pdftotext", "-");
  EXPECT_THAT(text, HasSubstr("بيت"));
  EXPECT_THAT(text, HasSubstr("שלום"));
}

TEST_F(PdfInPoppler, FontsAreEmbedded) {
  const std::string fonts = output("pdffonts");
  EXPECT_THAT(fonts, HasSubstr("DejaVuSans"));
  // name, type, encoding, then: embedded, a subset, with a map to Unicode
  EXPECT_THAT(fonts, testing::ContainsRegex("yes yes yes"));
}

TEST_F(PdfInPoppler, IsAsLargeAsItsPixelsAreInPrint) {
  // 2126 / 300 inches are 510.24 points.
  EXPECT_THAT(output("pdfinfo"), testing::ContainsRegex("Page size: +510.24 x 255.12 pts"));
  EXPECT_THAT(output("pdfinfo"), HasSubstr("Kirireel 0.1.0, model fan & co"));
}

TEST(Pdf, IsTheSameEveryTime) {
  EXPECT_EQ(pdf(), pdf());
}

TEST(SvgPage, HasLayersTextAndOneStyle) {
  const std::unique_ptr<picture::Canvas> page =
      picture::makeCanvas(picture::PageFormat::Svg, kPage);
  drawOn(*page);
  const std::string svg = page->finish();
  EXPECT_THAT(svg, HasSubstr("width=\"180.001mm\""));
  EXPECT_THAT(svg, HasSubstr("<desc>Kirireel 0.1.0, model fan &amp; co</desc>"));
  EXPECT_THAT(svg, HasSubstr("<g id=\"pictures\" inkscape:label=\"pictures\" "
                             "inkscape:groupmode=\"layer\">"));
  EXPECT_THAT(svg, HasSubstr(">Größe α = 90° &lt; 1</text>"));
  EXPECT_THAT(svg, HasSubstr(" direction=\"rtl\" text-anchor=\"end\" fill=\"#000000\">שלום abc<"));
  EXPECT_THAT(svg, HasSubstr("<path class=\"outline\" d=\"M100.00 100.00L600.00 100.00L600.00 "
                             "600.00ZM700.00 700.00L750.00 750.00\"/>"));
  EXPECT_THAT(svg, HasSubstr(".outline { fill: none; stroke: #263242; stroke-width: 1;"));
}

}  // namespace
}  // namespace kirireel
