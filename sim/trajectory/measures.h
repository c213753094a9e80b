/// How accurate a state is: figures that every summary states. Nothing here knows a solver.
#pragma once

#include <algorithm>
#include <memory>
#include <span>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/model/brick.h"
#include "sim/model/model.h"

namespace kirireel::trajectory {

/// Distances between the two sides of pivots, metres.
struct JointGap {
  double max = 0;   ///< metres
  double mean = 0;  ///< over all pivots, metres
};

/// Gaps of all pivots at the given poses; zeros when there are none.
/// A pose that is no number makes the largest gap no number.
JointGap jointGap(std::span<const model::Pivot> pivots, const Poses& poses);

/// The largest distance of any bottom vertex from its target, metres; 0 for no tiles.
double targetError(const std::vector<model::Tile>& target, const std::vector<model::Brick>& bricks,
                   const Poses& poses);

/// A true lower bound of the target error of rigid tiles, metres: the largest of the tiles' own
/// minimax errors: each tile is moved by itself (never mirrored) to minimise the distance of its
/// farthest vertex. See measures.cpp. 0 for no tiles.
double rigidBound(const std::vector<model::Tile>& tiles, const std::vector<model::Tile>& target);

/// Two bricks that overlap.
struct Penetration {
  double depth = 0;  ///< the shortest move that separates them, metres; 0 when nothing overlaps
  int brickA = -1;   ///< its number; -1: no bricks overlap
  int brickB = -1;   ///< the other's number
};

/// Of the pairs of so many bricks that are near each other, at most so many are looked at in one
/// state: a sheet has far fewer, heaps of bricks in one place may have more.
constexpr long mostPairs(std::size_t bricks) {
  return std::max(1'000'000L, 20 * static_cast<long>(bricks));
}

/// The deepest overlap of any pair, by the separating axes of convex prisms (face normals and
/// products of edges): exact for convex tiles and independent of the contact detection in use. Of
/// the first mostPairs() near pairs, here and below.
/// Costs a sort of all bricks and a few dozen axes for each pair of bricks near each other.
Penetration deepestPenetration(const std::vector<model::Brick>& bricks, const Poses& poses);

/// The same with joined bricks meeting without the corners that they share, and parts of one tile
/// not at all: what contacts hold apart. `zone` as in cutLength.
Penetration deepestPenetrationOutsidePivots(const std::vector<model::Brick>& bricks,
                                            std::span<const model::Pivot> pivots, double zone,
                                            const Poses& poses);

/// All pairs that overlap by more than `least` metres in this sense, the deepest first; the smaller
/// brick number is brickA.
std::vector<Penetration> penetrationsOutsidePivots(const std::vector<model::Brick>& bricks,
                                                   std::span<const model::Pivot> pivots,
                                                   double zone, const Poses& poses, double least);

/// Depths of overlaps in a state, or the largest of several states. Metres, >= 0.
struct PenetrationDepths {
  double whole = 0;          ///< of any two bricks
  double outsidePivots = 0;  ///< the same, joined bricks without the corners that they share
  double grown = 0;          ///< of that, what any pair has beyond its own depth at the start
};

/// Overlaps at the start of a run that are no deeper than this part of a tile are rounding: what
/// comes on top of them counts from zero.
inline constexpr double kRoundingOverlap = 1e-6;

/// Measures the overlaps of one run's states, one after the other. It remembers which axis
/// separated each pair best and checks it first: states close to each other cost little. The
/// figures do not depend on what it remembers.
class PenetrationMeter {
 public:
  /// Joined bricks as in penetrationsOutsidePivots(); overlaps at the start of `least` metres or
  /// less count as none there. Bricks must outlive this.
  /// `zone`: see cutLength(), `pivots`: which bricks are joined, where. `countsJoined`: whether
  /// joined bricks count. Costs a look at all near pairs of the start.
  PenetrationMeter(const std::vector<model::Brick>& bricks, std::span<const model::Pivot> pivots,
                   double zone, const Poses& start, double least, bool countsJoined = true);
  ~PenetrationMeter();
  PenetrationMeter(const PenetrationMeter&) = delete;
  PenetrationMeter& operator=(const PenetrationMeter&) = delete;

  /// The depths in a state.
  PenetrationDepths at(const Poses& poses) { return atLeast({}, poses); }
  /// The larger of each: the depth given, and that in a state.
  PenetrationDepths atLeast(const PenetrationDepths& known, const Poses& poses);

  /// Whether all near pairs of the start could be looked at, see mostPairs().
  bool seesAllPairs() const;

 private:
  struct Internals;
  std::unique_ptr<Internals> internals_;
};

/// Kinetic energy of all bricks, joules.
double kineticEnergy(const std::vector<model::Brick>& bricks, const Motion& motion);

}  // namespace kirireel::trajectory
