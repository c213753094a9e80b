/// Reads and writes models in any format.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/formats/read_settings.h"
#include "sim/model/model.h"

namespace kirireel::formats {

/// Reads the model at a path. The path is a folder (vertices.txt and constraints.txt, with "x y z"
/// or planar "x y" vertices), a .fold file, a .ply mesh, a cut pattern (.svg, .dxf), a contracted
/// .obj with its NAME_deployed.obj sibling as target, or any file of a planar model. `target` is
/// another model in any format. Its start becomes the target.
///
/// Unusual but unambiguous input is repaired (see repairs.h) unless the settings are strict. The
/// model lists each repair, and warnings get a line for it. Other harmless faults also become
/// warnings. All other faults throw InputError.
model::Model readModel(const std::filesystem::path& path,
                       const std::optional<std::filesystem::path>& target,
                       std::vector<std::string>& warnings, const ReadSettings& settings = {});

/// Reads another target for a model: a .txt file in the format of target.txt (such as a run's
/// final_vertices.txt), or the start of another model in any format. Throws InputError if its tiles
/// are not those of the model.
std::vector<model::Tile> readTarget(const std::filesystem::path& path, const model::Model& model,
                                    std::vector<std::string>& warnings);

/// Writes the model in the format of the path's ending: .fold, .obj (a target goes to its
/// NAME_deployed.obj sibling), NAME_vertices.txt for planar files (without target), or no ending
/// for a folder. Vertices are in the order of the model's own file. Throws InputError for another
/// ending, OutputError if writing fails.
void writeModel(const model::Model& model, const std::filesystem::path& path);

// ------------------------------------------------------------------------------------------------
// PyKirigami's model folders: vertices.txt, constraints.txt, and optionally target.txt, pull.txt,
// hull.txt. necks.txt is an addition by Kirireel.

/// Reads a model folder and checks it.
///
/// vertices.txt and target.txt hold one tile per line, "x y z" for each vertex. constraints.txt
/// holds one "tileA vertexA tileB vertexB [face]" per line, zero-based. Face is 1 bottom, 2 top, 3
/// both; the default is 1. pull.txt lists tile numbers. hull.txt lists the corners of the outline,
/// one "tile vertex" per line. necks.txt lists "joint width length kerf" with zero-based rows of
/// constraints.txt as joints. Blank lines and lines starting with '#' are ignored. Unconnected
/// tiles need a constraints.txt with only a comment.
///
/// Harmless faults (small gaps at joints, a target that is not quite congruent) are added to
/// warnings. All other faults throw InputError with file:line:column, the value found, the allowed
/// values and advice.
model::Model readModelFolder(const std::filesystem::path& folder, const ReadSettings& settings,
                             std::vector<std::string>& warnings);
/// The same with default settings.
model::Model readModelFolder(const std::filesystem::path& folder,
                             std::vector<std::string>& warnings);

/// Reads another target for a model, in the format of target.txt and in the order of the model's
/// own file, such as a run's final_vertices.txt. Warnings and errors are those of a model's own
/// target.
std::vector<model::Tile> readTargetFile(const std::filesystem::path& file,
                                        const model::Model& model,
                                        std::vector<std::string>& warnings);

/// Reads only tiles, as written by writeTiles(). Throws InputError with file:line:column.
std::vector<model::Tile> readTileFile(const std::filesystem::path& file);

/// Writes the model as such a folder and creates the folder if needed. Reading gives the same
/// doubles. Throws InputError for a model with links or fixed joints, and if one of the files
/// exists with other contents. Throws OutputError if writing fails.
void writeModelFolder(const model::Model& model, const std::filesystem::path& folder);

/// Writes only tiles, as in vertices.txt, with the unit of their coordinates. The end of a run can
/// then be the target of another.
void writeTiles(const std::vector<model::Tile>& tiles, const std::filesystem::path& file,
                const LengthUnit& unit = {});

}  // namespace kirireel::formats
