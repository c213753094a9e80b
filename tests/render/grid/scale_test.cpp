#include "render/grid/scale.h"

#include <gtest/gtest.h>

namespace kirireel {
namespace {

constexpr Colour kWhite = {255, 255, 255};
constexpr Colour kBlack = {0, 0, 0};

TEST(RoundLength, IsTheLongestOneTwoOrFive) {
  const auto text = [](double longest) { return roundLength(longest).text; };
  EXPECT_EQ(text(1), "1 m");
  EXPECT_EQ(text(0.999), "0.5 m");
  EXPECT_EQ(text(4.99), "2 m");
  EXPECT_EQ(text(0.06), "50 mm");
  EXPECT_EQ(text(0.0021), "2 mm");
  EXPECT_EQ(text(7e-5), "50 um");
  EXPECT_EQ(text(6000), "5 km");
  for (double longest = 1e-6; longest < 1e5; longest *= 1.37) {
    const double metres = roundLength(longest).metres;
    EXPECT_LE(metres, longest * (1 + 1e-8));
    EXPECT_GT(metres, 0.39 * longest);
  }
}

TEST(ScaleDrawer, DrawsABarOfTheExactLength) {
  Frame frame = makeFrame({400, 60}, kWhite);
  FrameSurface surface(frame);
  ScaleDrawer(16, kBlack).drawScaleBar(surface, "", 123, 200, 30);
  int dark = 0;
  for (int x = 0; x < 400; ++x) dark += frame.at(x, 30) == kBlack;
  EXPECT_EQ(dark, 123);
}

TEST(ScaleDrawer, DrawsAllColoursOfAScaleInOrder) {
  Frame frame = makeFrame({600, 40}, kWhite);
  FrameSurface surface(frame);
  ColourScale scale;
  scale.title = "gap, m";
  ScaleDrawer(14, kBlack).drawColourBar(surface, scale, 300, 20, 600);
  int x = 0;
  while (frame.at(x, 20) != mapColour(scale.map, 0)) ASSERT_LT(++x, 599);
  int length = 0;
  while (frame.at(x + length, 20) != mapColour(scale.map, 1)) ASSERT_LT(x + ++length, 599);
  EXPECT_EQ(length, 14 * 14 - 1);
  EXPECT_EQ(frame.at(x + length / 2, 20), mapColour(scale.map, double(length / 2) / length));
}

TEST(ScaleDrawer, KeepsWithinANarrowPicture) {
  Frame frame = makeFrame({200, 40}, kWhite);
  FrameSurface surface(frame);
  ColourScale scale;
  scale.title = "error, m";
  ScaleDrawer(10, kBlack).drawColourBar(surface, scale, 100, 20, 200);
  for (int y = 0; y < 40; ++y) {
    EXPECT_EQ(frame.at(0, y), kWhite);
    EXPECT_EQ(frame.at(199, y), kWhite);
  }
}

TEST(ColourScale, PlacesValues) {
  const ColourScale scale{ColourMap::Viridis, 2, 6, ""};
  EXPECT_EQ(shareOf(scale, 2), 0);
  EXPECT_EQ(shareOf(scale, 5), 0.75);
  EXPECT_EQ(shareOf({ColourMap::Viridis, 0, 0, ""}, 1), 0);
}

}  // namespace
}  // namespace kirireel
