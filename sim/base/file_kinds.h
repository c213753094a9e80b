/// The kind of file at a path. A name that the system cannot look up (too long, in a folder that may not be
/// read) names nothing: opening it reports the system's reason.
#pragma once

#include <filesystem>
#include <string>
#include <system_error>

namespace kirireel {

/// Whether anything has this name.
inline bool isPresent(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

/// Whether this is a regular file, or a link to one.
inline bool isFile(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(path, ignored);
}

/// Whether this is a folder, or a link to one.
inline bool isFolder(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::is_directory(path, ignored);
}

/// A file that the user named by its path, or by its name in a folder.
inline std::filesystem::path namedFile(const std::filesystem::path& file,
                                       const std::filesystem::path& folder) {
  return isPresent(file) || !isPresent(folder / file) ? file : folder / file;
}

/// Why a path names nothing. `kind`: "file" or "folder".
inline std::string whyAbsent(const std::filesystem::path& path, const std::string& kind) {
  std::error_code error;
  const bool isUnknown =
      std::filesystem::status(path, error).type() == std::filesystem::file_type::none;
  return isUnknown ? error.message() : "there is no such " + kind;
}

}  // namespace kirireel
