/// Cuts that are drawn as two lines, and their middle line.
#pragma once

#include <optional>

#include "sim/formats/arrangement.h"

namespace kirireel::formats {

/// Distance of a point to a segment, metres.
double distanceTo(const PlaneSegment& line, const Vector2& point);

/// Largest distance between two open lines, and between their ends, metres.
double apartOf(const DrawnPath& a, const DrawnPath& b);

/// The middle of two lines, up to the further end of both.
DrawnPath middleOf(const DrawnPath& a, const DrawnPath& b);

/// The middle line of a closed line whose sides are at most `most` apart, metres, between its
/// points that are farthest from each other. Absent if the sides are further apart, or if it is not
/// slender.
std::optional<DrawnPath> middleOfThin(const DrawnPath& ring, double most);

}  // namespace kirireel::formats
