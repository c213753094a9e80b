/// Threads that work on one job and end together.
#pragma once

#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace kirireel {

/// Starts the stages of a job, each on a thread of its own. The first error of any of them stops
/// the others, and finish() throws it.
class Crew {
 public:
  /// stopAll: makes every stage end soon, whatever it waits for; called from any thread.
  explicit Crew(std::function<void()> stopAll) : stopAll_(std::move(stopAll)) {}
  /// Stops what is still at work and waits for it.
  ~Crew();
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;

  /// Runs a stage on a thread of its own; what may end this thread from within may end that one.
  void start(std::function<void()> stage);

  /// Runs a stage on this thread. Throws nothing: an error is kept for finish().
  void run(const std::function<void()>& stage);

  /// Waits until every stage has ended; throws the first error. Afterwards the crew has no threads.
  /// Errors after the first are dropped: most are consequences of it.
  void finish();

 private:
  std::function<void()> stopAll_;
  std::mutex mutex_;
  std::exception_ptr error_;
  std::vector<std::jthread> threads_;
};

}  // namespace kirireel
