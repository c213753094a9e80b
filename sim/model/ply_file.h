/// PLY meshes of sheets in one state.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/model/model.h"

namespace kirireel {

/// Reads a sheet from a PLY file (Turk 1994), ASCII or binary of either byte order: faces are
/// tiles, vertex numbers that faces share are joints, so that faces with a common edge are hinged;
/// where no face shares any, corners that coincide are. Other elements and properties are passed
/// over.
///
/// Throws InputError for headers and numbers that are wrong, files that end early, and tiles that
/// make no bricks.
/// Coordinates count as metres. There is no target. A file as large as kMostTextBytes is read whole
/// into memory.
Model readPly(const std::filesystem::path& file, std::vector<std::string>& warnings);

}  // namespace kirireel
