/// Draws lines and other flat shapes over a finished picture.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "render/picture/frame.h"
#include "sim/base/geometry.h"

namespace kirireel::picture {

/// Convex polygons over a picture. Each pixel is mixed with the colour by the fraction of it that a
/// shape covers: 64 samples in 16 rows and 64 columns, so a line is equally wide in all directions
/// to 1/16 pixel, and a thin line is pale instead of dashed.
class ShapeRaster {
 public:
  /// Removes all shapes.
  void clear(FrameSize size);

  /// The next polygons are one shape: a pixel under two of them is mixed once. Opaque shapes of one
  /// colour in succession are one shape.
  void begin(Colour colour);

  /// Adds a convex polygon to the shape. corners: in order, pixels from the upper left corner of
  /// the picture; parts outside are clipped.
  void add(std::span<const Eigen::Vector2d> corners);

  /// Draws the shapes in their order. The frame has the size of the picture. Throws Interrupted if
  /// the user ends the program.
  void draw(Frame& frame);

 private:
  struct Polygon {
    std::size_t first = 0, end = 0;  ///< in corners_
    std::size_t shape = 0;           ///< in shapes_
    double highest = 0, lowest = 0;  ///< y, pixels
  };
  /// Pixels of a row that the present shape touches.
  struct Touched {
    int first = 0, end = 0;
  };

  void cover(const Polygon& polygon, int upper);
  void coverPixels(int row, int line, std::span<const int> firsts, const int* ends);
  void blend(Colour colour, int upper, Frame& frame);

  FrameSize size_;
  std::vector<Colour> shapes_;
  std::vector<Eigen::Vector2d> corners_;
  std::vector<Polygon> polygons_;
  std::vector<std::vector<std::size_t>> strips_;  ///< polygons by strip, in painting order
  std::vector<std::uint64_t> masks_;              ///< covered samples of a strip's pixels
  std::vector<Touched> touched_;                  ///< by row of a strip
};

}  // namespace kirireel::picture
