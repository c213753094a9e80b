// A pixel has 16 rows of 4 samples, one bit each. The samples of a row are shifted, so those of a
// pixel are in 64 different columns:
//
//     x = (k + (place of the row + 1/2) / 16) / 4,    y = (row + 1/2) / 16.
//
// The places were found by a search over permutations for the smallest error of an infinite line:
// its width is that of the polygon to 1/16 pixel in every direction (1/8 with places in a lattice).
//
// A bit is set at most once, so polygons of one shape may overlap. Strips of a few rows of pixels
// are drawn one after the other, since their bits fit into the processor's cache.
#include "render/picture/shape_raster.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <limits>
#include <utility>

#include "sim/base/interruption.h"

namespace kirireel::picture {
namespace {

constexpr int kDown = 16;  // rows of samples per pixel
constexpr int kAcross = 4;
constexpr std::uint64_t kWholeRow = 0xf;

/// Rows of pixels in a strip.
constexpr int kStripRows = 8;

/// x of the first sample of a row, in samples.
constexpr std::array<double, kDown> kShifts = [] {
  constexpr std::array<int, kDown> kPlaces = {7, 14, 5, 0, 8, 3, 11, 2, 12, 4, 10, 15, 9, 1, 13, 6};
  std::array<double, kDown> shifts{};
  for (int row = 0; row < kDown; ++row) shifts[row] = (kPlaces[row] + 0.5) / kDown;
  return shifts;
}();

/// The smallest integer >= value, in [0, high].
int ceilWithin(double value, int high) {
  if (!(value > 0)) return 0;
  if (value >= high) return high;
  const int floor = static_cast<int>(value);
  return floor + (floor < value ? 1 : 0);
}

/// Mixes a pixel with the colour of `count` covered samples. Opaque pixels need no division by
/// alpha.
void mix(std::uint8_t* pixel, Colour colour, int count) {
  constexpr int kWhole = kDown * kAcross * 255;
  const int cover = count * colour.alpha;
  if (pixel[3] < 255) {
    const Colour mean =
        blended({pixel[0], pixel[1], pixel[2], pixel[3]}, colour, count / double(kDown * kAcross));
    std::ranges::copy(std::array{mean.red, mean.green, mean.blue, mean.alpha}, pixel);
    return;
  }
  const std::array<int, 3> over = {colour.red, colour.green, colour.blue};
  for (int k = 0; k < 3; ++k) {
    const int sum = (kWhole - cover) * pixel[k] + cover * over[k];
    pixel[k] = static_cast<std::uint8_t>((sum + kWhole / 2) / kWhole);
  }
}

}  // namespace

void ShapeRaster::clear(FrameSize size) {
  size_ = size;
  shapes_.clear();
  corners_.clear();
  polygons_.clear();
  strips_.resize((size.height + kStripRows - 1) / kStripRows);
  for (std::vector<std::size_t>& strip : strips_) strip.clear();
  masks_.resize(static_cast<std::size_t>(size.width) * kStripRows);
  touched_.resize(kStripRows);
}

void ShapeRaster::begin(Colour colour) {
  if (!shapes_.empty() && shapes_.back() == colour && colour.alpha == 255) return;
  shapes_.push_back(colour);
}

void ShapeRaster::add(std::span<const Eigen::Vector2d> corners) {
  const auto [highest, lowest] =
      std::ranges::minmax(corners, {}, [](const Eigen::Vector2d& corner) { return corner.y(); });
  const int first = ceilWithin(highest.y() - 1, size_.height);
  const int end = ceilWithin(lowest.y() + 1, size_.height);
  if (first >= end) return;
  for (int strip = first / kStripRows; strip <= (end - 1) / kStripRows; ++strip) {
    strips_[strip].push_back(polygons_.size());
  }
  const std::size_t begin = corners_.size();
  corners_.insert(corners_.end(), corners.begin(), corners.end());
  polygons_.push_back({begin, corners_.size(), shapes_.size() - 1, highest.y(), lowest.y()});
}

void ShapeRaster::draw(Frame& frame) {
  assert(frame.size == size_);
  for (std::size_t strip = 0; strip < strips_.size(); ++strip) {
    checkInterruption();
    const int upper = static_cast<int>(strip) * kStripRows;
    const std::vector<std::size_t>& indices = strips_[strip];
    for (std::size_t k = 0; k < indices.size(); ++k) {
      const Polygon& polygon = polygons_[indices[k]];
      cover(polygon, upper);
      const bool isLast =
          k + 1 == indices.size() || polygons_[indices[k + 1]].shape != polygon.shape;
      if (isLast) blend(shapes_[polygon.shape], upper, frame);
    }
  }
}

/// Sets the bits of the rows of a strip. Each row of samples meets two sides of the polygon.
void ShapeRaster::cover(const Polygon& polygon, int upper) {
  constexpr int kRows = kStripRows * kDown;
  constexpr double kFar = std::numeric_limits<double>::infinity();
  std::array<double, kRows> left, right;  // samples
  const int rows = std::min(kStripRows, size_.height - upper) * kDown;
  const auto rowAt = [&](double y) { return ceilWithin((y - upper) * kDown - 0.5, rows); };
  const int begin = rowAt(polygon.highest), end = rowAt(polygon.lowest);
  for (int row = begin; row < end; ++row) {
    left[row] = kFar;
    right[row] = -kFar;
  }
  for (std::size_t k = polygon.first; k < polygon.end; ++k) {
    const Eigen::Vector2d* from = &corners_[k];
    const Eigen::Vector2d* to = &corners_[k + 1 < polygon.end ? k + 1 : polygon.first];
    if (from->y() > to->y()) std::swap(from, to);
    if (to->y() <= upper || from->y() >= upper + kStripRows) continue;
    const int first = rowAt(from->y()), last = rowAt(to->y());
    if (first >= last) continue;
    const double slope = kAcross * (to->x() - from->x()) / (to->y() - from->y()) / kDown;
    const double start = kAcross * from->x() - slope * ((from->y() - upper) * kDown - 0.5);
    for (int row = first; row < last; ++row) {
      const double x = start + slope * row;
      left[row] = std::min(left[row], x);
      right[row] = std::max(right[row], x);
    }
  }
  std::array<int, kRows> firsts, ends;
  const double columns = size_.width * kAcross;
  for (int row = begin; row < end; ++row) {
    // The number of samples to the left, including one at the same place.
    const double shift = 1 - kShifts[row % kDown];
    firsts[row] = static_cast<int>(std::clamp(left[row] + shift, 0.0, columns));
    ends[row] = static_cast<int>(std::clamp(right[row] + shift, 0.0, columns));
  }
  for (int row = begin; row < end; row = (row / kDown + 1) * kDown) {
    const int next = std::min(end, (row / kDown + 1) * kDown);
    coverPixels(row / kDown, row % kDown, {firsts.data() + row, firsts.data() + next},
                ends.data() + row);
  }
}

/// Sets the bits of a row of pixels, from one of its rows of samples on.
void ShapeRaster::coverPixels(int row, int line, std::span<const int> firsts, const int* ends) {
  std::uint64_t* const masks = masks_.data() + static_cast<std::size_t>(row) * size_.width;
  Touched touched = touched_[row];
  if (touched.end == 0) touched.first = size_.width;
  for (std::size_t k = 0; k < firsts.size(); ++k) {
    if (firsts[k] >= ends[k]) continue;
    const unsigned from = firsts[k], to = ends[k] - 1;
    const int first = static_cast<int>(from / kAcross), last = static_cast<int>(to / kAcross);
    const int shift = kAcross * (line + static_cast<int>(k));
    const std::uint64_t head = (kWholeRow << from % kAcross & kWholeRow) << shift;
    const std::uint64_t tail = kWholeRow >> (kAcross - 1 - to % kAcross) << shift;
    touched.first = std::min(touched.first, first);
    touched.end = std::max(touched.end, last + 1);
    if (first == last) {
      masks[first] |= head & tail;
      continue;
    }
    masks[first] |= head;
    for (int x = first + 1; x < last; ++x) masks[x] |= kWholeRow << shift;
    masks[last] |= tail;
  }
  touched_[row] = touched;
}

/// Mixes the pixels of a strip with the colour and clears the bits.
void ShapeRaster::blend(Colour colour, int upper, Frame& frame) {
  for (int row = 0; row < kStripRows; ++row) {
    const auto [first, end] = std::exchange(touched_[row], {});
    std::uint64_t* const masks = masks_.data() + static_cast<std::size_t>(row) * size_.width;
    for (int x = first; x < end; ++x) {
      const std::uint64_t mask = std::exchange(masks[x], 0);
      if (mask == 0) continue;
      mix(frame.pixels.data() + frame.rowStart(upper + row) + std::size_t{4} * x, colour,
          std::popcount(mask));
    }
  }
}

}  // namespace kirireel::picture
