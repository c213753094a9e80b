/// Runs in Python: deployed, opened, painted, saved.
#pragma once

#include <pybind11/pybind11.h>

namespace kirireel::python {

/// Adds Sample, Trajectory, Run, deploy() and open(). Angles are radians, lengths metres, times
/// seconds; poses are those of bricks' centres of mass.
void addRuns(pybind11::module_& module);

}  // namespace kirireel::python
