/// What is wrong with a target, told before the run.
#pragma once

#include <string>
#include <vector>

#include "sim/deploy/assembled_state.h"
#include "sim/scene/scene.h"

namespace kirireel {

/// One line each, with figures in metres and in tiles, where the scene's target is torn (its own
/// joints are open there by more than a thousandth of a tile), turned over, or out of reach of
/// rigid tiles by more than a tenth of a tile, and where a start was moved onto its target although
/// its place counts (ground, obstacles). Empty where all is well, or nothing pulls to the target.
std::vector<std::string> targetWarnings(const Scene& scene);

/// The same where no state with closed joints was found within a tenth of a tile, beyond what rigid
/// tiles by themselves miss; empty otherwise.
std::string reachWarning(const Scene& scene, const AssembledState& nearest);

}  // namespace kirireel
