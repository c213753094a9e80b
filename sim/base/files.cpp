// Input files and their hashes. For a file that is read completely, the hash is computed from the
// text: it belongs to exactly these bytes. A file that is read piecewise is hashed first and then
// read again.
//
// Records of one thread form a chain through `outer_`, the innermost first. The pointer to it is
// thread-local: runs on several threads do not record each other's files.
#include "sim/base/files.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <new>
#include <stdexcept>
#include <system_error>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <openssl/evp.h>
#include <unistd.h>
#include <zlib.h>

#include "sim/base/error.h"
#include "sim/base/file_kinds.h"
#include "sim/base/interruption.h"

namespace kirireel {
namespace {

thread_local InputRecord* innermost = nullptr;

std::string digestOf(std::istream& stream) {
  Sha256 hash;
  std::array<char, 1 << 16> bytes{};
  // The last read fails at the end of the file, but returns some bytes.
  while (stream.read(bytes.data(), bytes.size()), stream.gcount() > 0) {
    hash.add({bytes.data(), static_cast<std::size_t>(stream.gcount())});
  }
  return hash.finish();
}

void requireReadable(const std::filesystem::path& file, const std::string& purpose,
                     std::uintmax_t maxBytes) {
  if (!isPresent(file)) {
    throw inputErrorAt({file}, fmt::format("{}; {}", whyAbsent(file, "file"), purpose));
  }
  // A device or a pipe has no size and may never end.
  if (!isFile(file)) {
    throw inputErrorAt({file}, fmt::format("this is not a text file; {}", purpose));
  }
  std::error_code ignored;
  const std::uintmax_t size = std::filesystem::file_size(file, ignored);
  if (size > maxBytes) {
    throw inputErrorAt({file}, fmt::format("the file has {} bytes, but at most {} are allowed; {}",
                                           size, maxBytes, purpose));
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

std::string endingOf(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  std::ranges::transform(ending, ending.begin(),
                         [](unsigned char letter) { return std::tolower(letter); });
  return ending;
}

std::ifstream openInputFile(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  // Without a record, nothing is hashed.
  if (innermost && stream) {
    noteInput({path, digestOf(stream)});
    stream.clear();
    stream.seekg(0);
  }
  return stream;
}

std::string readTextFile(const std::filesystem::path& file, const std::string& purpose,
                         std::uintmax_t maxBytes) {
  requireReadable(file, purpose, maxBytes);
  std::error_code gone;
  const std::uintmax_t size = std::filesystem::file_size(file, gone);
  std::string text(gone ? 0 : size, '\0');
  errno = gone.value();
  std::ifstream stream(file, std::ios::binary);
  if (gone || !stream.read(text.data(), static_cast<std::streamsize>(text.size()))) {
    throw inputErrorAt({file}, fmt::format("the file cannot be read ({}); check its permissions",
                                           std::strerror(errno)));
  }
  if (innermost) noteInput({file, sha256(text)});
  return text;
}

// ------------------------------------------------------------------------------------------------
// JSON texts by nlohmann's library.

Json parseJson(std::string_view text) {
  return Json::parse(text);
}

Json parseJson(std::string_view text, int maxNested) {
  return Json::parse(text, [&](int depth, Json::parse_event_t, const Json&) {
    if (depth > maxNested) throw std::length_error("nested too deeply");
    return true;
  });
}

Json parseJsonOrDiscard(std::string_view text) {
  return Json::parse(text, nullptr, false);
}

std::string jsonText(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

// ------------------------------------------------------------------------------------------------
// Files that appear whole or not at all. They are written in the final folder under another name
// and renamed, which replaces an existing file at once (POSIX rename is atomic within one file
// system). The other name must be unused, because an existing file may be the user's.

namespace {

/// "deployment.part.mp4", or "deployment.part2.mp4" and so on if a file of that name exists: it may
/// belong to the user.
std::filesystem::path pendingName(const std::filesystem::path& finalPath) {
  std::string number;
  for (int k = 2;; ++k) {
    std::filesystem::path name = finalPath.stem();
    name += ".part" + number;
    name += finalPath.extension();
    name = finalPath.parent_path() / name;
    std::error_code ignored;
    if (!std::filesystem::exists(std::filesystem::symlink_status(name, ignored))) return name;
    number = std::to_string(k);
  }
}

}  // namespace

void requireWritableFolder(const std::filesystem::path& folder) {
  if (::access(folder.c_str(), W_OK | X_OK) == 0) return;
  throw OutputError(
      fmt::format("{}: error: cannot write in this folder ({}). Choose another folder",
                  folder.string(), std::strerror(errno)));
}

PendingFile::PendingFile(std::filesystem::path finalPath)
    : finalPath_(std::move(finalPath)), path_(pendingName(finalPath_)) {
  requireWritableFolder(finalPath_.has_parent_path() ? finalPath_.parent_path() : ".");
}

PendingFile::~PendingFile() {
  if (committed_) return;
  std::error_code ignored;
  // A destructor must not throw. A file that cannot be removed is harmless.
  std::filesystem::remove(path_, ignored);
}

void PendingFile::commit() {
  moveFile(path_, finalPath_);
  committed_ = true;
}

void moveFile(const std::filesystem::path& from, const std::filesystem::path& to) {
  std::error_code error;
  std::filesystem::rename(from, to, error);
  if (!error) return;
  throw OutputError(
      fmt::format("{}: error: cannot be put in place ({})", to.string(), error.message()));
}

void makeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error && isFolder(folder)) return;
  const std::string reason = error ? error.message() : "a file with this name exists";
  throw OutputError(fmt::format("{}: error: the folder cannot be created ({}). Choose another",
                                folder.string(), reason));
}

void writeTextFile(const std::filesystem::path& finalPath, const std::string& text) {
  PendingFile pending(finalPath);
  std::ofstream stream(pending.path(), std::ios::binary);
  stream << text;
  // Closing writes pending data: a full disk is detected here at the latest.
  stream.close();
  if (!stream) {
    throw OutputError(
        fmt::format("{}: error: cannot be written ({}); free some space or choose another folder",
                    finalPath.string(), std::strerror(errno)));
  }
  pending.commit();
}

// ------------------------------------------------------------------------------------------------
// SHA-256 by OpenSSL, which uses the processor's SHA instructions if available. Only this file
// includes OpenSSL.

struct Sha256::State {
  EVP_MD_CTX* context = EVP_MD_CTX_new();
};

Sha256::Sha256() : state_(std::make_unique<State>()) {
  EVP_DigestInit_ex(state_->context, EVP_sha256(), nullptr);
}

Sha256::~Sha256() {
  EVP_MD_CTX_free(state_->context);
}

void Sha256::add(std::span<const char> bytes) {
  checkInterruption();
  EVP_DigestUpdate(state_->context, bytes.data(), bytes.size());
}

std::string Sha256::finish() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> bytes{};
  unsigned int count = 0;
  EVP_DigestFinal_ex(state_->context, bytes.data(), &count);
  std::string digits;
  for (unsigned int k = 0; k < count; ++k) digits += fmt::format("{:02x}", bytes[k]);
  return digits;
}

std::string sha256(std::string_view text) {
  Sha256 hash;
  hash.add(text);
  return hash.finish();
}

// ------------------------------------------------------------------------------------------------
// zlib's checksums and compression, and base64. Only this file includes zlib: another library could
// replace it.

std::uint32_t checksumOf(std::span<const std::byte> bytes) {
  return static_cast<std::uint32_t>(
      crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

std::string compressed(std::span<const std::byte> bytes, int level) {
  uLongf size = compressBound(bytes.size());
  std::string packed(size, '\0');
  // With room for the worst case and a valid level, only lack of memory can fail.
  if (compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
                reinterpret_cast<const Bytef*>(bytes.data()), bytes.size(), level) != Z_OK) {
    throw std::bad_alloc();
  }
  // The bound was an upper limit.
  packed.resize(size);
  return packed;
}

std::string base64(std::span<const std::byte> bytes) {
  constexpr const char* kLetters =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  // Three bytes are 24 bits, i.e. four characters of 6 bits. Missing bytes at the end are zeros and
  // marked by '='.
  for (std::size_t k = 0; k < bytes.size(); k += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - k);
    std::uint32_t group = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      group = group << 8 | (i < count ? std::to_integer<std::uint32_t>(bytes[k + i]) : 0);
    }
    for (std::size_t i = 0; i < 4; ++i) {
      text += i <= count ? kLetters[group >> (18 - 6 * i) & 63] : '=';
    }
  }
  return text;
}

}  // namespace kirireel
