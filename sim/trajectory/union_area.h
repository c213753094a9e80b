/// The area that polygons cover together.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace kirireel::trajectory {

/// The area of the union of simple polygons, square metres: what several of them cover counts once.
/// The corners of each go round either way.
double unionArea(const std::vector<std::vector<Eigen::Vector2d>>& polygons);

}  // namespace kirireel::trajectory
