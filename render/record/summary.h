/// summary.json: what a run was, how accurate, and what it cost; whether its files still agree with
/// it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "render/record/job.h"
#include "sim/base/files.h"

namespace kirireel::record {

/// [x, y, z].
Json vectorJson(const Vector3& vector);

/// Events by time, as summary.json has them.
Json eventsJson(const std::vector<trajectory::Event>& events);

/// The text of summary.json, keys in a fixed order, ending in a newline. The same run gives the
/// same text but for "cost", "versions" and "sha256", the hash of everything before it. Figures
/// that do not exist (an error without a target) are null. `summary.digests` holds all files but
/// summary.json itself.
std::string summaryJson(const scene::Scene& scene, const RecordSettings& settings,
                        const RunSummary& summary);

/// What a run found out about its scene, as JSON, as trajectory.h5 keeps it: entries of
/// summary.json that its poses alone do not give.
std::string findingsText(const scene::Scene& scene, const RunSummary& summary);

/// The settings of a run as JSON, as trajectory.h5 keeps them: the same as summary.json's. Ends in
/// a newline.
std::string settingsText(const scene::Scene& scene, const RecordSettings& settings);

// ------------------------------------------------------------------------------------------------
// The versions of the program and of the libraries that shape its results.

/// The program's own version, e.g. "0.1.0".
std::string programVersion();

/// Names and versions, the program first. They enter the fingerprint of every run: another library
/// may give other bytes.
std::vector<std::pair<std::string, std::string>> allVersions();

/// The same, one "name version" a line.
std::string versionText();

// ------------------------------------------------------------------------------------------------
// Checks that the files of a finished run are unchanged.

/// What was found in a run's folder. Complaints begin with the path of the file that they are
/// about.
struct VerifyReport {
  int files = 0;                        ///< compared with their size and hash
  int samples = 0;                      ///< whose figures were computed again
  std::vector<std::string> complaints;  ///< one line each; none when all agrees
};

/// A run that is over, its files whole.
struct FinishedRun {
  std::string outcome;   ///< as in summary.json, never "interrupted"
  bool isShort = false;  ///< summary.json has a shortfall
  std::string summary;   ///< the text of summary.json
};

/// The run in a folder, when it was not interrupted, came from this order (see RecordSettings), and
/// left files that still are what they were. Anything else there, and nothing at all, gives none.
/// `order` is RecordSettings::order. Reads every file of the run, for its hash.
std::optional<FinishedRun> findFinishedRun(const std::filesystem::path& folder,
                                           const std::string& order);

/// Compares every file that the summary.json in the folder names with the size and the hash noted
/// there, and the summary with its own; computes the figures of trajectory.h5 again from its poses,
/// and compares them with those in it and in the summary. Throws InputError when there is no
/// summary.json. Costs what measuring all samples costs, overlaps above all.
VerifyReport verifyRun(const std::filesystem::path& folder);

}  // namespace kirireel::record
