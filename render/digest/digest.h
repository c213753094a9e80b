/// Fingerprints (SHA-256), by which a file is known to be the one that was written.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "sim/base/sha256.h"

namespace kirireel {

/// What a file holds, in short.
struct FileDigest {
  std::string name;          ///< relative to the run's folder
  std::uintmax_t bytes = 0;  ///< its size
  std::string sha256;        ///< 64 hexadecimal digits, of its bytes

  bool operator==(const FileDigest&) const = default;
};

/// The digest of a file in a folder. Throws InputError when it cannot be read. Reads the whole file
/// once.
FileDigest digestOf(const std::filesystem::path& folder, const std::string& name);

/// A JSON object's text (one key a line, ending in "\n}\n") with a last key "sha256" added, which
/// is the fingerprint of the text before. The text must end so, and must not be sealed yet.
std::string sealed(const std::string& json);

/// Whether a text is as sealed() left it, to the last byte.
bool isSealed(const std::string& text);

}  // namespace kirireel
