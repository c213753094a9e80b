/// A queue between two threads, short so that the faster one waits for the slower one.
///
/// Any number of threads may push and pop. One mutex and one condition: a video has some hundred
/// frames a second at most, so that the lock costs nothing that shows.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

namespace kirireel {

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

}  // namespace kirireel
