/// What the Python module gives: models, runs and their options.
#pragma once

#include <exception>
#include <string>
#include <type_traits>
#include <vector>

#include <pybind11/pybind11.h>

#include "sim/base/interruption.h"

namespace kirireel::python {

// ------------------------------------------------------------------------------------------------
// Ctrl-C while no Python code runs.

/// While it lives, Ctrl-C is noticed on every thread at once, besides by Python, which would only
/// look when the call is over. Python's own handler stays in charge, and a Ctrl-C that Python
/// ignores is ignored.
class InterruptionWatch {
 public:
  /// Watches for Ctrl-C from now on, on the thread that made it.
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

// ------------------------------------------------------------------------------------------------
// Options as Python gives them: keyword arguments with the names that scene.toml has.

/// The equivalent words of the command line: thickness=0.02 is --thickness=0.02, ground=True is
/// --ground, a list of numbers is 1,2,3, a list of lists or texts gives the option for each. Values
/// of False or None are omitted. `notHere` are names that the command has but this call has not;
/// throws InputError for them.
std::vector<std::string> optionWords(const pybind11::kwargs& options,
                                     const std::vector<std::string>& notHere);

/// Tells each as a UserWarning of Python. Throws what Python throws where warnings are errors.
/// Needs the interpreter.
void warn(const std::vector<std::string>& warnings);

// ------------------------------------------------------------------------------------------------
// Models in Python: read, made, written.

/// Adds Model, read() and generate(). Their errors are kirireel.InputError and
/// kirireel.OutputError.
void addModels(pybind11::module_& module);

// ------------------------------------------------------------------------------------------------
// Runs in Python: deployed, opened, painted, saved.

/// Adds Sample, Trajectory, Run, deploy() and open(). Angles are radians, lengths metres, times
/// seconds; poses are those of bricks' centres of mass.
void addRuns(pybind11::module_& module);

}  // namespace kirireel::python
