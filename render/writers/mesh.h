/// Bricks as surface meshes, for modelling and simulation programs. No assimp header is needed to
/// use it.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/base/length_unit.h"
#include "sim/brick/brick.h"

namespace kirireel::writers {

/// Writes all bricks (at least one) at the given poses. The ending of the path selects the format:
/// - .obj: one group per brick named TILE_00000 and so on, polygons, flat normals;
/// - .ply: one mesh, ASCII, triangles, vertices shared within a brick, no normals;
/// - .stl: triangles, binary, each with its own outward normal.
///
/// Every brick is closed, outward, and separate from touching neighbours: a joint would otherwise
/// be an edge of four faces. Coordinates are in the unit, which a comment in the file states.
/// Except in STL (single precision) they read back bitwise equal. Throws InputError for another
/// ending, OutputError if the file cannot be written, Interrupted if the user ends the program.
/// `poses` has one pose per brick. The text is built in memory.
void writeMesh(const std::filesystem::path& path, const std::vector<brick::Brick>& bricks,
               const Poses& poses, const LengthUnit& unit = {});

/// The version of assimp in use, e.g. "5.2.5".
std::string meshLibraryVersion();

// ------------------------------------------------------------------------------------------------
// A whole deployment as an animated glTF scene, for viewers and presentations.

/// The poses of all bricks at one time. The poses are those of the bricks' centres of mass, in
/// their order.
struct AnimationKey {
  double time = 0;  ///< seconds, ascending
  Poses poses;      ///< one per brick
};

/// The bytes of a binary glTF 2.0 file (.glb): one node and one mesh per brick, named TILE_00000
/// and so on, below a node that rotates z up to glTF's y up, and one animation with a position and
/// a rotation per brick and key. Flat outward faces, one material, single precision. The keys are
/// requested one by one, in order, the first at time 0; at least one. Throws InputError if they do
/// not fit.
///
/// Written without assimp, whose exporter copies all data for each channel: 33 s for 1,600 tiles
/// and 121 keys, in contrast to one second here. Memory: 28 bytes per brick and key, and a second
/// copy of the file during its composition.
std::string animationBytes(const std::vector<brick::Brick>& bricks, std::size_t keyCount,
                           const std::function<AnimationKey(std::size_t)>& key);

}  // namespace kirireel::writers
