/// PyKirigami's model folders: vertices.txt, constraints.txt, and optionally target.txt, pull.txt,
/// hull.txt.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/model/mending.h"
#include "sim/model/model.h"

namespace kirireel {

/// Reads a model folder and checks it.
///
/// vertices.txt and target.txt hold one tile a line, "x y z" for each vertex; constraints.txt holds
/// "tileA vertexA tileB vertexB [face]" a line, 0-based, face 1 bottom, 2 top, 3 both, 1 if absent;
/// pull.txt lists tile numbers; hull.txt lists the corners round the outside, "tile vertex" a line.
/// Blank lines and lines starting with '#' are passed over. A model of
/// loose tiles says so by a constraints.txt with nothing but a comment.
///
/// What a run can live with (joints apart by no more than a small part of a tile, a target that is
/// not quite congruent) is appended to warnings; everything else that is wrong throws InputError
/// with file:line:column, the value found, what is allowed and how to mend it.
Model readModelFolder(const std::filesystem::path& folder, const ReadSettings& settings,
                      std::vector<std::string>& warnings);
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

}  // namespace kirireel
