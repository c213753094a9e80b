/// What a sheet of tiles is like in one state or two, before any physics.
#pragma once

#include <vector>

#include "sim/model/model.h"

namespace kirireel {

/// Two tiles that lie in each other.
struct TileOverlap {
  int tileA = 0;
  int tileB = 0;
  double depth = 0;  ///< metres: the shortest move in the plane that separates flat neighbours, or
                     ///< how far tiles that cross in space reach through each other
};

/// All pairs that overlap by more than the tolerance in metres, the deepest first; of the first
/// mostPairs() near pairs where there are more.
/// Tiles need an area. Costs a sort, and the edges of both for each pair whose boxes meet.
std::vector<TileOverlap> tileOverlaps(const std::vector<Tile>& tiles, double tolerance);

/// The largest distance between the two corners of a pivot, metres; 0 for none.
/// Of links and fixed joints nothing is said.
double largestJointGap(const std::vector<Joint>& joints, const std::vector<Tile>& tiles);

/// The largest difference of any distance between two vertices of one tile, metres.
/// O(n^2) for a tile of n vertices.
double largestShapeChange(const std::vector<Tile>& start, const std::vector<Tile>& target);

/// The largest distance of a vertex from its tile's plane, metres.
double largestUnevenness(const std::vector<Tile>& tiles);

/// The least sine of the angle by which any tile turns at a corner: above 0 when all are convex.
double leastCornerSine(const std::vector<Tile>& tiles);

}  // namespace kirireel
