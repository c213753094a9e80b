/// A picture in the graphics context to draw into.
#pragma once

#include <cstdint>

#include <Eigen/Geometry>

namespace kirireel {

/// A framebuffer object with RGBA8 colours and depth. Belongs to the context current when made.
class Framebuffer {
 public:
  /// Throws OutputError when the driver refuses the size or lacks the memory. Both sides in pixels,
  /// at least 1.
  Framebuffer(int width, int height);
  ~Framebuffer();
  Framebuffer(const Framebuffer&) = delete;
  Framebuffer& operator=(const Framebuffer&) = delete;

  /// Width and height, pixels.
  const Eigen::Vector2i& sides() const { return sides_; }

  /// Draws go to this framebuffer from now on.
  void drawInto() const;

  /// Copies a box of pixels out as RGBA, rows in OpenGL's order (row 0 is where y is 0). The box's
  /// right and last row are not in it. rowPixels: pixels from one row's start to the next in the
  /// destination. Waits for all drawing to end. Throws OutputError when the driver ran out of
  /// memory on the way. `pixels` has room for rowPixels x height of the box x 4 bytes, less what
  /// follows the last row.
  void read(const Eigen::AlignedBox2i& box, int rowPixels, std::uint8_t* pixels) const;

 private:
  Eigen::Vector2i sides_;
  unsigned int framebuffer_ = 0;
  unsigned int colour_ = 0;
  unsigned int depth_ = 0;
};

}  // namespace kirireel
