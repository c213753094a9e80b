/// Many short jobs in a few child processes. A job that crashes, hangs or uses too much memory does
/// not affect other jobs.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

namespace kirireel::sweep {

/// How a job ended.
enum class Verdict : char {
  Done,     ///< its process ended with the exit code 0
  Failed,   ///< its process ended in any other way
  Skipped,  ///< there was nothing to do
};

/// Limits of the workers.
struct WorkerLimits {
  int count = 1;                 ///< number of processes, >= 1
  double seconds = 3600;         ///< wall time of each job, > 0
  std::int64_t memoryBytes = 0;  ///< data of each process; 0: no limit
};

/// The jobs of a pool, identified by numbers.
struct WorkerJobs {
  std::function<std::optional<std::uint64_t>()> next;  ///< returns the next job, or null
  std::function<Verdict(std::uint64_t)> work;          ///< does a job; called in a worker
  /// Called if a process ended before its job or was stopped at the time limit. The reason is one
  /// line.
  std::function<Verdict(std::uint64_t, const std::string& reason)> lost;
  /// Called after each job with its verdict, and a few times per second without one. Return false
  /// to stop all workers and their jobs at once.
  std::function<bool(std::optional<Verdict>)> watch;
};

/// Does all jobs. Forks workers from the caller, which must have only one thread. Each worker does
/// many jobs because starting the program takes longer than a short run. Workers end with the
/// caller. Only the caller handles SIGINT and SIGTERM. Repeats a job once if its process was killed
/// from outside (SIGKILL, for example when memory runs out). Returns false if `watch` stopped it.
/// Throws RunError if no process can be started, and the exceptions of `lost`. Calls `next`, `lost`
/// and `watch` in the caller's thread, one at a time. Linux only, because of prctl(2).
bool runInWorkers(const WorkerJobs& jobs, const WorkerLimits& limits);

}  // namespace kirireel::sweep
