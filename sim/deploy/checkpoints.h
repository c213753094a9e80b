/// What a deployment leaves on disk now and then while it runs, so that another process can go on
/// with it and end with the same bytes.
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "sim/base/state_tape.h"
#include "sim/deploy/search.h"

namespace kirireel::deploy {

/// How often checkpoints are made.
struct CheckpointPace {
  double leastSeconds = 2;       ///< from one to the next, by the clock
  double largestShare = 0.0025;  ///< of the time up to the next that making one may take
};

/// A run between two samples.
struct RunState {
  double time = 0;              ///< simulated seconds
  std::vector<double> numbers;  ///< all that it goes on from, see StateTape; empty before the run

  /// For files; see base/fields.h.
  static constexpr auto fields() {
    return describeFields<RunState>(field("time", &RunState::time, "s"),
                                    field("numbers", &RunState::numbers));
  }
};

/// A folder with the latest checkpoint of one run: state.h5, which appears whole, and the samples
/// up to it in samples_00001.h5 and so on, one file for each checkpoint that was made. Numbers are
/// exact and under checksums. The folder appears with the first checkpoint.
class Checkpoints {
 public:
  /// `order` tells this run from all others.
  Checkpoints(std::filesystem::path folder, std::string order, CheckpointPace pace = {});

  /// Looks for a checkpoint of this order. Says in one line what comes of it; nothing where there
  /// is none. One that is of another order or damaged is removed. Throws OutputError.
  std::string find();
  /// Removes the folder: the run is over, or begins anew. Throws OutputError.
  void remove();

  /// Whether it is time for the next checkpoint.
  bool isDue() const;
  /// Makes a checkpoint of a run, or of the search before it. Throws OutputError.
  void save(RunState run);

  /// How the trials of the search for a path ended, in order.
  std::vector<TrialEnd>& trials() { return trials_; }
  /// CPU seconds that the search has taken, in this process and those before it.
  double& searchSeconds() { return searchSeconds_; }
  /// Where samples are recorded, each with what the run notes beside it.
  StateTape& samples() { return samples_; }

  /// The run as of the latest checkpoint, found or made; null before the first.
  const RunState* run() const { return run_.numbers.empty() ? nullptr : &run_; }
  /// Plays that run's samples, one a call, until `take` returns false.
  void playSamples(const std::function<bool(StateTape&)>& take) const;

 private:
  using Clock = std::chrono::steady_clock;

  void transfer(StateTape& tape) { tape.transfer(trials_, searchSeconds_, sampleFiles_, run_); }
  std::filesystem::path samplesFile(std::size_t index) const;
  StateTape readSamples(std::size_t index) const;
  void write(const std::filesystem::path& path, const StateTape& tape) const;
  void waitAfter(Clock::duration taken);

  std::filesystem::path folder_;
  std::string order_;
  CheckpointPace pace_;
  std::vector<TrialEnd> trials_;
  double searchSeconds_ = 0;
  StateTape samples_;                     // since the last checkpoint
  std::vector<std::size_t> sampleFiles_;  // numbers in each
  RunState run_;
  Clock::time_point due_;
};

}  // namespace kirireel::deploy
