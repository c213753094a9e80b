/// Reads PNG files, for tests.
#pragma once

#include <filesystem>
#include <stdexcept>

#include <png.h>

#include "render/picture/frame.h"

namespace kirireel::test {

/// Any PNG as 8-bit RGBA, rows from the top. Throws std::runtime_error if it cannot be read.
inline picture::Frame readPng(const std::filesystem::path& path) {
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  picture::Frame frame;
  // The simplified interface of libpng converts any PNG to the requested format.
  bool isRead = png_image_begin_read_from_file(&image, path.c_str()) != 0;
  if (isRead) {
    image.format = PNG_FORMAT_RGBA;
    frame.size = {static_cast<int>(image.width), static_cast<int>(image.height)};
    frame.pixels.resize(PNG_IMAGE_SIZE(image));
    isRead = png_image_finish_read(&image, nullptr, frame.pixels.data(), 0, nullptr) != 0;
  }
  png_image_free(&image);
  if (!isRead) throw std::runtime_error(path.string() + ": " + image.message);
  return frame;
}

}  // namespace kirireel::test
