// ITU-R BT.709-6, items 3.2 to 3.4, applied to bytes of sRGB:
//
//   Y' = 16 + 219/255 (0.2126 R + 0.7152 G + 0.0722 B)
//   Cb = 128 + 224/255 (B - E) / 1.8556,  Cr = 128 + 224/255 (R - E) / 1.5748,
//
// where E is the bracket of the first line. A sample of Cb or Cr covers two rows of pixels and lies
// on an even column, whose weight is twice that of its neighbours.
//
// The loops have plain numbers and no branches, so the compiler makes vector instructions. Two
// channels are added at once, as the halves of a 32-bit word. They are weighted as floats, because
// SSE2 has no products of 32-bit integers.
#include <array>
#include <bit>
#include <cstring>
#include <vector>

#include "render/picture/video.h"

namespace kirireel::picture {
namespace {

static_assert(std::endian::native == std::endian::little, "a pixel's first byte is its lowest");

struct Weights {
  float red, green, blue;
};
constexpr Weights kLuma = {0.2126F, 0.7152F, 0.0722F};

constexpr float kLumaRange = 219.0F / 255;
constexpr Weights kBrightness = {kLumaRange * kLuma.red, kLumaRange* kLuma.green,
                                 kLumaRange* kLuma.blue};

/// Sum of the weights of the pixels of a sample of Cb or Cr: 2 rows of 1 + 2 + 1.
constexpr float kSummed = 8;
constexpr float kBlueRange = 224.0F / 255 / (2 - 2 * kLuma.blue) / kSummed;
constexpr float kRedRange = 224.0F / 255 / (2 - 2 * kLuma.red) / kSummed;
constexpr Weights kBlueness = {-kBlueRange * kLuma.red, -kBlueRange* kLuma.green,
                               kBlueRange*(1 - kLuma.blue)};
constexpr Weights kRedness = {kRedRange * (1 - kLuma.red), -kRedRange* kLuma.green,
                              -kRedRange* kLuma.blue};

/// The byte nearest to an offset plus the weighted channels. Adds 1/2 and truncates, which rounds
/// because all sums are positive.
std::uint8_t weighed(float offset, const Weights& weights, std::uint32_t red, std::uint32_t green,
                     std::uint32_t blue) {
  // One instruction converts signed numbers to floats.
  const auto number = [](std::uint32_t channel) {
    return static_cast<float>(static_cast<int>(channel));
  };
  return static_cast<std::uint8_t>(static_cast<int>(offset + 0.5F + weights.red * number(red) +
                                                    weights.green * number(green) +
                                                    weights.blue * number(blue)));
}

/// Red in the lowest byte, then green, blue and alpha.
std::uint32_t pixelAt(const std::uint8_t* row, int x) {
  std::uint32_t pixel = 0;
  std::memcpy(&pixel, row + std::ptrdiff_t{4} * x, sizeof pixel);
  return pixel;
}

/// Combines the bits of all pixels, so the loop has no branch.
bool isOpaqueRow(const std::uint8_t* row, int width) {
  std::uint32_t common = ~0U;
  for (int x = 0; x < width; ++x) common &= pixelAt(row, x);
  return common >> 24 == 255;
}

/// One byte per pixel.
void convertBrightness(const std::uint8_t* row, int width, std::uint8_t* brightness) {
  for (int x = 0; x < width; ++x) {
    const std::uint32_t pixel = pixelAt(row, x);
    brightness[x] = weighed(16, kBrightness, pixel & 255, pixel >> 8 & 255, pixel >> 16 & 255);
  }
}

/// Sums of pixels, two channels in the halves of a word.
struct ColumnSums {
  std::vector<std::uint32_t> redBlue, green;  ///< one per column, and one before the first

  explicit ColumnSums(int width) : redBlue(width + 1), green(width + 1) {}

  void add(const std::uint8_t* upper, const std::uint8_t* lower, int width) {
    constexpr std::uint32_t kHalves = 0x00FF00FF;
    std::uint32_t *both = redBlue.data() + 1, *middle = green.data() + 1;
    for (int x = 0; x < width; ++x) {
      const std::uint32_t a = pixelAt(upper, x), b = pixelAt(lower, x);
      both[x] = (a & kHalves) + (b & kHalves);
      middle[x] = (a >> 8 & 255) + (b >> 8 & 255);
    }
    redBlue[0] = redBlue[1];
    green[0] = green[1];
  }
};

/// The weights of columns are 1, 2, 1 around an even one. The right neighbour of the last even
/// column is inside the row, because the width is even.
void convertColours(const ColumnSums& sums, int width, std::uint8_t* blueness,
                    std::uint8_t* redness) {
  const auto filtered = [](const std::uint32_t* left) { return left[0] + 2 * left[1] + left[2]; };
  const std::uint32_t *redsBlues = sums.redBlue.data(), *greens = sums.green.data();
  for (int x = 0; x < width / 2; ++x) {
    const std::uint32_t redBlue = filtered(redsBlues + std::ptrdiff_t{2} * x);
    const std::uint32_t green = filtered(greens + std::ptrdiff_t{2} * x);
    blueness[x] = weighed(128, kBlueness, redBlue & 0xFFFF, green, redBlue >> 16);
    redness[x] = weighed(128, kRedness, redBlue & 0xFFFF, green, redBlue >> 16);
  }
}

}  // namespace

void copyOverWhite(const std::uint8_t* row, int width, std::uint8_t* copy) {
  if (isOpaqueRow(row, width)) {
    std::memcpy(copy, row, std::size_t{4} * width);
    return;
  }
  for (int x = 0; x < width; ++x) {
    const int alpha = row[4 * x + 3];
    for (int k = 4 * x; k < 4 * x + 3; ++k) {
      copy[k] = static_cast<std::uint8_t>((row[k] * alpha + 255 * (255 - alpha) + 127) / 255);
    }
    copy[4 * x + 3] = 255;
  }
}

void toVideoColours(const Frame& frame, const VideoPlanes& planes) {
  const auto [width, height] = frame.size;
  const auto& [brightness, blueness, redness] = planes;
  ColumnSums sums(width);
  std::array<std::vector<std::uint8_t>, 2> composed;
  for (int y = 0; y < height; y += 2) {
    std::array<const std::uint8_t*, 2> rows = {};
    for (int k = 0; k < 2; ++k) {
      rows[k] = frame.pixels.data() + frame.rowStart(y + k);
      if (!isOpaqueRow(rows[k], width)) {
        composed[k].resize(std::size_t{4} * width);
        copyOverWhite(rows[k], width, composed[k].data());
        rows[k] = composed[k].data();
      }
      convertBrightness(rows[k], width, brightness.rows + (y + k) * brightness.stride);
    }
    sums.add(rows[0], rows[1], width);
    convertColours(sums, width, blueness.rows + y / 2 * blueness.stride,
                   redness.rows + y / 2 * redness.stride);
  }
}

}  // namespace kirireel::picture
