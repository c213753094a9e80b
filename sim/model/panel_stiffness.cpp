// The stiffnesses of the bar and hinge model.
//
// Symbols: E Young's modulus (Pa), nu Poisson's ratio, t thickness (m), D = E t^3 / (12 (1 - nu^2))
// the bending stiffness of a plate (N m).
// - A bar's area follows from equal energy: a triangle under equal strain e in all directions
//   stores E t S e^2 / (1 - nu) as a plate, and E A (a + b + c) e^2 / 2 as three bars.
// - A panel that bends about its diagonal of length d: k = C D (d / t)^(1/3). The power 1/3 comes
//   from the ridge into which a thin sheet with held edges bends (A. E. Lobkovsky, Boundary layer
//   analysis of the ridge singularity in a thin plate, Phys. Rev. E 53, 1996). C was fitted to
//   finite elements in the paper that the header names; it falls for skew panels.
// - A fold of length l: k = D l / scale, the stiffness of a strip of panel as long as the fold and
//   as wide as the length scale.
#include "sim/model/panel_stiffness.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kirireel {
namespace {

double plateStiffness(double youngs, double poisson, double thickness) {
  // D in N m.
  return youngs * thickness * thickness * thickness / (12 * (1 - poisson * poisson));
}

}  // namespace

double barArea(const std::array<Vector3, 3>& triangle, double thickness, double poisson) {
  const auto& [a, b, c] = triangle;
  const double area = 0.5 * (b - a).cross(c - a).norm();
  const double round = (b - a).norm() + (c - b).norm() + (a - c).norm();
  return 2 * area * thickness / ((1 - poisson) * round);
}

double bendStiffness(const std::array<Vector3, 4>& corners, double diagonal, double youngs,
                     double poisson, double thickness) {
  constexpr double kLeast = 0.05;
  double skew = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    // The angle at corner k between its two sides, by atan2 so that right and flat angles keep
    // their digits.
    const Vector3 next = corners[(k + 1) % 4] - corners[k],
                  last = corners[(k + 3) % 4] - corners[k];
    skew += std::abs(std::numbers::pi / 2 - std::atan2(next.cross(last).norm(), next.dot(last)));
  }
  // The fit would turn negative for very skew panels, and no panel has a negative stiffness.
  const double share = std::max(kLeast, 0.55 - 0.42 * skew / std::numbers::pi);
  return share * plateStiffness(youngs, poisson, thickness) * std::cbrt(diagonal / thickness);
}

double foldStiffness(double length, double scale, double youngs, double poisson, double thickness) {
  return plateStiffness(youngs, poisson, thickness) * length / scale;
}

}  // namespace kirireel
