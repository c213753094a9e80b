/// Which samples of a run become pictures of their own.
#pragma once

#include <vector>

#include "render/record/pace.h"
#include "render/record/record.h"
#include "sim/trajectory/trajectory_file.h"

namespace kirireel {

/// The samples at which the timeline did this ("snapshot", "export"): the first not before each
/// event. In the order of the events, one each.
std::vector<std::size_t> samplesOf(const std::string& event, const TrajectoryReader& run);

/// The indices of the samples nearest to what was asked for, rising, each once. Throws InputError
/// for a time after the run's end.
std::vector<int> chooseFrames(const std::vector<double>& times, const MotionCurve& motion,
                              const std::vector<FrameChoice>& wanted);

}  // namespace kirireel
