/// The one place where files are opened to be read, so that a run knows all that it was made from.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace kirireel {

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

}  // namespace kirireel
