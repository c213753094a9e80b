/// Fills triangles on the processor, for pictures in which depth hides nothing.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sim/base/geometry.h"

namespace kirireel::picture {

/// Opaque triangles over a background; each hides the earlier ones. Covers the same samples as
/// OpenGL: corners are rounded to 1/256 sample, and a sample on a side belongs to the triangle on
/// its right, or above it.
class SpanRaster {
 public:
  /// RGBA bytes of one sample.
  using Sample = std::array<std::uint8_t, 4>;

  /// Removes all triangles. rows: of samples in the picture; they are read in strips of stripRows,
  /// from the top.
  void clear(int rows, int stripRows);

  /// corners: in samples from the lower left corner of the picture.
  void add(const std::array<Eigen::Vector2d, 3>& corners, Sample colour);

  /// Writes the samples of a box, row by row from its lowest. The box is in one strip, and in
  /// samples from the lower left corner, excluding right and upper.
  void read(const Eigen::AlignedBox2i& box, Sample background, std::vector<Sample>& samples) const;

 private:
  /// x of a side as a function of y.
  struct TriangleSide {
    double x = 0, y = 0, slope = 0;
    double at(double row) const { return x + slope * (row - y); }
  };
  struct Triangle {
    int firstRow = 0, endRow = 0;
    double middle = 0;  ///< y of the middle corner
    TriangleSide longest, lower, upper;
    Sample colour;
  };

  static TriangleSide sideOf(const Eigen::Vector2d& from, const Eigen::Vector2d& to);
  int stripOf(int row) const { return (rows_ - 1 - row) / stripRows_; }

  int rows_ = 0;
  int stripRows_ = 1;
  std::vector<Triangle> triangles_;
  std::vector<std::vector<int>> strips_;  ///< triangles by strip, in painting order
};

}  // namespace kirireel::picture
