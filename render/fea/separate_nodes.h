/// Nodes in one place, drawn apart.
#pragma once

#include <vector>

#include "render/fea/element_mesh.h"

namespace kirireel {

/// The positions of a mesh's nodes, metres, with those that lie in one place drawn apart: each 1e-7
/// of the sheet's size (the diagonal of its box) into the elements that it belongs to. Slits that
/// are shut have nodes in one place on both sides, to which programs that look for duplicate nodes
/// object, and which those that merge nodes would weld: Gmsh takes what differs by up to 2e-8 of
/// the size in each coordinate for one place. All other positions stay as they are. As many as the
/// mesh has. Where nodes still coincide after four passes they are left so.
std::vector<Vector3> separatedNodes(const ElementMesh& mesh);

}  // namespace kirireel
