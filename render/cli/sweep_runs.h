/// The runs of a sweep: what goes into each, what it is called, how it is made.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "render/cli/order_fingerprint.h"
#include "render/sweep/sweep_file.h"

namespace kirireel {

/// Keys and values as typed, by key.
using RunInputs = std::vector<std::pair<std::string, std::string>>;

/// The runs of one sweep file. name() and make() may be called in forked workers; not from two
/// threads at once, because of the cache.
class SweepRuns {
 public:
  /// Checks every key and value of the sweep against the options of `kirireel simulate` (or
  /// `record`, as the sweep keeps more) and the family's parameters, which come first where both
  /// have a key. Throws InputError with file:line:column, suggesting the nearest key.
  explicit SweepRuns(Sweep sweep);

  /// As it was read.
  const Sweep& sweep() const { return sweep_; }

  /// All that a run was told: the family, the settings of all runs, and its own parameters. `index`
  /// is below the number of runs of the plan. By key, the family first.
  RunInputs inputs(std::uint64_t index) const;

  /// Twenty hexadecimal digits of orderFingerprint() of the run as `kirireel simulate` (or
  /// `record`) would be told it, and of what it leaves.
  std::string name(std::uint64_t index) const;

  /// Makes the run in a folder. Throws what a run throws.
  void make(std::uint64_t index, const std::filesystem::path& folder) const;

 private:
  std::vector<SweepSetting> settings(std::uint64_t index) const;

  Sweep sweep_;
  mutable std::map<std::string, OrderInputs> inputs_;  ///< of the files that runs name
};

}  // namespace kirireel
