/// Ctrl-C while no Python code runs.
#pragma once

#include <exception>
#include <type_traits>

#include <pybind11/pybind11.h>

#include "sim/base/interruption.h"

namespace kirireel::python {

/// While it lives, Ctrl-C is noticed on every thread at once, besides by Python, which would only
/// look when the call is over. Python's own handler stays in charge, and a Ctrl-C that Python
/// ignores is ignored.
class InterruptionWatch {
 public:
  InterruptionWatch();
  ~InterruptionWatch();
  InterruptionWatch(const InterruptionWatch&) = delete;
  InterruptionWatch& operator=(const InterruptionWatch&) = delete;

  /// Throws CtrlC where it came since this was made. May be asked from any thread.
  void check() const;

  /// Throws what Python makes of it: KeyboardInterrupt. Needs the interpreter.
  [[noreturn]] static void raise();

 private:
  int before_;
};

/// Nothing of a run that Python ends is kept: unlike Interrupted, nobody catches this on its way.
class CtrlC : public std::exception {
 public:
  const char* what() const noexcept override { return "Ctrl-C"; }
};

/// Calls `work` while other threads have the interpreter; Ctrl-C ends it from within. Throws what
/// `work` throws, and KeyboardInterrupt. `work` must not touch Python's objects.
template <typename Work>
std::invoke_result_t<Work> withoutInterpreter(const Work& work) {
  const InterruptionWatch watch;
  const InterruptionScope scope([&watch] { watch.check(); });
  try {
    const pybind11::gil_scoped_release release;
    return work();
  } catch (const CtrlC&) {
    InterruptionWatch::raise();
  }
}

}  // namespace kirireel::python
