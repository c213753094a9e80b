/// How stiffly a neck of material joins two tiles, as a rotational spring.
#pragma once

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
/// neck's own, in its middle, and of its ends', 0.73 widths from the corner, weighed by what each
/// gives: slits that are shut end in tiles that give more on the slit's side. The 0.73 comes from
/// decks of sheets whose necks have no length (tests/cli/program_load_test.cpp).
double neckAxis(double width, double length);

}  // namespace kirireel
