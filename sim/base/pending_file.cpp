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

std::filesystem::path pendingName(const std::filesystem::path& finalPath) {
  std::filesystem::path name = finalPath.stem();
  name += ".part";
  name += finalPath.extension();
  return finalPath.parent_path() / name;
}

void requireWritableFolder(const std::filesystem::path& file) {
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  if (::access(folder.c_str(), W_OK | X_OK) == 0) return;
  throw OutputError(
      fmt::format("{}: error: cannot write in this folder ({}); choose another with --out",
                  folder.string(), std::strerror(errno)));
}

}  // namespace

PendingFile::PendingFile(std::filesystem::path finalPath)
    : finalPath_(std::move(finalPath)), path_(pendingName(finalPath_)) {
  requireWritableFolder(finalPath_);
  // What stands there is left of a killed run, or a link that must not be written through.
  ::unlink(path_.c_str());
}

PendingFile::~PendingFile() {
  if (committed_) return;
  std::error_code ignored;
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
