/// CalculiX as a solver: a program of its own, looked for when it is needed.
#pragma once

#include <string>

#include "sim/base/geometry.h"

namespace kirireel {

/// What a job on a mesh deck gives, in the deck's units.
struct Response {
  double largestDisplacement = 0;  ///< of all nodes
  double opening = 0;              ///< by how much the ends that forces pull at part, on the mean
};

/// The response of a job of staticJob, with keywords of CalculiX, that pulls along this axis;
/// `meshText` is the mesh deck that it includes. Runs `ccx` in a folder of its own. Throws
/// InputError when there is no such program, RunError with its last words when it fails.
Response responseByCalculix(const std::string& meshText, std::string jobText, int axis);

}  // namespace kirireel
