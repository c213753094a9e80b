/// PNG files.
///
/// Eight bits a channel; no other depth is written, because pictures have no more.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "render/picture/frame.h"

namespace kirireel::picture {

/// How a PNG is written. Flat-shaded pictures are smallest and quickest without row filters, so
/// there is no choice of filter.
struct PngSettings {
  int compressionLevel = 6;           ///< of zlib, 0 (none) to 9
  std::optional<double> dotsPerInch;  ///< printed resolution noted in the file, positive
  std::string description;            ///< who made it from what, UTF-8, noted too; may be empty
};

/// Writes a picture: RGB when it is opaque, else RGBA; tagged as sRGB. The file appears under its
/// name only when whole. Throws OutputError with the path and the reason (disk full, no
/// permission). The frame has at least one pixel. Time is zlib's: level 6 takes about twice as long
/// as level 3.
void writePng(const Frame& frame, const std::filesystem::path& path,
              const PngSettings& settings = {});

/// The same as bytes in memory. Throws OutputError when memory is short.
std::string pngBytes(const Frame& frame, const PngSettings& settings = {});

/// Reads any PNG as 8-bit RGBA. Throws InputError when it is missing or not a PNG. Palettes, grey
/// and 16 bits are converted. Rows from the top.
Frame readPng(const std::filesystem::path& path);

/// The version of libpng in use, e.g. "1.6.39".
std::string pngLibraryVersion();

}  // namespace kirireel::picture
