/// What lets a run leave an unstable equilibrium.
#pragma once

#include <cstddef>
#include <vector>

#include "sim/base/geometry.h"

namespace kirireel {

/// Small velocities for `count` bricks, turns apart: each component at random within a millionth of
/// the model's size (metres) a second. The same seed gives the same ones everywhere.
std::vector<Velocity> nudge(std::size_t count, double modelSize, unsigned seed);

}  // namespace kirireel
