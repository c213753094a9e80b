/// Area of the union of polygons.
#pragma once

#include <vector>

#include "sim/formats/arrangement.h"

namespace kirireel::formats {

/// The area of the union of simple polygons, square metres: overlaps count once. The corners of
/// each polygon may have either orientation.
double unionArea(const std::vector<PlaneRing>& polygons);

}  // namespace kirireel::formats
