/// The energy and the constraints of a planar sheet of rigid tiles with springs and ligaments, as
/// functions of three coordinates per tile.
#pragma once

#include <vector>

#include "sim/brick/brick.h"
#include "sim/brick/hinge.h"
#include "sim/brick/pair_force.h"
#include "sim/mechanics/load_path.h"

namespace kirireel::statics {

/// The part of a brick that a grip holds: a point or the rotation.
struct GripHandle {
  int brick = 0;                    ///< index >= 0
  Vector3 point = Vector3::Zero();  ///< in the brick's axes
  bool isTurn = false;              ///< true: holds the rotation, not the point
};

/// Moves or forces on parts of the sheet, in proportion to the load (>= 0).
struct Grip {
  std::vector<GripHandle> handles;  ///< one or more
  /// A direction in the plane; unused for rotations. It is shorter than 1 if it is the projection
  /// of an axis that leaves the plane. Amounts and forces are then along that axis.
  Vector3 direction = Vector3::UnitX();
  /// Value at load 1. A move displaces each handle by it along the direction since the start
  /// (metres, radians). A force is the total on all handles (newtons, N m). It keeps its direction.
  double amount = 0;
  bool isForce = false;  ///< true: a force, false: a move
  /// The sum of multipliers that is this grip's force. It is needed if other grips move the same
  /// handles along dependent directions, since multipliers are then not unique. Empty: its own
  /// multipliers.
  mechanics::GripSum force = {};
};

/// A sheet in the plane. Its coordinates are x and y of the displacement of each brick's centre of
/// mass in length scales, and the brick's rotation about z in radians, both since the start.
class ElasticSheet : public mechanics::LoadedSheet {
 public:
  /// `pinned`: the fixed tiles. Pivots must belong to exact joints: links are not supported, and
  /// ligaments replace the other joints. The length scale is the mean edge of the first brick.
  /// Tiles, bricks and poses have the same order.
  ElasticSheet(const std::vector<brick::Brick>& bricks, Poses start,
               const brick::PairForces& pairForces, const std::vector<brick::Pivot>& pivots,
               const std::vector<int>& pinned, std::vector<Grip> grips);

  int unknowns() const override { return 3 * static_cast<int>(start_.size()); }
  int rows() const override { return static_cast<int>(rows_.size()); }
  std::size_t grips() const override { return grips_.size(); }
  mechanics::RowRange rowsOf(std::size_t grip) const override;
  Vector startCoordinates() const override;
  Poses posesAt(const Vector& q) const override;
  double energy(const Vector& q) const override;
  double stiffnessScale() const override { return stiffness_; }
  Vector gradient(const Vector& q, double load) const override;
  Vector pull(const Vector& q) const override;
  /// Pivots in length scales, pins, and grips that move.
  Vector residual(const Vector& q, double load) const override;
  Matrix jacobian(const Vector& q) const override;
  Vector motion() const override;
  Matrix hessian(const Vector& q, double load, const Vector& multipliers) const override;
  double unit(std::size_t grip) const override;
  double displacement(std::size_t grip, const Vector& q) const override;
  double displacementSlope(std::size_t grip, const Vector& q, const Vector& along) const override;
  double force(std::size_t grip, double load, const Vector& multipliers) const override;

 private:
  /// A term of a constraint: the position of a handle along a direction, times a factor.
  struct Term {
    GripHandle handle;
    Vector3 direction;
    double factor = 1;
  };
  /// sum of terms = offset + load * motion.
  struct Row {
    std::vector<Term> terms;
    double offset = 0;
    double motion = 0;
  };

  /// Energy of a pair of bricks, in their coordinates.
  struct PairPart {
    int brickA = 0;
    int brickB = 0;
    brick::PlanarEnergy energy;
  };

  double largestStiffness() const;
  void addRow(std::vector<Term> terms, double motion, const Vector& start);
  Vector3 centreDistance(int brickA, int brickB) const;
  Vector3 arm(const GripHandle& handle, const Vector& q) const;
  double place(const Term& term, const Vector& q) const;
  Vector3 slope(const Term& term, const Vector& q) const;
  double bend(const Term& term, const Vector& q) const;
  std::vector<Term> forceTerms(const Grip& grip) const;
  double multiplierForce(std::size_t grip, const Vector& multipliers) const;
  brick::PlanarEnergy inLengthScales(brick::PlanarEnergy energy) const;
  brick::PlanarEnergy energyOf(const brick::Ligament& ligament, const Vector& q) const;
  std::vector<PairPart> pairParts(const Vector& q) const;

  Poses start_;
  std::vector<brick::HingeSpring> springs_;
  std::vector<Grip> grips_;
  std::vector<brick::Ligament> ligaments_;
  brick::PairForces others_;  // neither springs nor ligaments
  double scale_;              // metres
  double stiffness_;          // the largest of a coordinate, joules
  std::vector<Row> rows_;
  std::vector<Eigen::Index> firstRow_;  // of each grip
};

}  // namespace kirireel::statics
