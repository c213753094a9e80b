/// Area of the union of polygons.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace kirireel::trajectory {

/// The area of the union of simple polygons, square metres: overlaps count once. The corners of
/// each polygon may have either orientation.
double unionArea(const std::vector<std::vector<Eigen::Vector2d>>& polygons);

}  // namespace kirireel::trajectory
