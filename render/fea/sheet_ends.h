/// The edges at the ends of a sheet, where a test machine would grip it.
#pragma once

#include <array>
#include <compare>
#include <vector>

#include "sim/base/geometry.h"

namespace kirireel::fea {

/// An edge of a polygon: from its corner `edge` to the next.
struct PolygonEdge {
  int polygon = 0;  ///< zero-based
  int edge = 0;     ///< zero-based

  auto operator<=>(const PolygonEdge&) const = default;
};

/// A point at which two polygons of a sheet are connected.
struct PolygonLink {
  int first = 0;   ///< polygon, zero-based
  int second = 0;  ///< the other polygon
  Vector3 point;   ///< metres
};

/// The edges at the ends of a sheet.
struct EndEdges {
  Matrix3 axes = Matrix3::Identity();  ///< columns: the unit axes of the sheet
  bool isFlat = false;                 ///< all polygons lie in one plane, across z
  int longest = 0;                     ///< axis of the largest extent that has ends: 0 x, 1 y, 2 z
  std::array<std::vector<PolygonEdge>, 6> edges;  ///< XMIN to ZMAX, each sorted
};

/// The edges of polygons at each end of their sheet. An edge is at an end if its outward normal is
/// within 45 degrees of the axis, both its corners are within `tileSize` (metres) of the extreme,
/// and no polygon lies between it and the outside. The axes of a flat sheet in any plane are the
/// sides of the smallest rectangle around it and its normal. Its x is at most 45 degrees from x of
/// model::sheetFrame(). Other sheets have the world's axes. ZMIN and ZMAX of flat sheets are empty.
/// If several rectangles are equal, or several sides for the longest axis, the positions of the
/// links decide, since they rotate with the sheet. Polygons are anticlockwise seen from their
/// normals. Costs the edges near an end times all edges.
EndEdges findEndEdges(const std::vector<std::vector<Vector3>>& polygons,
                      const std::vector<PolygonLink>& links, double tileSize);

}  // namespace kirireel::fea
