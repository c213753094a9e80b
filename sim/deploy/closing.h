/// From full extension on to the second compact state of a sheet.
#pragma once

#include "sim/deploy/assembled_state.h"
#include "sim/deploy/continuation.h"
#include "sim/deploy/geometric_path.h"
#include "sim/deploy/search_budget.h"
#include "sim/scene/scene.h"

namespace kirireel::deploy {

/// Follows a sheet beyond full extension until its tiles meet again. `found` is its path to full
/// extension and becomes the whole path. Contacts are left out on the way.
///
/// Throws InputError for a sheet that does not extend, one with more than one motion half way to
/// full extension, one that stops before its tiles meet, and one whose tiles never meet.
void continueUntilClosed(const scene::Scene& scene, SearchBudget& budget,
                         const PathObserver& shouldContinue, GeometricPath& found);

}  // namespace kirireel::deploy
