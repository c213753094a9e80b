/// A file that appears under its final name only when it is whole.
#pragma once

#include <filesystem>
#include <string>

namespace kirireel {

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

  /// Where to write: beside the final name, same extension, e.g. "deployment.part.mp4"; under a
  /// name that nothing has yet.
  const std::filesystem::path& path() const { return path_; }
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

}  // namespace kirireel
