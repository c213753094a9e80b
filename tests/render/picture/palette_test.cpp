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

/// Lit from any side, and half dimmed by other bricks, as StatePainter lights measures.
TEST(Palette, ScalesStandOutFromEveryPage) {
  for (const bool isDark : {false, true}) {
    picture::Style style = isDark ? picture::darkStyle() : picture::Style();
    style.ambient = 0.84;
    style.key.strength *= 0.38;
    style.fill.strength *= 0.38;
    style.occlusion *= 0.38;
    const Vector3 towardsLight = (style.key.direction + style.fill.direction).normalized();
    for (const picture::Colour page : {style.background, style.ground}) {
      double least = 21;
      for (const auto map : {picture::ColourMap::Viridis, picture::ColourMap::Cividis,
                             picture::ColourMap::CoolWarm}) {
        double before = 0;
        for (int k = 0; k <= 40; ++k) {
          const picture::Colour colour = picture::mapColour(map, k / 40.0, page);
          for (const Vector3& normal : {towardsLight, Vector3(-towardsLight)}) {
            for (const double occluded : {0.0, 0.5}) {
              const picture::Colour seen = picture::faceColour(normal, colour, style, occluded);
              least = std::min(least, picture::contrastOf(seen, page));
            }
          }
          // Viridis and cividis still rise in lightness.
          if (map != picture::ColourMap::CoolWarm) {
            EXPECT_GE(lightness(colour), before - 0.5);
          }
          before = lightness(colour);
        }
      }
      EXPECT_GE(least, 3) << isDark;  // 3.00 to 3.06
    }
  }
}

TEST(Palette, ContrastIsThatOfTheStandard) {
  EXPECT_NEAR(picture::contrastOf({0, 0, 0}, {255, 255, 255}), 21, 1e-9);
  EXPECT_NEAR(picture::contrastOf({119, 119, 119}, {255, 255, 255}), 4.48, 0.005);  // #777
  EXPECT_NEAR(picture::contrastOf({68, 1, 84}, {22, 24, 28}), 1.17, 0.03);
}

TEST(Palette, TextIsReadableOnEveryBackground) {
  const picture::Colour dark = picture::Style().text;
  EXPECT_EQ(picture::readableText(dark, {255, 255, 255}), dark);
  EXPECT_EQ(picture::readableText(dark, {10, 20, 60}), picture::darkStyle().text);
  for (int grey = 0; grey < 256; ++grey) {
    const auto byte = static_cast<std::uint8_t>(grey);
    const picture::Colour page = {byte, byte, byte};
    EXPECT_GE(picture::contrastOf(picture::readableText(dark, page), page), 4.5) << grey;
  }
}

}  // namespace
}  // namespace kirireel
