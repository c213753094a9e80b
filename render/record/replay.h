/// A recorded run as a feed of samples.
#pragma once

#include "render/record/record.h"
#include "render/record/samples.h"
#include "sim/trajectory/trajectory_file.h"

namespace kirireel {

/// The state at any time of a run, seconds from 0 to its end. Between two samples positions go
/// straight and rotations by the shortest turn, measures are the earlier sample's.
Sample sampleAt(const TrajectoryReader& run, double time);

/// Gives the state every `step` simulated seconds from the start, and the last sample. The observer
/// may end it early, which the report then notes. What is passed must outlive the feed.
SampleFeed replay(const TrajectoryReader& run, double step, const ProgressObserver& observer,
                  PictureReport& report);

}  // namespace kirireel
