/// The edges that a person would hold at the ends of a sheet.
#pragma once

#include <array>
#include <compare>
#include <vector>

#include "sim/base/geometry.h"

namespace kirireel::fea {

/// An edge of a polygon: from its corner `edge` to the next.
struct PolygonEdge {
  int polygon = 0;  ///< its number, from 0
  int edge = 0;     ///< its number, from 0

  auto operator<=>(const PolygonEdge&) const = default;
};

/// The edges at the ends of a sheet.
struct EndEdges {
  Matrix3 axes = Matrix3::Identity();             ///< as SheetEnds has them
  bool isFlat = false;                            ///< as SheetEnds has it
  std::array<std::vector<PolygonEdge>, 6> edges;  ///< XMIN to ZMAX, each sorted
};

/// The edges of polygons that a person would hold at each end of the sheet that they make. An edge
/// is at an end if its outward normal is within 45 degrees of the axis, both its corners lie within
/// `tileSize` (metres) of the extreme, and no polygon lies between it and the outside. The axes of
/// a flat sheet are the sides of the smallest rectangle round it, x at most 45 degrees from the
/// world's; other sheets have the world's axes. ZMIN and ZMAX of flat sheets are empty. Polygons
/// run anticlockwise seen from their normals. Costs the edges near an end times all edges.
EndEdges findEndEdges(const std::vector<std::vector<Vector3>>& polygons, double tileSize);

}  // namespace kirireel::fea
