/// Quasiperiodic tilings as duals of superposed grids (de Bruijn 1981; Socolar, Steinhardt and
/// Levine 1985), and sheets made from them.
#pragma once

#include <complex>
#include <vector>

#include "sim/model/model.h"

namespace kirireel::generate {

/// An edge-to-edge tiling of a patch of the plane, edges of 1 m, about the origin.
struct Tiling {
  std::vector<std::complex<double>> vertices;  ///< by number; x + i y
  std::vector<std::vector<int>> tiles;         ///< vertex numbers, anticlockwise
  std::vector<std::complex<double>> duals;  ///< point of each tile in the grids. Duals of the tiles
                                            ///< around an inner vertex are corners of a convex
                                            ///< cell. The duals of two neighbours differ at right
                                            ///< angles to their common edge
  std::vector<bool> isThin;                 ///< whether the tile is a narrow rhombus
  double spread = 1;                        ///< mean ratio of a tile's position to its dual's
};

/// Rhombi of 72 and 36 degrees with fivefold symmetry (Penrose). Has complete rings of equal
/// distance from the centre, with at least `tiles` tiles. Rhombi beyond the last complete ring are
/// omitted.
Tiling penroseTiling(int tiles);

/// The same for squares and rhombi of 45 degrees with eightfold symmetry (Ammann and Beenker).
Tiling ammannBeenkerTiling(int tiles);

/// The same for squares, triangles and rhombi of 30 degrees with twelvefold symmetry (Stampfli
/// 1986).
Tiling stampfliTiling(int tiles);

/// Links the tiles to one closed chain that visits each tile once. Joints alternate between the two
/// ends of the crossed edges. Tiles with one neighbour are omitted. Throws InputError if no such
/// chain was found. The search is deterministic: it has a fixed seed and a fixed number of tries.
model::Model makeChain(const Tiling& tiling);

/// The largest connected part of the tiling without its narrow rhombi. Tiles with a common edge are
/// joined at its clockwise end, seen from the centre. Parts that touch only at a vertex are linked
/// there. Throws InputError if all tiles are narrow.
model::Model makeThinned(const Tiling& tiling);

/// The tiling's tiles and its grids' cells. Each corner of a tile is joined to a corner of its
/// vertex's cell. Tiles and cells rotate in opposite directions. The voids are parallelograms:
/// closed at 0 and pi, and rectangles at pi / 2. The arguments are the angles of start and target.
model::Model makeExpanded(const Tiling& tiling, double startAngle, double targetAngle);

}  // namespace kirireel::generate
