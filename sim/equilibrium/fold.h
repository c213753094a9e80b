/// The angle between two triangles with a common edge, and its derivatives.
#pragma once

#include <array>

#include <Eigen/Core>

#include "sim/base/geometry.h"

namespace kirireel {

using Vector12 = Eigen::Matrix<double, 12, 1>;
using Matrix12 = Eigen::Matrix<double, 12, 12>;

/// The two ends of the edge, then the third corner of the triangle to its left and of that to its
/// right, seen from above, metres.
using FoldPoints = std::array<Vector3, 4>;

/// Radians from -pi to pi, as FOLD has it: 0 where the triangles are flat, positive where their
/// upper sides turn towards each other (a valley).
double foldAngle(const FoldPoints& points);

/// The derivative of the angle by the points' coordinates, one point after the other.
Vector12 foldSlope(const FoldPoints& points);

/// The second derivative.
Matrix12 foldBend(const FoldPoints& points);

}  // namespace kirireel
