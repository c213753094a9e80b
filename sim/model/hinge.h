/// What joins two bricks: hinges with their springs, and elastic ligaments.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "sim/base/geometry.h"
#include "sim/model/brick.h"
#include "sim/model/pair_force.h"

namespace kirireel::model {

// ------------------------------------------------------------------------------------------------
// Hinges: where two bricks turn about one axis, and the torsional springs that may be there.

/// Two bricks that turn against each other about one axis, by an angle:
///
///   at a corner   the axis goes through the thickness; the angle is that between the two tiles'
///                 edges on the side where they are nearer at the start (on both alike: on the left
///                 of the first tile's corner), 0 where they lie flush;
///   at a fold     the axis lies in the tiles, as where two corners of an edge are joined; the
///                 angle is FOLD's: 0 where the tiles are flat, positive where the first tile's
///                 face, seen along its normal, is within (a valley).
///
/// The angle follows from the poses. It is continuous along a run: the sign of a rotation's
/// quaternion changes with each full turn, so an angle and the one a full turn on differ. Angles
/// that differ by two full turns do not.
struct Hinge {
  int brickA = 0;                   ///< its number, from 0
  int brickB = 0;                   ///< its number, from 0
  Vector3 axis = Vector3::UnitZ();  ///< unit, in the axes of brick A: B turns by it as angles grow
  double start = 0;                 ///< the angle at the start, radians
  double least = 0;                 ///< below this, bricks without thickness lie in each other
  double most = 0;                  ///< and above this
  int cornerA = kNoCorner;          ///< of a hinge at a corner: that of brick A's tile
  int cornerB = kNoCorner;          ///< likewise of brick B's
};

/// A linear torsional spring with a dashpot beside it, which pull with
///   moment = stiffness (rest - angle) - damping d(angle)/dt.
struct HingeSpring {
  Hinge hinge;           ///< where it pulls
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

/// The springs of all hinges as one force. A step takes them as rows, since their moments are
/// linear in the angles.
class HingeSprings : public PairForce {
 public:
  /// What files and summaries call it.
  static constexpr PairForceName kName{"hinges", "springs", "springs at {} hinges"};

  /// Of these springs, in their order.
  explicit HingeSprings(std::vector<HingeSpring> springs) : springs_(std::move(springs)) {}
  /// Those of a file. Throws InputError.
  static std::shared_ptr<const PairForce> read(const PairReader& file);

  const PairForceName& name() const override { return kName; }
  std::size_t size() const override { return springs_.size(); }
  std::pair<int, int> bricks(std::size_t pair) const override;
  double energy(std::size_t pair, const Poses& poses) const override;
  /// The hessian without what the turning of axes adds, which a hinge that is closed does not feel.
  PairEnergy derivatives(std::size_t pair, const Poses& poses) const override;
  void addForces(const Motion& motion, std::vector<Vector6>& forces) const override;
  std::vector<PairColumn> columns() const override;
  const std::vector<HingeSpring>* hingeSprings() const override { return &springs_; }
  /// Of all pairs too.
  using PairForce::energy;

 private:
  std::vector<HingeSpring> springs_;
};

/// The springs at hinges among these forces; empty where there are none.
const std::vector<HingeSpring>& hingeSpringsOf(const PairForces& forces);

// ------------------------------------------------------------------------------------------------
// Elastic ligaments in place of exact joints: what stretching and shearing a neck costs. Its
// bending is that of the spring at its hinge. In the plane.

/// A straight neck between a point of one brick and a point of another; without a length a pin that
/// gives: two points that are one at the start, and part across a slit or slide along it.
struct Ligament {
  int brickA = 0;                    ///< its number, from 0
  int brickB = 0;                    ///< its number, from 0
  int joint = 0;                     ///< of the model, see Pivot
  Vector3 pointA = Vector3::Zero();  ///< in the axes of brick A
  Vector3 pointB = Vector3::Zero();  ///< in the axes of brick B
  /// From point A to point B at the start, world axes, metres; zero for a pin.
  Vector3 start = Vector3::UnitX();
  Vector3 across = Vector3::UnitX();  ///< of a pin: unit, where its points part, at the start
  Vector3 normal = Vector3::UnitZ();  ///< unit, of the plane that the bricks move in, world axes
  double stretchStiffness = 0;        ///< N/m
  double shearStiffness = 0;          ///< N m/rad; of a pin N/m
  /// Of a pin, what the moment is beyond its hinge's spring: opening[0] a^2 + opening[1] a^3 with a
  /// the turn of brick B against A since the start, about the normal; N m/rad^2, N m/rad^3.
  std::array<double, 2> opening = {};

  /// Whether it has no length.
  bool isPin() const { return start.isZero(); }

  /// For files; see base/fields.h.
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

/// The stiffnesses of a neck as a beam of Timoshenko's: with A = w t, I = t w^3 / 12, G = E / (2 (1
/// + nu)) and the shear factor 5/6
///   stretch = E A / L,   1 / shear = L / (12 E I) + 1 / (5/6 G A L).
/// Metres, Pa; all positive. The tiles at its ends are taken for rigid in this.
void setNeckStiffness(double youngs, double poisson, double thickness, double width, double length,
                      Ligament& ligament);

/// The energy of a ligament whose normal is z, and its derivatives.
/// At the places of both bricks' centres of mass and their turns since the start. `armA`, `armB`:
/// the points from there, turned with the bricks; world axes.
/// `between`: from the centre of brick A to that of B, metres. The Hessian is symmetric and may be
/// indefinite.
PlanarEnergy ligamentEnergy(const Ligament& ligament, const Vector3& between, const Vector3& armA,
                            const Vector3& armB, double turnA, double turnB);

/// At poses whose rotations are turns about the normal since the start. Bricks turn by less than
/// half a turn against each other. Derivatives are in the axes of frameAlong(normal).
PlanarEnergy ligamentEnergy(const Ligament& ligament, const Poses& poses);

/// What ligaments hold at these poses, joules.
double elasticEnergy(std::span<const Ligament> ligaments, const Poses& poses);

/// All ligaments as one force.
class Ligaments : public PairForce {
 public:
  /// What files and summaries call it.
  static constexpr PairForceName kName{"ligaments", "ligaments", "{} ligaments"};

  /// Of these ligaments, in their order.
  explicit Ligaments(std::vector<Ligament> ligaments) : ligaments_(std::move(ligaments)) {}
  /// Those of a file. Throws InputError.
  static std::shared_ptr<const PairForce> read(const PairReader& file);

  const PairForceName& name() const override { return kName; }
  std::size_t size() const override { return ligaments_.size(); }
  std::pair<int, int> bricks(std::size_t pair) const override;
  double energy(std::size_t pair, const Poses& poses) const override;
  /// By the three coordinates of each brick in the plane; what leaves the plane is 0.
  PairEnergy derivatives(std::size_t pair, const Poses& poses) const override;
  int joint(std::size_t pair) const override { return ligaments_[pair].joint; }
  std::vector<PairColumn> columns() const override;
  const std::vector<Ligament>* ligaments() const override { return &ligaments_; }
  /// Of all pairs too.
  using PairForce::energy;

 private:
  std::vector<Ligament> ligaments_;
};

/// The ligaments among these forces; empty where there are none.
const std::vector<Ligament>& ligamentsOf(const PairForces& forces);

// ------------------------------------------------------------------------------------------------
// Springs and ligaments together: a neck is a ligament, and the spring at its hinge.

/// The moments on both bricks of each spring's hinge, N m, about the hinge's axis: on brick A, then
/// on brick B, at rest. Those of the spring alone are opposite and equal. A ligament between the
/// two adds its own about its end at each brick, so that these are what a neck's ends carry: as a
/// beam that is sheared, each end carries half of shear stiffness times angle more, or less.
std::vector<std::array<double, 2>> endMoments(std::span<const HingeSpring> springs,
                                              std::span<const Ligament> ligaments,
                                              const Poses& poses);

/// What forces between pairs of bricks hold at the two ends of a run.
struct Elasticity {
  /// How many pairs each force has, by PairForceName::counted.
  std::vector<std::pair<std::string, int>> counts;
  double energyStart = 0;  ///< of all, joules
  double energyEnd = 0;    ///< joules
  double momentEnd = 0;    ///< the largest of endMoments() in size at the end, N m

  /// How many pairs a force has, by the same name.
  int count(const std::string& name) const;

  /// For files; see base/fields.h.
  static constexpr auto fields() {
    return describeFields<Elasticity>(field("counts", &Elasticity::counts),
                                      field("energy_start", &Elasticity::energyStart, "J"),
                                      field("energy_end", &Elasticity::energyEnd, "J"),
                                      field("moment_end", &Elasticity::momentEnd, "N m"));
  }
};

/// The elasticity of a run that begins and ends in these poses.
Elasticity elasticityOf(const PairForces& forces, const Poses& start, const Poses& end);

}  // namespace kirireel::model
