#include "sim/model/neck_stiffness.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "sim/model/neck_table.h"

namespace kirireel {
namespace {

/// The table's ends at a length in widths, between rows along a straight line.
double endsOf(double length) {
  const auto above =
      std::ranges::find_if(kNeckTable, [&](const NeckRow& row) { return row.length > length; });
  if (above == kNeckTable.end()) return kNeckTable.back().ends;
  const NeckRow& below = *std::prev(above);
  const double share = (length - below.length) / (above->length - below.length);
  return std::lerp(below.ends, above->ends, share);
}

}  // namespace

double neckStiffness(double youngs, double thickness, double width, double length) {
  const double widths = length / width;
  return youngs * thickness * width * width / (12 * (widths + endsOf(widths)));
}

double neckAxis(double width, double length) {
  constexpr double kOwn = 0.5, kOfEnds = 0.73;  ///< widths
  const double widths = length / width, ends = endsOf(widths);
  return width * (kOwn * widths + kOfEnds * ends) / (widths + ends);
}

}  // namespace kirireel
