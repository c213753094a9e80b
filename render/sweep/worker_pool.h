/// Many short jobs in a few child processes. A job that crashes, hangs or uses too much memory
/// harms no other.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

namespace kirireel::sweep {

/// How a job ended.
enum class Verdict : char {
  Done,     ///< its process ended with the exit code 0
  Failed,   ///< it ended in any other way
  Skipped,  ///< there was nothing to do
};

/// Limits of the workers.
struct WorkerLimits {
  int count = 1;                 ///< of processes, at least 1
  double seconds = 3600;         ///< of wall time for each job, positive
  std::int64_t memoryBytes = 0;  ///< of data for each process; 0 for no limit
};

/// The jobs of a pool. Numbers name jobs.
struct WorkerJobs {
  std::function<std::optional<std::uint64_t>()> next;  ///< the next job, or null
  std::function<Verdict(std::uint64_t)> work;          ///< does a job; called in a worker
  /// Called when a job's process has ended before its job, or was stopped at the time limit, with
  /// the reason in one line.
  std::function<Verdict(std::uint64_t, const std::string& reason)> lost;
  /// Called after each job and a few times a second in between, then without a job; return false to
  /// stop all workers and their jobs at once.
  std::function<bool(std::optional<Verdict>)> watch;
};

/// Does all jobs. Workers are forked from the caller, which must not have more than one thread, and
/// do one job after the other, because starting the program again takes longer than a short run.
/// They always end with the caller. Only the caller handles SIGINT and SIGTERM. A job whose process
/// was killed from outside (SIGKILL, as when memory runs out) is tried once more. Returns false
/// when `watch` ended it. Throws RunError when processes cannot be made, and exceptions of `lost`.
/// `next`, `lost` and `watch` are called in the caller, one at a time. Linux only: it relies on
/// prctl(2).
bool runInWorkers(const WorkerJobs& jobs, const WorkerLimits& limits);

}  // namespace kirireel::sweep
