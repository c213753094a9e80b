/// The Python module: models, runs and their options.
#pragma once

#include <exception>
#include <string>
#include <type_traits>
#include <vector>

#include <pybind11/pybind11.h>

#include "sim/base/interruption.h"

namespace kirireel::python {

// ------------------------------------------------------------------------------------------------
// Ctrl-C during calls without Python code.

/// During its lifetime every thread can detect Ctrl-C at once. Python itself would only check after
/// the call. Python's own handler stays active, and a Ctrl-C that Python ignores is ignored.
class InterruptionWatch {
 public:
  /// Watches for Ctrl-C during its lifetime, on the thread that made it.
  InterruptionWatch();
  ~InterruptionWatch();
  InterruptionWatch(const InterruptionWatch&) = delete;
  InterruptionWatch& operator=(const InterruptionWatch&) = delete;

  /// Throws CtrlC if Ctrl-C was pressed since construction. Any thread may call it.
  void check() const;

  /// Throws Python's exception, usually KeyboardInterrupt. Requires the interpreter lock.
  [[noreturn]] static void raise();

 private:
  int before_;
};

/// Discards a run that Python ends: unlike Interrupted, no function catches this exception.
class CtrlC : public std::exception {
 public:
  const char* what() const noexcept override { return "Ctrl-C"; }
};

/// Calls `work` without the interpreter lock; Ctrl-C ends it. Throws exceptions of `work`, and
/// KeyboardInterrupt. `work` must not use Python objects.
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
// Options in Python: keyword arguments with the names in scene.toml.

/// The equivalent command line words: thickness=0.02 is --thickness=0.02, ground=True is --ground,
/// a list of numbers is 1,2,3. A list of lists or texts repeats the option. Values of False or None
/// are omitted. `notHere` are names of the command that this call does not accept. Throws
/// InputError for them.
std::vector<std::string> optionWords(const pybind11::kwargs& options,
                                     const std::vector<std::string>& notHere);

/// Issues each warning as a Python UserWarning. Throws Python's exception if warnings are errors.
/// Requires the interpreter lock.
void warn(const std::vector<std::string>& warnings);

// ------------------------------------------------------------------------------------------------
// Models in Python: read, made, written.

/// Adds Model, read() and generate(). Their errors are kirireel.InputError and
/// kirireel.OutputError.
void addModels(pybind11::module_& module);

// ------------------------------------------------------------------------------------------------
// Runs in Python: deployed, opened, painted, saved.

/// Adds Sample, Trajectory, Run, deploy() and open(). Angles are in radians, lengths in metres,
/// times in seconds. Poses are those of bricks' centres of mass.
void addRuns(pybind11::module_& module);

}  // namespace kirireel::python
