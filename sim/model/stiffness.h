/// How stiff sheets are that are made of a material: their necks, tiles and folds, as springs.
#pragma once

#include <array>

#include "sim/base/geometry.h"
#include "sim/model/brick.h"
#include "sim/model/model.h"

namespace kirireel::model {

// ------------------------------------------------------------------------------------------------
// How stiffly a neck of material joins two tiles, as springs.

/// What stays of a neck's width, metres: at the joint, too, a cut takes half a kerf.
inline double materialWidth(const Neck& neck) {
  return neck.width - neck.kerf / 2;
}

/// The moment per angle, N m/rad, of a neck in the sheet's plane between two tiles with a shut slit
/// beside it, as flat_sheet.h draws it:
///
///     k = E t w^3 / (12 (L + e w)),   e = 1.31 at L = 0, 1.26 from L = w on (neck_table.h)
///
/// A beam of length L gives E t w^3 / (12 L) (pure bending); the tiles give at its two ends as if
/// it were e widths longer, so that a beam alone is 25% too stiff at L = 5 w and 6% at 20 w. The
/// table of e comes from our own decks. Its limit at L = 0 is known: the end of a shut slit at a
/// free edge is a deep crack with E t w^2 / 15.8, H. Tada, P. C. Paris, G. R. Irwin, The Stress
/// Analysis of Cracks Handbook. Young's modulus in Pa, lengths in metres; length from 0,
/// the others positive; width and length small against the tiles. Compare W. J. O'Donnell, The
/// additional deflection of a cantilever due to the elasticity of the support, J. Appl. Mech. 27,
/// 1960.
double neckStiffness(double youngs, double thickness, double width, double length);

/// The corner of a tile at which a neck stands.
struct NeckCorner {
  double angle = 0;  ///< between the tile's two edges there, radians, above 0
  double side = 0;   ///< of a square of the tile's area, metres, above 0
};

/// That of a brick at a vertex of its tile.
NeckCorner neckCorner(const Brick& brick, int corner);

/// How far from the tiles' common corner, along the slit, such a neck's axis lies, metres: about
/// which tiles turn under a moment, and through which a force turns none. It is the mean of the
/// neck's own, in its middle, and of its ends', that of cornerNeck(), weighed by what each gives:
/// slits that are shut end in tiles that give more on the slit's side. A neck with a length begins
/// where both tiles have begun at its ends: beyond the corner between tiles with acute corners,
/// before it between obtuse ones.
double neckAxis(double width, double length, const std::array<NeckCorner, 2>& tiles);

/// How a neck without a length gives, which is how the tiles do that it joins: in the plane, with
/// respect to its axis, in which the three do not mix.
struct CornerNeck {
  double bending = 0;  ///< N m/rad
  double axis = 0;     ///< metres from the corner, along the slit
  double stretch = 0;  ///< N/m, across the slit
  double shear = 0;    ///< N/m, along the slit
  /// The moment at an angle a by which the slit opens is bending (a + opening[0] a^2 + opening[1]
  /// a^3): finite strains at its end make the neck stiffer as it opens, and softer as it closes.
  std::array<double, 2> opening = {};
};

/// Such a neck at the end of a shut slit between two tiles with these corners. From a table of our
/// own decks of two equal tiles, with tiles' motions the mean of their material's (neck_table.h):
/// each tile gives half of what such a pair does, and the halves add up. A moment turns tiles with
/// corners of 60 degrees twice as far as squares, those with 120 degrees 0.7 times. How a moment
/// slides tiles with unlike corners is left out. How far forces part tiles grows with the logarithm
/// of side over width without bound, as the displacement of a loaded corner does (S. P. Timoshenko,
/// J. N. Goodier, Theory of Elasticity, section 38); necks wider than 0.4 sides count as so wide,
/// corners outside 30 to 150 degrees as those.
CornerNeck cornerNeck(double youngs, double thickness, double width,
                      const std::array<NeckCorner, 2>& tiles);

/// The moment per angle, N m/rad, of a neck between two tiles with these corners beside a shut
/// slit: without a length cornerNeck()'s bending, else that of a neck whose ends give as much more
/// or less than those of squares in neckStiffness() as they do without a length.
double neckStiffness(double youngs, double thickness, double width, double length,
                     const std::array<NeckCorner, 2>& tiles);

// ------------------------------------------------------------------------------------------------
// How stiffly tiles stretch and bend, and folds turn, as bars and hinges.
//
// E. T. Filipov, K. Liu, T. Tachi, M. Schenk, G. H. Paulino, Bar and hinge models for scalable
// analysis of origami, Int. J. Solids Struct. 124, 2017; K. Liu, G. H. Paulino, Highly efficient
// nonlinear structural analysis of origami assemblages using the MERLIN2 software, Origami 7,
// 2018. Young's modulus in Pa, lengths in metres, all positive.

/// The cross-section of the three bars at the sides of a triangle, square metres: A = 2 S t / ((1 -
/// nu) (a + b + c)), S its area, with which the triangle, stretched alike in all directions, holds
/// as much as a plate.
double barArea(const std::array<Vector3, 3>& triangle, double thickness, double poisson);

/// The moment per angle, N m/rad, of a tile that bends about a diagonal of length D: k = C E t^3 /
/// (12 (1 - nu^2)) (D / t)^(1/3), C = 0.55 - 0.42 s / pi, s the sum over the four corners round the
/// diagonal of what they differ from right angles; C is 0.05 at least. Restrained by its edges, a
/// thin sheet bends along a ridge, hence the third root.
double bendStiffness(const std::array<Vector3, 4>& corners, double diagonal, double youngs,
                     double poisson, double thickness);

/// Of a fold of a length, N m/rad: k = E t^3 / (12 (1 - nu^2)) length / scale. The length scale is
/// that over which a panel as stiff as the fold would bend: 25 to 100 mm for paper of 0.1 mm.
double foldStiffness(double length, double scale, double youngs, double poisson, double thickness);

}  // namespace kirireel::model
