/// Runs in Python: deployed, opened, painted, saved.
#pragma once

#include <pybind11/pybind11.h>

namespace kirireel::python {

/// Adds Sample, Trajectory, Run, deploy() and open().
void addRuns(pybind11::module_& module);

}  // namespace kirireel::python
