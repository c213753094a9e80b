// Steps are 1, 2 or 5 times a power of ten, the least for which at most `mostTicks` fit into the
// range. Ticks are multiples k s of the step s, computed from k each time, so that no error adds
// up. Numbers have as many decimals as the step.
//
// A range below 1e-5 of its values would give ticks that read alike; it is drawn as a constant in
// the middle of an axis as wide as the value.
#include "render/grid/ticks.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace kirireel {
namespace {

/// Differences below this part of the values are rounding.
constexpr double kConstant = 1e-9;
/// A range below this part of its values is drawn as a constant: numbers along it could not be told
/// apart.
constexpr double kUnreadable = 1e-5;
/// Free above and below what is drawn, in parts of the range.
constexpr double kRoom = 0.05;

/// The least of 1, 2 and 5 times a power of ten that is not below the step.
double roundStep(double step) {
  const double power = std::pow(10, std::floor(std::log10(step)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= step * (1 - kConstant)) return factor * power;
  }
  return 10 * power;
}

/// With a true minus sign.
std::string numberText(double value, int decimals) {
  const std::string text = decimals <= 6 && std::abs(value) < 1e6
                               ? fmt::format("{:.{}f}", std::abs(value), std::max(0, decimals))
                               : fmt::format("{:.3g}", std::abs(value));
  return value < 0 ? "\u2212" + text : text;
}

}  // namespace

double Axis::shareOf(double value) const {
  if (isLogarithmic) return std::log(value / low) / std::log(high / low);
  return (value - low) / (high - low);
}

Axis makeAxis(const std::vector<double>& values, int mostTicks) {
  const auto [least, largest] = std::ranges::minmax_element(values);
  Axis axis{*least, *largest, false, {}, {}};
  const double size = std::max(std::abs(axis.low), std::abs(axis.high));
  if (axis.high - axis.low <= kUnreadable * size) {
    const double room = size > 0 ? 0.5 * size : 1;
    axis.low -= room;
    axis.high += room;
  } else {
    const double room = kRoom * (axis.high - axis.low);
    axis.low -= room;
    axis.high += room;
  }
  return makeAxisWithin(axis.low, axis.high, mostTicks);
}

Axis makeAxisWithin(double low, double high, int mostTicks) {
  Axis axis{low, high, false, {}, {}};
  if (high <= low) return axis;
  const double step = roundStep((high - low) / mostTicks);
  const int decimals = static_cast<int>(std::ceil(-std::log10(step) - kConstant));
  for (double k = std::ceil(low / step - kConstant); k * step <= high * (1 + kConstant); ++k) {
    axis.ticks.push_back(k * step);
    axis.texts.push_back(numberText(k == 0 ? 0 : k * step, decimals));
  }
  return axis;
}

Axis makeLogarithmicAxis(const std::vector<double>& values, int mostTicks) {
  double least = INFINITY, largest = 0;
  for (const double value : values) {
    if (value > 0) least = std::min(least, value);
    largest = std::max(largest, value);
  }
  if (largest == 0) least = largest = 1;
  Axis axis{std::pow(10, std::floor(std::log10(least))),
            std::pow(10, std::ceil(std::log10(largest))),
            true,
            {},
            {}};
  if (axis.low == axis.high) {
    axis.low /= 10;
    axis.high *= 10;
  }
  const int decades = static_cast<int>(std::lround(std::log10(axis.high / axis.low)));
  const int stride = (decades + mostTicks - 1) / mostTicks;
  const int lowest = static_cast<int>(std::lround(std::log10(axis.low)));
  for (int k = 0; k <= decades; k += stride) {
    axis.ticks.push_back(axis.low * std::pow(10, k));
    axis.texts.push_back(fmt::format("1e{}", lowest + k));
  }
  return axis;
}

}  // namespace kirireel
