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

/// Runs to do or to collect. carryOut() reads the sweep file.
struct SweepOrder {
  std::filesystem::path sweep;   ///< the sweep file
  std::filesystem::path folder;  ///< empty: out/NAME of the sweep file
  SweepShard shard;              ///< the runs that this process makes
  sweep::WorkerLimits limits;    ///< of each worker process
  bool retryFailed = false;      ///< also repeat failed runs
  bool collectOnly = false;      ///< do no runs
  bool confirmed = false;        ///< accept any number of runs
};

/// Adds `sweep`. The order must outlive the parsing.
CLI::App* addSweepCommand(CLI::App& program, SweepOrder& order);

/// Throws InputError if an argument is missing. Call it after parsing.
void completeOrder(const CLI::App& command, SweepOrder& order);

/// Does the missing runs. Then collects all results, except for one shard of several. Returns the
/// exit code: 1 if a run has failed (missing its target is not a failure), 4 after a signal. Throws
/// InputError for an invalid sweep file, OutputError if the folder cannot be written.
int carryOut(const SweepOrder& order);

// ------------------------------------------------------------------------------------------------
// The runs of a sweep: their settings, names and execution.

/// Keys and values as typed, ordered by key.
using RunInputs = std::vector<std::pair<std::string, std::string>>;

/// The runs of one sweep file. name() and make() may be called in forked workers, but not from two
/// threads at once because of the cache.
class SweepRuns {
 public:
  /// Checks every key and value of the sweep against the family's parameters and the options of
  /// `kirireel simulate` (or `record` if the sweep keeps pictures). Parameters precede options with
  /// the same key. Throws InputError with file:line:column, suggesting the nearest key.
  explicit SweepRuns(sweep::Sweep sweep);

  /// The plan in the file.
  const sweep::Sweep& sweep() const { return sweep_; }

  /// All settings of a run: the family, then the common settings and its own parameters by key.
  /// `index` < number of runs of the plan.
  RunInputs inputs(std::uint64_t index) const;

  /// Twenty hexadecimal digits of the fingerprint of the run's order, as that of `kirireel
  /// simulate` (or `record`), and of its files.
  std::string name(std::uint64_t index) const;

  /// Does the run in a folder. Throws the errors of runs.
  void make(std::uint64_t index, const std::filesystem::path& folder) const;

 private:
  std::vector<sweep::SweepSetting> settings(std::uint64_t index) const;

  sweep::Sweep sweep_;
  mutable std::map<std::string, OrderInputs> inputs_;  ///< of the runs' input files
};

}  // namespace kirireel::cli
