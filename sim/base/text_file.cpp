#include "sim/base/text_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include <fmt/format.h>

#include "sim/base/error.h"

namespace kirireel {
namespace {

void requireReadable(const std::filesystem::path& file, const std::string& purpose,
                     std::uintmax_t mostBytes) {
  std::error_code ignored;
  const auto status = std::filesystem::status(file, ignored);
  if (!std::filesystem::exists(status)) {
    throw inputErrorAt({file}, fmt::format("there is no such file; {}", purpose));
  }
  if (!std::filesystem::is_regular_file(status)) {
    throw inputErrorAt({file}, fmt::format("this is not a text file; {}", purpose));
  }
  const std::uintmax_t size = std::filesystem::file_size(file, ignored);
  if (size > mostBytes) {
    throw inputErrorAt({file}, fmt::format("the file has {} bytes, at most {} are read; {}", size,
                                           mostBytes, purpose));
  }
}

}  // namespace

std::string readTextFile(const std::filesystem::path& file, const std::string& purpose,
                         std::uintmax_t mostBytes) {
  requireReadable(file, purpose, mostBytes);
  std::ifstream stream(file, std::ios::binary);
  std::string text(std::filesystem::file_size(file), '\0');
  if (stream.read(text.data(), static_cast<std::streamsize>(text.size()))) return text;
  throw inputErrorAt({file}, fmt::format("the file cannot be read ({}); check its permissions",
                                         std::strerror(errno)));
}

}  // namespace kirireel
