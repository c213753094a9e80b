// zlib's checksums and compression, and base64. Only this file includes zlib, so that another
// library could take its place.
#include "sim/base/compression.h"

#include <algorithm>
#include <new>

#include <zlib.h>

namespace kirireel {

std::uint32_t checksumOf(std::span<const std::byte> bytes) {
  return static_cast<std::uint32_t>(
      crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

std::string compressed(std::span<const std::byte> bytes, int level) {
  uLongf size = compressBound(bytes.size());
  std::string packed(size, '\0');
  // With room for the worst case and a valid level, memory is all that can lack.
  if (compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
                reinterpret_cast<const Bytef*>(bytes.data()), bytes.size(), level) != Z_OK) {
    throw std::bad_alloc();
  }
  // The bound was an upper one.
  packed.resize(size);
  return packed;
}

std::string base64(std::span<const std::byte> bytes) {
  constexpr const char* kLetters =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  // Three bytes are 24 bits, which are four characters of 6 bits. What lacks at the end is filled
  // with zeros and shown by '='.
  for (std::size_t k = 0; k < bytes.size(); k += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - k);
    std::uint32_t group = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      group = group << 8 | (i < count ? std::to_integer<std::uint32_t>(bytes[k + i]) : 0);
    }
    for (std::size_t i = 0; i < 4; ++i) {
      text += i <= count ? kLetters[group >> (18 - 6 * i) & 63] : '=';
    }
  }
  return text;
}

}  // namespace kirireel
