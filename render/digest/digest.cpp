#include "render/digest/digest.h"

#include <array>
#include <fstream>
#include <memory>
#include <span>

#include <fmt/format.h>
#include <openssl/evp.h>

#include "sim/base/error.h"

namespace kirireel {
namespace {

constexpr std::size_t kReadBytes = 1 << 16;
constexpr const char* kEnd = "\n}\n";

class Hasher {
 public:
  Hasher() : state_(EVP_MD_CTX_new(), EVP_MD_CTX_free) {
    EVP_DigestInit_ex(state_.get(), EVP_sha256(), nullptr);
  }

  void add(std::span<const char> bytes) {
    EVP_DigestUpdate(state_.get(), bytes.data(), bytes.size());
  }

  std::string finish() {
    std::array<unsigned char, EVP_MAX_MD_SIZE> bytes{};
    unsigned int count = 0;
    EVP_DigestFinal_ex(state_.get(), bytes.data(), &count);
    std::string digits;
    for (unsigned int k = 0; k < count; ++k) digits += fmt::format("{:02x}", bytes[k]);
    return digits;
  }

 private:
  std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX*)> state_;
};

std::string sealOf(const std::string& json) {
  return fmt::format(",\n  \"sha256\": \"{}\"{}", sha256(json), kEnd);
}

}  // namespace

std::string sha256(const std::string& text) {
  Hasher hasher;
  hasher.add(text);
  return hasher.finish();
}

FileDigest digestOf(const std::filesystem::path& folder, const std::string& name) {
  std::ifstream file(folder / name, std::ios::binary);
  FileDigest digest{name, 0, ""};
  Hasher hasher;
  std::array<char, kReadBytes> bytes{};
  while (file.read(bytes.data(), bytes.size()), file.gcount() > 0) {
    hasher.add({bytes.data(), static_cast<std::size_t>(file.gcount())});
    digest.bytes += static_cast<std::uintmax_t>(file.gcount());
  }
  if (!file.eof() || file.bad()) {
    throw InputError(
        fmt::format("{}: error: the file cannot be read; check that it is there and its rights",
                    (folder / name).string()));
  }
  digest.sha256 = hasher.finish();
  return digest;
}

std::string sealed(const std::string& json) {
  return json.substr(0, json.size() - std::string(kEnd).size()) + sealOf(json);
}

bool isSealed(const std::string& text) {
  const std::size_t sealSize = sealOf("").size();
  if (text.size() < sealSize) return false;
  const std::string json = text.substr(0, text.size() - sealSize) + kEnd;
  return text == sealed(json);
}

}  // namespace kirireel
