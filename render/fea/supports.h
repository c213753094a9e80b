/// Which displacements to hold so that a sheet of hinged tiles can stand a static step.
#pragma once

#include <vector>

#include "render/fea/element_mesh.h"

namespace kirireel {

/// A displacement of a node along an axis of the world.
struct NodeDisplacement {
  int node = 0;  ///< from 0
  int axis = 0;  ///< 0, 1, 2: x, y, z
  int tile = 0;  ///< that the node belongs to

  auto operator<=>(const NodeDisplacement&) const = default;
};

/// For each of these tiles displacements of its nodes that fix it as a rigid body: six, which
/// strain nothing, or where no six do so in all turns, all nine of three nodes. They lie on nodes
/// that follow no others and belong to no joint, so that what holds or drives them acts through the
/// joints on the other tiles; where a tile has no such nodes, on nodes of joints. Plane elements
/// have three. `turns` are the rotations that the tiles will have from the mesh's state on, one
/// list a tile, or none. Throws InputError when even these do not fix a tile: all of them follow
/// others. `tiles` counts from 0; one list of displacements a tile, in their order.
std::vector<std::vector<NodeDisplacement>> tileDisplacements(
    const ElementMesh& mesh, const std::vector<int>& tiles,
    const std::vector<std::vector<Quaternion>>& turns = {});

/// The fewest displacements that leave the sheet no way to move without strain, were its tiles
/// rigid: six for the motions of the whole and one for each mechanism of the first order. None of
/// them takes load from another; the reactions follow from equilibrium alone. Where springs stand
/// at all hinges no mechanism is left. `fixedTiles` are held by other means already. Sorted. Throws
/// InputError as tileDisplacements does. Costs a sparse QR factorisation of six unknowns a tile
/// (free_columns.h).
std::vector<NodeDisplacement> leastSupports(const ElementMesh& mesh,
                                            const std::vector<int>& fixedTiles = {});

}  // namespace kirireel
