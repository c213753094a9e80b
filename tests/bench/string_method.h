/// The least opening of joints between two states, by a method of its own.
#pragma once

#include <vector>

#include "sim/scene/scene.h"

namespace kirireel {

/// The largest gap of any joint, metres, on the path from the first state of `guide` to the last on
/// which that was found to be least; by the string method from the guide. Of paths on which bricks
/// overlap by at most `mostGrown` metres more than at the start; infinity where the guide falls to
/// none.
double leastOpening(const Scene& scene, const std::vector<Poses>& guide, double mostGrown);

}  // namespace kirireel
