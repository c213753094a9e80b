#include "sim/model/panel_stiffness.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kirireel {
namespace {

double plateStiffness(double youngs, double poisson, double thickness) {
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
    const Vector3 next = corners[(k + 1) % 4] - corners[k],
                  last = corners[(k + 3) % 4] - corners[k];
    skew += std::abs(std::numbers::pi / 2 - std::atan2(next.cross(last).norm(), next.dot(last)));
  }
  const double share = std::max(kLeast, 0.55 - 0.42 * skew / std::numbers::pi);
  return share * plateStiffness(youngs, poisson, thickness) * std::cbrt(diagonal / thickness);
}

double foldStiffness(double length, double scale, double youngs, double poisson, double thickness) {
  return plateStiffness(youngs, poisson, thickness) * length / scale;
}

}  // namespace kirireel
