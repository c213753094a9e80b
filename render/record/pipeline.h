/// Communication between the threads of a recording, and their cost.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "render/picture/frame.h"
#include "sim/base/interruption.h"
#include "sim/trajectory/trajectory.h"
#include "sim/trajectory/trajectory_file.h"

namespace kirireel::record {

// ------------------------------------------------------------------------------------------------
// A short queue between two threads; the faster one waits for the slower one.
//
// Any number of threads may push and pop. One mutex and one condition suffice: a video has at most
// some hundred frames per second, so the cost of the lock is negligible.

/// Passes values from pushing to popping threads, in order. Holds at most `capacity` values.
template <typename T>
class BoundedQueue {
 public:
  /// The capacity is at least 1.
  explicit BoundedQueue(std::size_t capacity) : capacity_(capacity) {}

  /// Waits for space and adds a value. Returns false without adding after stop().
  bool push(T value) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return stopped_ || values_.size() < capacity_; });
    if (stopped_) return false;
    values_.push_back(std::move(value));
    changed_.notify_all();
    return true;
  }

  /// Waits for a value and removes it. Empty after close() if no values are left, and after stop().
  std::optional<T> pop() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return stopped_ || closed_ || !values_.empty(); });
    if (stopped_ || values_.empty()) return std::nullopt;
    std::optional<T> value = std::move(values_.front());
    values_.pop_front();
    changed_.notify_all();
    return value;
  }

  /// Declares the end of input; remaining values can still be popped.
  void close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    changed_.notify_all();
  }

  /// Ends both sides at once and destroys the remaining values.
  void stop() {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    values_.clear();
    changed_.notify_all();
  }

  /// Whether stop() was called; any thread may call this.
  bool isStopped() {
    const std::lock_guard lock(mutex_);
    return stopped_;
  }

 private:
  std::size_t capacity_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<T> values_;
  bool closed_ = false;
  bool stopped_ = false;
};

// ------------------------------------------------------------------------------------------------
// Threads that work on one job and end together.

/// Starts the stages of a job, each on its own thread. The first error of any of them stops the
/// others, and finish() throws it.
class TaskGroup {
 public:
  /// stopAll: stops every stage soon, even a waiting one; any thread may call it.
  explicit TaskGroup(std::function<void()> stopAll) : stopAll_(std::move(stopAll)) {}
  /// Stops running stages and waits for them.
  ~TaskGroup();
  TaskGroup(const TaskGroup&) = delete;
  TaskGroup& operator=(const TaskGroup&) = delete;

  /// Runs a stage on its own thread, with the interruption checks of this thread.
  void start(std::function<void()> stage);

  /// Runs a stage on this thread. Does not throw: stores an error for finish().
  void run(const std::function<void()>& stage);

  /// Waits until every stage has ended; throws the first error. Afterwards there are no threads.
  /// Errors after the first are dropped, since most are consequences of it.
  void finish();

 private:
  std::function<void()> stopAll_;
  std::mutex mutex_;
  std::exception_ptr error_;
  std::vector<std::jthread> threads_;
};

// ------------------------------------------------------------------------------------------------
// Samples that several threads share.
//
// A sample is shared and never changed, so no thread needs a copy or a lock to read it. It is
// destroyed when the last thread has released it.

/// A sample that several threads may read at the same time.
using SharedSample = std::shared_ptr<const trajectory::Sample>;

/// Number of samples that wait between two threads: enough to equalise their pace, and a limit of
/// their memory.
inline constexpr std::size_t kWaitingSamples = 16;

// ------------------------------------------------------------------------------------------------
// Writes a run's trajectory on its own thread during the deployment.

/// Owns the file and the thread. Without finish() the destructor leaves no file.
class ThreadedTrajectoryWriter {
 public:
  /// The file gets the curves' channels (makeCurveMeter). `subject` must outlive this object.
  /// Throws OutputError if the file cannot be made.
  ThreadedTrajectoryWriter(const std::filesystem::path& path, const trajectory::Subject& subject);

  /// Passes a sample to the thread. Returns false after a write error, which finish() throws. May
  /// wait for space in the queue.
  bool take(const SharedSample& sample);

  /// Waits for the last sample and moves the file into place. Throws OutputError.
  void finish(const trajectory::TrajectoryEnd& end);

 private:
  void writeAll();

  trajectory::TrajectoryWriter writer_;
  BoundedQueue<SharedSample> samples_;
  TaskGroup tasks_;  // last: its thread ends before the members that it uses
};

// ------------------------------------------------------------------------------------------------
// Frames of a video with reused memory.

/// Spare frames for any thread. Otherwise painters would allocate some tens of megabytes per frame,
/// which the encoder's thread frees, and the heap would grow during a video.
class FramePool {
 public:
  /// A spare frame with any content; an empty one if there is none.
  picture::Frame take() {
    const std::lock_guard lock(mutex_);
    if (spare_.empty()) return {};
    picture::Frame frame = std::move(spare_.back());
    spare_.pop_back();
    return frame;
  }

  /// The pool keeps its memory until a painter takes it.
  void giveBack(picture::Frame frame) {
    const std::lock_guard lock(mutex_);
    spare_.push_back(std::move(frame));
  }

 private:
  std::mutex mutex_;
  std::vector<picture::Frame> spare_;
};

// ------------------------------------------------------------------------------------------------
// Cost of parts of a run.
//
// CPU seconds are those of one thread, so concurrent stages can be separated. Wall seconds are from
// a monotonic clock.

/// Peak resident memory of this process, bytes.
std::int64_t peakMemoryBytes();

/// Adds the CPU seconds of its thread during its lifetime to a sum.
class CpuTimer {
 public:
  /// `sum` gets the CPU time of this thread from now to destruction, seconds.
  explicit CpuTimer(double& sum) : sum_(sum), start_(threadCpuSeconds()) {}
  ~CpuTimer() { sum_ += threadCpuSeconds() - start_; }
  CpuTimer(const CpuTimer&) = delete;
  CpuTimer& operator=(const CpuTimer&) = delete;

 private:
  double& sum_;
  double start_;
};

/// Wall time since construction.
class Stopwatch {
 public:
  /// Seconds since construction.
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace kirireel::record
