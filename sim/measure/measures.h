/// How accurate a state is: figures that every summary states. Nothing here knows a solver.
#pragma once

#include <map>
#include <span>
#include <utility>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/brick/brick.h"
#include "sim/model/model.h"

namespace kirireel {

/// Distances between the two sides of pivots, metres.
struct JointGap {
  double max = 0;
  double mean = 0;
};

/// Gaps of all pivots at the given poses; zeros when there are none.
JointGap jointGap(std::span<const Pivot> pivots, const Poses& poses);

/// The largest distance of any bottom vertex from its target, metres; 0 for no tiles.
double targetError(const std::vector<Tile>& target, const std::vector<Brick>& bricks,
                   const Poses& poses);

/// A true lower bound of the target error of rigid tiles, metres: the largest of the tiles' own
/// minimax errors, each tile moved by itself (never mirrored) so that its farthest vertex is as
/// near as can be. See rigid_bound.cpp. 0 for no tiles.
double rigidBound(const std::vector<Tile>& tiles, const std::vector<Tile>& target);

/// Two bricks that overlap.
struct Penetration {
  double depth = 0;  ///< the shortest move that separates them, metres; 0 when nothing overlaps
  int brickA = -1;
  int brickB = -1;
};

/// The deepest overlap of any pair, by the separating axes of convex prisms (face normals and
/// products of edges): exact for convex tiles and independent of the contact detection in use.
Penetration deepestPenetration(const std::vector<Brick>& bricks, const Poses& poses);

/// The same with joined bricks meeting without the corners that they share: what contacts hold
/// apart. `zone` as in withoutSharedCorners.
Penetration deepestPenetrationOutsidePivots(const std::vector<Brick>& bricks,
                                            std::span<const Pivot> pivots, double zone,
                                            const Poses& poses);

/// All pairs that overlap by more than `least` metres in this sense, the deepest first; the smaller
/// brick number is brickA.
std::vector<Penetration> penetrationsOutsidePivots(const std::vector<Brick>& bricks,
                                                   std::span<const Pivot> pivots, double zone,
                                                   const Poses& poses, double least);

/// How much deeper bricks overlap than at the start of a run, where some models' bricks do: what
/// contacts have to prevent.
class PenetrationGrowth {
 public:
  /// Deepest, and how much deeper than at the start, of any pairs, metres, from 0.
  struct Depths {
    double deepest = 0;
    double grown = 0;
  };

  /// As penetrationsOutsidePivots(), whose `least` is for overlaps at the start. Bricks and pivots
  /// must outlive this.
  PenetrationGrowth(const std::vector<Brick>& bricks, std::span<const Pivot> pivots, double zone,
                    const Poses& start, double least);

  Depths at(const Poses& poses) const;

 private:
  const std::vector<Brick>& bricks_;
  std::span<const Pivot> pivots_;
  double zone_;
  std::map<std::pair<int, int>, double> atStart_;  // metres
};

/// Kinetic energy of all bricks, joules.
double kineticEnergy(const std::vector<Brick>& bricks, const Motion& motion);

}  // namespace kirireel
