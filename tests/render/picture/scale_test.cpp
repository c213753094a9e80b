#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "render/picture/label.h"
#include "tests/render/picture/colours.h"

namespace kirireel {
namespace {

using test::kBlack;
using test::kWhite;

TEST(RoundLength, IsTheLongestOneTwoOrFive) {
  const auto text = [](double longest, const char* unit) {
    return picture::roundLength(longest, *findLengthUnit(unit)).text;
  };
  EXPECT_EQ(text(1, "m"), "1 m");
  EXPECT_EQ(text(0.999, "m"), "0.5 m");
  EXPECT_EQ(text(4.99, "m"), "2 m");
  EXPECT_EQ(text(0.06, "m"), "0.05 m");
  EXPECT_EQ(text(0.06, "mm"), "50 mm");
  EXPECT_EQ(text(0.06, "in"), "2 in");  // 2.36 in
  EXPECT_EQ(text(7e-5, "um"), "50 µm");
  EXPECT_EQ(text(6000, "km"), "5 km");
  for (const LengthUnit& unit : lengthUnits()) {
    for (double longest = 1e-6; longest < 1e5; longest *= 1.37) {
      const double metres = picture::roundLength(longest, unit).metres;
      EXPECT_LE(metres, longest * (1 + 1e-8));
      EXPECT_GT(metres, 0.39 * longest);
    }
  }
}

TEST(ScaleDrawer, DrawsABarOfTheExactLength) {
  picture::Frame frame = picture::makeFrame({400, 60}, kWhite);
  picture::FrameSurface surface(frame);
  picture::ScaleDrawer(16, kBlack).drawScaleBar(surface, "", 123, 200, 30);
  int dark = 0;
  for (int x = 0; x < 400; ++x) dark += frame.at(x, 30) == kBlack;
  EXPECT_EQ(dark, 123);
}

TEST(ScaleDrawer, DrawsAllColoursOfAScaleInOrder) {
  picture::Frame frame = picture::makeFrame({600, 40}, kWhite);
  picture::FrameSurface surface(frame);
  constexpr int kRow = 10;  // of the bar, above its ticks
  picture::ColourScale scale;
  scale.title = "gap, m";
  picture::ScaleDrawer(14, kBlack).drawColourBar(surface, scale, 300, 20, 600);
  int x = 0;
  while (frame.at(x, kRow) != picture::mapColour(scale.map, 0)) ASSERT_LT(++x, 599);
  int length = 0;
  while (frame.at(x + length, kRow) != picture::mapColour(scale.map, 1))
    ASSERT_LT(x + ++length, 599);
  EXPECT_EQ(length, 14 * 14 - 1);
  EXPECT_EQ(frame.at(x + length / 2, kRow),
            picture::mapColour(scale.map, double(length / 2) / length));
}

/// In a narrow space the text is smaller, the bar keeps at least 5 em, and all is in the space.
TEST(ScaleDrawer, KeepsAColourBarInNarrowSpaces) {
  picture::ColourScale scale;
  scale.title = "rotation, degrees";
  scale.most = 45;
  for (const int width : {120, 160, 240}) {
    picture::Frame frame = picture::makeFrame({400, 60}, kWhite);
    picture::FrameSurface surface(frame);
    picture::ScaleDrawer(20, kBlack).drawColourBar(surface, scale, 200, 30, width);
    int bar = 0, outside = 0;
    for (int x = 0; x < 400; ++x) {
      bool isColoured = false;
      for (int y = 0; y < 60; ++y) {
        const picture::Colour colour = frame.at(x, y);
        if (std::abs(x - 199.5) > 0.5 * width && colour != kWhite) ++outside;
        isColoured |= colour.red != colour.green;
      }
      bar += isColoured ? 1 : 0;
    }
    EXPECT_EQ(outside, 0) << width;
    EXPECT_GE(bar, 0.25 * width) << width;
  }
}

// The oracle is the position of each round value on the bar.
TEST(ScaleDrawer, DrawsTicksAtRoundValues) {
  picture::Frame frame = picture::makeFrame({600, 40}, kWhite);
  picture::FrameSurface surface(frame);
  const picture::ColourScale scale{picture::ColourMap::Viridis, 0, 3.1, ""};
  picture::ScaleDrawer(14, kBlack).drawColourBar(surface, scale, 300, 20, 600);
  int left = 0;
  while (frame.at(left, 10) != picture::mapColour(scale.map, 0)) ASSERT_LT(++left, 599);
  std::vector<int> ticks;
  for (int x = 0; x < 600; ++x) {
    if (frame.at(x, 18) == kBlack) ticks.push_back(x - left);
  }
  const int last = 14 * 14 - 1;
  const auto place = [last](double value) {
    return static_cast<int>(std::lround(value / 3.1 * last));
  };
  EXPECT_EQ(ticks, (std::vector<int>{0, place(1), place(2), place(3)}));
}

TEST(ScaleDrawer, DrawsALegendOfTheFreeWidth) {
  for (const int width : {600, 150}) {
    picture::Frame frame = picture::makeFrame({600, 40}, kWhite);
    picture::FrameSurface surface(frame);
    const picture::Colour red = {200, 10, 10}, green = {10, 150, 10};
    picture::ScaleDrawer(14, kBlack)
        .drawLegend(surface, {{red, "36 triangles"}, {green, "48 hexagons"}}, 300, 20, width);
    int least = 600, most = 0, reds = 0, greens = 0;
    for (int x = 0; x < 600; ++x) {
      for (int y = 0; y < 40; ++y) {
        if (frame.at(x, y) == kWhite) continue;
        least = std::min(least, x);
        most = std::max(most, x);
        reds += frame.at(x, y) == red;
        greens += frame.at(x, y) == green;
      }
    }
    EXPECT_EQ(reds, greens);
    EXPECT_GT(reds, 20);
    EXPECT_GE(least, 300 - width / 2 - 2);
    EXPECT_LE(most, 300 + width / 2 + 2);
  }
}

TEST(ScaleDrawer, KeepsWithinANarrowPicture) {
  picture::Frame frame = picture::makeFrame({200, 40}, kWhite);
  picture::FrameSurface surface(frame);
  picture::ColourScale scale;
  scale.title = "error, m";
  picture::ScaleDrawer(10, kBlack).drawColourBar(surface, scale, 100, 20, 200);
  for (int y = 0; y < 40; ++y) {
    EXPECT_EQ(frame.at(0, y), kWhite);
    EXPECT_EQ(frame.at(199, y), kWhite);
  }
}

TEST(ColourScale, PlacesValues) {
  const picture::ColourScale scale{picture::ColourMap::Viridis, 2, 6, ""};
  EXPECT_EQ(picture::shareOf(scale, 2), 0);
  EXPECT_EQ(picture::shareOf(scale, 5), 0.75);
  EXPECT_EQ(picture::shareOf({picture::ColourMap::Viridis, 0, 0, ""}, 1), 0);
}

}  // namespace
}  // namespace kirireel
