/// Which samples of a trajectory are exported.
#pragma once

#include <string>
#include <vector>

#include "sim/trajectory/trajectory_file.h"

namespace kirireel {

/// Throws InputError for a name that means nothing below, whatever the trajectory.
void requireStateName(const std::string& name);

/// The samples that are named, rising. A name is one of
/// - `initial`, `final`, `all`;
/// - `25%`: a share of the simulated time, 0 to 100;
/// - `1.5` or `1.5s`: a time, from 0 to the end, seconds;
/// - `30deg`: the first sample at which some tile has turned so far from its start;
/// - `event:TEXT`: the first event whose text contains this.
///
/// Shares, times and events stand for the nearest sample. Throws InputError for a name that means
/// nothing, a state that is not in the trajectory, and two names of one sample, whose files would
/// have one name.
std::vector<std::size_t> chooseStates(const TrajectoryReader& trajectory,
                                      const std::vector<std::string>& names);

}  // namespace kirireel
