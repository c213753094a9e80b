/// Path from full extension to the second compact state of a sheet.
#pragma once

#include "sim/path/continuation.h"
#include "sim/run/assembled_state.h"
#include "sim/run/geometric_path.h"
#include "sim/run/search_budget.h"
#include "sim/scene/scene.h"

namespace kirireel::path {

/// Follows a sheet beyond full extension until its tiles meet again. `found` is its path to full
/// extension and is extended to the whole path. Contacts are ignored along the path.
///
/// Throws InputError if the sheet does not extend, has more than one motion half-way to full
/// extension, stops before its tiles meet, or never meets.
void continueUntilClosed(const scene::Scene& scene, run::SearchBudget& budget,
                         const PathObserver& shouldContinue, run::GeometricPath& found);

}  // namespace kirireel::path
