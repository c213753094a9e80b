/// The planar files of the quasicrystal kirigami simulator (Liu, Choi and Mahadevan 2022).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/model/model.h"

namespace kirireel {

/// Whether a file of vertices holds "x y" pairs rather than "x y z": an even count of numbers on
/// every line, not always a multiple of 3, and no joint beside it that names its face.
bool holdsPlanarModel(const std::filesystem::path& vertices);

/// Reads a planar model. The vertices' file holds one tile a line, "x y" for each vertex, in either
/// sense; the constraints' file, whose name has "constraints" in place of "vertices", "tile vertex
/// tile vertex" a line, counted from 1. Vertices that coincide become joints on both faces, others
/// keep their distance as links.
///
/// Throws InputError with file and line for numbers that are wrong and tiles that make no bricks;
/// suggests the right base when the constraints seem to count from 0.
Model readPlanarFiles(const std::filesystem::path& vertices, std::vector<std::string>& warnings);

}  // namespace kirireel
