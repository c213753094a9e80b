/// FOLD files (github.com/edemaine/fold, version 1.2): JSON, a sheet in one frame or several.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/model/model.h"

namespace kirireel {

/// Reads a sheet: the first frame with coordinates is the start, the last one, if there are more,
/// the target. faces_vertices are tiles; vertices that faces share are joints, so that faces with a
/// common edge are hinged, unless the edge is a cut or joins them to one piece. A flat sheet in one
/// frame goes where its edges_foldAngle fold it. Keys of Kirireel's own, which writeFold leaves,
/// say more.
///
/// Throws InputError for text that is no JSON, no faces, wrong numbers, tiles that make no bricks.
/// Coordinates count as metres, whatever the file's frame_unit says. Appends to warnings what a run
/// can live with: tiles of a target that are not congruent, angles that do not close.
Model readFold(const std::filesystem::path& file, std::vector<std::string>& warnings);

/// Writes the model with its edges, their assignments and the angles that they fold by, so that
/// origami programs fold it and reading gives it back to the last bit. Throws OutputError.
/// An existing file is replaced.
void writeFold(const Model& model, const std::filesystem::path& file);

}  // namespace kirireel
