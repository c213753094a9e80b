/// summary.json: the settings, accuracy and cost of a run. Checks that its files still agree with
/// it.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "render/record/job.h"
#include "sim/base/files.h"

namespace kirireel::record {

/// [x, y, z].
Json vectorJson(const Vector3& vector);

/// Events by time, as in summary.json.
Json eventsJson(const std::vector<trajectory::Event>& events);

/// The text of summary.json with keys in a fixed order and a newline at its end. The same run gives
/// the same text except for "cost", "versions" and "sha256", the hash of everything before it.
/// Figures that do not exist (an error without a target) are null. `summary.digests` has all files
/// except summary.json itself.
std::string summaryJson(const scene::Scene& scene, const RecordSettings& settings,
                        const RunSummary& summary);

/// Findings of a run about its scene as JSON, as stored in trajectory.h5: the entries of
/// summary.json that do not follow from its poses.
std::string findingsText(const scene::Scene& scene, const RunSummary& summary);

/// The settings of a run as JSON, equal in trajectory.h5 and summary.json. Ends with a newline.
std::string settingsText(const scene::Scene& scene, const RecordSettings& settings);

// ------------------------------------------------------------------------------------------------
// The versions of the program and of the libraries that affect its results.

/// The program's own version, e.g. "0.1.0".
std::string programVersion();

/// Author and source of a run's pictures, for the metadata of PNG, SVG, PDF and video files.
/// `order`: fingerprint of the run; may be empty.
std::string madeBy(const std::vector<std::string>& models, const std::string& order = "");

/// Names and versions, the program first. Part of the fingerprint of every run, because another
/// library may give other bytes.
std::vector<std::pair<std::string, std::string>> allVersions();

/// The same as text, one "name version" per line.
std::string versionText();

/// The inputs of a run of a sweep by their names, from run.json in its folder. Empty for other
/// runs.
std::map<std::string, std::string> sweepInputs(const std::filesystem::path& folder);

// ------------------------------------------------------------------------------------------------
// Checks that the files of a finished run are unchanged.

/// Result of checking a run's folder. Each complaint begins with the path of the file concerned.
struct VerifyReport {
  int files = 0;                        ///< number of files whose size and hash were compared
  int samples = 0;                      ///< number of samples whose figures were recomputed
  std::vector<std::string> complaints;  ///< one line each; empty if all agrees
};

/// A finished run with unchanged files.
struct FinishedRun {
  std::string outcome;   ///< as in summary.json, never "interrupted"
  bool isShort = false;  ///< summary.json has a shortfall
  std::string summary;   ///< the text of summary.json
};

/// The run in a folder, if it was not interrupted, has this order and its files are unchanged; null
/// in any other case, also for an empty folder. `order` is RecordSettings::order. Reads every file
/// of the run for its hash.
std::optional<FinishedRun> findFinishedRun(const std::filesystem::path& folder,
                                           const std::string& order);

/// Compares every file listed in the folder's summary.json with its recorded size and hash, and the
/// summary with its own hash. Recomputes the figures of trajectory.h5 from its poses and compares
/// them with those in it and in the summary. Throws InputError if there is no summary.json. The
/// cost is that of measuring all samples, mainly of overlaps.
VerifyReport verifyRun(const std::filesystem::path& folder);

}  // namespace kirireel::record
