#include "render/cli/interrupt.h"

#include <atomic>
#include <csignal>

namespace kirireel {
namespace {

std::atomic<bool> interrupted = false;
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may not wait for a lock");

extern "C" void noteInterrupt(int /*signal*/) {
  interrupted = true;
}

}  // namespace

void noteSignals() {
  std::signal(SIGINT, noteInterrupt);
  std::signal(SIGTERM, noteInterrupt);
  std::signal(SIGXFSZ, SIG_IGN);
}

bool takeInterrupt() {
  return interrupted.exchange(false);
}

}  // namespace kirireel
