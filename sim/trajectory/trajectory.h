/// A deployment's record: the poses of all bricks by time.
#pragma once

#include <vector>

#include "sim/base/geometry.h"
#include "sim/brick/brick.h"

namespace kirireel {

/// The state at one time, with its measures.
struct Sample {
  double time = 0;         ///< simulated seconds from the start
  Poses poses;             ///< one a brick
  double jointGap = 0;     ///< largest, metres
  double targetError = 0;  ///< largest, metres; 0 without a target
};

/// All samples of one run, equally spaced in time from 0 to the end.
struct Trajectory {
  std::vector<Brick> bricks;
  std::vector<Sample> samples;  ///< at least the start
};

}  // namespace kirireel
