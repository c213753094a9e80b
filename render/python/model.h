/// Models in Python: read, made, written.
#pragma once

#include <pybind11/pybind11.h>

namespace kirireel::python {

/// Adds Model, read() and generate(). Their errors are kirireel.InputError and
/// kirireel.OutputError.
void addModels(pybind11::module_& module);

}  // namespace kirireel::python
