#include "render/picture/grid.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include <gtest/gtest.h>

#include "render/picture/label.h"
#include "sim/base/error.h"
#include "tests/support/refusal.h"

namespace kirireel {
namespace {

void cutToFilledPart(std::vector<picture::GridPicture>& pictures) {
  const picture::PictureBox part = picture::filledPart(pictures);
  for (picture::GridPicture& picture : pictures)
    picture.frame = picture::cutOut(picture.frame, part);
}

std::vector<picture::GridPicture> colouredPictures(int count, picture::FrameSize size) {
  std::vector<picture::GridPicture> pictures;
  for (int k = 0; k < count; ++k) {
    pictures.push_back(
        {picture::makeFrame(size, {static_cast<std::uint8_t>(10 * k), 100, 200}), "t"});
  }
  return pictures;
}

TEST(GridLayout, HasGapsAndCaptionsInProportion) {
  picture::GridStyle style;
  style.gap = 0.1;
  style.captionSize = 0.25;
  const picture::GridLayout layout = picture::layOutGrid({160, 100}, {2, 3}, style);
  EXPECT_EQ(layout.gap, 10);
  EXPECT_EQ(layout.textSize, 25);
  EXPECT_EQ(layout.captionHeight, 40);
  EXPECT_EQ(layout.sheet, (picture::FrameSize{10 + 3 * 170, 10 + 2 * 150}));
  EXPECT_EQ(layout.left(2), 350);
  EXPECT_EQ(layout.upper(1), 160);
}

TEST(GridLayout, KeepsCaptionsLegibleUnderTinyPictures) {
  EXPECT_EQ(picture::layOutGrid({32, 18}, {1, 1}).textSize, 9);
}

TEST(GridLayout, RefusesEmptyAndHugeShapes) {
  EXPECT_EQ(test::refusalOf([] {
              picture::layOutGrid({10, 10}, {0, 3});
            }),
            "error: a grid cannot have 0 x 3 cells; give at least one row and one column, for "
            "example --grid 3x3");
  picture::GridStyle style;
  style.gap = 0;
  style.captionSize = 0;
  EXPECT_EQ(
      test::refusalOf([&] {
        picture::layOutGrid({1280, 720}, {2, 1000000}, style);
      }),
      "error: a grid of 2 x 1000000 pictures of 1280 x 720 pixels needs 1280000000 x 1468 pixels, "
      "at most 16384 per side are allowed; choose fewer or smaller pictures with --grid or --size");
}

TEST(Grid, FillsRowsFromTheLeftAndLeavesTheRestBlank) {
  const std::vector<picture::GridPicture> pictures = colouredPictures(5, {60, 40});
  const picture::GridShape shape{2, 3};
  const picture::GridLayout layout = picture::layOutGrid({60, 40}, shape);
  const picture::Frame sheet = picture::composeGrid(pictures, shape);
  EXPECT_EQ(sheet.size, layout.sheet);
  for (int cell = 0; cell < 6; ++cell) {
    const int left = layout.left(cell % 3);
    const int upper = layout.upper(cell / 3);
    const picture::Colour expected =
        cell < 5 ? pictures[cell].frame.at(0, 0) : picture::Colour{255, 255, 255};
    EXPECT_EQ(sheet.at(left, upper), expected) << cell;
    EXPECT_EQ(sheet.at(left + 59, upper + 39), expected) << cell;
    EXPECT_EQ(sheet.at(left - 1, upper), (picture::Colour{255, 255, 255})) << cell;
    EXPECT_EQ(sheet.at(left, upper + 40), (picture::Colour{255, 255, 255})) << cell;
  }
}

TEST(Grid, CentresCaptionsInTheStripUnderThePicture) {
  std::vector<picture::GridPicture> pictures = colouredPictures(1, {300, 200});
  pictures[0].caption = "t = 1.25 s";
  picture::GridStyle style;
  style.captionSize = 0.15;
  const picture::GridLayout layout = picture::layOutGrid({300, 200}, {1, 1}, style);
  const picture::Frame sheet = picture::composeGrid(pictures, {1, 1}, style);
  int first = sheet.size.width, last = -1, upper = sheet.size.height, lower = -1;
  for (int y = layout.upper(0) + 200; y < sheet.size.height; ++y) {
    for (int x = 0; x < sheet.size.width; ++x) {
      if (sheet.at(x, y) == style.background) continue;
      first = std::min(first, x);
      last = std::max(last, x);
      upper = std::min(upper, y);
      lower = std::max(lower, y);
    }
  }
  EXPECT_NEAR((first + last) / 2.0, sheet.size.width / 2.0, 2);  // measured 0.5
  EXPECT_GT(upper, layout.upper(0) + 200);
  EXPECT_LT(lower, layout.upper(0) + 200 + layout.captionHeight);
}

TEST(Grid, RefusesPicturesThatDoNotFit) {
  EXPECT_EQ(test::refusalOf([] {
              picture::composeGrid({}, {1, 1});
            }),
            "error: a grid needs at least one picture");
  EXPECT_EQ(test::refusalOf([] {
              picture::composeGrid(colouredPictures(5, {9, 9}), {2, 2});
            }),
            "error: a grid of 2 x 2 has room for 4 pictures, not 5; change --grid");
  std::vector<picture::GridPicture> mixed = colouredPictures(2, {9, 9});
  mixed[1].frame = picture::makeFrame({9, 8}, {});
  EXPECT_EQ(test::refusalOf([&] {
              picture::composeGrid(mixed, {2, 2});
            }),
            "error: pictures of one grid must have the same size, not 9 x 8 and 9 x 9 pixels");
}

TEST(TrimAlike, KeepsTheContentOfAllPictures) {
  const picture::Colour white{255, 255, 255}, red{255, 0, 0};
  std::vector<picture::GridPicture> pictures(2, {picture::makeFrame({400, 300}, white), ""});
  pictures[0].frame.set(100, 80, red);
  pictures[1].frame.set(299, 279, red);
  cutToFilledPart(pictures);
  // The marks span 200 x 200 pixels, with a margin of a twentieth of that on each side.
  EXPECT_EQ(pictures[0].frame.size, (picture::FrameSize{220, 220}));
  EXPECT_EQ(pictures[1].frame.size, (picture::FrameSize{220, 220}));
  EXPECT_EQ(pictures[0].frame.at(10, 10), red);
  EXPECT_EQ(pictures[1].frame.at(209, 209), red);
}

TEST(TrimAlike, LeavesRoomForCaptionsUnderNarrowModels) {
  std::vector<picture::GridPicture> pictures(1,
                                             {picture::makeFrame({400, 300}, {255, 255, 255}), ""});
  for (int y = 50; y < 250; ++y) pictures[0].frame.set(200, y, {0, 0, 0});
  cutToFilledPart(pictures);
  EXPECT_EQ(pictures[0].frame.size, (picture::FrameSize{91, 220}));
  EXPECT_EQ(pictures[0].frame.at(45, 10), (picture::Colour{0, 0, 0}));
}

TEST(TrimAlike, KeepsEmptyAndFullPictures) {
  std::vector<picture::GridPicture> pictures(1,
                                             {picture::makeFrame({40, 30}, {255, 255, 255}), ""});
  cutToFilledPart(pictures);
  EXPECT_EQ(pictures[0].frame.size, (picture::FrameSize{40, 30}));
  pictures[0].frame.set(39, 0, {});
  pictures[0].frame.set(0, 29, {});
  cutToFilledPart(pictures);
  EXPECT_EQ(pictures[0].frame.size, (picture::FrameSize{40, 30}));
}

TEST(PictureBox, OfALargerPictureIsTheSamePart) {
  const picture::PictureBox part{10, 21, {100, 50}};
  EXPECT_EQ(part.scaled(2.5).left, 25);
  EXPECT_EQ(part.scaled(2.5).upper, 53);
  EXPECT_EQ(part.scaled(2.5).size, (picture::FrameSize{250, 125}));
}

/// Records the drawn texts.
class NotedSurface : public picture::Surface {
 public:
  void box(double, double, double, double, picture::Colour) override {}
  void text(const std::string& line, double left, double baseline, int em, picture::Colour,
            picture::Weight) override {
    lines.push_back(line);
    ems.push_back(em);
    places.emplace_back(left, baseline);
  }

  std::vector<std::string> lines;
  std::vector<int> ems;
  std::vector<std::pair<double, double>> places;
};

TEST(Grid, KeepsItsTextSizeAndWrapsCaptions) {
  picture::GridStyle style;
  style.textSize = 20;
  const std::vector<std::string> captions = {"12.5%, t = 1.25 s, error 0.0012 m", "50%"};
  const picture::GridLayout layout = picture::layOutGrid({220, 200}, {1, 2}, style, captions);
  NotedSurface surface;
  picture::drawGridText(surface, layout, style, captions, 2);
  EXPECT_EQ(surface.lines,
            (std::vector<std::string>{"12.5%, t = 1.25 s,", "error 0.0012 m", "50%"}));
  for (const int em : surface.ems) EXPECT_EQ(em, 20);
  for (const auto& [left, baseline] : surface.places) EXPECT_LT(baseline, layout.sheet.height - 5);
}

TEST(Grid, LettersItsPanels) {
  picture::GridStyle style;
  style.letters = picture::PanelLetters::Plain;
  const picture::GridLayout layout = picture::layOutGrid({60, 40}, {10, 3}, style);
  NotedSurface surface;
  picture::drawGridText(surface, layout, style, std::vector<std::string>(28), 3);
  EXPECT_EQ(surface.lines[0], "(a)");
  EXPECT_EQ(surface.lines[2 * 25], "(z)");
  EXPECT_EQ(surface.lines[2 * 27], "(ab)");
  // Over its picture, under the caption of the one above.
  EXPECT_LT(surface.places[2 * 3].second, layout.upper(1));
  EXPECT_GT(surface.places[2 * 3].second, layout.upper(0) + 40 + layout.captionHeight);
}

TEST(Grid, ReportsWhatItsColumnsAre) {
  picture::GridStyle style;
  style.heads = {"flat", "Öffnung 45°"};
  const picture::GridLayout layout = picture::layOutGrid({100, 60}, {2, 2}, style);
  NotedSurface surface;
  picture::drawGridText(surface, layout, style, std::vector<std::string>(4), 2);
  ASSERT_GE(surface.lines.size(), 2);
  for (int column = 0; column < 2; ++column) {
    EXPECT_EQ(surface.lines[column], style.heads[column]);
    const auto& [left, baseline] = surface.places[column];
    const int width = picture::LabelWriter(surface.ems[column]).width(style.heads[column]);
    EXPECT_NEAR(left + width / 2.0, layout.left(column) + 50, 1);
    EXPECT_LT(baseline, layout.upper(0));
  }
  EXPECT_EQ(layout.upper(1) - layout.upper(0), picture::layOutGrid({100, 60}, {2, 2}).upper(1) -
                                                   picture::layOutGrid({100, 60}, {2, 2}).upper(0));
}

TEST(Grid, RefusesOtherNumbersOfHeads) {
  picture::GridStyle style;
  style.heads = {"flat", "open"};
  try {
    picture::layOutGrid({100, 60}, {2, 3}, style);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "error: 3 columns have 2 heads; give --column-heads one per column, separated by "
                 "commas, or change --grid");
  }
}

TEST(Grid, LeadsFromPictureToPictureByArrows) {
  picture::GridStyle style;
  style.arrows = true;
  const picture::GridLayout layout = picture::layOutGrid({100, 60}, {2, 3}, style);
  NotedSurface surface;
  // Five pictures: two arrows in the first row, one in the second.
  picture::drawGridText(surface, layout, style, std::vector<std::string>(5), 3);
  int arrows = 0;
  for (std::size_t k = 0; k < surface.lines.size(); ++k) {
    if (surface.lines[k] != picture::kArrow) continue;
    const auto& [left, baseline] = surface.places[k];
    const int column = arrows % 2, row = arrows / 2;
    EXPECT_GE(left, layout.left(column) + 100);
    EXPECT_LE(left + picture::LabelWriter(surface.ems[k]).width(picture::kArrow),
              layout.left(column + 1));
    EXPECT_GT(baseline, layout.upper(row));
    EXPECT_LT(baseline, layout.upper(row) + 60);
    ++arrows;
  }
  EXPECT_EQ(arrows, 3);
  EXPECT_EQ(layout.sheet.width, layout.left(2) + 100 + layout.gap);
}

TEST(CaptionText, ReportsTheChosenParts) {
  const picture::CaptionValues values{0.125, 1.25, M_PI / 4, 0.00123, 4.56e-13};
  EXPECT_EQ(picture::captionText({.progress = true}, values), "12.5%");
  EXPECT_EQ(picture::captionText({.time = true}, values), "t = 1.25 s");
  EXPECT_EQ(picture::captionText({true, true, true, true, true}, values),
            "12.5%, t = 1.25 s, turned 45.0°, error 0.0012 m, gap 4.6e-13 m");
  EXPECT_EQ(picture::captionText({.error = true, .gap = true}, {0, 0, 0, 2, 12}),
            "error 2.0 m, gap 12 m");
  EXPECT_EQ(picture::captionText({.error = true, .gap = true},
                                 {0, 0, 0, 0.002, 1.2e-5, *findLengthUnit("mm")}),
            "error 2.0 mm, gap 0.012 mm");
  EXPECT_EQ(picture::captionText({}, values), "");
  EXPECT_EQ(picture::captionText({.time = true, .error = true}, {}), "t = 0.00 s");
  EXPECT_EQ(picture::captionText({.progress = true}, {.progress = 1}), "100%");
  EXPECT_EQ(picture::captionText({.progress = true}, {.progress = 2 / 3.0}), "66.7%");
}

TEST(Grid, ShrinksCaptionsThatAreTooWide) {
  std::vector<picture::GridPicture> pictures = colouredPictures(2, {220, 200});
  for (picture::GridPicture& picture : pictures) picture.caption = "t = 1.25 s, error 1.2e-03 m";
  const picture::GridLayout layout = picture::layOutGrid({220, 200}, {1, 2});
  const picture::Frame sheet = picture::composeGrid(pictures, {1, 2});
  // No text is between the columns or at their sides.
  for (int y = layout.upper(0) + 200; y < sheet.size.height; ++y) {
    for (int x = 0; x < layout.gap; ++x) {
      ASSERT_EQ(sheet.at(x, y), picture::GridStyle().background);
      ASSERT_EQ(sheet.at(layout.left(1) - 1 - x, y), picture::GridStyle().background);
    }
  }
}

TEST(Grid, DrawsABarOfTheTrueLengthBelowAllPictures) {
  picture::GridStyle style;
  style.scale = {0.013, {}};
  const picture::GridLayout layout = picture::layOutGrid({300, 200}, {1, 2}, style);
  const picture::Frame sheet = picture::composeGrid(colouredPictures(2, {300, 200}), {1, 2}, style);
  EXPECT_EQ(sheet.size.height,
            picture::layOutGrid({300, 200}, {1, 2}).sheet.height + layout.scaleHeight);
  // Half a picture's width is 1.95 m, so the bar represents 1 m.
  int longest = 0;
  for (int y = layout.upper(0) + 200 + layout.captionHeight; y < sheet.size.height; ++y) {
    int run = 0;
    for (int x = 0; x < sheet.size.width; ++x) {
      run = sheet.at(x, y) == style.text ? run + 1 : 0;
      longest = std::max(longest, run);
    }
  }
  EXPECT_EQ(longest, std::lround(1 / 0.013));
}

TEST(Grid, DrawsTheScaleOfColoursBelowAllPictures) {
  picture::GridStyle style;
  style.colourScale = picture::ColourScale{picture::ColourMap::Cividis, 0, 2, "displacement, m"};
  const picture::Frame sheet = picture::composeGrid(colouredPictures(4, {300, 200}), {2, 2}, style);
  const picture::Colour bright = picture::mapColour(picture::ColourMap::Cividis, 1);
  int found = 0;
  for (int y = sheet.size.height - 40; y < sheet.size.height; ++y) {
    for (int x = 0; x < sheet.size.width; ++x) found += sheet.at(x, y) == bright ? 1 : 0;
  }
  EXPECT_GT(found, 3);
}

}  // namespace
}  // namespace kirireel
