/// A picture in the graphics context to draw into.
#pragma once

#include <cstdint>

#include <Eigen/Geometry>

namespace kirireel {

/// A framebuffer object with an RGBA8 texture. Belongs to the context current
/// when made.
class Framebuffer {
 public:
  /// Whether hidden surfaces are to be removed when drawing into it.
  enum class Depth { None, Tested };

  /// Throws OutputError when the driver refuses the size or lacks the memory.
  Framebuffer(int width, int height, Depth depth);
  ~Framebuffer();
  Framebuffer(const Framebuffer&) = delete;
  Framebuffer& operator=(const Framebuffer&) = delete;

  /// Draws go to the lower left width x height pixels of this framebuffer from now on.
  void drawInto(int width, int height) const;

  /// Makes its colours texture 0 of the program in use.
  void bindTexture() const;

  /// Copies a box of pixels out as RGBA, rows in OpenGL's order (row 0 is where y is 0). The box's
  /// right and last row are not in it. rowPixels: pixels from one row's start to the next in the
  /// destination. Waits for all drawing to end. Throws OutputError when the driver ran out of
  /// memory on the way.
  void read(const Eigen::AlignedBox2i& box, int rowPixels, std::uint8_t* pixels) const;

 private:
  unsigned int framebuffer_ = 0;
  unsigned int texture_ = 0;
  unsigned int depth_ = 0;
};

}  // namespace kirireel
