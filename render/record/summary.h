/// summary.json: what a run was, how accurate, and what it cost.
#pragma once

#include <string>
#include <utility>
#include <vector>

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

// ------------------------------------------------------------------------------------------------
// The versions of the program and of the libraries that shape its results.

/// The program's own version, e.g. "0.1.0".
std::string programVersion();

/// Names and versions, the program first. They enter the fingerprint of every run: another library
/// may give other bytes.
std::vector<std::pair<std::string, std::string>> allVersions();

/// The same, one "name version" a line.
std::string versionText();

}  // namespace kirireel
