#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "render/picture/painter.h"

namespace kirireel {
namespace {

/// Three rows of random samples; the last channel is `alpha` if it is not negative.
std::vector<std::uint8_t> randomSamples(int count, int alpha) {
  std::mt19937 random(7);
  std::vector<std::uint8_t> samples(std::size_t{4} * 2 * 3 * count);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    samples[k] = static_cast<std::uint8_t>(k % 4 == 3 && alpha >= 0 ? alpha : random() % 256);
  }
  return samples;
}

/// The sum of a pixel's samples in a channel, by the definition.
double sum(const std::vector<std::uint8_t>& samples, int count, int pixel, int channel,
           int down = 3) {
  double total = 0;
  for (int row = 0; row < down; ++row) {
    for (int side = 0; side < 2; ++side) {
      total += samples[std::size_t{4} * (row * 2 * count + 2 * pixel + side) + channel];
    }
  }
  return total;
}

TEST(AverageRow, IsTheNearestByteToTheMean) {
  constexpr int kCount = 501;
  const std::vector<std::uint8_t> samples = randomSamples(kCount, 255);
  std::vector<std::uint8_t> pixels(std::size_t{4} * kCount);
  for (const int down : {2, 3}) {
    picture::averageRow({samples.data(), 2 * kCount, true, down}, kCount, pixels.data());
    for (int x = 0; x < kCount; ++x) {
      for (int k = 0; k < 4; ++k) {
        const double mean = sum(samples, kCount, x, k, down) / (2 * down);
        ASSERT_EQ(pixels[4 * x + k], std::floor(mean + 0.5));
      }
    }
  }
}

TEST(AverageRow, TakesAlphaOutOfTheColours) {
  constexpr int kCount = 64;
  std::vector<std::uint8_t> samples = randomSamples(kCount, -1);
  // Premultiplied: no colour is brighter than its alpha.
  for (std::size_t k = 0; k < samples.size(); ++k) {
    samples[k] = std::min(samples[k], samples[k / 4 * 4 + 3]);
  }
  std::vector<std::uint8_t> pixels(std::size_t{4} * kCount);
  picture::averageRow({samples.data(), 2 * kCount, false}, kCount, pixels.data());
  for (int x = 0; x < kCount; ++x) {
    const double alpha = sum(samples, kCount, x, 3);
    ASSERT_EQ(pixels[4 * x + 3], std::floor(alpha / 6 + 0.5));
    for (int k = 0; k < 3; ++k) {
      ASSERT_NEAR(pixels[4 * x + k], 255 * sum(samples, kCount, x, k) / alpha, 0.5 + 1e-9);
    }
  }
}

TEST(AverageRow, GivesTheSameForOpaqueSamplesEitherWay) {
  constexpr int kCount = 100;
  const std::vector<std::uint8_t> samples = randomSamples(kCount, 255);
  std::vector<std::uint8_t> quick(std::size_t{4} * kCount), general(quick.size());
  for (const int down : {2, 3}) {
    picture::averageRow({samples.data(), 2 * kCount, true, down}, kCount, quick.data());
    picture::averageRow({samples.data(), 2 * kCount, false, down}, kCount, general.data());
    EXPECT_EQ(quick, general);
  }
}

}  // namespace
}  // namespace kirireel
