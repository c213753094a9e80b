/// The Python module kirireel._kirireel.
#include <pybind11/numpy.h>

#include "render/python/bindings.h"
#include "render/record/summary.h"
#include "sim/base/error.h"

namespace py = pybind11;

namespace {

using namespace kirireel;

/// Adds the classes of the program's errors. Each also derives from Python's class for such errors.
void addErrors(py::module_& module) {
  py::register_exception<Error>(module, "Error");
  const py::object base = module.attr("Error");
  py::register_exception<InputError>(module, "InputError",
                                     py::make_tuple(base, py::handle(PyExc_ValueError)));
  py::register_exception<OutputError>(module, "OutputError",
                                      py::make_tuple(base, py::handle(PyExc_OSError)));
  py::register_exception<RunError>(module, "RunError",
                                   py::make_tuple(base, py::handle(PyExc_RuntimeError)));
}

}  // namespace

PYBIND11_MODULE(_kirireel, module) {
  module.doc() = "Kirireel's C++, for the package kirireel.";
  // pybind11 imports NumPy for its first array, and two threads that both do this wait for each
  // other: import it now.
  py::dtype::of<double>();
  module.attr("__version__") = record::programVersion();
  addErrors(module);
  python::addModels(module);
  python::addRuns(module);
}
