/// What a sheet of tiles is like in one state or two, before any physics.
#pragma once

#include <vector>

#include "sim/model/model.h"

namespace kirireel::trajectory {

/// Two tiles that lie in each other.
struct TileOverlap {
  int tileA = 0;     ///< its number, >= 0
  int tileB = 0;     ///< its number, >= 0
  double depth = 0;  ///< metres: the shortest move in the plane that separates flat neighbours, or
                     ///< how far tiles that cross in space reach through each other
};

/// All pairs that overlap by more than the tolerance in metres, the deepest first; of the first
/// mostPairs() near pairs where there are more.
/// Tiles need an area. Costs a sort, and the edges of both for each pair whose boxes meet.
std::vector<TileOverlap> tileOverlaps(const std::vector<model::Tile>& tiles, double tolerance);

/// The largest distance between the two corners of a pivot, metres; 0 for none.
/// Of links and fixed joints nothing is said.
double largestJointGap(const std::vector<model::Joint>& joints,
                       const std::vector<model::Tile>& tiles);

/// The largest difference of any distance between two vertices of one tile, metres.
/// O(n^2) for a tile of n vertices.
double largestShapeChange(const std::vector<model::Tile>& start,
                          const std::vector<model::Tile>& target);

/// The largest distance of a vertex from its tile's plane, metres.
double largestUnevenness(const std::vector<model::Tile>& tiles);

/// The least sine of the angle by which any tile turns at a corner: above 0 when all are convex.
double leastCornerSine(const std::vector<model::Tile>& tiles);

// ------------------------------------------------------------------------------------------------
// How many ways a sheet of rigid tiles can move, from the rank of its joints' Jacobian.

/// The first-order mobility of one state.
struct Mobility {
  bool isCounted = true;      ///< false: too many unknowns, what follows from the rank is not known
  int unknowns = 0;           ///< 3 a tile in the plane, 6 in space
  int equations = 0;          ///< that the joints make
  int rank = 0;               ///< of the Jacobian (equations x unknowns)
  int freedoms = 0;           ///< motions beyond those of the whole as one rigid body
  int redundant = 0;          ///< equations that follow from others
  double leastKept = 0;       ///< the least singular value that counts towards the rank; 0 for none
  double largestDropped = 0;  ///< the largest one that does not; 0 for none. The ratio of the two
                              ///< says how certain the rank is.
  /// The least one kept is at least leastKept, the largest one dropped at most largestDropped:
  /// their values are not known.
  bool areBounds = false;
};

/// Where tiles may move.
enum class Freedom {
  Plane,  ///< in the plane of a flat sheet, about its normal; of others, along x and y, about z
  Space,  ///< three dimensions
};

/// The singular value up to which rounding of the model's coordinates explains one that should be
/// zero: ten times the last digit, in tiles.
double zeroSingularValue(const model::Model& model);

/// The mobility of the model's joints with its tiles in the given state, for bricks of this
/// thickness in metres (joints on both faces are hinges). Rotations are measured in tile sizes, so
/// that singular values are plain numbers; those above 1e-6 of the largest and above
/// zeroSingularValue() count. Up to 900 unknowns by a dense singular value decomposition; above, by
/// counting the pivots' signs of J^T J - s^2 (Sylvester's law of inertia), which
/// bounds singular values by powers of ten. More than 60,000 unknowns, as of 10,000 tiles in space,
/// are not counted: that takes minutes. For rank and freedom of links, fixed joints and pivots
/// alike. Throws Interrupted where a scope asks for it.
Mobility mobility(const model::Model& model, const std::vector<model::Tile>& state, Freedom freedom,
                  double thickness);

}  // namespace kirireel::trajectory
