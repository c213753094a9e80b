/// Shared by all fuzz targets: a folder for the input's files, and the allowed errors.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "sim/model/model.h"

/// libFuzzer's entry point, which every target defines: reads one input. A reader that ends the
/// process is faulty.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size);

namespace kirireel::fuzz {

/// The bytes of an input.
inline std::string_view inputText(const std::uint8_t* bytes, std::size_t size) {
  return {reinterpret_cast<const char*>(bytes), size};
}

/// A folder of only this process, in memory if the system supports it. Removed with the process.
const std::filesystem::path& folder();

/// Writes a file into folder().
void place(const std::string& name, std::string_view text);

/// Writes an input with several files, separated by lines "%%", into folder(). Removes files
/// without a part in the input.
void placeParts(std::span<const char* const> names, std::string_view input);

/// Calls a reader. It may throw Kirireel's errors, each one short line. Anything else ends the
/// process, and so does CPU time of a second or more.
void read(const std::function<void()>& reader);

/// Ends the process unless a model is valid: tiles enclose areas, and joints, targets, pulled tiles
/// and hull refer to existing tiles.
void requireSound(const model::Model& model);

}  // namespace kirireel::fuzz
