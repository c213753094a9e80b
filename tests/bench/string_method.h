/// The least opening of joints between two states, and the least length of a path, by a method of
/// its own.
#pragma once

#include <vector>

#include "sim/scene/scene.h"

namespace kirireel {

/// The largest gap of any joint, metres, on the path from the first state of `guide` to the last on
/// which that was found to be least; by the string method from the guide. Of paths on which bricks
/// overlap by at most `mostGrown` metres more than at the start; infinity where the guide falls to
/// none.
double leastOpening(const scene::Scene& scene, const std::vector<Poses>& guide, double mostGrown);

/// The length to which a path with closed joints was shortened, its ends held, over the length that
/// it has: 1 where no path nearby is shorter that has the symmetries of the model that this one
/// has. Bricks overlap on it by at most `mostGrown` metres more than at the start; images stop at
/// contacts and do not slide along them.
double leastLength(const scene::Scene& scene, const std::vector<Poses>& path, double mostGrown);

}  // namespace kirireel
