/// Detours cut out of a path of the mechanism.
#pragma once

#include "sim/deploy/continuation.h"

namespace kirireel {

/// A path is a detour where it is longer than its tiles' own motions by more than this factor.
inline constexpr double kDetour = 1.5;

/// Whether a path is that much longer than the tiles' own motions from its first state to its last.
/// Costs one distance of two states.
bool isDetour(const Scene& scene, const MechanismPath& path);

/// The path with its detours cut out: the states in between are left out wherever the mechanism,
/// among the contacts that the scene asks for, goes a shorter way from one state to a later one, on
/// which no bricks overlap by more than `mostGrown` metres beyond their overlap at the start.
/// Joints of the path are closed. Ends early when the budget is spent or `goesOn`, which may be
/// empty, returns false.
MechanismPath withShortcuts(const Scene& scene, MechanismPath path, double mostGrown,
                            SearchBudget& budget, const PathObserver& goesOn = {});

}  // namespace kirireel
