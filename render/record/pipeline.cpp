// Exceptions do not leave a thread by themselves: run() keeps the first and stops the others,
// finish() joins all and throws it on the thread of the caller. Checks for interruption belong to a
// thread, so a new one takes over those of the thread that starts it.
#include "render/record/pipeline.h"

#include <sys/resource.h>

#include "sim/trajectory/run_curves.h"

namespace kirireel::record {

TaskGroup::~TaskGroup() {
  if (threads_.empty()) return;
  stopAll_();
  threads_.clear();
}

void TaskGroup::start(std::function<void()> stage) {
  threads_.emplace_back([this, stage = std::move(stage), checks = presentChecks()] {
    const InterruptionScope scope(checks);
    run(stage);
  });
}

void TaskGroup::run(const std::function<void()>& stage) {
  try {
    stage();
  } catch (...) {
    // Carried to the thread that waits in finish().
    {
      const std::lock_guard lock(mutex_);
      if (!error_) error_ = std::current_exception();
    }
    stopAll_();
  }
}

void TaskGroup::finish() {
  for (std::jthread& thread : threads_) thread.join();
  threads_.clear();
  if (error_) std::rethrow_exception(error_);
}

// ------------------------------------------------------------------------------------------------
// A thread compresses and writes samples while the deployment continues. At most sixteen samples
// wait; then the deployment waits.

ThreadedTrajectoryWriter::ThreadedTrajectoryWriter(const std::filesystem::path& path,
                                                   const trajectory::Subject& subject)
    : writer_(path, subject, trajectory::makeCurveMeter(subject)),
      samples_(kWaitingSamples),
      tasks_([this] { samples_.stop(); }) {
  tasks_.start([this] { writeAll(); });
}

bool ThreadedTrajectoryWriter::take(const SharedSample& sample) {
  return samples_.push(sample);
}

void ThreadedTrajectoryWriter::writeAll() {
  while (const std::optional<SharedSample> sample = samples_.pop()) writer_.append(**sample);
}

void ThreadedTrajectoryWriter::finish(const trajectory::TrajectoryEnd& end) {
  samples_.close();
  tasks_.finish();
  writer_.finish(end);
}

// ------------------------------------------------------------------------------------------------
// The cost of parts of a run.

std::int64_t peakMemoryBytes() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::int64_t>(usage.ru_maxrss) * 1024;  // Linux counts kibibytes
}

}  // namespace kirireel::record
