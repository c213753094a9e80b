/// The digits that a file was written with, found from its numbers alone.
///
/// A number of a file that was rounded to 3 decimals has at most 3 of them, and the shortest text
/// that reads back as the same double has as many as were written, but for zeros at its end. So the
/// place of the last digit shows in the numbers themselves, whatever the format: it is the finest
/// place that any of them uses. In a file of so many significant digits, large numbers have fewer
/// decimals than small ones; there the last place of the largest numbers counts. Files with 15
/// significant digits or more were not rounded.
#pragma once

#include <vector>

#include "sim/model/model.h"

namespace kirireel {

/// The last place that the coordinates were written with, metres, such as 0.001; 0 where they have
/// all their digits.
double lastPlace(const std::vector<Tile>& tiles);

/// What rounding the coordinates may carry, metres: the last place, or 0 where the numbers are
/// exact as written. They are when all are multiples of a coarser step, as 0.25 (five last places
/// at least), or when the last place is too coarse for tiles of that size to be roundings of
/// anything.
double roundingOf(const std::vector<Tile>& tiles);

/// How far apart corners may be that are one, metres: one unit of the last place along each axis,
/// by which two roundings of one point can differ, but never a visible part of a tile; and at least
/// a millionth of the sheet, since designs are solved to finite precision.
double samePlaceTolerance(const std::vector<Tile>& tiles);

/// Points nearer than this part of the sheet's size are one. Largest met in the published pairs: 0.
inline constexpr double kSamePlace = 1e-6;

}  // namespace kirireel
