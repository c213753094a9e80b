/// Accuracy figures of a state, as in summary.json. They do not depend on a solver.
#pragma once

#include <algorithm>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/brick/brick.h"
#include "sim/model/model.h"

namespace kirireel::trajectory {

/// Distances between the two sides of pivots, metres.
struct JointGap {
  double max = 0;   ///< metres
  double mean = 0;  ///< over all pivots, metres
};

/// Gaps of all pivots at the given poses; zeros if there are none. If a pose is not finite, the
/// largest gap is NaN.
JointGap jointGap(std::span<const brick::Pivot> pivots, const Poses& poses);

/// The largest distance of any bottom vertex from its target, metres; 0 for no tiles.
double targetError(const std::vector<model::Tile>& target, const std::vector<brick::Brick>& bricks,
                   const Poses& poses);

/// A lower bound of the target error of rigid tiles, metres: the largest of the tiles' own minimax
/// errors. Each tile is moved by itself (never mirrored) to minimise the distance of its farthest
/// vertex. See measures.cpp. 0 for no tiles.
double rigidBound(const std::vector<model::Tile>& tiles, const std::vector<model::Tile>& target);

/// Two bricks that overlap.
struct Penetration {
  double depth = 0;  ///< length of the shortest move that separates them, metres; 0 without overlap
  int brickA = -1;   ///< index >= 0; -1: no bricks overlap
  int brickB = -1;   ///< index of the other brick
};

/// Maximum number of near pairs that are checked in one state. Sheets have far fewer; many bricks
/// in one place may have more.
constexpr long maxPairs(std::size_t bricks) {
  return std::max(1'000'000L, 20 * static_cast<long>(bricks));
}

/// The deepest overlap of any pair, by the separating axes of convex prisms (face normals and
/// products of edges). Exact for convex tiles, and independent of the contact detection. Only the
/// first maxPairs() near pairs are checked, here and below. Costs a sort of all bricks and a few
/// dozen axes for each pair of near bricks.
Penetration deepestPenetration(const std::vector<brick::Brick>& bricks, const Poses& poses);

/// The same for the pairs that contacts keep apart: joined bricks are compared without the corners
/// that they share, and parts of one tile are not compared. `zone` as in cutLength().
Penetration deepestPenetrationOutsidePivots(const std::vector<brick::Brick>& bricks,
                                            std::span<const brick::Pivot> pivots, double zone,
                                            const Poses& poses);

/// All such pairs that overlap by more than `least` metres, the deepest first. brickA is the
/// smaller index.
std::vector<Penetration> penetrationsOutsidePivots(const std::vector<brick::Brick>& bricks,
                                                   std::span<const brick::Pivot> pivots,
                                                   double zone, const Poses& poses, double least);

/// Depths of overlaps in a state, or the largest of several states. Metres, >= 0.
struct PenetrationDepths {
  double whole = 0;          ///< of any two bricks
  double outsidePivots = 0;  ///< the same, with joined bricks without the corners that they share
  double grown = 0;          ///< the same, minus the pair's own depth at the start
};

/// A depth of PenetrationDepths that is not requested: no overlap is deeper, metres.
inline constexpr double kAnyDepth = std::numeric_limits<double>::infinity();

/// Overlaps at the start up to this fraction of a tile count as rounding: their growth is measured
/// from zero.
inline constexpr double kRoundingOverlap = 1e-6;

/// Measures the overlaps of successive states of one run. It stores the best separating axis of
/// each pair and checks it first: similar states cost little. The figures do not depend on the
/// stored axes.
class PenetrationMeter {
 public:
  /// Treats joined bricks as penetrationsOutsidePivots() does. Overlaps at the start of up to
  /// `least` metres count as zero. Keeps a reference to `bricks`. `zone`: see cutLength().
  /// `pivots`: positions of the joints. `countsJoined`: whether joined bricks count. Checks all
  /// near pairs of the start.
  PenetrationMeter(const std::vector<brick::Brick>& bricks, std::span<const brick::Pivot> pivots,
                   double zone, const Poses& start, double least, bool countsJoined = true);
  ~PenetrationMeter();
  PenetrationMeter(const PenetrationMeter&) = delete;
  PenetrationMeter& operator=(const PenetrationMeter&) = delete;

  /// The depths in a state, metres.
  PenetrationDepths at(const Poses& poses) { return atLeast({}, poses); }
  /// PenetrationDepths::grown of a state, or the given value (>= 0) if that is larger, metres.
  double grownAt(const Poses& poses, double known = 0);
  /// The maximum of the given depths and those in a state, metres.
  PenetrationDepths atLeast(const PenetrationDepths& known, const Poses& poses);
  /// For each of some states: the maximum of the given depths and those of all states up to it. The
  /// same bits as atLeast() of each state in turn. If the states belong to one short motion, most
  /// pairs are measured only in the first and the last of them.
  std::vector<PenetrationDepths> atLeastEach(const PenetrationDepths& known,
                                             std::span<const Poses* const> states);

  /// Whether all near pairs of the start could be checked, see maxPairs().
  bool seesAllPairs() const;

 private:
  struct Internals;
  std::unique_ptr<Internals> internals_;
};

/// Kinetic energy of all bricks, joules.
double kineticEnergy(const std::vector<brick::Brick>& bricks, const Motion& motion);

}  // namespace kirireel::trajectory
