// A pixel is the mean of its samples, 2 across and 2 or 3 down. Samples hold premultiplied colours:
// c a / 255 for a channel c and alpha a, both 0 to 255. Their sum is already weighted by alpha. A
// pixel with straight alpha has
//
//     alpha = mean of a,    c = 255 sum(c a / 255) / sum(a).
//
// Opaque pictures, which most are, need no division by alpha: all four channels are means. Means
// are of sRGB bytes and not of light.
//
// A sixth in whole numbers: round(s / 6) = ((s + 3) 43691) >> 18 for s up to 6 * 255, because
// 43691 = ceil(2^18 / 6).
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "render/picture/painter.h"

namespace kirireel::picture {
namespace {

constexpr int kChannels = 4;

/// The nearest byte to the mean of the sum of a pixel's samples, halves up. A sixth is exact by a
/// multiplication, which is quicker than a division.
template <int kDown>
constexpr std::uint8_t meanOf(unsigned sum) {
  constexpr unsigned kSamples = kSamplesAcross * kDown;
  if constexpr (kSamples == 4) return static_cast<std::uint8_t>((sum + 2) / 4);
  static_assert(kSamples == 4 || kSamples == 6);
  return static_cast<std::uint8_t>(((sum + 3) * 43691) >> 18);
}

/// The sums of one pixel's samples, channel by channel. Red, green, blue, alpha.
std::array<unsigned, kChannels> sums(const SampleRows& rows, int pixel) {
  std::array<unsigned, kChannels> sum = {};
  for (int row = 0; row < rows.samplesDown; ++row) {
    const std::uint8_t* samples = rows.samples + std::ptrdiff_t{kChannels} * row * rows.rowSamples +
                                  std::ptrdiff_t{kChannels} * kSamplesAcross * pixel;
    for (int k = 0; k < kChannels; ++k) sum[k] += samples[k] + samples[kChannels + k];
  }
  return sum;
}

template <int kDown>
void averageTransparentRow(const SampleRows& rows, int count, std::uint8_t* pixels) {
  for (int x = 0; x < count; ++x) {
    const std::array<unsigned, kChannels> sum = sums(rows, x);
    const unsigned alpha = sum[3];
    for (int k = 0; k < 3; ++k) {
      pixels[kChannels * x + k] =
          alpha == 0 ? 0 : static_cast<std::uint8_t>((255 * sum[k] + alpha / 2) / alpha);
    }
    pixels[kChannels * x + 3] = meanOf<kDown>(alpha);
  }
}

/// Two samples next to each other.
std::uint64_t pairAt(const std::uint8_t* samples) {
  std::uint64_t pair;
  std::memcpy(&pair, samples, sizeof pair);
  return pair;
}

template <int kDown>
void averageOpaqueRow(const SampleRows& rows, int count, std::uint8_t* pixels) {
  const std::ptrdiff_t stride = std::ptrdiff_t{kChannels} * rows.rowSamples;
  for (int x = 0; x < count; ++x) {
    const std::uint8_t* samples = rows.samples + std::ptrdiff_t{kChannels} * kSamplesAcross * x;
    std::uint8_t* pixel = pixels + std::ptrdiff_t{kChannels} * x;
    // Most pixels are within one face.
    const std::uint64_t pair = pairAt(samples);
    bool isPlain = pair >> 32 == (pair & 0xffffffff);
    for (int row = 1; row < kDown; ++row) isPlain &= pairAt(samples + row * stride) == pair;
    if (isPlain) {
      std::memcpy(pixel, samples, kChannels);
      continue;
    }
    const std::array<unsigned, kChannels> sum = sums(rows, x);
    for (int k = 0; k < kChannels; ++k) pixel[k] = meanOf<kDown>(sum[k]);
  }
}

template <int kDown>
void average(const SampleRows& rows, int count, std::uint8_t* pixels) {
  if (rows.opaque) {
    averageOpaqueRow<kDown>(rows, count, pixels);
  } else {
    averageTransparentRow<kDown>(rows, count, pixels);
  }
}

}  // namespace

void averageRow(const SampleRows& rows, int count, std::uint8_t* pixels) {
  if (rows.samplesDown == kMostSamplesDown) {
    average<kMostSamplesDown>(rows, count, pixels);
  } else {
    average<2>(rows, count, pixels);
  }
}

}  // namespace kirireel::picture
