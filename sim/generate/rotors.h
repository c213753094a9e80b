/// Sheets of regular tiles of two kinds that turn against each other at their corners.
#pragma once

#include "sim/model/model.h"

namespace kirireel {

/// How large a sheet is and how far it opens.
struct RotorShape {
  int columns = 4;         ///< cells along the first lattice direction, positive
  int rows = 4;            ///< cells along the second
  double startAngle = 0;   ///< by which neighbours have turned, radians; 0 is closed
  double targetAngle = 0;  ///< the same at the target
};

/// Rotating triangles with edges of 1 m: two a cell, pointing up and down; a kagome lattice of
/// hexagonal voids at 120 degrees, closed again at 240.
Model makeRotatingTriangles(const RotorShape& shape);

/// Regular hexagons, one a cell, and the triangles between them, edges of 1 m; widest at 90
/// degrees, closed again at 180. At least 2 columns and 2 rows.
Model makeHexagonsAndTriangles(const RotorShape& shape);

}  // namespace kirireel
