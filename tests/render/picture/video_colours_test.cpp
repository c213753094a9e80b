#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "render/picture/video.h"

namespace kirireel {
namespace {

constexpr picture::FrameSize kPicture{34, 6};

/// Planes with memory of their own, rows farther apart than they are long.
struct Planes {
  static constexpr std::ptrdiff_t kStride = 64;
  std::array<std::vector<std::uint8_t>, 3> bytes;

  explicit Planes(const picture::Frame& frame) {
    for (auto& plane : bytes) plane.resize(kStride * frame.size.height, 7);
    picture::toVideoColours(
        frame,
        {{bytes[0].data(), kStride}, {bytes[1].data(), kStride}, {bytes[2].data(), kStride}});
  }
  double at(int plane, int x, int y) const { return bytes[plane][kStride * y + x]; }
};

picture::Frame randomFrame(bool opaque) {
  std::mt19937 random(3);
  picture::Frame frame = picture::makeFrame(kPicture, {});
  for (std::size_t k = 0; k < frame.pixels.size(); ++k) {
    frame.pixels[k] = k % 4 == 3 && opaque ? 255 : static_cast<std::uint8_t>(random());
  }
  return frame;
}

/// A pixel over white, by the definition; columns beyond the picture are those at its border.
std::array<double, 3> colourAt(const picture::Frame& frame, int x, int y) {
  const picture::Colour colour = frame.at(std::max(x, 0), y);
  const auto over = [&colour](int channel) {
    return std::round((channel * colour.alpha + 255.0 * (255 - colour.alpha)) / 255);
  };
  return {over(colour.red), over(colour.green), over(colour.blue)};
}

double lumaOf(const std::array<double, 3>& colour) {
  return 0.2126 * colour[0] + 0.7152 * colour[1] + 0.0722 * colour[2];
}

/// The mean of the pixels that a colour sample represents.
std::array<double, 3> filtered(const picture::Frame& frame, int x, int y) {
  std::array<double, 3> mean = {};
  for (int row = 0; row < 2; ++row) {
    for (int side = -1; side <= 1; ++side) {
      const std::array<double, 3> colour = colourAt(frame, 2 * x + side, 2 * y + row);
      for (int k = 0; k < 3; ++k) mean[k] += colour[k] * (side == 0 ? 0.25 : 0.125);
    }
  }
  return mean;
}

TEST(VideoColours, AreThoseOfTheStandard) {
  for (const bool opaque : {true, false}) {
    const picture::Frame frame = randomFrame(opaque);
    const Planes planes(frame);
    for (int y = 0; y < kPicture.height; ++y) {
      for (int x = 0; x < kPicture.width; ++x) {
        const double exact = 16 + 219 * lumaOf(colourAt(frame, x, y)) / 255;
        ASSERT_NEAR(planes.at(0, x, y), exact, 0.5001);
      }
    }
    for (int y = 0; y < kPicture.height / 2; ++y) {
      for (int x = 0; x < kPicture.width / 2; ++x) {
        const std::array<double, 3> mean = filtered(frame, x, y);
        const double luma = lumaOf(mean);
        ASSERT_NEAR(planes.at(1, x, y), 128 + 224 * (mean[2] - luma) / 1.8556 / 255, 0.5001);
        ASSERT_NEAR(planes.at(2, x, y), 128 + 224 * (mean[0] - luma) / 1.5748 / 255, 0.5001);
      }
    }
  }
}

TEST(VideoColours, LeaveGreysGrey) {
  for (int level = 0; level < 256; ++level) {
    const auto grey = static_cast<std::uint8_t>(level);
    const Planes planes(picture::makeFrame({2, 2}, {grey, grey, grey}));
    EXPECT_EQ(planes.at(1, 0, 0), 128);
    EXPECT_EQ(planes.at(2, 0, 0), 128);
    EXPECT_NEAR(planes.at(0, 1, 1), 16 + 219 * level / 255.0, 0.5001);
  }
}

TEST(VideoColours, StayWithinTheirPlanes) {
  const Planes planes(randomFrame(true));
  EXPECT_EQ(planes.at(0, kPicture.width, 0), 7);
  EXPECT_EQ(planes.at(1, kPicture.width / 2, 0), 7);
  EXPECT_EQ(planes.at(2, 0, kPicture.height / 2), 7);
}

}  // namespace
}  // namespace kirireel
