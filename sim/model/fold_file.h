/// FOLD files (github.com/edemaine/fold, version 1.1): JSON, a sheet in one frame or several.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/model/model.h"

namespace kirireel {

/// Reads a sheet: the first frame with coordinates is the start, the last one, if there are more,
/// the target. faces_vertices are tiles; vertices that faces share are joints, so that faces with a
/// common edge are hinged. Keys of Kirireel's own, which writeFold leaves, say more.
///
/// Throws InputError for text that is no JSON, no faces, wrong numbers, tiles that make no bricks.
Model readFold(const std::filesystem::path& file, std::vector<std::string>& warnings);

/// Writes the model, so that reading gives it back to the last bit. Throws OutputError.
void writeFold(const Model& model, const std::filesystem::path& file);

}  // namespace kirireel
