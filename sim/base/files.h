/// Files: reading with a record of inputs, atomic writing, SHA-256, compression, and JSON texts. No
/// header of OpenSSL or zlib is needed to use it.
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
// The one place where files are opened to be read: a run knows all files that it was made from.

/// A file that was read.
struct InputFile {
  std::filesystem::path path;  ///< as it was opened
  std::string sha256;          ///< of all its bytes, 64 hexadecimal digits
};

/// Notes every file that its thread opens for reading while it lives, in the order of opening; a
/// file that is opened again is noted again. Of records within each other each notes the file.
class InputRecord {
 public:
  /// `files` gets the notes and must outlive the record.
  explicit InputRecord(std::vector<InputFile>& files);
  ~InputRecord();
  InputRecord(const InputRecord&) = delete;
  InputRecord& operator=(const InputRecord&) = delete;

 private:
  friend void noteInput(const InputFile&);

  std::vector<InputFile>& files_;
  InputRecord* outer_;  // of the same thread; null for the first
};

/// A name's ending with its dot, in lower case: ".svg" of "SHEET.Svg"; "" where it has none.
std::string endingOf(const std::filesystem::path& file);

/// Opens a file that is read piece by piece, and notes it. The stream has failed where the file
/// cannot be opened.
std::ifstream openInputFile(const std::filesystem::path& path);

/// Largest text file that is read, bytes: room for 250,000 tiles, and a bound on the memory that a
/// file can ask for.
inline constexpr std::uintmax_t kMostTextBytes = 64u << 20;

/// All bytes of a text file. `purpose` ends the messages: what to give or to write. Throws
/// InputError when the file is missing, unreadable, no regular file or larger than `mostBytes`.
/// Line ends are not changed.
std::string readTextFile(const std::filesystem::path& file, const std::string& purpose,
                         std::uintmax_t mostBytes = kMostTextBytes);

/// Appends formatted text to what will be the text of a file.
template <typename... Arguments>
void appendText(std::string& text, fmt::format_string<Arguments...> format,
                Arguments&&... arguments) {
  fmt::format_to(std::back_inserter(text), format, std::forward<Arguments>(arguments)...);
}

// ------------------------------------------------------------------------------------------------
// JSON texts. They are read and written only here: each place that does takes the compiler seconds.

/// Keys keep the order in which they were set: the same values give the same text.
using Json = nlohmann::ordered_json;

/// Parses a JSON text. Throws nlohmann::json::parse_error, with the position of the fault.
Json parseJson(std::string_view text);

/// The same for a file of others. Throws std::length_error if values are nested deeper than that:
/// the library compares and copies them by recursion, which such a file takes to the end of the
/// stack.
Json parseJson(std::string_view text, int mostNested);

/// The same, but discarded (Json::is_discarded) where the syntax is wrong.
Json parseJsonOrDiscard(std::string_view text);

/// JSON as a text: in one line, or a line an entry, indented by so many spaces. Names of files and
/// models may hold anything; bytes that are not UTF-8 become U+FFFD.
std::string jsonText(const Json& json, int indent = -1);

// ------------------------------------------------------------------------------------------------
// A file that appears under its final name only when it is whole.

/// Write to path(), then commit(). Without commit the destructor removes what was written, so an
/// interrupted or failed write leaves nothing under the final name. A link under the final name is
/// replaced, never written through.
class PendingFile {
 public:
  /// Throws OutputError when the folder of finalPath does not exist or cannot be written.
  explicit PendingFile(std::filesystem::path finalPath);
  ~PendingFile();
  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;

  /// Where to write: next to the final name, same extension, e.g. "deployment.part.mp4". No file of
  /// this name exists.
  const std::filesystem::path& path() const { return path_; }
  /// Where the file goes in the end.
  const std::filesystem::path& finalPath() const { return finalPath_; }

  /// Renames path() to finalPath(). Throws OutputError when that fails.
  void commit();

 private:
  std::filesystem::path finalPath_;
  std::filesystem::path path_;
  bool committed_ = false;
};

/// Makes a folder and those above it. Throws OutputError with the system's reason.
void makeFolder(const std::filesystem::path& folder);

/// Throws OutputError, with the system's reason, when no files can be made in a folder.
void requireWritableFolder(const std::filesystem::path& folder);

/// Writes text whole to finalPath through a PendingFile. Throws OutputError naming the path and the
/// system's reason (disk full, no permission).
void writeTextFile(const std::filesystem::path& finalPath, const std::string& text);

// ------------------------------------------------------------------------------------------------
// SHA-256 (FIPS 180-4), by which bytes are known again. No OpenSSL header is needed to use it.

/// The hash of bytes that come piece by piece.
class Sha256 {
 public:
  /// Of no bytes yet.
  Sha256();
  ~Sha256();
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;

  /// Appends bytes to what is hashed.
  void add(std::span<const char> bytes);

  /// 64 hexadecimal digits of all that was added. To be called once.
  std::string finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// SHA-256 of a text, 64 hexadecimal digits.
std::string sha256(std::string_view text);

// ------------------------------------------------------------------------------------------------
// Bytes made smaller, and checksums of bytes: zlib.

/// The CRC-32 of bytes, as zlib counts it.
std::uint32_t checksumOf(std::span<const std::byte> bytes);

/// The bytes in zlib's format (RFC 1950), which browsers unpack as "deflate". level: 1 (quick) to 9
/// (small). The same bytes give the same result with the same zlib.
/// Throws std::bad_alloc where memory is short.
std::string compressed(std::span<const std::byte> bytes, int level = 6);

/// Bytes as text, 64 characters for 6 bits each (RFC 4648, section 4).
std::string base64(std::span<const std::byte> bytes);

}  // namespace kirireel
