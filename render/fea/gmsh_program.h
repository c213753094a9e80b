/// Gmsh as a mesher: a program of its own, looked for when it is needed.
#pragma once

#include <string>

namespace kirireel {

/// The mesh that Gmsh makes of a geometry (.geo), as the text of a Gmsh 2.2 file. Runs `gmsh` on
/// one thread in a folder of its own, so that the same geometry gives the same mesh. Throws
/// InputError when there is no such program, RunError with its last words when it fails.
std::string meshedByGmsh(const std::string& geometry);

}  // namespace kirireel
