/// What a page says of a run in words.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "sim/trajectory/trajectory_file.h"

namespace kirireel {

/// Facts in the order of reading: what, and how much.
using Facts = std::vector<std::pair<std::string, std::string>>;

/// What a run was, how it ended and how accurate it is, from its trajectory alone. Texts are plain,
/// not yet escaped. Reads every sample once.
Facts factsOf(const TrajectoryReader& run);

/// What a run warns of, one line each.
std::vector<std::string> warningsOf(const TrajectoryReader& run);

/// Text as HTML shows it literally, within elements and attributes.
std::string htmlText(const std::string& text);

}  // namespace kirireel
