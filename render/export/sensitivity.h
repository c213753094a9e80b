/// How much what a deck says depends on its elements.
#pragma once

#include <string>
#include <vector>

#include "render/export/export.h"

namespace kirireel {

/// One line for each state that settings export as a deck (with necks one for the flat sheet): what
/// its job gives in CalculiX, and what it gives with elements half as long. Throws InputError when
/// ccx is not installed, when there are no decks, when elements half as long are too many, and what
/// making elements throws; RunError when ccx fails. Takes as long as CalculiX does, twice for each
/// state; the finer one dominates.
std::vector<std::string> meshSensitivity(const TrajectoryReader& trajectory,
                                         const ExportSettings& settings);

}  // namespace kirireel
