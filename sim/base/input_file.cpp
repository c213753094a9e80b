// Files that are read, each noted with its hash. A file that is read whole is hashed from the text
// that was read, so that the hash belongs to just these bytes; one that is read piece by piece is
// hashed first and read again.
//
// Records of one thread form a chain through `outer_`, the innermost first. The pointer to it is
// thread-local, so that runs on several threads do not note each other's files.
#include "sim/base/input_file.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/base/sha256.h"

namespace kirireel {
namespace {

thread_local InputRecord* innermost = nullptr;

std::string digestOf(std::istream& stream) {
  Sha256 hash;
  std::array<char, 1 << 16> bytes{};
  // The last read fails for lack of bytes, but has some.
  while (stream.read(bytes.data(), bytes.size()), stream.gcount() > 0) {
    hash.add({bytes.data(), static_cast<std::size_t>(stream.gcount())});
  }
  return hash.finish();
}

void requireReadable(const std::filesystem::path& file, const std::string& purpose,
                     std::uintmax_t mostBytes) {
  std::error_code ignored;
  const auto status = std::filesystem::status(file, ignored);
  if (!std::filesystem::exists(status)) {
    throw inputErrorAt({file}, fmt::format("there is no such file; {}", purpose));
  }
  // A device or a pipe has no size and may never end.
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

InputRecord::InputRecord(std::vector<InputFile>& files) : files_(files), outer_(innermost) {
  innermost = this;
}

InputRecord::~InputRecord() {
  innermost = outer_;
}

void noteInput(const InputFile& file) {
  for (InputRecord* record = innermost; record; record = record->outer_) {
    record->files_.push_back(file);
  }
}

std::ifstream openInputFile(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  // Where nobody asks, nothing is hashed.
  if (innermost && stream) {
    noteInput({path, digestOf(stream)});
    stream.clear();
    stream.seekg(0);
  }
  return stream;
}

std::string readTextFile(const std::filesystem::path& file, const std::string& purpose,
                         std::uintmax_t mostBytes) {
  requireReadable(file, purpose, mostBytes);
  std::ifstream stream(file, std::ios::binary);
  std::string text(std::filesystem::file_size(file), '\0');
  if (!stream.read(text.data(), static_cast<std::streamsize>(text.size()))) {
    throw inputErrorAt({file}, fmt::format("the file cannot be read ({}); check its permissions",
                                           std::strerror(errno)));
  }
  if (innermost) noteInput({file, sha256(text)});
  return text;
}

}  // namespace kirireel
