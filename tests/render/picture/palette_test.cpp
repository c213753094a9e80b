#include <cmath>
#include <limits>
#include <set>

#include <gtest/gtest.h>

#include "render/picture/style.h"

namespace kirireel {
namespace {

/// Lightness L* of CIE 1976, 0 to 100, of an sRGB colour.
double lightness(picture::Colour colour) {
  const auto linear = [](std::uint8_t byte) {
    const double value = byte / 255.0;
    return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
  };
  const double luminance =
      0.2126 * linear(colour.red) + 0.7152 * linear(colour.green) + 0.0722 * linear(colour.blue);
  return luminance > 0.008856 ? 116 * std::cbrt(luminance) - 16 : 903.3 * luminance;
}

TEST(Palette, ScalesGrowEvenlyLighter) {
  for (const picture::ColourMap map : {picture::ColourMap::Viridis, picture::ColourMap::Cividis}) {
    const double dark = lightness(picture::mapColour(map, 0));
    const double range = lightness(picture::mapColour(map, 1)) - dark;
    EXPECT_GT(range, 70);
    for (int k = 0; k <= 64; ++k) {
      const double share = k / 64.0;
      const double expected = dark + share * range;
      EXPECT_NEAR(lightness(picture::mapColour(map, share)), expected, 3) << share;  // measured 1.9
    }
  }
}

TEST(Palette, DivergingScalesGrowDarkerFromTheMiddle) {
  const auto at = [](double share) {
    return lightness(picture::mapColour(picture::ColourMap::CoolWarm, share));
  };
  for (int k = 1; k <= 32; ++k) {
    const double away = k / 64.0, nearer = (k - 1) / 64.0;
    EXPECT_LT(at(0.5 - away), at(0.5 - nearer) + 0.3) << away;
    EXPECT_LT(at(0.5 + away), at(0.5 + nearer) + 0.3) << away;
    EXPECT_NEAR(at(0.5 - away), at(0.5 + away), 3) << away;
  }
  EXPECT_EQ(picture::mapColour(picture::ColourMap::CoolWarm, 0.5),
            (picture::Colour{221, 221, 221}));
}

TEST(Palette, ScalesEndWithTheirEnds) {
  EXPECT_EQ(picture::mapColour(picture::ColourMap::Viridis, -2), (picture::Colour{68, 1, 84}));
  EXPECT_EQ(picture::mapColour(picture::ColourMap::Viridis, 7), (picture::Colour{253, 231, 37}));
  EXPECT_EQ(picture::mapColour(picture::ColourMap::Cividis, 0.5), (picture::Colour{125, 124, 120}));
}

TEST(Palette, MissingValuesAreGrey) {
  EXPECT_EQ(
      picture::mapColour(picture::ColourMap::Viridis, std::numeric_limits<double>::quiet_NaN()),
      (picture::Colour{160, 160, 160}));
}

TEST(Palette, KindsHaveSevenColours) {
  std::set<int> colours;
  for (int kind = 0; kind < 14; ++kind) {
    const picture::Colour colour = picture::kindColour(kind);
    colours.insert(colour.red << 16 | colour.green << 8 | colour.blue);
  }
  EXPECT_EQ(colours.size(), 7U);
}

}  // namespace
}  // namespace kirireel
