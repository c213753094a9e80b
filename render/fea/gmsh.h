/// Gmsh meshes of bricks.
#pragma once

#include <string>

#include "render/fea/deck_text.h"
#include "render/fea/element_mesh.h"

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

}  // namespace kirireel
