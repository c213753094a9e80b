/// What all fuzz targets share: a place for the input's files, and what a reader may throw.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "sim/model/model.h"

/// libFuzzer's entry point, which every target defines: reads one input. What ends the process is a
/// fault of the reader.
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

/// Calls a reader. It may throw Kirireel's errors, each one short line; anything else ends the
/// process, and so does a second or more of the processor's time.
void read(const std::function<void()>& reader);

/// Ends the process unless a model that was read has all that others rely on: tiles that enclose
/// something, and joints, targets, pulled tiles and a hull that name what is there.
void requireSound(const model::Model& model);

}  // namespace kirireel::fuzz
