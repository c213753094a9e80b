// SHA-256 by OpenSSL, which uses the processor's instructions for it where there are any. Only this
// file includes OpenSSL.
#include "sim/base/sha256.h"

#include <array>

#include <fmt/format.h>
#include <openssl/evp.h>

#include "sim/base/interruption.h"

namespace kirireel {

struct Sha256::State {
  EVP_MD_CTX* context = EVP_MD_CTX_new();
};

Sha256::Sha256() : state_(std::make_unique<State>()) {
  EVP_DigestInit_ex(state_->context, EVP_sha256(), nullptr);
}

Sha256::~Sha256() {
  EVP_MD_CTX_free(state_->context);
}

void Sha256::add(std::span<const char> bytes) {
  checkInterruption();
  EVP_DigestUpdate(state_->context, bytes.data(), bytes.size());
}

std::string Sha256::finish() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> bytes{};
  unsigned int count = 0;
  EVP_DigestFinal_ex(state_->context, bytes.data(), &count);
  std::string digits;
  for (unsigned int k = 0; k < count; ++k) digits += fmt::format("{:02x}", bytes[k]);
  return digits;
}

std::string sha256(std::string_view text) {
  Sha256 hash;
  hash.add(text);
  return hash.finish();
}

}  // namespace kirireel
