// Scan conversion: a row of samples at y is inside a triangle between its longest side and one of
// the two others. A strip of rows fits into the processor's cache, so filling costs less than in a
// framebuffer of the whole picture.
#include "render/picture/span_raster.h"

#include <algorithm>
#include <cmath>

namespace kirireel::picture {
namespace {

/// Steps of a corner in a sample, as in Mesa's llvmpipe.
constexpr double kSteps = 256;

/// The smallest whole number >= value, at least low and at most high.
int ceilWithin(double value, int low, int high) {
  return static_cast<int>(std::clamp(std::ceil(value), double(low), double(high)));
}

}  // namespace

void SpanRaster::clear(int rows, int stripRows) {
  rows_ = rows;
  stripRows_ = stripRows;
  triangles_.clear();
  strips_.resize((rows + stripRows - 1) / stripRows);
  for (std::vector<int>& strip : strips_) strip.clear();
}

SpanRaster::TriangleSide SpanRaster::sideOf(const Eigen::Vector2d& from,
                                            const Eigen::Vector2d& to) {
  const Eigen::Vector2d along = to - from;
  return {from.x(), from.y(), along.y() > 0 ? along.x() / along.y() : 0};
}

void SpanRaster::add(const std::array<Eigen::Vector2d, 3>& corners, Sample colour) {
  std::array<Eigen::Vector2d, 3> sorted;
  for (int k = 0; k < 3; ++k) {
    // Samples are at whole numbers from here on.
    sorted[k] = ((corners[k].array() - 0.5) * kSteps).round() / kSteps;
  }
  std::ranges::sort(sorted, {}, [](const Eigen::Vector2d& corner) { return corner.y(); });
  const auto& [low, middle, high] = sorted;
  const int first = ceilWithin(low.y(), 0, rows_), end = ceilWithin(high.y(), 0, rows_);
  if (first >= end) return;
  for (int strip = stripOf(end - 1); strip <= stripOf(first); ++strip) {
    strips_[strip].push_back(static_cast<int>(triangles_.size()));
  }
  triangles_.push_back({first, end, middle.y(), sideOf(low, high), sideOf(low, middle),
                        sideOf(middle, high), colour});
}

void SpanRaster::read(const Eigen::AlignedBox2i& box, Sample background,
                      std::vector<Sample>& samples) const {
  const int columns = box.sizes().x();
  samples.assign(static_cast<std::size_t>(columns) * box.sizes().y(), background);
  for (const int index : strips_[stripOf(box.min().y())]) {
    const Triangle& triangle = triangles_[index];
    const int first = std::max(triangle.firstRow, box.min().y());
    const int end = std::min(triangle.endRow, box.max().y());
    for (int row = first; row < end; ++row) {
      const double a = triangle.longest.at(row);
      const double b = (row < triangle.middle ? triangle.lower : triangle.upper).at(row);
      const int left = ceilWithin(std::min(a, b), box.min().x(), box.max().x());
      const int right = ceilWithin(std::max(a, b), box.min().x(), box.max().x());
      Sample* const start =
          samples.data() + static_cast<std::size_t>(row - box.min().y()) * columns - box.min().x();
      std::fill(start + left, start + right, triangle.colour);
    }
  }
}

}  // namespace kirireel::picture
