/// What a load path is followed through: the energy of a sheet and the constraints on it as
/// functions of coordinates, and the grips that load it.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "sim/base/geometry.h"

namespace kirireel {

/// A sheet in coordinates q, each a length in length scales or an angle in radians; energies are in
/// joules. Grips are counted from 0; the load is what their moves and forces are in proportion to.
/// Everything is a function of q, load and multipliers alone; objects have no state that a call
/// changes. Vectors have unknowns() or rows() entries.
class LoadedSheet {
 public:
  using Vector = Eigen::VectorXd;
  using Matrix = Eigen::SparseMatrix<double>;

  virtual ~LoadedSheet() = default;

  /// The number of coordinates: length of q, gradient and pull.
  virtual int unknowns() const = 0;
  /// The number of constraints: length of residual, motion and multipliers. Rows may be redundant.
  virtual int rows() const = 0;
  /// How many grips load the sheet.
  virtual std::size_t grips() const = 0;

  /// The coordinates of the sheet as it was built, at the load 0.
  virtual Vector startCoordinates() const = 0;
  /// Where the tiles are; those that give are where they fit best.
  virtual Poses posesAt(const Vector& q) const = 0;

  /// What the sheet holds, joules.
  virtual double energy(const Vector& q) const = 0;
  /// The largest stiffness that a coordinate may meet, joules: what tolerances refer to.
  virtual double stiffnessScale() const = 0;
  /// A stiffness below this part of the largest counts as none.
  virtual double noStiffness() const = 0;
  /// How much heavier constraints weigh than the largest stiffness where equations are factored.
  virtual double constraintWeight() const = 0;
  /// d(energy)/dq less the grips' forces, load * pull(q).
  virtual Vector gradient(const Vector& q, double load) const = 0;
  /// The grips' forces at the load 1.
  virtual Vector pull(const Vector& q) const = 0;
  /// What must be 0, in length scales and radians.
  virtual Vector residual(const Vector& q, double load) const = 0;
  /// Its derivative by q.
  virtual Matrix jacobian(const Vector& q) const = 0;
  /// Minus its derivative by the load.
  virtual Vector motion() const = 0;
  /// The derivative of gradient + jacobian^T multipliers by q.
  /// Symmetric, all entries given.
  virtual Matrix hessian(const Vector& q, double load, const Vector& multipliers) const = 0;

  /// What a grip's displacement is a multiple of in q: metres, or 1 for turns.
  virtual double unit(std::size_t grip) const = 0;
  /// How far a grip has moved since the start, the mean over its handles, metres or radians.
  virtual double displacement(std::size_t grip, const Vector& q) const = 0;
  /// Its derivative along a direction of q.
  virtual double displacementSlope(std::size_t grip, const Vector& q,
                                   const Vector& along) const = 0;
  /// What a grip pulls with along its direction, newtons or N m. Linear in load and multipliers.
  /// Of a grip that moves, minus the sum of its rows' multipliers; of one that pushes, load times
  /// its amount.
  virtual double force(std::size_t grip, double load, const Vector& multipliers) const = 0;
};

}  // namespace kirireel
