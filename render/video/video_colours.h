/// Pictures as video encoders take them: brightness and two differences of colours.
#pragma once

#include <cstddef>
#include <cstdint>

#include "render/picture/frame.h"

namespace kirireel {

/// Where a plane of a picture goes.
struct VideoPlane {
  std::uint8_t* rows = nullptr;  ///< the first row
  std::ptrdiff_t stride = 0;     ///< bytes from one row's start to the next
};

/// All of a picture. The second and the third have half as many rows and columns as the first.
struct VideoPlanes {
  VideoPlane brightness;  ///< Y': 16 (black) to 235 (white)
  VideoPlane blueness;    ///< Cb: 16 to 240, 128 for grey
  VideoPlane redness;     ///< Cr, likewise
};

/// Copies a row of RGBA pixels as it looks on white. c' = c a / 255 + 255 (1 - a / 255), rounded;
/// alpha becomes 255. `copy` has room for 4 width bytes.
void copyOverWhite(const std::uint8_t* row, int width, std::uint8_t* copy);

/// Converts a frame of even width and height from sRGB to BT.709, limited range, 4:2:0, the
/// coloured samples in line with the left pixels. What is transparent shows white. Each byte is the
/// nearest to the exact value, but for the rounding of floats. The planes must be large enough. One
/// pass over the frame.
void toVideoColours(const Frame& frame, const VideoPlanes& planes);

}  // namespace kirireel
