/// `kirireel sweep SWEEP`.
#pragma once

#include <cstdint>
#include <filesystem>

#include "render/sweep/worker_pool.h"

namespace CLI {
class App;
}

namespace kirireel {

/// A part of a sweep: every `count`-th run from the `number`-th on. Numbers count from 1; `number`
/// is at most `count`.
struct SweepShard {
  std::uint64_t number = 1;  ///< from 1 to count
  std::uint64_t count = 1;
};

/// Runs that are to be made or gathered. Nothing of the sweep file is read before carryOut().
struct SweepOrder {
  std::filesystem::path sweep;   ///< the sweep file
  std::filesystem::path folder;  ///< empty: out/NAME of the sweep file
  SweepShard shard;
  WorkerLimits limits;
  bool retryFailed = false;
  bool collectOnly = false;  ///< make no runs
  bool confirmed = false;    ///< however many runs there are
};

/// Adds `sweep`. The order must outlive the parsing.
CLI::App* addSweepCommand(CLI::App& program, SweepOrder& order);

/// Throws InputError where something is missing. To be called after parsing.
void completeOrder(const CLI::App& command, SweepOrder& order);

/// Makes the runs that are missing and, unless it is one shard of several, gathers them all.
/// Returns the exit code: 1 when a run has failed, but not when one ended short of its target. 4
/// when a signal ended it. Throws InputError for a sweep file that cannot be meant, OutputError
/// where the folder cannot be written.
int carryOut(const SweepOrder& order);

}  // namespace kirireel
