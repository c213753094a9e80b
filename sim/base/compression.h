/// Bytes made smaller, and checksums of bytes: zlib.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace kirireel {

/// The CRC-32 of bytes, as zlib counts it.
std::uint32_t checksumOf(std::span<const std::byte> bytes);

/// The bytes in zlib's format (RFC 1950), which browsers unpack as "deflate". level: 1 (quick) to 9
/// (small). The same bytes give the same result with the same zlib.
/// Throws std::bad_alloc where memory is short.
std::string compressed(std::span<const std::byte> bytes, int level = 6);

/// Bytes as text, 64 characters for 6 bits each (RFC 4648, section 4).
std::string base64(std::span<const std::byte> bytes);

}  // namespace kirireel
