/// A flat sheet with necks of material at its joints, in one piece, as finite elements.
#pragma once

#include <string>

#include "render/export/element_mesh.h"

namespace kirireel {

/// The outline as a Gmsh geometry: one surface a tile and a neck, quadrilaterals of the rule's
/// size, small at the necks: the finer the rule, the finer both. The text is in Gmsh's own language
/// (.geo), lengths in metres. `tileSize` is the mean length of tiles' edges, metres.
std::string neckGeometry(const NeckOutline& outline, const ElementRule& rule, double tileSize);

/// The start of a planar model as one sheet with the rule's necks, of this thickness in metres:
/// solids, shells in the middle of the thickness, or plane elements in the plane z = 0. Tiles and
/// necks share nodes where they meet; the two sides of a slit share none. Meshed by Gmsh, which
/// must be installed.
///
/// Throws what neckOutline, requireValidRule and meshedByGmsh throw. The mesh has no joints and no
/// clusters.
ElementMesh makeNeckMesh(const Model& model, double thickness, const ElementRule& rule);

}  // namespace kirireel
