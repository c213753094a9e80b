/// The decimal places of a file's coordinates, found only from its numbers.
#pragma once

#include <vector>

#include "sim/model/model.h"

namespace kirireel::formats {

// A number that was rounded to 3 decimals has at most 3 decimals. The shortest text that reads back
// as the same double has the written digits, except for trailing zeros. The last decimal place is
// therefore the finest place of any number, in every format. With a fixed number of significant
// digits, large numbers have fewer decimals than small ones. The last place of the largest numbers
// counts in that case. Files with 15 or more significant digits were not rounded, except to single
// precision.

/// The last place of the coordinates, metres: decimal, such as 0.001, or binary if a
/// program in single precision wrote them. 0 if the coordinates have all their digits.
double lastPlace(const std::vector<model::Tile>& tiles);

/// Rounding error of the coordinates, metres: the last place, or 0 if the numbers are exact. They
/// are exact if all are multiples of a coarser step such as 0.25 (at least five last places). They
/// are also exact if the last place is too coarse for tiles of that size.
double roundingOf(const std::vector<model::Tile>& tiles);
/// The same for tiles whose last place is known, metres, such as corners of a drawing's lines.
double roundingOf(const std::vector<model::Tile>& tiles, double place);

/// Maximum distance of corners that count as one point, metres: one unit of the last place along
/// each axis, since two roundings of one point can differ by that. At most a small fraction of a
/// tile, at least a millionth of the sheet because designs are solved to finite precision.
double samePlaceTolerance(const std::vector<model::Tile>& tiles);

/// Points nearer than this fraction of the sheet's size are one. Largest in published pairs: 0.
inline constexpr double kSamePlace = 1e-6;

}  // namespace kirireel::formats
