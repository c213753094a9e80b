/// What the threads of a recording pass to each other, and what they cost.
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
// A queue between two threads, short so that the faster one waits for the slower one.
//
// Any number of threads may push and pop. One mutex and one condition: a video has some hundred
// frames a second at most. The lock costs nothing that shows.

/// Hands values from the thread that pushes to the thread that pops, in order, at most `capacity`
/// of them at a time.
template <typename T>
class BoundedQueue {
 public:
  /// The capacity is at least 1.
  explicit BoundedQueue(std::size_t capacity) : capacity_(capacity) {}

  /// Waits for room and adds a value. False, and nothing added, once the queue was stopped.
  bool push(T value) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return stopped_ || values_.size() < capacity_; });
    if (stopped_) return false;
    values_.push_back(std::move(value));
    changed_.notify_all();
    return true;
  }

  /// Waits for a value and takes it. Empty when the queue was closed and everything is taken, or
  /// when it was stopped.
  std::optional<T> pop() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return stopped_ || closed_ || !values_.empty(); });
    if (stopped_ || values_.empty()) return std::nullopt;
    std::optional<T> value = std::move(values_.front());
    values_.pop_front();
    changed_.notify_all();
    return value;
  }

  /// Says that nothing more comes; what is in the queue is still taken.
  void close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    changed_.notify_all();
  }

  /// Ends both sides at once; what is in the queue is lost, and destroyed here.
  void stop() {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    values_.clear();
    changed_.notify_all();
  }

  /// Whether it was stopped; any thread may ask.
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
  /// stopAll: stops every stage soon, also while it waits; may be called from any thread.
  explicit TaskGroup(std::function<void()> stopAll) : stopAll_(std::move(stopAll)) {}
  /// Stops what is still at work and waits for it.
  ~TaskGroup();
  TaskGroup(const TaskGroup&) = delete;
  TaskGroup& operator=(const TaskGroup&) = delete;

  /// Runs a stage on its own thread, with the interruption checks of this thread.
  void start(std::function<void()> stage);

  /// Runs a stage on this thread. Throws nothing: an error is kept for finish().
  void run(const std::function<void()>& stage);

  /// Waits until every stage has ended; throws the first error. Afterwards the tasks has no
  /// threads. Errors after the first are dropped: most are consequences of it.
  void finish();

 private:
  std::function<void()> stopAll_;
  std::mutex mutex_;
  std::exception_ptr error_;
  std::vector<std::jthread> threads_;
};

// ------------------------------------------------------------------------------------------------
// Samples that are handed from thread to thread.
//
// A sample is shared and never changed: no thread needs a copy or a lock to read it; it
// goes when the last thread has done with it.

/// A sample that several threads may read at the same time.
using SharedSample = std::shared_ptr<const trajectory::Sample>;

/// How many samples wait between two threads: enough to even out their pace, and all the memory
/// that they may take.
inline constexpr std::size_t kWaitingSamples = 16;

// ------------------------------------------------------------------------------------------------
// Writes a run's trajectory on its own thread during the deployment.

/// Owns the file and the thread. A writer that goes without finish() leaves no file.
class ThreadedTrajectoryWriter {
 public:
  /// The file gets the curves' channels (makeCurveMeter). `subject` must outlive this. Throws
  /// OutputError when the file cannot be made.
  ThreadedTrajectoryWriter(const std::filesystem::path& path, const trajectory::Subject& subject);

  /// Hands over a sample. False once writing has failed; finish() throws the reason. May wait for
  /// room in the queue.
  bool take(const SharedSample& sample);

  /// Waits for the last sample and puts the file in place. Throws OutputError.
  void finish(const trajectory::TrajectoryEnd& end);

 private:
  void writeAll();

  trajectory::TrajectoryWriter writer_;
  BoundedQueue<SharedSample> samples_;
  TaskGroup tasks_;  // last: its thread ends before what it uses
};

// ------------------------------------------------------------------------------------------------
// Frames of a video whose memory is used again.

/// Spare frames, for any thread. Painters would else ask the heap for some tens of megabytes a
/// frame, which the encoder's thread returns: the heap then grows during a video.
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

  /// Its memory stays in the pool until a painter takes it.
  void giveBack(picture::Frame frame) {
    const std::lock_guard lock(mutex_);
    spare_.push_back(std::move(frame));
  }

 private:
  std::mutex mutex_;
  std::vector<picture::Frame> spare_;
};

// ------------------------------------------------------------------------------------------------
// What parts of a run cost.
//
// CPU seconds are those of one thread: stages which run at the same time can be kept
// apart; wall seconds are those of a clock that is never set back.

/// Largest resident memory of this process so far, bytes. Never falls.
std::int64_t peakMemoryBytes();

/// Adds the CPU seconds that its thread uses during its lifetime to a sum.
class CpuTimer {
 public:
  /// Adds the CPU time of its thread, from now to its end, to a sum of seconds.
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
  /// CPU seconds since it was made.
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace kirireel::record
