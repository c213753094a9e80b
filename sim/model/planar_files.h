/// The planar files of the quasicrystal kirigami simulator (Liu, Choi and Mahadevan 2022).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/model/mending.h"
#include "sim/model/model.h"

namespace kirireel {

/// Whether a file of vertices holds "x y" pairs rather than "x y z": an even count of numbers on
/// every line that is not always a multiple of 3 above 6, and no joint beside it that names its
/// face.
bool holdsPlanarModel(const std::filesystem::path& vertices);

/// Reads a planar model, of which `named` is any file (see planar_siblings.h). The vertices' file
/// holds one tile a line, "x y" for each vertex, in either sense; a list of joints "tile vertex
/// tile vertex" a line, counted from 1; a hull "tile vertex" a line, counted from 0. Vertices that
/// coincide as far as the file's digits can tell become joints on both faces, others keep their
/// distance as links.
///
/// Throws InputError with file and line for numbers that are wrong and tiles that make no bricks.
Model readPlanarFiles(const std::filesystem::path& named, const ReadSettings& settings,
                      std::vector<std::string>& warnings);

/// Writes a planar model as such files: `vertices` and, beside it, its joints and its hull, if it
/// has one. Throws InputError for a start that is not flat, and for fixed joints; OutputError when
/// writing fails.
void writePlanarFiles(const Model& model, const std::filesystem::path& vertices);

}  // namespace kirireel
