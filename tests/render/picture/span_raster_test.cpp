#include "render/picture/span_raster.h"

#include <algorithm>
#include <array>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace kirireel {
namespace {

constexpr int kColumns = 40;
constexpr int kRows = 36;
constexpr int kStripRows = 8;
const picture::SpanRaster::Sample kBackground = {9, 9, 9, 255};

using Corners = std::array<Eigen::Vector2d, 3>;
using Samples = std::vector<picture::SpanRaster::Sample>;

/// The whole picture from its lower left corner, read strip by strip.
Samples samplesOf(const picture::SpanRaster& raster) {
  Samples all(kColumns * kRows), strip;
  for (int upper = 0; upper < kRows; upper += kStripRows) {
    const int end = kRows - upper, first = std::max(0, end - kStripRows);
    raster.read({Eigen::Vector2i(0, first), Eigen::Vector2i(kColumns, end)}, kBackground, strip);
    std::ranges::copy(strip, all.begin() + kColumns * first);
  }
  return all;
}

/// In whole steps of 1/256 sample: exact.
bool covers(const Corners& corners, int column, int row) {
  std::array<Eigen::Vector2<long>, 3> steps;
  for (int k = 0; k < 3; ++k) steps[k] = (256 * corners[k].array() - 128).round().cast<long>();
  const auto across = [](const Eigen::Vector2<long>& a, const Eigen::Vector2<long>& b) {
    return a.x() * b.y() - a.y() * b.x();
  };
  const long area = across(steps[1] - steps[0], steps[2] - steps[0]);
  if (area == 0) return false;
  if (area < 0) std::swap(steps[1], steps[2]);
  const Eigen::Vector2<long> sample(256 * column, 256 * row);
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector2<long> along = steps[(k + 1) % 3] - steps[k];
    const long side = across(along, sample - steps[k]);
    // Anticlockwise: left sides go down, lower sides to the right.
    const bool isOwn = along.y() < 0 || (along.y() == 0 && along.x() > 0);
    if (side < 0 || (side == 0 && !isOwn)) return false;
  }
  return true;
}

TEST(SpanRaster, CoversTheSamplesWithinATriangle) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-20, 60);
  picture::SpanRaster raster;
  for (int trial = 0; trial < 300; ++trial) {
    Corners corners;
    for (Eigen::Vector2d& corner : corners) {
      corner = {place(random), place(random)};
      // Many sides through samples, level and upright ones too.
      if (trial % 2 == 0) corner = corner.array().round() + 0.5;
    }
    raster.clear(kRows, kStripRows);
    raster.add(corners, {1, 2, 3, 255});
    const Samples samples = samplesOf(raster);
    for (int row = 0; row < kRows; ++row) {
      for (int column = 0; column < kColumns; ++column) {
        EXPECT_EQ(samples[kColumns * row + column] != kBackground, covers(corners, column, row))
            << trial << " " << column << " " << row;
      }
    }
  }
}

TEST(SpanRaster, LaterTrianglesHideEarlierOnes) {
  picture::SpanRaster raster;
  raster.clear(kRows, kStripRows);
  const Corners corners = {Eigen::Vector2d(0, 0), {40, 0}, {0, 36}};
  raster.add(corners, {1, 1, 1, 255});
  raster.add(corners, {2, 2, 2, 255});
  EXPECT_EQ(samplesOf(raster)[0][0], 2);
  raster.clear(kRows, kStripRows);
  EXPECT_EQ(samplesOf(raster)[0], kBackground);
}

}  // namespace
}  // namespace kirireel
