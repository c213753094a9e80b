/// Bricks as surface meshes, for modelling and simulation programs. No assimp header is needed to
/// use it.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/base/length_unit.h"
#include "sim/model/brick.h"

namespace kirireel::writers {

/// Writes all bricks, at least one, at the given poses; the ending of the path chooses the format:
/// - .obj: one group a brick named TILE_00000 and so on, polygons, flat normals;
/// - .ply: one mesh, ASCII, triangles, vertices shared within a brick, no normals;
/// - .stl: triangles, binary, each with its own outward normal.
///
/// Every brick is closed, outward, and apart from its neighbours even where they touch: a joint
/// would else be an edge of four faces. Coordinates are in the unit, which the file names in a
/// comment, and, but for STL's single precision, read back to the last bit. Throws InputError for
/// another ending, OutputError when the file cannot be written. `poses` has one pose a brick. The
/// text is built in memory. Throws Interrupted when the user ends the program.
void writeMesh(const std::filesystem::path& path, const std::vector<model::Brick>& bricks,
               const Poses& poses, const LengthUnit& unit = {});

/// The version of assimp in use, e.g. "5.2.5".
std::string meshLibraryVersion();

// ------------------------------------------------------------------------------------------------
// A whole deployment as an animated glTF scene, for viewers and presentations.

/// The poses of all bricks at one time. The poses are those of the bricks' centres of mass, in
/// their order.
struct AnimationKey {
  double time = 0;  ///< seconds, rising
  Poses poses;      ///< one a brick
};

/// The bytes of a binary glTF 2.0 file (.glb): one node and one mesh a brick, named TILE_00000 and
/// so on, below a node that turns z up into glTF's y up; one animation with a position and a
/// rotation a brick and key. Flat outward faces, one material, single precision. The keys are asked
/// for one by one, in order, the first at time 0; at least one. Throws InputError when they do not
/// fit.
///
/// Written without assimp, whose exporter copies all that it has for each channel: 33 s for 1,600
/// tiles and 121 keys, where this takes a second. Memory: 28 bytes a brick and key, and the file a
/// second time while it is put together.
std::string animationBytes(const std::vector<model::Brick>& bricks, std::size_t keyCount,
                           const std::function<AnimationKey(std::size_t)>& key);

}  // namespace kirireel::writers
