/// SHA-256 (FIPS 180-4), by which bytes are known again. No OpenSSL header is needed to use it.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace kirireel {

/// The hash of bytes that come piece by piece.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;

  void add(std::span<const char> bytes);

  /// 64 hexadecimal digits of all that was added. To be called once.
  std::string finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// SHA-256 of a text, 64 hexadecimal digits.
std::string sha256(std::string_view text);

}  // namespace kirireel
