/// Gmsh meshes of bricks.
#pragma once

#include <string>

#include "render/fea/element_mesh.h"

namespace kirireel {

/// The text of a Gmsh 2.2 mesh: the solid elements with one physical volume a tile (TILE_00000),
/// its faces as physical surfaces (TILE_00000_SBOT, _STOP) and the nodes of each joint as physical
/// points (JOINT_00000_A, _B). Coordinates read back to the same doubles.
std::string gmshMesh(const ElementMesh& mesh);

}  // namespace kirireel
