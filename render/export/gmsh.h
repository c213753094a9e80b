/// Gmsh meshes of bricks.
#pragma once

#include <string>
#include <vector>

#include "render/export/deck.h"
#include "render/export/element_mesh.h"

namespace kirireel {

/// The text of a Gmsh 4.1 mesh with one physical group a kind: the volumes TILES (and NECKS), the
/// surfaces BOTTOM and TOP, the points JOINTS where joined tiles share nodes. Tile t is the entity
/// t + 1 of its volume, its faces the entities 3 t + 1 and 3 t + 2, and each node of a joint an
/// entity of its own. No element stands in it twice. With SetChoice::All or Joints the nodes of
/// each joint have a group (JOINT_00000_A, _B) besides, with All each tile and its faces too
/// (TILE_00000, _SBOT, _STOP) and the surfaces SIDES (_SIDE, entity 3 t + 3). Gmsh reads thousands
/// of groups slowly. Coordinates in metres, to the last bit but at shut slits, where nodes that
/// would lie in one place stand apart (separatedNodes), so that no program welds them. Lengths stay
/// in metres whatever a deck's unit. All of the text is built in memory.
std::string gmshMesh(const ElementMesh& mesh, SetChoice sets = SetChoice::Usual);

// ------------------------------------------------------------------------------------------------
// Nodes in one place, drawn apart.

/// The positions of a mesh's nodes, metres, with those that lie in one place drawn apart: each 1e-7
/// of the sheet's size (the diagonal of its box) into the elements that it belongs to. Slits that
/// are shut have nodes in one place on both sides, to which programs that look for duplicate nodes
/// object, and which those that merge nodes would weld: Gmsh takes what differs by up to 2e-8 of
/// the size in each coordinate for one place. All other positions stay as they are. As many as the
/// mesh has. Where nodes still coincide after four passes they are left so.
std::vector<Vector3> separatedNodes(const ElementMesh& mesh);

}  // namespace kirireel
