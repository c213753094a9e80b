#include "render/picture/average.h"

#include <array>
#include <cstddef>

namespace kirireel {
namespace {

constexpr int kSamples = kSamplesAcross * kSamplesDown;
constexpr int kChannels = 4;

/// round(sum / 6), halves up, for sums of up to six bytes: exact, and quicker than a division.
constexpr std::uint8_t sixth(unsigned sum) {
  return static_cast<std::uint8_t>(((sum + kSamples / 2) * 43691) >> 18);
}

/// The sums of one pixel's samples, channel by channel.
std::array<unsigned, kChannels> sums(const SampleRows& rows, int pixel) {
  std::array<unsigned, kChannels> sum = {};
  for (int row = 0; row < kSamplesDown; ++row) {
    const std::uint8_t* samples = rows.samples + std::ptrdiff_t{kChannels} * row * rows.rowSamples +
                                  std::ptrdiff_t{kChannels} * kSamplesAcross * pixel;
    for (int k = 0; k < kChannels; ++k) sum[k] += samples[k] + samples[kChannels + k];
  }
  return sum;
}

void averageTransparentRow(const SampleRows& rows, int count, std::uint8_t* pixels) {
  for (int x = 0; x < count; ++x) {
    const std::array<unsigned, kChannels> sum = sums(rows, x);
    const unsigned alpha = sum[3];
    for (int k = 0; k < 3; ++k) {
      pixels[kChannels * x + k] =
          alpha == 0 ? 0 : static_cast<std::uint8_t>((255 * sum[k] + alpha / 2) / alpha);
    }
    pixels[kChannels * x + 3] = sixth(alpha);
  }
}

}  // namespace

void averageRow(const SampleRows& rows, int count, std::uint8_t* pixels) {
  if (!rows.opaque) return averageTransparentRow(rows, count, pixels);
  const std::ptrdiff_t stride = std::ptrdiff_t{kChannels} * rows.rowSamples;
  const std::uint8_t* first = rows.samples;
  const std::uint8_t* second = first + stride;
  const std::uint8_t* third = second + stride;
  // Plain loops over bytes, which the compiler turns into vector instructions.
  for (int x = 0; x < count; ++x) {
    for (int k = 0; k < kChannels; ++k) {
      const int left = 2 * kChannels * x + k, right = left + kChannels;
      pixels[kChannels * x + k] = sixth(first[left] + first[right] + second[left] + second[right] +
                                        third[left] + third[right]);
    }
  }
}

}  // namespace kirireel
