/// What parts of a run cost.
///
/// CPU seconds are those of one thread, so that stages which run at the same time can be told
/// apart; wall seconds are those of a clock that is never set back.
#pragma once

#include <chrono>
#include <cstdint>

#include "sim/base/cpu_time.h"

namespace kirireel {

/// Largest resident memory of this process so far, bytes. Never falls.
std::int64_t peakMemoryBytes();

/// Adds the CPU seconds that its thread uses during its lifetime to a sum.
class CpuTimer {
 public:
  explicit CpuTimer(double& sum) : sum_(sum), start_(threadCpuSeconds()) {}
  ~CpuTimer() { sum_ += threadCpuSeconds() - start_; }
  CpuTimer(const CpuTimer&) = delete;
  CpuTimer& operator=(const CpuTimer&) = delete;

 private:
  double& sum_;
  double start_;
};

/// Seconds on the wall since it was made.
class Stopwatch {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace kirireel
