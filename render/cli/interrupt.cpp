#include "render/cli/interrupt.h"

#include <atomic>
#include <csignal>

namespace kirireel {
namespace {

std::atomic<int> noted = 0;
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler may not wait for a lock");

extern "C" void noteInterrupt(int signal) {
  noted = signal;
}

}  // namespace

void noteSignals() {
  std::signal(SIGINT, noteInterrupt);
  std::signal(SIGTERM, noteInterrupt);
  if (std::signal(SIGHUP, noteInterrupt) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

std::optional<std::string> takeInterrupt() {
  switch (noted.exchange(0)) {
    case SIGINT:
      return "SIGINT";
    case SIGTERM:
      return "SIGTERM";
    case SIGHUP:
      return "SIGHUP";
    default:
      return std::nullopt;
  }
}

}  // namespace kirireel
