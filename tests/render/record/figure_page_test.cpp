// Pages of panels. Oracles: lengths in print from the settings; the same panel as the only one on a
// page.
#include "render/record/figure_page.h"

#include <regex>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/picture/png.h"
#include "render/record/record.h"
#include "sim/generate/lattice.h"
#include "tests/support/files.h"
#include "tests/support/png.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

class FigurePageTest : public testing::Test {
 protected:
  /// Records sheets of squares once.
  static void SetUpTestSuite() {
    for (const auto& [name, side] : {std::pair("small", 2), std::pair("large", 3)}) {
      scene::Scene scene;
      scene.model = generate::makeTessellation({.columns = side, .rows = side});
      scene.model.name = name;
      scene.stop.duration = 0.5;
      record::RecordSettings settings;
      settings.folder = runs().path() / name;
      settings.video = settings.snapshots = settings.meshes = false;
      record::record(scene, settings,
                     [](const record::Progress&) { return record::Interruption(); });
    }
  }

  static const test::TemporaryFolder& runs() {
    static const test::TemporaryFolder folder;
    return folder;
  }

  static record::FigurePanel pictures(const std::string& run, int states = 2) {
    record::FigurePanel panel;
    panel.runs = {runs().path() / run / "trajectory.h5"};
    panel.pictures.size = {160, 120};
    panel.pictures.grid = {1, states};
    panel.where = {"page.toml", 7, 3};
    return panel;
  }

  static record::FigurePanel plot(const std::string& curve) {
    record::FigurePanel panel;
    panel.runs = {runs().path() / "small" / "trajectory.h5",
                  runs().path() / "large" / "trajectory.h5"};
    panel.curves = record::CurvesSettings{.selected = {curve}};
    panel.where = {"page.toml", 7, 3};
    return panel;
  }

  /// The files of a page with these rows.
  record::FigurePage page(std::vector<std::vector<record::FigurePanel>> rows) const {
    record::FigurePage page;
    page.width = 120;
    page.dotsPerInch = 150;
    page.rows = std::move(rows);
    page.folder = folder_.path();
    page.files = {"page.svg"};
    return page;
  }

  std::string svgOf(const record::FigurePage& page) const {
    record::writeFigure(page);
    return test::bytesOf(folder_ / "page.svg");
  }

  static std::string messageOf(const record::FigurePage& page) {
    try {
      record::writeFigure(page);
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  }

  test::TemporaryFolder folder_;
};

/// Height of a page in its own unit, pixels.
double heightOf(const std::string& svg) {
  std::smatch found;
  EXPECT_TRUE(std::regex_search(svg, found, std::regex("viewBox=\"0 0 [0-9]+ ([0-9]+)\"")));
  return std::stod(found[1]);
}

/// Where a letter in bold begins, pixels.
Eigen::Vector2d placeOf(const std::string& letter, const std::string& svg) {
  std::smatch found;
  const std::regex text("<text x=\"([0-9.]+)\" y=\"([0-9.]+)\" [^>]*bold\"[^>]*>" + letter + "<");
  EXPECT_TRUE(std::regex_search(svg, found, text)) << letter;
  return found.empty() ? Eigen::Vector2d(-1, -1)
                       : Eigen::Vector2d(std::stod(found[1]), std::stod(found[2]));
}

TEST_F(FigurePageTest, HasPicturesAndPlotsWithLetters) {
  record::FigurePanel titled = pictures("large");
  titled.title = "A large sheet";
  record::FigurePage figure = page({{pictures("small", 3)}, {titled, plot("radius")}});
  figure.files = {"page.svg", "page.pdf", "page.png"};
  const std::string svg = svgOf(figure);
  EXPECT_THAT(svg, HasSubstr("width=\"120.057mm\""));  // 709 pixels, the next above 708.7
  EXPECT_THAT(svg, HasSubstr("panel_1_picture_03"));
  EXPECT_THAT(svg, HasSubstr("panel_2_picture_02"));
  EXPECT_THAT(svg, HasSubstr("panel_3_curves_1"));
  EXPECT_THAT(svg, HasSubstr("model small, large"));
  EXPECT_THAT(svg, HasSubstr(">A large sheet</text>"));
  const Eigen::Vector2d a = placeOf("a", svg), b = placeOf("b", svg), c = placeOf("c", svg);
  EXPECT_EQ(a.x(), 0);
  EXPECT_EQ(b.x(), 0);
  EXPECT_LT(a.y(), b.y());
  EXPECT_EQ(b.y(), c.y());
  // Two equal panels with a gap of one em, 15 pixels: (709 - 15) / 2 + 15.
  EXPECT_EQ(c.x(), 362);
  EXPECT_EQ(test::readPng(folder_ / "page.png").size.width, 709);
  EXPECT_EQ(test::bytesOf(folder_ / "page.pdf").substr(0, 5), "%PDF-");
}

TEST_F(FigurePageTest, SharesAndHeightsAreThoseOfThePanels) {
  record::FigurePanel wide = plot("radius");
  wide.share = 3;
  wide.height = 40;
  record::FigurePage figure = page({{pictures("small"), wide}});
  figure.rows[0][0].height = 20;
  const std::string svg = svgOf(figure);
  EXPECT_EQ(placeOf("b", svg).x(), 188);  // floor(694 / 4) + 15
  // 1.6 em and 40 mm; the pictures are lower.
  EXPECT_NEAR(heightOf(svg), 40 / 25.4 * 150 + 1.6 * 15, 1);
}

/// A plot without a height fills the row, so it does not change the height of the page.
TEST_F(FigurePageTest, PlotsFillTheHeightOfPictures) {
  const std::string single = svgOf(page({{pictures("small", 1), pictures("small", 1)}}));
  const std::string both = svgOf(page({{pictures("small", 1), plot("radius")}}));
  EXPECT_EQ(heightOf(single), heightOf(both));
}

TEST_F(FigurePageTest, EqualPagesHaveEqualBytes) {
  for (const char* file : {"page.svg", "page.pdf", "page.png"}) {
    record::FigurePage figure = page({{pictures("small"), plot("theta")}});
    figure.files = {file};
    record::writeFigure(figure);
    const std::string first = test::bytesOf(folder_ / file);
    record::writeFigure(figure);
    EXPECT_EQ(first, test::bytesOf(folder_ / file)) << file;
  }
}

TEST_F(FigurePageTest, PanelsHaveTheirOwnOutlines) {
  record::FigurePage figure = page({{pictures("small"), pictures("small")}});
  figure.rows[0][1].pictures.appearance.outlineColour = picture::Colour{255, 0, 0};
  const std::string svg = svgOf(figure);
  EXPECT_THAT(svg, HasSubstr("#panel_1 .outline { fill: none; stroke: #263242"));
  EXPECT_THAT(svg, HasSubstr("#panel_2 .outline { fill: none; stroke: #ff0000"));
  EXPECT_THAT(svg, HasSubstr("#panel_1 .silhouette { stroke-width: 1.563"));  // 0.75 pt
}

TEST_F(FigurePageTest, ErrorsNameThePanel) {
  EXPECT_THAT(messageOf(page({{plot("raduis")}})),
              testing::StartsWith("page.toml:7:3: error: --curves: there is no curve 'raduis'; "
                                  "give some of size, width, height, depth, "));
  record::FigurePanel narrow = pictures("small");
  narrow.share = 0.1;
  EXPECT_EQ(messageOf(page({{narrow, pictures("small")}})),
            "page.toml:7:3: error: this panel is 10.7 mm wide, at least 25.4 mm are needed; give "
            "it a larger share, or its row fewer panels");
  record::FigurePanel heads = pictures("small");
  heads.pictures.columnHeads = {"only"};
  EXPECT_THAT(messageOf(page({{heads}})),
              HasSubstr("page.toml:7:3: error: 2 columns have 1 heads"));
  EXPECT_FALSE(fs::exists(folder_ / "page.svg"));
}

TEST(FigurePage, HasThreeFormats) {
  EXPECT_EQ(record::pageFormatOf("a.SVG"), picture::PageFormat::Svg);
  EXPECT_THROW(record::pageFormatOf("a.jpg"), InputError);
}

}  // namespace
}  // namespace kirireel
