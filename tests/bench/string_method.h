/// The smallest opening of joints between two states, and the smallest length of a path, by an
/// independent method.
#pragma once

#include <vector>

#include "sim/scene/scene.h"

namespace kirireel {

/// Minimum over paths from the first state of `guide` to the last of the largest gap of any joint,
/// metres, by the string method from the guide. Bricks overlap by at most `maxGrown` metres more
/// than at the start. Infinity if no such path is found.
double minOpening(const scene::Scene& scene, const std::vector<Poses>& guide, double maxGrown);

/// The length of a shortened path with closed joints and fixed ends, over its original length. 1 if
/// no path nearby with the same symmetries of the model is shorter. Bricks overlap on it by at most
/// `maxGrown` metres more than at the start; images stop at contacts and do not slide along them.
double minLength(const scene::Scene& scene, const std::vector<Poses>& path, double maxGrown);

}  // namespace kirireel
