/// Geometry of a sheet in one or two states, without physics.
#pragma once

#include <vector>

#include "sim/model/model.h"

namespace kirireel::trajectory {

/// Two overlapping tiles.
struct TileOverlap {
  int tileA = 0;     ///< index >= 0
  int tileB = 0;     ///< index >= 0
  double depth = 0;  ///< metres: the shortest move in the plane that separates flat neighbours, or
                     ///< the length by which tiles that cross in space pass through each other
};

/// All pairs that overlap by more than the tolerance in metres, the deepest first. At most the
/// first maxPairs() near pairs are checked. Tiles need an area. Costs a sort, and the edges of both
/// tiles for each pair whose boxes overlap.
std::vector<TileOverlap> tileOverlaps(const std::vector<model::Tile>& tiles, double tolerance);

/// The largest difference of any distance between two vertices of one tile, metres. O(n^2) for a
/// tile of n vertices.
double largestShapeChange(const std::vector<model::Tile>& start,
                          const std::vector<model::Tile>& target);

/// The largest distance of a vertex from its tile's plane, metres.
double largestUnevenness(const std::vector<model::Tile>& tiles);

/// The smallest sine of the exterior angle at any corner of a tile: > 0 if all tiles are convex.
double smallestCornerSine(const std::vector<model::Tile>& tiles);

// ------------------------------------------------------------------------------------------------
// Degrees of freedom of a sheet of rigid tiles, from the rank of its joints' Jacobian.

/// The first-order mobility of one state.
struct Mobility {
  bool isCounted = true;  ///< false: too many unknowns; the rank and its results are unknown
  int unknowns = 0;       ///< 3 per tile in the plane, 6 in space
  int equations = 0;      ///< number of the joints' equations
  int rank = 0;           ///< of the Jacobian (equations x unknowns)
  int freedoms = 0;       ///< motions other than those of the whole as one rigid body
  int redundant = 0;      ///< equations that depend on others
  double smallestKept =
      0;  ///< the smallest singular value that counts towards the rank; 0 for none
  double largestDropped = 0;  ///< the largest one that does not; 0 for none. The ratio of the two
                              ///< shows how certain the rank is.
  /// smallestKept is only a lower bound and largestDropped an upper bound: their exact values are
  /// unknown.
  bool areBounds = false;

  /// Whether all singular values that count are too large to come from a redundant joint of tiles
  /// that do not fit exactly.
  bool isCertain() const { return isCounted && (rank == 0 || smallestKept > model::kMaxMisfit); }
};

/// The space in which tiles may move.
enum class Freedom {
  Plane,  ///< in the plane of a flat sheet, about its normal; else along x and y, about z
  Space,  ///< three dimensions
};

/// Upper limit of singular values that should be zero but are not because of the rounding of the
/// coordinates: ten times the last digit, in tiles.
double zeroSingularValue(const model::Model& model);

/// The mobility of the model's joints with its tiles in the given state, for bricks of this
/// thickness in metres (joints on both faces are hinges). Rotations are measured in tile sizes,
/// which makes singular values plain numbers. Those above 1e-6 of the largest and above
/// zeroSingularValue() count, but not those below a gap of the spectrum that a misfit of the tiles
/// explains: largestDropped is then about the misfit, in tiles. Up to 900 unknowns use a dense
/// singular value decomposition. Above, it counts the pivots' signs of J^T J - s^2 (Sylvester's law
/// of inertia), which bounds singular values by powers of ten. More than 60,000 unknowns, as of
/// 10,000 tiles in space, are not counted: that takes minutes. For rank and freedom of links, fixed
/// joints and pivots alike. Throws Interrupted if the scope allows interruption.
Mobility mobility(const model::Model& model, const std::vector<model::Tile>& state, Freedom freedom,
                  double thickness);

}  // namespace kirireel::trajectory
