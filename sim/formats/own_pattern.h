/// Cut patterns written by `kirireel export`.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/formats/drawing.h"
#include "sim/formats/tile_checks.h"

namespace kirireel::formats {

/// A pattern written by `kirireel export`. Its layers contain the kinds of lines.
model::Model ownPattern(const Drawing& drawing, const std::filesystem::path& file,
                        std::vector<std::string>& warnings);

/// Whether the names of layers are those of such a pattern.
bool isOwnPattern(const Drawing& drawing);

/// Tiles of a drawing, which have no line of their own in the file.
TileTable patternTable(const std::filesystem::path& file, const std::vector<model::Tile>& tiles);

}  // namespace kirireel::formats
