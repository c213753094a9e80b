/// Bricks as surface meshes, for modelling and simulation programs. No assimp header is needed to
/// use it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/brick/brick.h"

namespace kirireel {

/// Writes all bricks, at least one, at the given poses; the ending of the path chooses the format:
/// - .obj: one group a brick named TILE_00000 and so on, polygons, flat normals;
/// - .ply: one mesh, ASCII, triangles, vertices shared within a brick, no normals;
/// - .stl: triangles, binary, each with its own outward normal.
///
/// Every brick is closed, outward, and apart from its neighbours even where they touch: a joint
/// would else be an edge of four faces. Coordinates are in metres and, but for STL's single
/// precision, read back to the last bit. Throws InputError for another ending, OutputError when the
/// file cannot be written. `poses` has one pose a brick. The text is built in memory. Throws
/// Interrupted when the user ends the program.
void writeMesh(const std::filesystem::path& path, const std::vector<Brick>& bricks,
               const Poses& poses);

/// The version of assimp in use, e.g. "5.2.5".
std::string meshLibraryVersion();

}  // namespace kirireel
