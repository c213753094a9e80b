/// Round numbers along an axis.
#pragma once

#include <string>
#include <vector>

namespace kirireel {

/// A range of values and the marks along it, rising, all within it.
struct Axis {
  double low = 0;
  double high = 1;                 ///< above low
  bool isLogarithmic = false;      ///< equal steps of the page are equal ratios; low is above 0
  std::vector<double> ticks;       ///< where numbers stand
  std::vector<std::string> texts;  ///< the numbers, one a tick

  /// Where a value stands: 0 at low, 1 at high. Beyond 0 to 1 for values off the axis. On a
  /// logarithmic axis the value must be above 0.
  double shareOf(double value) const;
};

/// An axis that holds finite values, at least one, with at most so many ticks at multiples of 1, 2
/// or 5 times a power of ten; a constant (to 1e-5 of itself)
/// stands in its middle.
Axis makeAxis(const std::vector<double>& values, int mostTicks);

/// An axis of this range, high at low or above, with such ticks within it. Without ticks where low
/// and high are equal.
Axis makeAxisWithin(double low, double high, int mostTicks);

/// The same with ticks at powers of ten; values of 0 and below have no place on it. With none above
/// 0, an axis from 0.1 to 10.
Axis makeLogarithmicAxis(const std::vector<double>& values, int mostTicks);

}  // namespace kirireel
