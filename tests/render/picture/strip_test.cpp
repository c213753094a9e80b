#include <gtest/gtest.h>

#include "render/picture/state_painter.h"

namespace kirireel {
namespace {

constexpr picture::FrameSize kWhole = {640, 360};
constexpr picture::Colour kSheet = {10, 200, 30};

/// A frame with a picture of one colour, and its strip.
picture::Frame framed(const picture::StripParts& parts, const picture::StripText& text,
                      const std::optional<picture::ColourScale>& colours = {},
                      const std::optional<picture::PictureScale>& scale = {}) {
  const picture::Strip strip(kWhole, parts, {});
  picture::Frame frame = picture::makeFrame(strip.picture(), kSheet);
  strip.append(frame, text, colours, {}, scale);
  return frame;
}

int countOf(const picture::Frame& frame, picture::Colour colour) {
  int count = 0;
  for (int y = 0; y < frame.size.height; ++y) {
    for (int x = 0; x < frame.size.width; ++x) count += frame.at(x, y) == colour ? 1 : 0;
  }
  return count;
}

TEST(Strip, IsAbsentWithoutParts) {
  EXPECT_EQ(picture::Strip(kWhole, {}, {}).picture(), kWhole);
}

TEST(Strip, NeverLiesOverThePicture) {
  const picture::StripParts parts{.longestCaption = "100%, t = 12.00 s",
                                  .progressBar = true,
                                  .scaleBar = true,
                                  .colours = true};
  const picture::Frame frame = framed(parts, {"50%, t = 6.00 s", 0.5}, picture::ColourScale{},
                                      picture::PictureScale{0.01, {}});
  EXPECT_EQ(frame.size, kWhole);
  const picture::FrameSize picture = picture::Strip(kWhole, parts, {}).picture();
  EXPECT_EQ(countOf(frame, kSheet), picture.width * picture.height);
}

TEST(Strip, FillsItsBarByTheProgress) {
  const picture::Colour text = picture::Style().text;
  const int whole = countOf(framed({.progressBar = true}, {"", 1}), text);
  EXPECT_GT(whole, 600);
  EXPECT_NEAR(countOf(framed({.progressBar = true}, {"", 0.25}), text), 0.25 * whole, 0.01 * whole);
  EXPECT_EQ(countOf(framed({.progressBar = true}, {"", 0}), text), 0);
}

TEST(Strip, ShrinksTextUntilTheLongestCaptionFits) {
  const std::string longest(60, 'm');
  const picture::Frame frame = framed({.longestCaption = longest}, {longest, 0});
  for (int y = 0; y < frame.size.height; ++y) {
    ASSERT_TRUE(frame.at(0, y) == kSheet || frame.at(0, y) == picture::Style().background);
    ASSERT_EQ(frame.at(0, y), frame.at(frame.size.width - 1, y));
  }
}

TEST(Strip, KeepsLettersAtTheirPositionInAllFrames) {
  const picture::StripParts parts{.longestCaption = "100%, t = 10.00 s"};
  const picture::Frame early = framed(parts, {"9%, t", 0}),
                       late = framed(parts, {"9%, t = 10.00 s", 0});
  const int upper = picture::Strip(kWhole, parts, {}).picture().height;
  for (int x = 0; x < kWhole.width / 2 - 40; ++x) {
    for (int y = upper; y < kWhole.height; ++y) ASSERT_EQ(early.at(x, y), late.at(x, y)) << x;
  }
}

}  // namespace
}  // namespace kirireel
