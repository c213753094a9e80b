/// The energy of a planar sheet of rigid tiles with springs and ligaments between them, and the
/// constraints on it, as functions of three coordinates a tile.
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "sim/brick/brick.h"
#include "sim/brick/hinge.h"
#include "sim/equilibrium/ligament.h"

namespace kirireel {

/// What a grip holds of a brick: a point, or its turn.
struct GripHandle {
  int brick = 0;
  Vector3 point = Vector3::Zero();  ///< in the brick's axes
  bool isTurn = false;
};

/// What moves or pushes parts of the sheet, in proportion to the load: a number from 0 on.
struct Grip {
  std::vector<GripHandle> handles;       ///< one or more
  Vector3 direction = Vector3::UnitX();  ///< unit, in the plane; of no meaning for turns
  /// At the load 1: by how much each handle is moved along the direction since the start (metres,
  /// radians), or with how much all of them together are pushed (newtons, N m; a dead load, which
  /// keeps its direction).
  double amount = 0;
  bool isForce = false;
};

/// A sheet in the plane. Its coordinates q are x and y of each brick's centre of mass in length
/// scales and the brick's turn about z since the start in radians; energies are in joules.
class ElasticSheet {
 public:
  using Vector = Eigen::VectorXd;
  using Matrix = Eigen::SparseMatrix<double>;

  /// `pinned`: the tiles that stay where they are. Pivots must be of joints that are exact: links
  /// are not known, and ligaments take the place of others.
  ElasticSheet(const std::vector<Brick>& bricks, Poses start, std::vector<HingeSpring> springs,
               const std::vector<Pivot>& pivots, const std::vector<int>& pinned,
               std::vector<Grip> grips, std::vector<Ligament> ligaments = {});

  int unknowns() const { return 3 * static_cast<int>(start_.size()); }
  int rows() const { return static_cast<int>(rows_.size()); }
  const std::vector<Grip>& grips() const { return grips_; }

  Vector startCoordinates() const;
  Poses posesAt(const Vector& q) const;

  /// What springs and ligaments hold, joules.
  double energy(const Vector& q) const;
  /// The largest stiffness that a coordinate may meet, joules: what tolerances refer to.
  double stiffnessScale() const;
  /// d(energy)/dq less the grips' forces, load * pull(q).
  Vector gradient(const Vector& q, double load) const;
  /// The grips' forces at the load 1.
  Vector pull(const Vector& q) const;
  /// What must be 0: pivots in length scales, pins, and grips that move.
  Vector residual(const Vector& q, double load) const;
  /// Its derivative by q.
  Matrix jacobian(const Vector& q) const;
  /// Minus its derivative by the load.
  Vector motion() const;
  /// The derivative of gradient + jacobian^T multipliers by q.
  Matrix hessian(const Vector& q, double load, const Vector& multipliers) const;

  /// What a grip's displacement is a multiple of in q: metres, or 1 for turns.
  double unit(const Grip& grip) const { return grip.handles.front().isTurn ? 1 : scale_; }
  /// How far a grip has moved since the start, the mean over its handles, metres or radians.
  double displacement(const Grip& grip, const Vector& q) const;
  /// Its derivative along a direction of q.
  double displacementSlope(const Grip& grip, const Vector& q, const Vector& along) const;
  /// What a grip pulls with along its direction, newtons or N m. Linear in load and multipliers.
  double force(std::size_t grip, double load, const Vector& multipliers) const;

 private:
  /// A part of a constraint: the place of a handle along a direction, times a factor.
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

  void addRow(std::vector<Term> terms, double motion, const Vector& start);
  Vector3 arm(const GripHandle& handle, const Vector& q) const;
  double place(const Term& term, const Vector& q) const;
  Vector3 slope(const Term& term, const Vector& q) const;
  double bend(const Term& term, const Vector& q) const;
  std::vector<Term> forceTerms(const Grip& grip) const;
  LigamentEnergy energyOf(const Ligament& ligament, const Vector& q) const;

  Poses start_;
  std::vector<HingeSpring> springs_;
  std::vector<Grip> grips_;
  std::vector<Ligament> ligaments_;
  double scale_;  // metres
  std::vector<Row> rows_;
  std::vector<std::size_t> firstRow_;  // of each grip, where it moves
};

}  // namespace kirireel
