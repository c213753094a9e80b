/// Which samples of a trajectory are exported.
#pragma once

#include <string>
#include <vector>

#include "sim/trajectory/trajectory_file.h"

namespace kirireel {

/// A sample and what its files are called.
struct ChosenState {
  std::size_t sample = 0;
  std::string label;  ///< "final", "50pct", "1.5s", "30deg", "event_TEXT"; "0007" of `all`

  bool operator==(const ChosenState&) const = default;
};

/// Throws InputError for a name that means nothing below, whatever the trajectory.
void requireStateName(const std::string& name);

/// A name as part of a file's: letters, digits, points and hyphens. The sample counts for `all`
/// alone. Throws as requireStateName does.
std::string stateLabel(const std::string& name, std::size_t sample);

/// The samples that are named, rising. A name is one of
/// - `initial`, `final`, `all`;
/// - `25%`: a share of the simulated time, 0 to 100;
/// - `1.5` or `1.5s`: a time, from 0 to the end, seconds;
/// - `30deg`: the first sample at which some tile has turned so far from its start;
/// - `event:TEXT`: the first event whose text contains this.
///
/// Shares, times and events stand for the nearest sample. Throws InputError for a name that means
/// nothing, a state that is not in the trajectory, and two names of one sample. An angle reads the
/// trajectory up to its sample; the others look at times alone.
std::vector<ChosenState> chooseStates(const TrajectoryReader& trajectory,
                                      const std::vector<std::string>& names);

}  // namespace kirireel
