/// Ctrl-C while no Python code runs.
#pragma once

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

  /// Whether Ctrl-C came since this was made. May be asked from any thread.
  bool isInterrupted() const;

  /// Throws what Python makes of it (KeyboardInterrupt) where Ctrl-C came. Needs the interpreter.
  void raise() const;

 private:
  int before_;
};

}  // namespace kirireel::python
