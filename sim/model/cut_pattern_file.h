/// Cut patterns as models again: the SVG and DXF files that `export --format svg,dxf` leaves.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/model/model.h"

namespace kirireel {

/// Reads the sheet that a cut pattern was drawn from: tiles, vertices and hinges, at true size in
/// metres, in the plane z = 0 (an SVG knows no origin: its sheet begins near (0, 0)). Layers or
/// groups are named cuts, slits and hinges, see render/sheet/cut_pattern.h. Tiles come in the order
/// of their first line; joints are on both faces. There is no target.
///
/// Throws InputError for files that hold no such lines, lines that end nowhere, and tiles that make
/// no bricks.
Model readCutPattern(const std::filesystem::path& file, std::vector<std::string>& warnings);

}  // namespace kirireel
