/// How stiffly a neck of material joins two tiles, as a rotational spring.
#pragma once

namespace kirireel {

/// The moment per angle, N m/rad, of a neck in the sheet's plane between two tiles with a shut slit
/// beside it, as neck_outline.h draws it:
///
///     k = E t w^3 / (12 (L + 1.26 w))
///
/// A beam of length L gives E t w^3 / (12 L) (pure bending); the tiles give at its two ends as if
/// it were 1.26 widths longer, so that a beam alone is 20% too stiff at L = 5 w and 6% at 20 w. The
/// factor comes from plane stress meshes (tests/render/fea/neck_sheet_test.cpp), where it is 1.26
/// to 1.27 for L from w / 2 to 20 w. Young's modulus in Pa, lengths in metres, all positive; width
/// and length small against the tiles. Compare W. J. O'Donnell, The additional deflection of a
/// cantilever due to the elasticity of the support, J. Appl. Mech. 27, 1960.
double neckStiffness(double youngs, double thickness, double width, double length);

}  // namespace kirireel
