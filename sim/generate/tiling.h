/// Quasiperiodic tilings, as duals of superposed grids (de Bruijn 1981; Socolar, Steinhardt and
/// Levine 1985), and the sheets that they become.
#pragma once

#include <complex>
#include <vector>

#include "sim/model/model.h"

namespace kirireel::generate {

/// An edge-to-edge tiling of a patch of the plane, edges of 1 m, about the origin.
struct Tiling {
  std::vector<std::complex<double>> vertices;  ///< anticlockwise, in the plane of complex numbers
  std::vector<std::vector<int>> tiles;         ///< vertex numbers, anticlockwise
  std::vector<std::complex<double>> duals;  ///< a point a tile in the grids: the duals of the tiles
                                            ///< round an inner vertex are a convex cell's corners,
                                            ///< and neighbours' duals differ at right angles to
                                            ///< their common edge
  std::vector<bool> isThin;                 ///< whether the tile is a narrow rhombus
  double spread = 1;                        ///< of a tile's place over its dual's, on average
};

/// Rhombi of 72 and 36 degrees with fivefold symmetry (Penrose): whole rings of equal distance from
/// the centre, at least `tiles` in all. More rhombi are made than are used, since those beyond the
/// last whole ring are omitted.
Tiling penroseTiling(int tiles);

/// Squares and rhombi of 45 degrees with eightfold symmetry (Ammann and Beenker), counted so.
Tiling ammannBeenkerTiling(int tiles);

/// Squares, triangles and rhombi of 30 degrees with twelvefold symmetry (Stampfli 1986), counted
/// so.
Tiling stampfliTiling(int tiles);

/// The tiles linked to one closed chain that visits each once, joined alternately at the one and
/// the other end of the edges that it crosses. Tiles with one neighbour are omitted. Throws
/// InputError when no such chain was found. The search has a fixed seed and a fixed number of
/// tries: its result is always the same.
model::Model makeChain(const Tiling& tiling);

/// The tiling without its narrow rhombi: every two tiles that share an edge are joined at its
/// clockwise end as seen from the centre, and parts that touch only at a vertex are linked there.
/// The largest connected part.
model::Model makeThinned(const Tiling& tiling);

/// The tiling's tiles and its grids' cells, each corner of a tile joined to a corner of the cell of
/// its vertex. Tiles turn one way and cells the other, the voids are parallelograms: closed at 0,
/// open at right angles at pi / 2, closed at pi. The start and the target have these angles.
model::Model makeExpanded(const Tiling& tiling, double startAngle, double targetAngle);

}  // namespace kirireel::generate
