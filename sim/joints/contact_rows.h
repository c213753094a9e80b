/// The contacts of one step as rows of the step's system: normal rows that may only push,
/// tangential rows that slip beyond Coulomb's bound.
#pragma once

#include <algorithm>

#include "sim/base/state_tape.h"
#include "sim/brick/contact.h"
#include "sim/joints/coordinates.h"

namespace kirireel {

/// One point contact, or one support of a planar scene, in D degrees of freedom a brick.
///
/// Normal: w = row u with w + bias >= 0 and multiplier >= 0, one of them zero. Tangential: the
/// multiplier opposes sliding and is at most slipBound long; slipBound is friction times the normal
/// multiplier of the step before (lagged), which keeps each step convex.
template <int D>
struct ContactRow {
  static constexpr int kTangents = 2;  ///< of a planar contact the second is vertical, hence zero
  using RowVector = typename Coordinates<D>::RowVector;
  using TangentRows = Eigen::Matrix<double, kTangents, D>;
  using Tangent = Eigen::Matrix<double, kTangents, 1>;
  using TangentMatrix = Eigen::Matrix<double, kTangents, kTangents>;

  Contact contact;
  bool hasNormal = true;  ///< false for supports, which only rub
  /// The normal row's part for each brick: velocity along the normal by the brick's D velocities.
  /// That of B is zero where the other side is fixed.
  RowVector normalA, normalB;
  /// Two rows for each brick, likewise, along two directions that span the contact's plane.
  TangentRows tangentA, tangentB;
  double bias = 0;        ///< gap / step, m/s; 0 where they overlap
  double aim = 0;         ///< gap that closing aims at where the contact pushes, metres
  double multiplier = 0;  ///< normal impulse, from 0
  Tangent slipMultiplier = Tangent::Zero();  ///< tangential impulse on A
  double slipBound = 0;                      ///< largest tangential impulse

  // The state that the present factor was made for.
  bool active = false;
  TangentMatrix slipStiffness = TangentMatrix::Zero();  ///< times rho

  /// Velocity of A's point relative to B along the normal.
  double normalVelocity(const Eigen::VectorXd& u) const;
  /// The same along the tangents.
  Tangent slipVelocity(const Eigen::VectorXd& u) const;
  /// Adds scale * row^T to a vector of all bricks.
  void addNormal(double scale, Eigen::VectorXd& to) const;
  /// Adds (tangent rows)^T * scale, likewise.
  void addTangent(const Tangent& scale, Eigen::VectorXd& to) const;

  /// The normal impulse that the augmented Lagrangian gives at u to a contact that pushes or pulls.
  double pushingImpulse(const Eigen::VectorXd& u, double rho) const;
  /// The normal impulse that the augmented Lagrangian gives at u.
  double trialImpulse(const Eigen::VectorXd& u, double rho) const;
  /// The tangential impulse, cut to the bound; `stiffness` gets its negative derivative by the slip
  /// velocity, divided by rho.
  Tangent trialSlipImpulse(const Eigen::VectorXd& u, double rho, TangentMatrix* stiffness) const;
  /// Whether friction acts: supports have a bound from the start, contacts after they have pushed.
  bool rubs() const { return slipBound > 0; }
  /// Whether it is in force in its present state.
  bool acts() const { return active || rubs(); }

  /// What the row of the next step takes from this one.
  void transfer(StateTape& tape) { tape.transfer(contact, hasNormal, multiplier, slipMultiplier); }
};

/// The row of a contact at the poses where a step of `step` seconds starts. An overlap there
/// may stay while the bricks move (taking it back by speed would add energy); closing aims at
/// `recovery` metres less of it.
template <int D>
ContactRow<D> makeContactRow(const Contact& contact, const Poses& poses, double step,
                             double recovery);

/// Sets the row's directions for its contact at these poses.
template <int D>
void placeRow(ContactRow<D>& row, const Poses& poses);

/// The end of the rows that belong to the same plane as the first, which follow each other.
template <int D, typename Iterator>
Iterator endOfPlane(Iterator first, Iterator end) {
  return std::find_if(first + 1, end, [&](const ContactRow<D>& row) {
    return !row.hasNormal || !onOnePlane(first->contact, row.contact);
  });
}

}  // namespace kirireel
