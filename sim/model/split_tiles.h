/// Tiles that bend: rigid parts hinged along their common edges.
#pragma once

#include <array>
#include <vector>

#include "sim/model/model.h"

namespace kirireel {

/// The triangles that a tile is split into, its corner numbers anticlockwise: by the diagonals from
/// the corner whose diagonals are shortest, concave tiles into ears.
std::vector<std::array<int, 3>> tileTriangles(const Tile& tile);

/// The model with the given tiles, in the numbers of its file, (all, when empty) split into
/// triangles by the diagonals from the corner whose diagonals are shortest, concave ones into ears;
/// triangles stay whole. Parts are joined at both ends of a common diagonal on the bottom face, a
/// hinge. The first part keeps the tile's number, the others follow after the last tile; joints
/// hold the first part that has their corner, targets are split alike, and all parts of a pulled
/// tile are pulled. Throws InputError for a tile that does not exist.
Model splitTiles(const Model& model, const std::vector<int>& tiles);

}  // namespace kirireel
