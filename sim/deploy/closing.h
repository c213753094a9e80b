/// Path from full extension to the second compact state of a sheet.
#pragma once

#include "sim/deploy/assembled_state.h"
#include "sim/deploy/continuation.h"
#include "sim/deploy/geometric_path.h"
#include "sim/deploy/search_budget.h"
#include "sim/scene/scene.h"

namespace kirireel::deploy {

/// Follows a sheet beyond full extension until its tiles meet again. `found` is its path to full
/// extension and is extended to the whole path. Contacts are ignored along the path.
///
/// Throws InputError if the sheet does not extend, has more than one motion half-way to full
/// extension, stops before its tiles meet, or never meets.
void continueUntilClosed(const scene::Scene& scene, SearchBudget& budget,
                         const PathObserver& shouldContinue, GeometricPath& found);

}  // namespace kirireel::deploy
