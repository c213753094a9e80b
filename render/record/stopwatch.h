/// What parts of a run cost.
#pragma once

#include <chrono>
#include <cstdint>

namespace kirireel {

/// CPU seconds that this process has used on all its threads.
double processCpuSeconds();

/// Largest resident memory of this process so far, bytes.
std::int64_t peakMemoryBytes();

/// Adds the CPU seconds of its own lifetime to a sum.
class CpuTimer {
 public:
  explicit CpuTimer(double& sum) : sum_(sum), start_(processCpuSeconds()) {}
  ~CpuTimer() { sum_ += processCpuSeconds() - start_; }
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
