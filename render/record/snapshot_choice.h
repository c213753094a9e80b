/// Which samples of a trajectory make a snapshot grid.
#pragma once

#include <vector>

#include "render/record/record.h"
#include "sim/trajectory/trajectory.h"

namespace kirireel {

/// How far the bricks have travelled at each sample: the sum over the samples so far of the mean
/// distance that a bottom vertex moved, metres. Starts with 0 and never falls.
std::vector<double> travelledWay(const Trajectory& trajectory);

/// Indices of at most `count` samples (at least 1), rising, the first and the last among them when
/// count is 2 or more (the last alone when it is 1). A trajectory with fewer samples gives them
/// all. In between each is the sample nearest to its share of time or way.
std::vector<int> chooseSnapshots(const Trajectory& trajectory, int count, SnapshotSpacing spacing);

}  // namespace kirireel
