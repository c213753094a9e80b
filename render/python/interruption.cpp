// Python's handler of SIGINT only sets a flag, which the interpreter looks at between its own
// instructions; a run of minutes in C++ would not see it. While a watch lives, our handler stands
// before Python's: it counts, then calls Python's, which sets its flag as ever. check() compares
// the count with that at the watch's beginning, from whichever thread works.
//
// Several watches may live at the same time, on several threads; the first puts the handler in and
// the last takes it out.
#include "render/python/interruption.h"

#include <atomic>
#include <csignal>
#include <mutex>

namespace kirireel::python {
namespace {

std::atomic<int> interruptions = 0;
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler may not wait for a lock");

std::mutex handlerMutex;
int watches = 0;                     // that live
struct sigaction pythonAction = {};  // before the first of them

extern "C" void noteAndPassOn(int signal) {
  ++interruptions;
  pythonAction.sa_handler(signal);
}

/// Neither ignored nor left to the system, and of the kind that takes a signal's number alone.
bool isHandled(const struct sigaction& action) {
  return action.sa_handler != SIG_DFL && action.sa_handler != SIG_IGN &&
         (action.sa_flags & SA_SIGINFO) == 0;
}

}  // namespace

InterruptionWatch::InterruptionWatch() : before_(interruptions) {
  const std::lock_guard lock(handlerMutex);
  if (watches++ > 0) return;
  ::sigaction(SIGINT, nullptr, &pythonAction);
  if (!isHandled(pythonAction)) return;
  // Flags and mask stay Python's.
  struct sigaction ours = pythonAction;
  ours.sa_handler = noteAndPassOn;
  ::sigaction(SIGINT, &ours, nullptr);
}

InterruptionWatch::~InterruptionWatch() {
  const std::lock_guard lock(handlerMutex);
  if (--watches == 0 && isHandled(pythonAction)) ::sigaction(SIGINT, &pythonAction, nullptr);
}

void InterruptionWatch::check() const {
  if (interruptions != before_) throw CtrlC();
}

void InterruptionWatch::raise() {
  // On the main thread this runs Python's handler, which raises; other threads end in the same way.
  if (PyErr_CheckSignals() == 0) PyErr_SetNone(PyExc_KeyboardInterrupt);
  throw pybind11::error_already_set();
}

}  // namespace kirireel::python
