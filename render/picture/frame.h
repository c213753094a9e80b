/// A rendered image in memory. Needs no graphics library.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
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

/// Width and height of a picture, pixels, each 1 to kMaxFrameSide.
struct FrameSize {
  int width = 1280;  ///< pixels, from 1
  int height = 720;  ///< pixels, from 1

  /// Width over height.
  double aspect() const { return static_cast<double>(width) / height; }
  bool operator==(const FrameSize&) const = default;
};

/// The size itself. Throws InputError when a side is outside 1 to kMaxFrameSide.
FrameSize requireValidSize(FrameSize size);

/// One picture: RGBA, 4 bytes a pixel, rows from the top, pixels from the left, straight alpha.
struct Frame {
  FrameSize size;                    ///< of the picture, pixels
  std::vector<std::uint8_t> pixels;  ///< size.width * size.height * 4 bytes

  /// x from 0 at the left, y from 0 at the top; both must be within the picture.
  Colour at(int x, int y) const;
  /// The same holds for x and y.
  void set(int x, int y, Colour colour);

  /// Index in pixels of the first byte of a row.
  std::size_t rowStart(int y) const { return static_cast<std::size_t>(y) * size.width * 4; }
};

/// A picture of one colour. storage: a frame that is needed no more, whose memory it gets. Throws
/// InputError for a size out of range. Memory is 4 bytes a pixel.
Frame makeFrame(FrameSize size, Colour colour, Frame storage = {});

/// Copies source onto target with its top left corner at (x, y); it must fit inside.
void pasteFrame(Frame& target, const Frame& source, int x, int y);

/// True when every pixel has alpha 255. Looks at all pixels.
bool isOpaque(const Frame& frame);

}  // namespace kirireel::picture
