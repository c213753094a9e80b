/// Models in any format.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/model/mending.h"
#include "sim/model/model.h"

namespace kirireel {

/// Reads the model at a path, in the format that stands there: a folder (vertices.txt and
/// constraints.txt, with "x y z" or planar "x y" vertices), a .fold file, a contracted .obj whose
/// NAME_deployed.obj sibling is the target, a .ply mesh, a cut pattern (.svg, .dxf), or any file of
/// a planar model. `target` names another model whose start becomes the target, in any format.
///
/// What is odd but clear is mended (see mending.h): the model lists it, and warnings have a line of
/// each, unless the settings are strict. What a run can live with is appended to warnings too;
/// everything else that is wrong throws InputError.
Model readModel(const std::filesystem::path& path,
                const std::optional<std::filesystem::path>& target,
                std::vector<std::string>& warnings, const ReadSettings& settings = {});

/// Reads another target for a model: a .txt file in the format of target.txt (a run's
/// final_vertices.txt is one), or the start of another model in any format. Throws InputError when
/// its tiles are not the model's.
std::vector<Tile> readTarget(const std::filesystem::path& path, const Model& model,
                             std::vector<std::string>& warnings);

/// Writes the model in the format of the path's ending: .fold, .obj (a target goes to its
/// NAME_deployed.obj sibling), NAME_vertices.txt for planar files (which have no target), or none
/// for a folder. Each tile's vertices are written in the order of the model's own file. Throws
/// InputError for another ending, OutputError when writing fails.
void writeModel(const Model& model, const std::filesystem::path& path);

}  // namespace kirireel
