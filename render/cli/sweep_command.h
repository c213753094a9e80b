/// `kirireel sweep SWEEP`.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "render/cli/record_command.h"
#include "render/sweep/sweep_plan.h"
#include "render/sweep/worker_pool.h"

namespace CLI {
class App;
}

namespace kirireel::cli {

/// A part of a sweep: every `count`-th run from the `number`-th on. Numbers count from 1; `number`
/// is at most `count`.
struct SweepShard {
  std::uint64_t number = 1;  ///< from 1 to count
  std::uint64_t count = 1;   ///< of shards, >= 1
};

/// Runs to make or to gather. Nothing of the sweep file is read before carryOut().
struct SweepOrder {
  std::filesystem::path sweep;   ///< the sweep file
  std::filesystem::path folder;  ///< empty: out/NAME of the sweep file
  SweepShard shard;              ///< the runs that this process makes
  sweep::WorkerLimits limits;    ///< of each worker process
  bool retryFailed = false;      ///< runs that failed before are tried again
  bool collectOnly = false;      ///< make no runs
  bool confirmed = false;        ///< accepts any number of runs
};

/// Adds `sweep`. The order must outlive the parsing.
CLI::App* addSweepCommand(CLI::App& program, SweepOrder& order);

/// Throws InputError if an argument is missing. Call it after parsing.
void completeOrder(const CLI::App& command, SweepOrder& order);

/// Makes the missing runs and, unless it is one shard of several, collects all results. Returns
/// the exit code: 1 if a run has failed (missing its target is not a failure), 4 after a
/// signal. Throws InputError for an invalid sweep file, OutputError if the folder cannot be
/// written.
int carryOut(const SweepOrder& order);

// ------------------------------------------------------------------------------------------------
// The runs of a sweep: their settings, names and execution.

/// Keys and values as typed, by key.
using RunInputs = std::vector<std::pair<std::string, std::string>>;

/// The runs of one sweep file. name() and make() may be called in forked workers; not from two
/// threads at once, because of the cache.
class SweepRuns {
 public:
  /// Checks every key and value of the sweep against the options of `kirireel simulate` (or
  /// `record`, as the sweep keeps more) and the family's parameters, which come first where both
  /// have a key. Throws InputError with file:line:column, suggesting the nearest key.
  explicit SweepRuns(sweep::Sweep sweep);

  /// The plan as read.
  const sweep::Sweep& sweep() const { return sweep_; }

  /// All settings of a run: the family, the settings of all runs, and its own parameters. `index`
  /// is below the number of runs of the plan. By key, the family first.
  RunInputs inputs(std::uint64_t index) const;

  /// Twenty hexadecimal digits of orderFingerprint() of the run as `kirireel simulate` (or
  /// `record`) as orders, and of its files.
  std::string name(std::uint64_t index) const;

  /// Makes the run in a folder. Throws like a run.
  void make(std::uint64_t index, const std::filesystem::path& folder) const;

 private:
  std::vector<sweep::SweepSetting> settings(std::uint64_t index) const;

  sweep::Sweep sweep_;
  mutable std::map<std::string, OrderInputs> inputs_;  ///< of the files that runs name
};

}  // namespace kirireel::cli
