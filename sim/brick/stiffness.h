/// Stiffness of sheets of a given material: their necks, tiles and folds as springs.
#pragma once

#include <array>

#include "sim/base/geometry.h"
#include "sim/brick/brick.h"
#include "sim/model/model.h"

namespace kirireel::brick {

// ------------------------------------------------------------------------------------------------
// Stiffness of a neck of material between two tiles.

/// Remaining width of a neck, metres. A cut removes half a kerf at the joint too.
inline double materialWidth(const model::Neck& neck) {
  return neck.width - neck.kerf / 2;
}

/// Rotational stiffness, N m/rad, of a neck in the sheet's plane between two tiles. A closed slit
/// lies next to it, as in flat_sheet.h:
///
///     k = E t w^3 / (12 (L + e w)),   e = 1.31 at L = 0, 1.26 from L = w on (neck_table.h)
///
/// A beam of length L has E t w^3 / (12 L) (pure bending). The tiles' compliance at both ends acts
/// like e widths of additional length. A beam without this is 25% too stiff at L = 5 w and 6% at 20
/// w. The table of e comes from our own decks. Its limit at L = 0 is known: the end of a closed
/// slit at a free edge is a deep crack with E t w^2 / 15.8, H. Tada, P. C. Paris, G. R. Irwin, The
/// Stress Analysis of Cracks Handbook. Young's modulus in Pa, lengths in metres; length >= 0,
/// others > 0; width and length small relative to the tiles. Compare W. J. O'Donnell, The
/// additional deflection of a cantilever due to the elasticity of the support, J. Appl. Mech. 27,
/// 1960.
double neckStiffness(double youngs, double thickness, double width, double length);

/// The corner of a tile at a neck.
struct NeckCorner {
  double angle = 0;  ///< between the tile's two edges there, radians, > 0
  double side = 0;   ///< of a square of the tile's area, metres, > 0
};

/// The corner of a brick at a vertex of its tile.
NeckCorner neckCorner(const Brick& brick, int corner);

/// Distance of such a neck's axis from the tiles' common corner along the slit, metres. Tiles turn
/// about this axis under a moment, and a force through it turns no tile. It is the mean of two
/// axes, weighted by compliance: the middle of the neck, and the axis of its ends (cornerNeck()).
/// The ends of a closed slit are more compliant on the slit's side. A neck with a length begins
/// where both tiles have begun at its ends. This is beyond the corner for acute corners and before
/// it for obtuse ones.
double neckAxis(double width, double length, const std::array<NeckCorner, 2>& tiles);

/// Stiffness of a neck of length 0, which comes from its tiles. It is planar and refers to the
/// neck's axis, about which the three components are independent.
struct CornerNeck {
  double bending = 0;  ///< N m/rad
  double axis = 0;     ///< metres from the corner along the slit
  double stretch = 0;  ///< N/m, across the slit
  double shear = 0;    ///< N/m, along the slit
  /// The moment at an opening angle a of the slit is bending (a + opening[0] a^2 + opening[1] a^3).
  /// Finite strains at the slit's end make the neck stiffer in opening and softer in closing.
  std::array<double, 2> opening = {};
};

/// Such a neck at the end of a closed slit between two tiles with these corners. The table comes
/// from our own decks of two equal tiles, whose motions are means over their material
/// (neck_table.h). Each tile has half the compliance of such a pair, and the halves add up. A
/// moment turns tiles with corners of 60 degrees twice as far as squares, those with 120 degrees
/// 0.7 times. The sliding of unlike corners by a moment is neglected. The opening by forces grows
/// without bound with log(side / width), as at a loaded corner (S. P. Timoshenko, J. N. Goodier,
/// Theory of Elasticity, section 38). Larger widths than 0.4 sides count as 0.4 sides, and corners
/// are clamped to the range from 30 to 150 degrees.
CornerNeck cornerNeck(double youngs, double thickness, double width,
                      const std::array<NeckCorner, 2>& tiles);

/// Rotational stiffness, N m/rad, of a neck between two tiles with these corners next to a closed
/// slit. Length 0: bending of cornerNeck(). Otherwise the neck's ends have the
/// compliance between squares, scaled by the ratio of both at length 0.
double neckStiffness(double youngs, double thickness, double width, double length,
                     const std::array<NeckCorner, 2>& tiles);

// ------------------------------------------------------------------------------------------------
// Stiffness of tiles in stretching and bending, and of folds, as bars and hinges.
//
// E. T. Filipov, K. Liu, T. Tachi, M. Schenk, G. H. Paulino, Bar and hinge models for scalable
// analysis of origami, Int. J. Solids Struct. 124, 2017; K. Liu, G. H. Paulino, Highly efficient
// nonlinear structural analysis of origami assemblages using the MERLIN2 software, Origami 7,
// 2018. Young's modulus in Pa, lengths in metres, all positive.

/// The cross-section of the three bars at the sides of a triangle, square metres:
/// A = 2 S t / ((1 - nu) (a + b + c)), S its area. Under equal strain in all directions the bars
/// store the same energy as a plate.
double barArea(const std::array<Vector3, 3>& triangle, double thickness, double poisson);

/// Rotational stiffness, N m/rad, of a tile that bends about a diagonal of length D:
/// k = C E t^3 / (12 (1 - nu^2)) (D / t)^(1/3), C = 0.55 - 0.42 s / pi, C >= 0.05. s is the sum of
/// the deviations from right angles over the four corners around the diagonal. A thin sheet with
/// restrained edges bends along a ridge, which gives the third root.
double bendStiffness(const std::array<Vector3, 4>& corners, double diagonal, double youngs,
                     double poisson, double thickness);

/// Rotational stiffness of a fold, N m/rad: k = E t^3 / (12 (1 - nu^2)) length / scale. Scale is
/// the length over which a panel with the fold's stiffness bends: 25 to 100 mm for paper of 0.1 mm.
double foldStiffness(double length, double scale, double youngs, double poisson, double thickness);

}  // namespace kirireel::brick
