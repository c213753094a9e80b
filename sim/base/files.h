/// Files: reading with a record of inputs, atomic writing, SHA-256, compression, and JSON texts. It
/// needs no header of OpenSSL or zlib.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json_fwd.hpp>

namespace kirireel {

// ------------------------------------------------------------------------------------------------
// All input files are opened here: a run knows all files that it was made from.

/// A file that was read.
struct InputFile {
  std::filesystem::path path;  ///< as opened
  std::string sha256;          ///< of all its bytes, 64 hexadecimal digits
};

/// Records every file that its thread opens for reading during its lifetime, in order. A file that
/// is opened again is recorded again. Nested records each record the file.
class InputRecord {
 public:
  /// `files` receives the entries and must outlive the record.
  explicit InputRecord(std::vector<InputFile>& files);
  ~InputRecord();
  InputRecord(const InputRecord&) = delete;
  InputRecord& operator=(const InputRecord&) = delete;

 private:
  friend void noteInput(const InputFile&);

  std::vector<InputFile>& files_;
  InputRecord* outer_;  // of the same thread; null for the first
};

/// A name's ending with its dot, in lower case: ".svg" of "SHEET.Svg"; "" if it has none.
std::string endingOf(const std::filesystem::path& file);

/// Opens a file for piecewise reading, and records it. The stream is in a failed state if the file
/// cannot be opened.
std::ifstream openInputFile(const std::filesystem::path& path);

/// Size limit of text files, bytes. It allows 250,000 tiles and bounds the memory that a file can
/// request.
inline constexpr std::uintmax_t kMaxTextBytes = 64u << 20;

/// All bytes of a text file. `purpose` ends the messages: what to give or to write. Throws
/// InputError if the file is missing, unreadable, not a regular file or larger than `maxBytes`.
/// Line ends are not changed.
std::string readTextFile(const std::filesystem::path& file, const std::string& purpose,
                         std::uintmax_t maxBytes = kMaxTextBytes);

/// Appends formatted text to the future text of a file.
template <typename... Arguments>
void appendText(std::string& text, fmt::format_string<Arguments...> format,
                Arguments&&... arguments) {
  fmt::format_to(std::back_inserter(text), format, std::forward<Arguments>(arguments)...);
}

// ------------------------------------------------------------------------------------------------
// JSON texts. Only this file includes the library, because it takes the compiler seconds.

/// Keys keep the order in which they were set: the same values give the same text.
using Json = nlohmann::ordered_json;

/// Parses a JSON text. Throws nlohmann::json::parse_error, with the position of the fault.
Json parseJson(std::string_view text);

/// The same for untrusted files. Throws std::length_error if values are nested deeper than
/// `maxNested`: the library compares and copies them recursively, and deep nesting would overflow
/// the stack.
Json parseJson(std::string_view text, int maxNested);

/// The same, but discarded (Json::is_discarded) if the syntax is wrong.
Json parseJsonOrDiscard(std::string_view text);

/// JSON as text: in one line, or one line per entry, indented by `indent` spaces. Names of files
/// and models may contain any bytes; those that are not UTF-8 become U+FFFD.
std::string jsonText(const Json& json, int indent = -1);

// ------------------------------------------------------------------------------------------------
// A file that gets its final name only when it is complete.

/// Write to path(), then call commit(). Without commit() the destructor removes the file: an
/// interrupted or failed write leaves nothing under the final name. A link under the final name is
/// replaced, never followed.
class PendingFile {
 public:
  /// Throws OutputError if the folder of finalPath does not exist or cannot be written.
  explicit PendingFile(std::filesystem::path finalPath);
  ~PendingFile();
  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;

  /// The temporary file: next to the final name, same extension, e.g. "deployment.part.mp4". No
  /// file of this name existed before.
  const std::filesystem::path& path() const { return path_; }
  /// The final name.
  const std::filesystem::path& finalPath() const { return finalPath_; }

  /// Renames path() to finalPath(). Throws OutputError if that fails.
  void commit();

 private:
  std::filesystem::path finalPath_;
  std::filesystem::path path_;
  bool committed_ = false;
};

/// Renames a file or a folder within one file system (rename(2)). Throws OutputError.
void moveFile(const std::filesystem::path& from, const std::filesystem::path& to);

/// Creates a folder and its parents. Throws OutputError with the system's reason.
void makeFolder(const std::filesystem::path& folder);

/// Throws OutputError, with the system's reason, if files cannot be created in a folder.
void requireWritableFolder(const std::filesystem::path& folder);

/// Writes a text atomically to finalPath by a PendingFile. Throws OutputError with the path and the
/// system's reason (disk full, no permission).
void writeTextFile(const std::filesystem::path& finalPath, const std::string& text);

// ------------------------------------------------------------------------------------------------
// SHA-256 (FIPS 180-4), to identify contents. It needs no OpenSSL header.

/// The hash of bytes that are added piecewise.
class Sha256 {
 public:
  /// Starts without bytes.
  Sha256();
  ~Sha256();
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;

  /// Adds bytes to the hash.
  void add(std::span<const char> bytes);

  /// 64 hexadecimal digits for all bytes added. Call it once.
  std::string finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// SHA-256 of a text, 64 hexadecimal digits.
std::string sha256(std::string_view text);

// ------------------------------------------------------------------------------------------------
// Compression and checksums by zlib.

/// The CRC-32 of bytes, as in zlib.
std::uint32_t checksumOf(std::span<const std::byte> bytes);

/// The bytes in zlib's format (RFC 1950), which browsers unpack as "deflate". level: 1 (fast) to 9
/// (small). The same bytes give the same result with the same zlib version. Throws std::bad_alloc
/// if memory is short.
std::string compressed(std::span<const std::byte> bytes, int level = 6);

/// Bytes as text, 64 characters for 6 bits each (RFC 4648, section 4).
std::string base64(std::span<const std::byte> bytes);

}  // namespace kirireel
