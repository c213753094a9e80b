/// Warnings about the target, issued before the run.
#pragma once

#include <string>
#include <vector>

#include "sim/run/assembled_state.h"
#include "sim/scene/scene.h"

namespace kirireel::path {

/// One line per problem, with figures in metres and in tiles. The target's own joints are open by
/// more than a thousandth of a tile, the target is turned over, or rigid tiles miss it by more than
/// a tenth of a tile. Another warning is about a start that was aligned to its target although
/// ground or obstacles fix its position. Empty without problems or without a pull to the target.
std::vector<std::string> targetWarnings(const scene::Scene& scene);

/// Warns if no state with closed joints was found within a tenth of a tile of the target, beyond
/// the distance that single rigid tiles miss. Otherwise empty.
std::string reachWarning(const scene::Scene& scene, const run::AssembledState& nearest);

}  // namespace kirireel::path
