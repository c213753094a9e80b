#include <gtest/gtest.h>

#include "render/picture/state_painter.h"

namespace kirireel {
namespace {

constexpr FrameSize kWhole = {640, 360};
constexpr Colour kSheet = {10, 200, 30};

/// A frame whose picture is one colour all over, with its strip.
Frame framed(const StripParts& parts, const StripText& text,
             const std::optional<ColourScale>& colours = {},
             const std::optional<double>& metresPerPixel = {}) {
  const Strip strip(kWhole, parts, {});
  Frame frame = makeFrame(strip.picture(), kSheet);
  strip.append(frame, text, colours, {}, metresPerPixel);
  return frame;
}

int countOf(const Frame& frame, Colour colour) {
  int count = 0;
  for (int y = 0; y < frame.size.height; ++y) {
    for (int x = 0; x < frame.size.width; ++x) count += frame.at(x, y) == colour ? 1 : 0;
  }
  return count;
}

TEST(Strip, IsNotThereWithoutParts) {
  EXPECT_EQ(Strip(kWhole, {}, {}).picture(), kWhole);
}

TEST(Strip, NeverLiesOverThePicture) {
  const StripParts parts{"100%, t = 12.00 s", true, true, true};
  const Frame frame = framed(parts, {"50%, t = 6.00 s", 0.5}, ColourScale{}, 0.01);
  EXPECT_EQ(frame.size, kWhole);
  const FrameSize picture = Strip(kWhole, parts, {}).picture();
  EXPECT_EQ(countOf(frame, kSheet), picture.width * picture.height);
}

TEST(Strip, FillsItsBarByTheProgress) {
  const Colour text = Style().text;
  const int whole = countOf(framed({.progressBar = true}, {"", 1}), text);
  EXPECT_GT(whole, 600);
  EXPECT_NEAR(countOf(framed({.progressBar = true}, {"", 0.25}), text), 0.25 * whole, 0.01 * whole);
  EXPECT_EQ(countOf(framed({.progressBar = true}, {"", 0}), text), 0);
}

TEST(Strip, ShrinksTextUntilTheLongestCaptionFits) {
  const std::string longest(60, 'm');
  const Frame frame = framed({.longestCaption = longest}, {longest, 0});
  for (int y = 0; y < frame.size.height; ++y) {
    ASSERT_TRUE(frame.at(0, y) == kSheet || frame.at(0, y) == Style().background);
    ASSERT_EQ(frame.at(0, y), frame.at(frame.size.width - 1, y));
  }
}

TEST(Strip, KeepsLettersInTheirPlaceFromFrameToFrame) {
  const StripParts parts{.longestCaption = "100%, t = 10.00 s"};
  const Frame early = framed(parts, {"9%, t", 0}), late = framed(parts, {"9%, t = 10.00 s", 0});
  const int upper = Strip(kWhole, parts, {}).picture().height;
  for (int x = 0; x < kWhole.width / 2 - 40; ++x) {
    for (int y = upper; y < kWhole.height; ++y) ASSERT_EQ(early.at(x, y), late.at(x, y)) << x;
  }
}

}  // namespace
}  // namespace kirireel
