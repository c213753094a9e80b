/// CalculiX as a solver: a program of its own, looked for when it is needed.
#pragma once

#include <string>

namespace kirireel {

/// By how much the two ends that the forces of a job of staticJob pull at part, on the mean, in the
/// deck's unit of length; the job has keywords of CalculiX and pulls along this axis, `meshText` is
/// the mesh deck that it includes. Runs `ccx` in a folder of its own. Throws InputError when there
/// is no such program, RunError with its last words when it fails. `axis` is 0, 1 or 2. The folder
/// is removed whatever happens. It takes as long as ccx does: a sparse direct factorisation of
/// three unknowns a node.
double openingByCalculix(const std::string& meshText, std::string jobText, int axis);

}  // namespace kirireel
