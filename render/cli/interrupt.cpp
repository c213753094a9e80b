// A handler may do nothing but note the number of its signal (C++ standard, [support.signal];
// signal-safety(7)): a lock-free atomic. Whoever works asks takeInterrupt() now and then and ends
// at a place where files are whole. A second signal is noted in the same way, so an impatient user
// ends the next stage too, and never leaves half a file.
//
// SIGXFSZ comes when a file would grow beyond the limit of its process (ulimit -f); ignored, the
// write fails with EFBIG, which is reported like a full disk.
#include "render/cli/interrupt.h"

#include <atomic>
#include <csignal>

namespace kirireel {
namespace {

std::atomic<int> noted = 0;
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler may not wait for a lock");

/// Later signals replace earlier ones that nobody has taken.
extern "C" void noteInterrupt(int signal) {
  noted = signal;
}

}  // namespace

void noteSignals() {
  std::signal(SIGINT, noteInterrupt);
  std::signal(SIGTERM, noteInterrupt);
  // signal() returns what was set before: nohup ignores SIGHUP, and so it stays.
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
