/// The nodes at the ends of a sheet.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "render/fea/element_mesh.h"

namespace kirireel {

/// Nodes under a name.
struct NamedNodes {
  std::string name;
  std::vector<int> nodes;  ///< rising, from 0; reference nodes count on after the mesh's own
};

/// XMIN, XMAX, YMIN, YMAX, ZMIN and ZMAX: the nodes in the six planes of the box round the sheet,
/// to 1e-6 of its size; ZMIN and ZMAX are left out of flat sheets, whose faces they would be. Then
/// BOXCORNERS, the nodes in two planes across different axes (three where there is a ZMIN). Nodes
/// that follow others are left out; the reference nodes of rigid patches are in. A set may be
/// empty. The order is that of this list. One pass over the nodes; nothing is thrown.
std::vector<NamedNodes> boundarySets(const ElementMesh& mesh);

/// The axis along which the sheet is longest, among those with a MIN and a MAX. 0 for x, 1 for y, 2
/// for z. Of axes of equal extent the first.
int longestAxis(const ElementMesh& mesh);

}  // namespace kirireel
