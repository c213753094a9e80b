// Stiffnesses of necks from tables of finite element runs.
//
// A neck of length L and width w (m) connects two tiles in a sheet of thickness t (m) and Young's
// modulus E (Pa). It is a beam in series with its two junctions at the tiles. The tiles' compliance
// is expressed as e widths of additional neck length:
//   k = E t w^3 / (12 (L + e w))                                    N m/rad
// This is exact for pure bending of a long neck, and for the measured table at any length. No
// closed formula for e between its limits is known, so the code uses a table. The values change by
// at most 4%. Linear interpolation between rows therefore has an error far below 1%.
//
// A neck of length 0 has three stiffnesses about its own axis. The table gives the flexibilities b,
// s, h and the axis x of a pair of equal tiles (dimensionless; x in widths from the corner):
//   bending = E t w^2 / b,   stretch = E t / s,   shear = E t / h   (N m/rad, N/m, N/m)
// s and h grow with log(side / w), like the planar displacement under a point force. They are
// therefore interpolated linearly in the logarithm.
//
// With a the tiles' angle at the neck, b, b x, s and h are the cubic polynomials of cot(a / 2)
// through the table's four angles. b x is the opening of the corners by a moment, and by
// reciprocity the turn by a force. The solution for a blunt wedge grows as a power of the
// cotangent, which a polynomial of a fits less well. Relative errors against decks with other
// angles:
//   angle          b      x      s      h
//   45            0.010  0.005  0.060  0.049
//   75 and 105    0.004  0.001  0.022  0.020
//   135           0.007  0.003  0.019  0.031
//   150           0.009  0.016  0.056  0.108
//
// The line of the slit separates the compliances: tiles A and B with pair values b_A, b_B ... are
// in series. Each has half of its pair's flexibility, and both turn about the same axis:
//   b = (b_A + b_B) / 2,   x = (b_A x_A + b_B x_B) / (b_A + b_B),   h = (h_A + h_B) / 2,
//   s = (s_A + b_A (x_A - x)^2 + s_B + b_B (x_B - x)^2) / 2
// Decks of 60 next to 120 degrees agree within 1% at 0.05 sides, with the values of rhombi.
//
// Between other tiles, a neck with a length uses their b instead of the b of squares. It is scaled
// by the same factor as e, which falls with the length:
//   k = E t w^2 / (12 L / w + b e(L / w) / e(0))
#include "sim/brick/stiffness.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <span>

#include "sim/brick/neck_table.h"

namespace kirireel::brick {
namespace {

/// Value of e at a length in widths, linear between rows.
double endsOf(double length) {
  const auto above =
      std::ranges::find_if(kNeckTable, [&](const NeckRow& row) { return row.length > length; });
  if (above == kNeckTable.end()) return kNeckTable.back().ends;
  const NeckRow& below = *std::prev(above);
  const double share = (length - below.length) / (above->length - below.length);
  return std::lerp(below.ends, above->ends, share);
}

/// The row of one angle at a width in sides. Bending is linear in the width between rows and before
/// the first row. Stretch and shear are linear in its logarithm.
CornerNeckRow rowAtWidth(std::span<const CornerNeckRow> table, double width) {
  // Beyond the last row the tiles are hardly larger than the neck. Below the first row the first
  // two rows are extrapolated.
  width = std::min(width, table.back().width);
  const auto isWider = [&](const CornerNeckRow& row) { return row.width >= width; };
  const auto above = std::find_if(std::next(table.begin()), table.end(), isWider);
  const CornerNeckRow& a = *std::prev(above);
  const CornerNeckRow& b = *above;
  const double share = (width - a.width) / (b.width - a.width);
  const double inLog = std::log(width / a.width) / std::log(b.width / a.width);
  return {a.angle,
          width,
          std::lerp(a.bend, b.bend, share),
          std::lerp(a.axis, b.axis, share),
          std::lerp(a.stretch, b.stretch, inLog),
          std::lerp(a.shear, b.shear, inLog)};
}

/// cot(a / 2) of an angle a in radians.
double halfCotangent(double angle) {
  return 1 / std::tan(0.5 * angle);
}

/// The table's row for a pair of equal tiles. Lagrange's polynomial through all angles, used
/// between them and slightly beyond.
CornerNeckRow rowOf(double width, const NeckCorner& tile) {
  constexpr std::size_t kWidths = kCornerNeckTable.size() / kCornerNeckAngles;
  const double angle = std::clamp(tile.angle, 30 * kDegree, 150 * kDegree);
  std::array<CornerNeckRow, kCornerNeckAngles> rows;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    rows[k] =
        rowAtWidth(std::span(kCornerNeckTable).subspan(k * kWidths, kWidths), width / tile.side);
  }
  CornerNeckRow sum{angle / kDegree, rows[0].width};
  for (const CornerNeckRow& row : rows) {
    const double u = halfCotangent(row.angle * kDegree);
    double weight = 1;
    for (const CornerNeckRow& other : rows) {
      if (&other == &row) continue;
      const double v = halfCotangent(other.angle * kDegree);
      weight *= (halfCotangent(angle) - v) / (u - v);
    }
    sum.bend += weight * row.bend;
    sum.axis += weight * row.bend * row.axis;
    sum.stretch += weight * row.stretch;
    sum.shear += weight * row.shear;
  }
  sum.axis /= sum.bend;
  return sum;
}

/// Two tiles in series, as explained above.
CornerNeckRow cornerRow(double width, const std::array<NeckCorner, 2>& tiles) {
  const CornerNeckRow a = rowOf(width, tiles[0]), b = rowOf(width, tiles[1]);
  CornerNeckRow both{0.5 * (a.angle + b.angle), 0.5 * (a.width + b.width)};
  both.bend = 0.5 * (a.bend + b.bend);
  both.axis = (a.bend * a.axis + b.bend * b.axis) / (a.bend + b.bend);
  const auto stretchOf = [&](const CornerNeckRow& row) {
    const double arm = row.axis - both.axis;
    return row.stretch + row.bend * arm * arm;
  };
  both.stretch = 0.5 * (stretchOf(a) + stretchOf(b));
  both.shear = 0.5 * (a.shear + b.shear);
  return both;
}

/// Additional length of a neck between these tiles, in widths. For squares it falls with the length
/// as in the table, for other tiles by the same factor.
double endsBetween(double width, double length, const CornerNeckRow& tiles) {
  return tiles.bend / 12 * endsOf(length / width) / endsOf(0);
}

}  // namespace

double neckStiffness(double youngs, double thickness, double width, double length) {
  const double widths = length / width;
  return youngs * thickness * width * width / (12 * (widths + endsOf(widths)));
}

NeckCorner neckCorner(const Brick& brick, int corner) {
  const std::size_t count = brick.bottom.size();
  const auto k = static_cast<std::size_t>(corner);
  const Vector3 next = brick.bottom[(k + 1) % count] - brick.bottom[k];
  const Vector3 last = brick.bottom[(k + count - 1) % count] - brick.bottom[k];
  // The tile lies anticlockwise from the next edge to the last.
  const double angle = std::atan2(brick.normal.dot(next.cross(last)), next.dot(last));
  return {angle > 0 ? angle : angle + 2 * std::numbers::pi,
          std::sqrt(brick.volume / brick.thickness)};
}

namespace {

/// Start of a neck's strip along a closed slit, metres from the corner, as flat_sheet.cpp draws it.
/// Both tiles are cut back by half of the neck's length. The strip starts where both have begun, at
/// the earliest half of its width before the corner.
double neckBegin(double width, double length, const std::array<NeckCorner, 2>& tiles) {
  double begin = -0.5 * width;
  for (const NeckCorner& tile : tiles) {
    if (tile.angle < std::numbers::pi) {
      begin = std::max(begin, 0.5 * length / std::tan(tile.angle));
    }
  }
  return begin;
}

}  // namespace

double neckAxis(double width, double length, const std::array<NeckCorner, 2>& tiles) {
  // A neck bends about its middle, and its ends about the axis of cornerRow(). The weights are
  // their angles under the same moment: L / w and e.
  constexpr double kOwn = 0.5;  ///< widths
  const CornerNeckRow row = cornerRow(width, tiles);
  const double widths = length / width, ends = endsBetween(width, length, row);
  const double within = width * (kOwn * widths + row.axis * ends) / (widths + ends);
  return neckBegin(width, length, tiles) + within;
}

CornerNeck cornerNeck(double youngs, double thickness, double width,
                      const std::array<NeckCorner, 2>& tiles) {
  const CornerNeckRow row = cornerRow(width, tiles);
  const double sheet = youngs * thickness;
  return {sheet * width * width / row.bend, row.axis * width, sheet / row.stretch,
          sheet / row.shear, kCornerNeckOpening};
}

double neckStiffness(double youngs, double thickness, double width, double length,
                     const std::array<NeckCorner, 2>& tiles) {
  const double ends = endsBetween(width, length, cornerRow(width, tiles));
  return youngs * thickness * width * width / (12 * (length / width + ends));
}

// ------------------------------------------------------------------------------------------------
// Stiffnesses of the bar and hinge model.
//
// Symbols: E Young's modulus (Pa), nu Poisson's ratio, t thickness (m), D = E t^3 / (12 (1 - nu^2))
// the bending stiffness of a plate (N m).
// - A bar's area follows from equal energy: under equal strain e in all directions, a triangle
//   stores E t S e^2 / (1 - nu) as a plate, and E A (a + b + c) e^2 / 2 as three bars.
// - A panel that bends about its diagonal of length d: k = C D (d / t)^(1/3). The power 1/3 comes
//   from the ridge in a thin sheet with held edges (A. E. Lobkovsky, Boundary layer analysis of the
//   ridge singularity in a thin plate, Phys. Rev. E 53, 1996). The paper in the header fitted C to
//   finite elements. C is smaller for skew panels.
// - A fold of length l: k = D l / scale. This is the stiffness of a strip of panel with the fold's
//   length and the length scale as width.

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
  constexpr double kMin = 0.05;
  double skew = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    // The angle at corner k between its two sides. atan2 keeps its precision at right and flat
    // angles.
    const Vector3 next = corners[(k + 1) % 4] - corners[k],
                  last = corners[(k + 3) % 4] - corners[k];
    skew += std::abs(std::numbers::pi / 2 - std::atan2(next.cross(last).norm(), next.dot(last)));
  }
  // The fit becomes negative for very skew panels. A stiffness must be positive.
  const double share = std::max(kMin, 0.55 - 0.42 * skew / std::numbers::pi);
  return share * plateStiffness(youngs, poisson, thickness) * std::cbrt(diagonal / thickness);
}

double foldStiffness(double length, double scale, double youngs, double poisson, double thickness) {
  return plateStiffness(youngs, poisson, thickness) * length / scale;
}

}  // namespace kirireel::brick
