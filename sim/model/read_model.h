/// Models in any format.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/model/model.h"
#include "sim/model/model_checks.h"

namespace kirireel::model {

/// Reads the model at a path, in the format that stands there: a folder (vertices.txt and
/// constraints.txt, with "x y z" or planar "x y" vertices), a .fold file, a contracted .obj whose
/// NAME_deployed.obj sibling is the target, a .ply mesh, a cut pattern (.svg, .dxf), or any file of
/// a planar model. `target` names another model whose start becomes the target, in any format.
///
/// What is odd but clear is mended (see model_checks.h): the model lists it, and warnings have a
/// line of each, unless the settings are strict. What a run can live with is appended to warnings
/// too; everything else that is wrong throws InputError.
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

// ------------------------------------------------------------------------------------------------
// PyKirigami's model folders: vertices.txt, constraints.txt, and optionally target.txt, pull.txt,
// hull.txt. necks.txt is Kirireel's own.

/// Reads a model folder and checks it.
///
/// vertices.txt and target.txt hold one tile a line, "x y z" for each vertex; constraints.txt holds
/// "tileA vertexA tileB vertexB [face]" a line, 0-based, face 1 bottom, 2 top, 3 both, 1 if absent;
/// pull.txt lists tile numbers; hull.txt lists the corners round the outside, "tile vertex" a line;
/// necks.txt lists "joint width length kerf", joints being rows of constraints.txt, from 0.
/// Blank lines and lines starting with '#' are passed over. A model of
/// loose tiles says so by a constraints.txt with nothing but a comment.
///
/// What a run can live with (joints apart by no more than a small part of a tile, a target that is
/// not quite congruent) is appended to warnings; everything else that is wrong throws InputError
/// with file:line:column, the value found, what is allowed and how to mend it.
Model readModelFolder(const std::filesystem::path& folder, const ReadSettings& settings,
                      std::vector<std::string>& warnings);
/// The same of a folder, with how its files are read at its defaults.
Model readModelFolder(const std::filesystem::path& folder, std::vector<std::string>& warnings);

/// Reads another target for a model, in the format of target.txt and in the order of the model's
/// own file: a run's final_vertices.txt is one. Warnings and errors are those of a model's own
/// target.
std::vector<Tile> readTargetFile(const std::filesystem::path& file, const Model& model,
                                 std::vector<std::string>& warnings);

/// Reads tiles alone, as writeTiles() leaves them. Throws InputError with file:line:column.
std::vector<Tile> readTileFile(const std::filesystem::path& file);

/// Writes the model as such a folder, numbers so that reading gives the same doubles. The folder is
/// made if need be. Throws InputError for a model with links or fixed joints, and where one of
/// these files is there and says anything else; OutputError when writing fails.
void writeModelFolder(const Model& model, const std::filesystem::path& folder);

/// Writes tiles alone in the format of vertices.txt, so that a run's end can be another's target.
void writeTiles(const std::vector<Tile>& tiles, const std::filesystem::path& file);

}  // namespace kirireel::model
