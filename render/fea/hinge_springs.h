/// Springs at the hinges of a deck.
#pragma once

#include <span>

#include "render/fea/element_mesh.h"
#include "sim/brick/hinge.h"

namespace kirireel {

/// Gives a mesh with rigid patches the springs that bricks in these poses have at hinges across
/// the plane z = const, shared evenly by the patches that join two tiles there. Springs at other
/// hinges, and in meshes without patches, are left out: returns how many. `springs` name bricks by
/// the tiles' numbers in the mesh; `poses` are those of the mesh. Angles in radians, stiffness in N
/// m/rad. Springs of stiffness 0 count as absent.
int addHingeSprings(ElementMesh& mesh, std::span<const HingeSpring> springs, const Poses& poses);

}  // namespace kirireel
