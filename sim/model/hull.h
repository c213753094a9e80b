/// The outside of a sheet.
#pragma once

#include <vector>

#include "sim/model/model.h"

namespace kirireel {

/// One corner for each vertex on the convex outline of all vertices, seen along z: anticlockwise
/// from the leftmost (the lowest of these). Of corners at one point the first counts.
/// Heights do not matter. At least one tile; costs O(n log n) for n vertices.
std::vector<Corner> outlineCorners(const std::vector<Tile>& tiles);

}  // namespace kirireel
