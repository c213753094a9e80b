/// Fingerprints of texts and files: SHA-256 (FIPS 180-4).
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace kirireel {

/// Takes in texts one after the other; texts split elsewhere give another digest.
class Digest {
 public:
  Digest();
  ~Digest();
  Digest(const Digest&) = delete;
  Digest& operator=(const Digest&) = delete;

  void add(std::string_view text);

  /// What was added since the last call, as 64 hexadecimal digits.
  std::string take();

 private:
  struct Internals;
  std::unique_ptr<Internals> internals_;
};

/// The digest of what a model, target or scene file consists of: of a folder its files by name and
/// content, of a file its own content and that of the files beside it whose names start alike up to
/// the last '_' (a contracted OBJ and its deployed one). Where they stand does not matter.
/// Throws InputError when there is no such file or folder, or it cannot be read.
std::string digestOfFiles(const std::filesystem::path& path);

}  // namespace kirireel
