/// Meshes as models: Wavefront OBJ and PLY.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/model/model.h"

namespace kirireel {

// ------------------------------------------------------------------------------------------------
// Wavefront OBJ files: a sheet in one state, or a pair of files with the same faces in two states.

/// The file with the other state of a contracted one: NAME_deployed.obj beside NAME_contracted.obj
/// or NAME.obj; none when there is no such file.
std::optional<std::filesystem::path> deployedSibling(const std::filesystem::path& contracted);

/// Reads a sheet from its state at the start and, if given, at the target. Faces are tiles, vertex
/// numbers that faces share are joints; where no face shares any, corners that coincide in all
/// given states are. Comments "# joint A a B b FACE" and "# pull TILE", which writeObjPair leaves,
/// say more and then count instead. Other statements (vt, vn, g, o, s, usemtl, mtllib) are passed
/// over.
///
/// Throws InputError with file and line for numbers, faces and tiles that are wrong, and for states
/// whose faces differ; appends to warnings what a run can live with.
Model readObjPair(const std::filesystem::path& start,
                  const std::optional<std::filesystem::path>& target,
                  std::vector<std::string>& warnings);

/// Writes the start to `file` and the target, if there is one, to its sibling NAME_deployed.obj, so
/// that reading gives the same model to the last bit. Throws InputError for a model with links or
/// fixed joints, which the format cannot hold, OutputError when writing fails.
void writeObjPair(const Model& model, const std::filesystem::path& file);

// ------------------------------------------------------------------------------------------------
// PLY meshes of sheets in one state.

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
