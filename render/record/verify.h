/// Whether what a finished run left still is what it says it is.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace kirireel {

/// What was found in a run's folder. Complaints begin with the path of the file that they are
/// about.
struct VerifyReport {
  int files = 0;                        ///< compared with their size and hash
  int samples = 0;                      ///< whose figures were computed again
  std::vector<std::string> complaints;  ///< one line each; none when all agrees
};

/// A run that is over, its files whole.
struct FinishedRun {
  std::string outcome;           ///< as summary.json has it, never "interrupted"
  std::optional<bool> atTarget;  ///< as summary.json has it
  std::string summary;           ///< the text of summary.json
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

}  // namespace kirireel
