/// A rendered image in memory. Needs no graphics library.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace kirireel::picture {

/// A colour of a picture: sRGB bytes, straight (not premultiplied) alpha.
struct Colour {
  std::uint8_t red = 0;      ///< sRGB
  std::uint8_t green = 0;    ///< sRGB
  std::uint8_t blue = 0;     ///< sRGB
  std::uint8_t alpha = 255;  ///< 0 transparent, 255 opaque

  bool operator==(const Colour&) const = default;
};

/// Largest width and height of a picture, pixels: the texture limit of the software renderer.
inline constexpr int kMaxFrameSide = 16384;

/// Width and height of a picture, pixels, each in [1, kMaxFrameSide].
struct FrameSize {
  int width = 1280;  ///< pixels, >= 1
  int height = 720;  ///< pixels, >= 1

  /// Width over height.
  double aspect() const { return static_cast<double>(width) / height; }
  bool operator==(const FrameSize&) const = default;
};

/// The whole number of pixels nearest to a length in pixels, halves away from zero.
inline int wholePixels(double length) {
  return static_cast<int>(std::lround(length));
}

/// Returns the size. Throws InputError if a side is not in [1, kMaxFrameSide].
FrameSize requireValidSize(FrameSize size);

/// One picture: RGBA, 4 bytes per pixel, rows from the top, pixels from the left, straight alpha.
struct Frame {
  FrameSize size;                    ///< of the picture, pixels
  std::vector<std::uint8_t> pixels;  ///< size.width * size.height * 4 bytes

  /// x counts from the left, y from the top; both must be inside the picture.
  Colour at(int x, int y) const;
  /// The same conditions apply.
  void set(int x, int y, Colour colour);

  /// Index in pixels of the first byte of a row.
  std::size_t rowStart(int y) const { return static_cast<std::size_t>(y) * size.width * 4; }
};

/// A picture of one colour. storage: a frame that is no longer needed, whose memory is reused.
/// Throws InputError for a size out of range. Memory is 4 bytes per pixel.
Frame makeFrame(FrameSize size, Colour colour, Frame storage = {});

/// Copies source into target with its top left corner at (x, y). It must fit.
void pasteFrame(Frame& target, const Frame& source, int x, int y);

/// The colour of a pixel under another one: `cover` in [0, 1] is the covered share of the pixel.
Colour blended(Colour under, Colour over, double cover = 1);

/// Blends source over target with its top left corner at (x, y). It must fit.
void blendFrame(Frame& target, const Frame& source, int x, int y);

/// Blends a disc over a picture. Lengths are pixels from the upper left. Parts outside are clipped.
void blendDisc(Frame& target, double x, double y, double radius, Colour colour);

/// Whether every pixel has alpha 255. Checks all pixels.
bool isOpaque(const Frame& frame);

}  // namespace kirireel::picture
