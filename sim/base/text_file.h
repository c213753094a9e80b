/// Text files, read whole.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace kirireel {

/// Largest text file that is read, bytes: room for 250,000 tiles, and a bound on the memory that a
/// file can ask for.
inline constexpr std::uintmax_t kMostTextBytes = 64u << 20;

/// All bytes of a text file. `purpose` ends the messages: what to give or to write. Throws
/// InputError when the file is missing, unreadable, no regular file or larger than `mostBytes`.
std::string readTextFile(const std::filesystem::path& file, const std::string& purpose,
                         std::uintmax_t mostBytes = kMostTextBytes);

}  // namespace kirireel
