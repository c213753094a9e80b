/// Exponents from measured points.
#pragma once

#include <vector>

namespace kirireel {

/// A point to be fitted; both above 0.
struct PowerPoint {
  double x = 0;  ///< above 0
  double y = 0;  ///< above 0
};

/// The exponent b of y = a x^b by least squares of the logarithms; not a number for fewer than two
/// different x.
double fittedExponent(const std::vector<PowerPoint>& points);

}  // namespace kirireel
