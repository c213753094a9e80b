/// Files that appear together or not at all.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace kirireel {

/// Collects files in a folder of its own beside their final place. Without commit() the destructor
/// removes them.
class FileSet {
 public:
  /// Makes the folder, and those above it. Throws OutputError.
  explicit FileSet(std::filesystem::path folder);
  ~FileSet();
  FileSet(const FileSet&) = delete;
  FileSet& operator=(const FileSet&) = delete;

  /// Where to write the file of this name until commit(); it must be whole before the next call.
  std::filesystem::path add(const std::string& name);

  /// Puts all files in place. Throws OutputError.
  std::vector<std::string> commit();

 private:
  std::filesystem::path folder_;
  std::filesystem::path stage_;
  std::vector<std::string> names_;
};

}  // namespace kirireel
