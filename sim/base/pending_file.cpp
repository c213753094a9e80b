// Files that appear whole or not at all. They are written beside their final place and renamed,
// which replaces an existing file at once (POSIX rename is atomic within one file system). The name
// beside is one that nothing has yet, as a file of that name may be the user's own.
#include "sim/base/pending_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include <fmt/format.h>
#include <unistd.h>

#include "sim/base/error.h"

namespace kirireel {
namespace {

/// "deployment.part.mp4", or "deployment.part2.mp4" and so on where something of that name is: it
/// may be anybody's.
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
      fmt::format("{}: error: cannot write in this folder ({}); choose another with --out",
                  folder.string(), std::strerror(errno)));
}

PendingFile::PendingFile(std::filesystem::path finalPath)
    : finalPath_(std::move(finalPath)), path_(pendingName(finalPath_)) {
  requireWritableFolder(finalPath_.has_parent_path() ? finalPath_.parent_path() : ".");
}

PendingFile::~PendingFile() {
  if (committed_) return;
  std::error_code ignored;
  // A destructor must not throw, and what cannot be removed harms nobody.
  std::filesystem::remove(path_, ignored);
}

void PendingFile::commit() {
  std::error_code error;
  std::filesystem::rename(path_, finalPath_, error);
  if (error) {
    throw OutputError(fmt::format("{}: error: cannot be put in place ({})", finalPath_.string(),
                                  error.message()));
  }
  committed_ = true;
}

void makeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error && std::filesystem::is_directory(folder)) return;
  const std::string reason = error ? error.message() : "a file of that name is there";
  throw OutputError(fmt::format("{}: error: the folder cannot be made ({}); choose another",
                                folder.string(), reason));
}

void writeTextFile(const std::filesystem::path& finalPath, const std::string& text) {
  PendingFile pending(finalPath);
  std::ofstream stream(pending.path(), std::ios::binary);
  stream << text;
  // Closing writes what is pending: a full disk shows here at the latest.
  stream.close();
  if (!stream) {
    throw OutputError(
        fmt::format("{}: error: cannot be written ({}); free some space or choose "
                    "another folder with --out",
                    finalPath.string(), std::strerror(errno)));
  }
  pending.commit();
}

}  // namespace kirireel
