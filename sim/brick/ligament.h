/// Elastic ligaments in place of exact joints: what stretching and shearing a neck costs. Its
/// bending is that of the spring at its hinge. In the plane.
#pragma once

#include <array>
#include <span>

#include <Eigen/Core>

#include "sim/base/geometry.h"

namespace kirireel {

/// A straight neck between a point of one brick and a point of another; without a length a pin that
/// gives: two points that are one at the start, and part across a slit or slide along it.
struct Ligament {
  int brickA = 0;
  int brickB = 0;
  int joint = 0;                     ///< of the model, see Pivot
  Vector3 pointA = Vector3::Zero();  ///< in the axes of brick A
  Vector3 pointB = Vector3::Zero();  ///< in the axes of brick B
  /// From point A to point B at the start, world axes, metres; zero for a pin.
  Vector3 start = Vector3::UnitX();
  Vector3 across = Vector3::UnitX();  ///< of a pin: unit, where its points part, at the start
  double stretchStiffness = 0;        ///< N/m
  double shearStiffness = 0;          ///< N m/rad; of a pin N/m
  /// Of a pin, what the moment is beyond its hinge's spring: opening[0] a^2 + opening[1] a^3 with a
  /// the turn of brick B against A since the start, about z; N m/rad^2, N m/rad^3.
  std::array<double, 2> opening = {};

  bool isPin() const { return start.isZero(); }
};

/// The stiffnesses of a neck as a beam of Timoshenko's: with A = w t, I = t w^3 / 12, G = E / (2 (1
/// + nu)) and the shear factor 5/6
///   stretch = E A / L,   1 / shear = L / (12 E I) + 1 / (5/6 G A L).
/// Metres, Pa; all positive. The tiles at its ends are taken for rigid in this.
void setNeckStiffness(double youngs, double poisson, double thickness, double width, double length,
                      Ligament& ligament);

/// The energy of a ligament in the plane with its derivatives by x, y and turn of brick A, then of
/// brick B; metres, radians, joules.
struct LigamentEnergy {
  double energy = 0;
  Vector6 gradient = Vector6::Zero();
  Matrix6 hessian = Matrix6::Zero();
};

/// At the places of both bricks' centres of mass and their turns since the start. `armA`, `armB`:
/// the points from there, turned with the bricks; world axes.
/// `between`: from the centre of brick A to that of B, metres. The Hessian is symmetric and may be
/// indefinite.
LigamentEnergy ligamentEnergy(const Ligament& ligament, const Vector3& between, const Vector3& armA,
                              const Vector3& armB, double turnA, double turnB);

/// At poses whose rotations are turns about z since the start. Bricks turn by less than half a turn
/// against each other.
LigamentEnergy ligamentEnergy(const Ligament& ligament, const Poses& poses);

/// What ligaments hold at these poses, joules.
double elasticEnergy(std::span<const Ligament> ligaments, const Poses& poses);

}  // namespace kirireel
