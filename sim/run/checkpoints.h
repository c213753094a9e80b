/// Checkpoints of a deployment on disk. Another process can continue from one and ends with
/// identical results.
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/state_tape.h"
#include "sim/run/search.h"

namespace kirireel::run {

/// Frequency of checkpoints.
struct CheckpointPace {
  double minSeconds = 2;         ///< minimum time between two checkpoints, wall time
  double largestShare = 0.0025;  ///< maximum share of that time spent on writing
};

/// State of a run between two samples.
struct RunState {
  double time = 0;              ///< simulated seconds
  std::vector<double> numbers;  ///< complete state, see StateTape; empty before the run

  static constexpr auto fields() {
    return describeFields<RunState>(field("time", &RunState::time, "s"),
                                    field("numbers", &RunState::numbers));
  }
};

/// A folder with the latest checkpoint of one run. state.h5 is written atomically. The samples up
/// to it are in samples_00001.h5 and so on, one file per checkpoint. Numbers are exact and
/// protected by checksums. The first checkpoint creates the folder.
class Checkpoints {
 public:
  /// `order` identifies this run.
  Checkpoints(std::filesystem::path folder, std::string order, CheckpointPace pace = {});

  /// Searches a checkpoint of this order. Returns one line about the result, or an empty string if
  /// there is none. Removes a checkpoint that is damaged or of another order. Throws OutputError.
  std::string find();
  /// Removes the folder, because the run has ended or starts again. Throws OutputError.
  void remove();

  /// Whether the next checkpoint is due.
  bool isDue() const;
  /// Writes a checkpoint of a run, or of the search before it. Throws OutputError.
  void save(RunState run);

  /// Result of the straight pull, if the search has tried it.
  std::optional<TrialEnd>& straightPull() { return straightPull_; }
  /// CPU seconds of the search, including earlier processes.
  double& searchSeconds() { return searchSeconds_; }
  /// Receives the samples, each with the run's data at that time.
  StateTape& samples() { return samples_; }

  /// The state of the latest checkpoint, read or written. Null before the first.
  const RunState* run() const { return run_.numbers.empty() ? nullptr : &run_; }
  /// Plays back that run's samples, one per call, until `take` returns false.
  void playSamples(const std::function<bool(StateTape&)>& take) const;

 private:
  using Clock = std::chrono::steady_clock;

  void transfer(StateTape& tape) {
    tape.transfer(straightPull_, searchSeconds_, sampleFiles_, run_);
  }
  std::filesystem::path samplesFile(std::size_t index) const;
  StateTape readSamples(std::size_t index) const;
  void write(const std::filesystem::path& path, const StateTape& tape) const;
  void waitAfter(Clock::duration taken);

  std::filesystem::path folder_;
  std::string order_;
  CheckpointPace pace_;
  std::optional<TrialEnd> straightPull_;
  double searchSeconds_ = 0;
  StateTape samples_;                     // since the last checkpoint
  std::vector<std::size_t> sampleFiles_;  // count of numbers in each
  RunState run_;
  Clock::time_point due_;
};

}  // namespace kirireel::run
