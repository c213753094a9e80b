// A record seals itself: its last key is the SHA-256 (FIPS 180-4) of the text without that key.
//
//     {                                   {
//       "a": 1            sealed()          "a": 1,
//     }                    ---->            "sha256": "<hash of the text on the left>"
//                                         }
//
// So a reader can tell whether anybody has changed a byte. It is no signature: whoever changes the
// text on purpose can compute the hash again.
#include "render/digest/digest.h"

#include <array>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/base/input_file.h"

namespace kirireel {
namespace {

constexpr const char* kEnd = "\n}\n";

/// Always of one length, which isSealed() relies on.
std::string sealOf(const std::string& json) {
  return fmt::format(",\n  \"sha256\": \"{}\"{}", sha256(json), kEnd);
}

}  // namespace

FileDigest digestOf(const std::filesystem::path& folder, const std::string& name) {
  std::ifstream file = openInputFile(folder / name);
  FileDigest digest{name, 0, ""};
  Sha256 hash;
  std::array<char, 1 << 16> bytes{};
  // Piece by piece, since videos and trajectories may be larger than memory. The last piece sets
  // eof.
  while (file.read(bytes.data(), bytes.size()), file.gcount() > 0) {
    hash.add({bytes.data(), static_cast<std::size_t>(file.gcount())});
    digest.bytes += static_cast<std::uintmax_t>(file.gcount());
  }
  if (!file.eof() || file.bad()) {
    throw InputError(
        fmt::format("{}: error: the file cannot be read; check that it is there and its rights",
                    (folder / name).string()));
  }
  digest.sha256 = hash.finish();
  return digest;
}

std::string sealed(const std::string& json) {
  return json.substr(0, json.size() - std::string(kEnd).size()) + sealOf(json);
}

bool isSealed(const std::string& text) {
  // Takes the seal off, makes it anew and compares.
  const std::size_t sealSize = sealOf("").size();
  if (text.size() < sealSize) return false;
  const std::string json = text.substr(0, text.size() - sealSize) + kEnd;
  return text == sealed(json);
}

}  // namespace kirireel
