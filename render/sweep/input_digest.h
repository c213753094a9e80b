/// Fingerprints of what a run depends on.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace kirireel {

/// Takes in texts one after the other; texts split elsewhere give another digest.
class InputDigest {
 public:
  void add(std::string_view text);

  /// SHA-256 of what was added since the last call, 64 hexadecimal digits.
  std::string take();

 private:
  std::string texts_;
};

/// The digest of what a model, target or scene file consists of: of a folder its files by name and
/// content, of a file its own content and that of the files beside it whose names start alike up to
/// the last '_' (a contracted OBJ and its deployed one). Where they stand does not matter.
/// Throws InputError when there is no such file or folder, or it cannot be read.
std::string digestOfFiles(const std::filesystem::path& path);

}  // namespace kirireel
