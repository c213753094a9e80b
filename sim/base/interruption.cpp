// Checks for interruption, cheap enough for inner loops. A check reads the kernel's coarse clock in
// shared memory. It calls the scopes only if 10 ms have passed since the last call on this thread.
// Scopes and their times are thread-local. A worker thread gets its checks from presentChecks().
#include "sim/base/interruption.h"

#include <ctime>
#include <utility>

namespace kirireel {
namespace {

constexpr long kBetweenChecks = 10;  // milliseconds

thread_local const InterruptionScope* innermostScope = nullptr;
thread_local long nextCheck = 0;  // milliseconds
thread_local int catchers = 0;

/// Milliseconds since an arbitrary time. Exact to 4 ms, and five times faster than the exact time:
/// innermost loops call it.
long coarseTime() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC_COARSE, &now);
  return 1000 * now.tv_sec + now.tv_nsec / 1'000'000;
}

}  // namespace

InterruptionScope::InterruptionScope(InterruptionCheck check)
    : check_(std::move(check)), outer_(std::exchange(innermostScope, this)) {}

InterruptionScope::~InterruptionScope() {
  innermostScope = outer_;
}

void InterruptionScope::callAll() const {
  if (outer_) outer_->callAll();
  check_();
}

InterruptionCatcher::InterruptionCatcher() {
  ++catchers;
}

InterruptionCatcher::~InterruptionCatcher() {
  --catchers;
}

bool InterruptionCatcher::exists() {
  return catchers > 0;
}

void checkInterruption() {
  if (!innermostScope) return;
  const long now = coarseTime();
  if (now < nextCheck) return;
  // Set before the calls, which may throw.
  nextCheck = now + kBetweenChecks;
  innermostScope->callAll();
}

InterruptionCheck presentChecks() {
  return [scope = innermostScope] {
    if (scope) scope->callAll();
  };
}

// ------------------------------------------------------------------------------------------------
// The clock of the calling thread counts only while the thread runs. Times do not depend on the
// load of the machine, except through its caches.

namespace {

double secondsOf(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace

double threadCpuSeconds() {
  return secondsOf(CLOCK_THREAD_CPUTIME_ID);
}

double processCpuSeconds() {
  return secondsOf(CLOCK_PROCESS_CPUTIME_ID);
}

}  // namespace kirireel
