/// What captions and scales are drawn on: pixels, or a page of vector graphics.
#pragma once

#include <string>

#include "render/picture/frame.h"

namespace kirireel {

/// Lengths are pixels from the upper left corner. Text is set in the font of setFont().
class Surface {
 public:
  virtual ~Surface() = default;

  /// A filled rectangle.
  virtual void box(double left, double upper, double width, double height, Colour colour) = 0;

  /// One line of text in UTF-8 from its left end, its letters on `baseline`. em: its size.
  virtual void text(const std::string& line, double left, double baseline, int em,
                    Colour colour) = 0;
};

/// Draws on a picture, which must outlive it. What falls outside is left out.
class FrameSurface : public Surface {
 public:
  explicit FrameSurface(Frame& frame) : frame_(frame) {}

  void box(double left, double upper, double width, double height, Colour colour) override;
  /// Throws OutputError when the font is missing.
  void text(const std::string& line, double left, double baseline, int em, Colour colour) override;

 private:
  Frame& frame_;
};

}  // namespace kirireel
