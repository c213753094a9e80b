// Exceptions do not leave a thread by themselves: run() keeps the first and stops the others,
// finish() joins all and throws it on the thread of the caller. Checks for interruption belong to a
// thread, so a new one takes over those of the thread that starts it.
#include "render/record/crew.h"

#include "sim/base/interruption.h"

namespace kirireel {

Crew::~Crew() {
  if (threads_.empty()) return;
  stopAll_();
  threads_.clear();
}

void Crew::start(std::function<void()> stage) {
  threads_.emplace_back([this, stage = std::move(stage), checks = presentChecks()] {
    const InterruptionScope scope(checks);
    run(stage);
  });
}

void Crew::run(const std::function<void()>& stage) {
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

void Crew::finish() {
  for (std::jthread& thread : threads_) thread.join();
  threads_.clear();
  if (error_) std::rethrow_exception(error_);
}

}  // namespace kirireel
