/// Connections between two bricks: hinges with their springs, and elastic ligaments.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "sim/base/geometry.h"
#include "sim/brick/brick.h"
#include "sim/brick/pair_force.h"

namespace kirireel::brick {

// ------------------------------------------------------------------------------------------------
// Hinges: the common axis of two bricks, and the torsional springs there.

/// A common axis of rotation of two bricks, with its angle:
///
///   at a corner   the axis goes through the thickness. The angle is between the edges of the two
///                 tiles on the side where they are nearer at the start. If both sides are equal,
///                 it is on the left of the first tile's corner. 0 if the edges are flush.
///   at a fold     the axis lies in the tiles, for example if two corners of an edge are joined.
///                 The angle is FOLD's: 0 if the tiles are flat, positive for a valley
///                 (the fold is on the side of the first tile's normal).
///
/// The angle depends only on the poses. The quaternion's sign changes with each full turn, so
/// angles that differ by one full turn are different. Angles that differ by two full turns are
/// equal: the angle is continuous within one full turn to both sides of the middle of least and
/// most. A run ends before it leaves them, see findJump().
struct Hinge {
  int brickA = 0;                   ///< number, zero-based
  int brickB = 0;                   ///< number, zero-based
  Vector3 axis = Vector3::UnitZ();  ///< unit, in the axes of brick A; B turns about it
  double start = 0;                 ///< the angle at the start, radians
  double least = 0;                 ///< radians; below it, bricks without thickness overlap
  double most = 0;                  ///< radians; the same above it
  int cornerA = kNoCorner;          ///< of a hinge at a corner: the corner of brick A's tile
  int cornerB = kNoCorner;          ///< the same for brick B
};

/// A linear torsional spring with a parallel dashpot:
///   moment = stiffness (rest - angle) - damping d(angle)/dt.
struct HingeSpring {
  Hinge hinge;           ///< axis of the spring
  double stiffness = 0;  ///< N m/rad, >= 0
  double rest = 0;       ///< radians
  double damping = 0;    ///< N m s/rad, >= 0
};

/// Result of findHinges().
struct FoundHinges {
  std::vector<Hinge> hinges;                    ///< in the order of their first pivots
  std::vector<std::pair<int, int>> ballJoints;  ///< bricks that share only one point, in space
};

/// The hinges between bricks at their start poses: pairs that share the points of one line, or one
/// point in a planar scene. Pairs that share more are rigid. Links have no axis. O(pivots log
/// pivots). `bricks` must be at the start, with parallel axes.
FoundHinges findHinges(const std::vector<Brick>& bricks, std::span<const Pivot> pivots,
                       bool planar);

/// The hinge's angle at these poses, radians.
double hingeAngle(const Hinge& hinge, const Poses& poses);

/// The rate at which the hinge's angle grows at this motion of the bricks, rad/s.
double hingeRate(const Hinge& hinge, const Motion& motion);

/// The moment of each spring at rest at these poses, N m, positive towards larger angles. One per
/// spring, in the same order. Damping is not included.
std::vector<double> hingeMoments(std::span<const HingeSpring> springs, const Poses& poses);

/// Stored energy of the springs at these poses, joules: sum of stiffness (angle - rest)^2 / 2.
double elasticEnergy(std::span<const HingeSpring> springs, const Poses& poses);

/// The springs of all hinges as one force. The time step treats them as rows of its linear system,
/// since their moments are linear in the angles.
class HingeSprings : public PairForce {
 public:
  /// Names in files and summaries.
  static constexpr PairForceName kName{"hinges", "springs", "springs at {} hinges"};

  /// Keeps the order of the springs.
  explicit HingeSprings(std::vector<HingeSpring> springs) : springs_(std::move(springs)) {}
  /// Reads the springs of a file. Throws InputError.
  static std::shared_ptr<const PairForce> read(const PairReader& file);

  const PairForceName& name() const override { return kName; }
  std::size_t size() const override { return springs_.size(); }
  std::pair<int, int> bricks(std::size_t pair) const override;
  double energy(std::size_t pair, const Poses& poses) const override;
  /// The Hessian without the term of the rotating axes, which is zero for a closed hinge.
  PairEnergy derivatives(std::size_t pair, const Poses& poses) const override;
  void addForces(const Motion& motion, std::vector<Vector6>& forces) const override;
  /// An angle jumps if its bricks turned by more than a full turn past the middle of their range.
  std::optional<std::pair<int, int>> findJump(const Poses& from, const Poses& to) const override;
  std::vector<PairColumn> columns() const override;
  const std::vector<HingeSpring>* hingeSprings() const override { return &springs_; }
  /// Energy of all pairs.
  using PairForce::energy;

 private:
  std::vector<HingeSpring> springs_;
};

/// The springs at hinges among these forces; empty if there are none.
const std::vector<HingeSpring>& hingeSpringsOf(const PairForces& forces);

// ------------------------------------------------------------------------------------------------
// Elastic ligaments in place of exact joints: stretching and shear of a neck, in the plane. The
// spring at its hinge models its bending.

/// A straight neck between a point of one brick and a point of another. A ligament of length 0 is
/// an elastic pin: its two points coincide at the start and can separate or slide along a slit.
struct Ligament {
  int brickA = 0;                    ///< number, zero-based
  int brickB = 0;                    ///< number, zero-based
  int joint = 0;                     ///< of the model, see Pivot
  Vector3 pointA = Vector3::Zero();  ///< in the axes of brick A
  Vector3 pointB = Vector3::Zero();  ///< in the axes of brick B
  /// From point A to point B at the start, world axes, metres; zero for a pin.
  Vector3 start = Vector3::UnitX();
  Vector3 across = Vector3::UnitX();  ///< of a pin: unit, direction of its opening at the start
  Vector3 normal = Vector3::UnitZ();  ///< unit, of the plane of motion of the bricks, world axes
  double stretchStiffness = 0;        ///< N/m
  double shearStiffness = 0;          ///< N m/rad; N/m for a pin
  /// Moment of a pin in addition to its hinge's spring, opening[0] a^2 + opening[1] a^3. a is the
  /// turn of brick B relative to A since the start about the normal; N m/rad^2, N m/rad^3.
  std::array<double, 2> opening = {};

  /// Whether its length is 0.
  bool isPin() const { return start.isZero(); }

  static constexpr auto fields() {
    return describeFields<Ligament>(
        field("brick_a", &Ligament::brickA), field("brick_b", &Ligament::brickB),
        field("joint", &Ligament::joint), field("point_a", &Ligament::pointA, "m"),
        field("point_b", &Ligament::pointB, "m"), field("start", &Ligament::start, "m"),
        field("across", &Ligament::across), field("normal", &Ligament::normal),
        field("stretch_stiffness", &Ligament::stretchStiffness, "N/m"),
        field("shear_stiffness", &Ligament::shearStiffness), field("opening", &Ligament::opening));
  }
};

/// Sets the stiffnesses of a neck as a Timoshenko beam. With A = w t, I = t w^3 / 12,
/// G = E / (2 (1 + nu)) and the shear factor 5/6:
///   stretch = E A / L,   1 / shear = L / (12 E I) + 1 / (5/6 G A L).
/// Metres, Pa; all positive. The tiles at both ends are assumed rigid.
void setNeckStiffness(double youngs, double poisson, double thickness, double width, double length,
                      Ligament& ligament);

/// The energy of a ligament with normal z, and its derivatives by the positions of both centres of
/// mass and the turns of both bricks since the start. `armA`, `armB`: from the centres to the
/// ligament's points, rotated with the bricks; world axes. `between`: from the centre of brick A to
/// that of B, metres. The Hessian is symmetric but can be indefinite.
PlanarEnergy ligamentEnergy(const Ligament& ligament, const Vector3& between, const Vector3& armA,
                            const Vector3& armB, double turnA, double turnB);

/// The same at poses whose rotations are turns about the normal since the start. The relative turn
/// must be less than half a turn. Derivatives are in the axes of frameAlong(normal).
PlanarEnergy ligamentEnergy(const Ligament& ligament, const Poses& poses);

/// Stored energy of the ligaments at these poses, joules.
double elasticEnergy(std::span<const Ligament> ligaments, const Poses& poses);

/// All ligaments as one force.
class Ligaments : public PairForce {
 public:
  /// Names in files and summaries.
  static constexpr PairForceName kName{"ligaments", "ligaments", "{} ligaments"};

  /// Keeps the order of the ligaments.
  explicit Ligaments(std::vector<Ligament> ligaments) : ligaments_(std::move(ligaments)) {}
  /// Reads the ligaments of a file. Throws InputError.
  static std::shared_ptr<const PairForce> read(const PairReader& file);

  const PairForceName& name() const override { return kName; }
  std::size_t size() const override { return ligaments_.size(); }
  std::pair<int, int> bricks(std::size_t pair) const override;
  double energy(std::size_t pair, const Poses& poses) const override;
  /// By the three planar coordinates of each brick. Entries of other coordinates are 0.
  PairEnergy derivatives(std::size_t pair, const Poses& poses) const override;
  int joint(std::size_t pair) const override { return ligaments_[pair].joint; }
  std::vector<PairColumn> columns() const override;
  const std::vector<Ligament>* ligaments() const override { return &ligaments_; }
  /// Energy of all pairs.
  using PairForce::energy;

 private:
  std::vector<Ligament> ligaments_;
};

/// The ligaments among these forces; empty if there are none.
const std::vector<Ligament>& ligamentsOf(const PairForces& forces);

// ------------------------------------------------------------------------------------------------
// Springs and ligaments together: a neck is a ligament with a spring at its hinge.

/// Moments on two bricks about the axis of their hinge, N m.
struct EndMoments {
  int brickA = 0;  ///< number, zero-based
  int brickB = 0;  ///< number, zero-based
  double onA = 0;
  double onB = 0;
};

/// The moments of each spring at rest. The two moments of a spring are equal and opposite. A
/// ligament between the two bricks adds its moment about its end at each brick: half of shear
/// stiffness times shear angle, with the same sign on both. The sums are the moments that both ends
/// of a neck carry.
std::vector<EndMoments> endMoments(const PairForces& forces, const Poses& poses);

/// Pair forces at the start and the end of a run.
struct Elasticity {
  /// Number of pairs of each force, by PairForceName::counted.
  std::vector<std::pair<std::string, int>> counts;
  double energyStart = 0;  ///< of all forces, joules
  double energyEnd = 0;    ///< joules
  double momentEnd = 0;    ///< largest absolute value of endMoments() at the end, N m

  /// Number of pairs of the force with this name.
  int count(const std::string& name) const;

  static constexpr auto fields() {
    return describeFields<Elasticity>(field("counts", &Elasticity::counts),
                                      field("energy_start", &Elasticity::energyStart, "J"),
                                      field("energy_end", &Elasticity::energyEnd, "J"),
                                      field("moment_end", &Elasticity::momentEnd, "N m"));
  }
};

/// The elasticity of a run with these start and end poses.
Elasticity elasticityOf(const PairForces& forces, const Poses& start, const Poses& end);

}  // namespace kirireel::brick
