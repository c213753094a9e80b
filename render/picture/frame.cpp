// Frames are plain arrays of bytes. Nothing here knows of graphics libraries, so encoders, grids
// and readers of PNG share one type. A frame of 1280 x 720 takes 3.7 MB.
#include "render/picture/frame.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "sim/base/error.h"

namespace kirireel::picture {

FrameSize requireValidSize(FrameSize size) {
  const auto valid = [](int side) { return side >= 1 && side <= kMaxFrameSide; };
  if (valid(size.width) && valid(size.height)) return size;
  throw InputError(fmt::format(
      "error: a picture of {} x {} pixels cannot be drawn; width and height may be 1 to {}, "
      "for example --size 1280x720",
      size.width, size.height, kMaxFrameSide));
}

Colour Frame::at(int x, int y) const {
  const std::uint8_t* pixel = pixels.data() + rowStart(y) + static_cast<std::size_t>(x) * 4;
  return {pixel[0], pixel[1], pixel[2], pixel[3]};
}

void Frame::set(int x, int y, Colour colour) {
  std::uint8_t* pixel = pixels.data() + rowStart(y) + static_cast<std::size_t>(x) * 4;
  pixel[0] = colour.red;
  pixel[1] = colour.green;
  pixel[2] = colour.blue;
  pixel[3] = colour.alpha;
}

Frame makeFrame(FrameSize size, Colour colour, Frame storage) {
  requireValidSize(size);
  Frame frame{size, std::move(storage.pixels)};
  frame.pixels.resize(frame.rowStart(size.height));
  for (int x = 0; x < size.width; ++x) frame.set(x, 0, colour);
  const std::size_t rowBytes = frame.rowStart(1);
  for (int y = 1; y < size.height; ++y) {
    std::copy_n(frame.pixels.data(), rowBytes, frame.pixels.data() + frame.rowStart(y));
  }
  return frame;
}

void pasteFrame(Frame& target, const Frame& source, int x, int y) {
  assert(x >= 0 && x + source.size.width <= target.size.width);
  assert(y >= 0 && y + source.size.height <= target.size.height);
  const std::size_t rowBytes = static_cast<std::size_t>(source.size.width) * 4;
  for (int row = 0; row < source.size.height; ++row) {
    std::copy_n(source.pixels.data() + source.rowStart(row), rowBytes,
                target.pixels.data() + target.rowStart(y + row) + static_cast<std::size_t>(x) * 4);
  }
}

// Straight alpha: with the alphas a (over, times its cover) and b (under),
//     alpha = a + b (1 - a),   colour = (a over + b (1 - a) under) / alpha.
Colour blended(Colour under, Colour over, double cover) {
  const double a = cover * over.alpha / 255, b = under.alpha / 255.0 * (1 - a);
  const auto channel = [&](std::uint8_t below, std::uint8_t above) {
    return a + b > 0 ? static_cast<std::uint8_t>(std::lround((b * below + a * above) / (a + b)))
                     : below;
  };
  return {channel(under.red, over.red), channel(under.green, over.green),
          channel(under.blue, over.blue), static_cast<std::uint8_t>(std::lround(255 * (a + b)))};
}

void blendFrame(Frame& target, const Frame& source, int x, int y) {
  assert(x >= 0 && x + source.size.width <= target.size.width);
  assert(y >= 0 && y + source.size.height <= target.size.height);
  for (int row = 0; row < source.size.height; ++row) {
    for (int column = 0; column < source.size.width; ++column) {
      const Colour over = source.at(column, row);
      if (over.alpha == 0) continue;
      target.set(x + column, y + row, blended(target.at(x + column, y + row), over));
    }
  }
}

/// A pixel is covered in proportion to its distance from the border, within a pixel.
void blendDisc(Frame& target, double x, double y, double radius, Colour colour) {
  const auto range = [radius](double middle, int side) {
    return std::pair(std::clamp(static_cast<int>(std::floor(middle - radius - 1)), 0, side),
                     std::clamp(static_cast<int>(std::ceil(middle + radius + 1)), 0, side));
  };
  const auto [left, right] = range(x, target.size.width);
  const auto [upper, lower] = range(y, target.size.height);
  for (int row = upper; row < lower; ++row) {
    for (int column = left; column < right; ++column) {
      const double distance = std::hypot(column + 0.5 - x, row + 0.5 - y);
      const double cover = std::clamp(radius + 0.5 - distance, 0.0, 1.0);
      if (cover > 0) target.set(column, row, blended(target.at(column, row), colour, cover));
    }
  }
}

bool isOpaque(const Frame& frame) {
  for (std::size_t alpha = 3; alpha < frame.pixels.size(); alpha += 4) {
    if (frame.pixels[alpha] != 255) return false;
  }
  return true;
}

}  // namespace kirireel::picture
