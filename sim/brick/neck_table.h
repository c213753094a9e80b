/// Compliance of tiles at the end of a neck: the tables of neckStiffness() and cornerNeck(), made
/// from plane stress decks in CalculiX:
///   KIRIREEL_GOLDEN=update fea_tools_test --gtest_filter=NeckSheet.Table*
#pragma once

#include <array>
#include <cstddef>

namespace kirireel::brick {

/// One neck next to a closed slit, between two tiles 50 times as wide. The tiles are so wide that
/// their own bending is negligible.
struct NeckRow {
  double length = 0;  ///< in widths
  double ends = 0;    ///< additional length of the neck in widths: k = E t w^2 / (12 (L/w + ends))
};

/// By ascending length; the last row also applies to longer necks.
inline constexpr auto kNeckTable = std::to_array<NeckRow>({
    {0, 1.312},
    {0.1, 1.299},
    {0.25, 1.285},
    {0.5, 1.274},
    {1, 1.268},
    {2, 1.267},
    {5, 1.265},
    {10, 1.263},
    {20, 1.259},
});

/// One neck of length 0 at the end of a closed slit between two equal tiles, nu = 0.3: isosceles
/// triangles with this angle at the neck up to 60 degrees, regular polygons beyond. All
/// flexibilities are dimensionless. They are used for any Poisson's ratio.
struct CornerNeckRow {
  double angle = 0;    ///< of either tile at the neck, degrees
  double width = 0;    ///< in sides of a square of a tile's area
  double bend = 0;     ///< relative rotation of the tiles per moment, times E t w^2
  double axis = 0;     ///< rotation axis under a moment, widths from the corner
  double stretch = 0;  ///< opening there per force across the slit through it, times E t
  double shear = 0;    ///< sliding along the slit per force along it, times E t
};

/// Number of angles. All have the same widths.
inline constexpr std::size_t kCornerNeckAngles = 4;

/// By ascending angle, and for one angle by ascending width.
// clang-format off
inline constexpr auto kCornerNeckTable = std::to_array<CornerNeckRow>({
    {30, 0.0125, 152.760, 1.4175, 379.080, 62.510},
    {30, 0.025, 153.849, 1.3946, 278.254, 52.199},
    {30, 0.05, 153.994, 1.3561, 184.904, 41.844},
    {30, 0.1, 153.114, 1.2874, 105.093, 31.513},
    {30, 0.15, 151.077, 1.2274, 67.587, 25.517},
    {30, 0.2, 148.406, 1.1733, 46.106, 21.317},
    {30, 0.25, 145.250, 1.1239, 32.616, 18.123},
    {30, 0.3, 141.486, 1.0793, 23.640, 15.572},
    {30, 0.4, 132.504, 1.0014, 13.063, 11.696},
    {60, 0.0125, 32.239, 1.0169, 44.652, 28.800},
    {60, 0.025, 32.318, 1.0043, 33.599, 23.903},
    {60, 0.05, 32.332, 0.9812, 23.254, 19.010},
    {60, 0.1, 32.146, 0.9399, 14.170, 14.132},
    {60, 0.15, 31.774, 0.9031, 9.745, 11.310},
    {60, 0.2, 31.313, 0.8692, 7.125, 9.343},
    {60, 0.25, 30.707, 0.8387, 5.416, 7.852},
    {60, 0.3, 29.983, 0.8109, 4.240, 6.667},
    {60, 0.4, 28.232, 0.7623, 2.783, 4.895},
    {90, 0.0125, 15.701, 0.7318, 12.972, 17.097},
    {90, 0.025, 15.726, 0.7249, 10.156, 14.136},
    {90, 0.05, 15.723, 0.7122, 7.479, 11.177},
    {90, 0.1, 15.640, 0.6893, 5.054, 8.234},
    {90, 0.15, 15.503, 0.6686, 3.820, 6.538},
    {90, 0.2, 15.296, 0.6501, 3.052, 5.360},
    {90, 0.25, 15.024, 0.6337, 2.526, 4.473},
    {90, 0.3, 14.701, 0.6190, 2.144, 3.777},
    {90, 0.4, 13.917, 0.5943, 1.632, 2.761},
    {120, 0.0125, 11.314, 0.5651, 6.933, 11.194},
    {120, 0.025, 11.322, 0.5622, 5.703, 9.271},
    {120, 0.05, 11.318, 0.5568, 4.507, 7.350},
    {120, 0.1, 11.264, 0.5478, 3.370, 5.446},
    {120, 0.15, 11.184, 0.5399, 2.749, 4.356},
    {120, 0.2, 11.055, 0.5336, 2.333, 3.611},
    {120, 0.25, 10.903, 0.5280, 2.028, 3.065},
    {120, 0.3, 10.705, 0.5238, 1.791, 2.648},
    {120, 0.4, 10.229, 0.5180, 1.440, 2.091},
});
// clang-format on

/// CornerNeck::opening, 1/rad and 1/rad^2, of all widths and angles: from decks of squares with
/// large displacements up to 0.6 rad. *ELASTIC is then a hyperelastic material, linear in Green's
/// strain.
inline constexpr std::array<double, 2> kCornerNeckOpening = {0.35, -0.25};

}  // namespace kirireel::brick
