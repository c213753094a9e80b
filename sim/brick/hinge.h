/// Hinges: where two bricks turn about one axis, and the torsional springs that may be there.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/brick/brick.h"

namespace kirireel {

/// Two bricks that turn against each other about one axis, by an angle:
///
///   at a corner   the axis goes through the thickness; the angle is that between the two tiles'
///                 edges on the side where they are nearer at the start (on both alike: on the left
///                 of the first tile's corner), 0 where they lie flush;
///   at a fold     the axis lies in the tiles, as where two corners of an edge are joined; the
///                 angle is FOLD's: 0 where the tiles are flat, positive where the first tile's
///                 face, seen along its normal, is within (a valley).
///
/// The angle is told apart from its turns by 2 pi by what bricks can reach without passing through
/// each other, so that it is a function of the poses alone.
struct Hinge {
  int brickA = 0;
  int brickB = 0;
  Vector3 axis = Vector3::UnitZ();  ///< unit, in the axes of brick A: B turns by it as angles grow
  double start = 0;                 ///< the angle at the start, radians
  double least = 0;                 ///< below this, bricks without thickness lie in each other
  double most = 0;                  ///< and above this
};

/// A linear torsional spring with a dashpot beside it, which pull with
///   moment = stiffness (rest - angle) - damping d(angle)/dt.
struct HingeSpring {
  Hinge hinge;
  double stiffness = 0;  ///< N m/rad, from 0
  double rest = 0;       ///< radians
  double damping = 0;    ///< N m s/rad, from 0
};

/// What was found of the joints of bricks.
struct FoundHinges {
  std::vector<Hinge> hinges;                    ///< in the order of their first pivots
  std::vector<std::pair<int, int>> ballJoints;  ///< bricks that share one point alone, in space
};

/// The hinges among bricks at their start poses: each pair that shares the points of one line, or
/// in a planar scene one point. Pairs that share more are rigid, and links turn about no axis.
/// O(pivots log pivots). `bricks` stand as at the start, when all axes are parallel.
FoundHinges findHinges(const std::vector<Brick>& bricks, std::span<const Pivot> pivots,
                       bool planar);

/// The hinge's angle at these poses, radians.
double hingeAngle(const Hinge& hinge, const Poses& poses);

/// The rate at which the hinge's angle grows while the bricks move so, rad/s.
double hingeRate(const Hinge& hinge, const Motion& motion);

/// The moment of each spring at rest at these poses, N m: above 0 where it pulls to larger angles.
/// One a spring, in their order. Dampers are not in it.
std::vector<double> hingeMoments(std::span<const HingeSpring> springs, const Poses& poses);

/// What the springs hold at these poses, joules: the sum of stiffness (angle - rest)^2 / 2.
double elasticEnergy(std::span<const HingeSpring> springs, const Poses& poses);

/// What springs hold at the two ends of a run.
struct Elasticity {
  int springs = 0;         ///< how many
  double energyStart = 0;  ///< joules
  double energyEnd = 0;    ///< joules
  double momentEnd = 0;    ///< the largest of all springs in size at the end, N m
};

Elasticity elasticityOf(std::span<const HingeSpring> springs, const Poses& start, const Poses& end);

}  // namespace kirireel
