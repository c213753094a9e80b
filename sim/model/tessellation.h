/// The rotating rectangles and parallelograms: m x n tiles joined at corners, one degree of freedom
/// in the plane.
#pragma once

#include "sim/model/model.h"

namespace kirireel {

/// What to generate. Lengths in metres, angles in radians; at most 250,000 tiles.
struct TessellationShape {
  int columns = 4;                          ///< tiles along x, at least 1
  int rows = 4;                             ///< tiles along y, at least 1
  double length = 1;                        ///< of a tile along x when closed, positive
  double width = 1;                         ///< of a tile's other side, positive
  double skew = 0;                          ///< of that side from the y axis, clockwise, below pi/2
  double startAngle = 0;                    ///< between neighbouring tiles, 0 (closed) to pi
  double targetAngle = 1.5707963267948966;  ///< of the target, 0 to pi
  JointFace face = JointFace::Both;
};

/// The tessellation with its target and its joints. Tile column * rows + row stands in the given
/// column and row; its vertices start bottom left and run anticlockwise.
/// Throws InputError for counts, lengths or angles out of range.
Model makeTessellation(const TessellationShape& shape);

/// Its tiles at one opening angle theta, in the axes in which even tiles (column + row even) are
/// turned by -theta/2 and odd ones by +theta/2, centred on the origin: the mechanism's exact motion
///   v(theta) = F_odd e^(-i theta/2) + F_even e^(i theta/2)   (complex coordinates),
/// closed and rigid for every theta.
std::vector<Tile> tessellationTiles(const TessellationShape& shape, double angle);

}  // namespace kirireel
