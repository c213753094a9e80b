/// Options as Python gives them: keyword arguments with the names that scene.toml has.
#pragma once

#include <string>
#include <vector>

#include <pybind11/pybind11.h>

namespace kirireel::python {

/// The words of the command line that say the same: thickness=0.02 is --thickness=0.02, ground=True
/// is --ground, a list of numbers is 1,2,3, a list of lists or texts gives the option for each.
/// What is False or None is left out. `notHere` are names that the command has but this call has
/// not; throws InputError for them.
std::vector<std::string> optionWords(const pybind11::kwargs& options,
                                     const std::vector<std::string>& notHere);

/// Tells each as a UserWarning of Python. Throws what Python throws where warnings are errors.
/// Needs the interpreter.
void warn(const std::vector<std::string>& warnings);

}  // namespace kirireel::python
