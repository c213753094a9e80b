/// PNG files.
///
/// Pictures have eight bits per channel, so no other depth is written.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "render/picture/frame.h"

namespace kirireel::picture {

/// Settings of a PNG. No row filters: without them flat-shaded pictures are smallest and fastest.
struct PngSettings {
  int compressionLevel = 6;           ///< of zlib, 0 (none) to 9
  std::optional<double> dotsPerInch;  ///< printed resolution stored in the file, > 0
  std::string description;            ///< author and source stored in the file, UTF-8; may be empty
};

/// Writes a picture as RGB if it is opaque, else as RGBA, marked as sRGB. The file appears under
/// its name when it is complete. Throws OutputError with the path and the reason (disk full, no
/// permission). The frame has at least one pixel. Level 6 takes about twice as long as level 3.
void writePng(const Frame& frame, const std::filesystem::path& path,
              const PngSettings& settings = {});

/// The same as bytes in memory. Throws OutputError if memory is short.
std::string pngBytes(const Frame& frame, const PngSettings& settings = {});

/// The version of libpng in use, e.g. "1.6.39".
std::string pngLibraryVersion();

}  // namespace kirireel::picture
