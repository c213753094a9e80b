/// summary.json: what a run was, how accurate, and what it cost.
#pragma once

#include <string>

#include "render/record/record.h"

namespace kirireel {

/// The text of summary.json, keys in a fixed order, ending in a newline. The same run gives the
/// same text but for "cost", "versions" and "sha256", the seal of all that stands before it.
/// Figures that do not exist (an error without a target) are null. `summary.digests` holds all
/// files but summary.json itself.
std::string summaryJson(const Scene& scene, const RecordSettings& settings,
                        const RunSummary& summary);

/// What a run found out about its scene, as JSON, as trajectory.h5 keeps it: entries of
/// summary.json that its poses alone do not give.
std::string findingsText(const Scene& scene, const RunSummary& summary);

/// The settings of a run as JSON, as trajectory.h5 keeps them: the same as summary.json's. Ends in
/// a newline.
std::string settingsText(const Scene& scene, const RecordSettings& settings);

}  // namespace kirireel
