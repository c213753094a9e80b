/// How stiffly a neck of material joins two tiles, as springs.
#pragma once

#include <array>

namespace kirireel {

/// The moment per angle, N m/rad, of a neck in the sheet's plane between two tiles with a shut slit
/// beside it, as neck_outline.h draws it:
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

/// How far from the tiles' common corner, along the slit, such a neck's axis lies, metres: about
/// which tiles turn under a moment, and through which a force turns none. It is the mean of the
/// neck's own, in its middle, and of its ends', that of cornerNeck(), weighed by what each gives:
/// slits that are shut end in tiles that give more on the slit's side. `side`: of the tiles,
/// metres.
double neckAxis(double width, double length, double side);

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

/// Such a neck at the end of a shut slit between two tiles of these sides (of a square of their
/// area), metres. From a table of our own decks of two squares, with tiles' motions the mean of
/// their material's (neck_table.h), as exact as tiles are like squares. How far forces part tiles
/// grows with the logarithm of side over width without bound, as the displacement of a loaded
/// corner does (S. P. Timoshenko, J. N. Goodier, Theory of Elasticity, section 38); necks wider
/// than 0.4 sides count as so wide.
CornerNeck cornerNeck(double youngs, double thickness, double width, double side);

}  // namespace kirireel
