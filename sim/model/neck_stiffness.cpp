// Stiffnesses of necks from tables of finite element runs.
//
// A neck of length L and width w (m) between two tiles in a sheet of thickness t (m) and Young's
// modulus E (Pa) is a beam in series with the two places where it meets the tiles. The tiles' share
// is said as a length: e widths that the neck seems longer, so that
//   k = E t w^3 / (12 (L + e w))                                    N m/rad
// is exact for pure bending of a long neck and for the measured table at any length. A table rather
// than a closed formula stands here, because no closed formula is known for e between its limits;
// the values change by 4% at most, so that straight lines between the rows err by far less than 1%.
//
// A neck without length has three stiffnesses about its own axis. With the table's flexibilities b,
// s, h (no unit):
//   bending = E t w^2 / b,   stretch = E t / s,   shear = E t / h   (N m/rad, N/m, N/m)
// s and h grow with log(side / w), as the displacement under a force at a point does in the plane,
// so that they are taken along straight lines of the logarithm.
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

/// The table's row at a width in sides: between rows, and before the first, what bends along a
/// straight line of the width, what stretches and shears along one of its logarithm.
CornerNeckRow cornerRow(double width) {
  const auto& table = kCornerNeckTable;
  // Beyond the last row the tiles are hardly more than the neck. Below the first row the first two
  // rows are continued.
  width = std::min(width, table.back().width);
  const auto isWider = [&](const CornerNeckRow& row) { return row.width >= width; };
  const auto above = std::find_if(std::next(table.begin()), table.end(), isWider);
  const CornerNeckRow& a = *std::prev(above);
  const CornerNeckRow& b = *above;
  const double share = (width - a.width) / (b.width - a.width);
  const double inLog = std::log(width / a.width) / std::log(b.width / a.width);
  return {width, std::lerp(a.bend, b.bend, share), std::lerp(a.axis, b.axis, share),
          std::lerp(a.stretch, b.stretch, inLog), std::lerp(a.shear, b.shear, inLog)};
}

}  // namespace

double neckStiffness(double youngs, double thickness, double width, double length) {
  const double widths = length / width;
  return youngs * thickness * width * width / (12 * (widths + endsOf(widths)));
}

double neckAxis(double width, double length, double side) {
  // The axis of a neck's own bending lies in its middle; that of its ends where cornerRow() says.
  // Both weigh by the angle that they give under one moment: L / w against e.
  constexpr double kOwn = 0.5;  ///< widths
  const double widths = length / width, ends = endsOf(widths);
  return width * (kOwn * widths + cornerRow(width / side).axis * ends) / (widths + ends);
}

CornerNeck cornerNeck(double youngs, double thickness, double width, double side) {
  const CornerNeckRow row = cornerRow(width / side);
  const double sheet = youngs * thickness;
  return {sheet * width * width / row.bend, row.axis * width, sheet / row.stretch,
          sheet / row.shear, kCornerNeckOpening};
}

}  // namespace kirireel
