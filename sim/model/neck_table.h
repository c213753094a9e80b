/// How much tiles give where a neck ends: the tables behind neckStiffness() and cornerNeck(), made
/// from plane stress decks that CalculiX runs:
///   KIRIREEL_GOLDEN=update fea_tools_test --gtest_filter=NeckSheet.Table*
#pragma once

#include <array>

namespace kirireel {

/// One neck beside a shut slit, between two tiles 50 times as wide.
/// The tiles are so much wider that their own bending does not count.
struct NeckRow {
  double length = 0;  ///< in widths
  double ends = 0;  ///< the widths by which the neck seems longer: k = E t w^2 / (12 (L/w + ends))
};

/// By rising length; the last row holds for longer necks too.
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

/// One neck without length at the end of a shut slit between two squares, nu = 0.3.
/// All its flexibilities have no unit. They are used for any Poisson's ratio.
struct CornerNeckRow {
  double width = 0;    ///< in sides of the squares
  double bend = 0;     ///< the turn of a square against the other per moment, times E t w^2
  double axis = 0;     ///< where a moment turns them about, widths from the corner
  double stretch = 0;  ///< how far they part there per force across the slit through it, times E t
  double shear = 0;    ///< how far they slide along the slit per force along it, times E t
};

/// By rising width.
inline constexpr auto kCornerNeckTable = std::to_array<CornerNeckRow>({
    {0.0125, 15.701, 0.7318, 12.972, 17.097},
    {0.025, 15.726, 0.7249, 10.156, 14.136},
    {0.05, 15.723, 0.7122, 7.479, 11.177},
    {0.1, 15.640, 0.6893, 5.054, 8.234},
    {0.15, 15.503, 0.6686, 3.820, 6.538},
    {0.2, 15.296, 0.6501, 3.052, 5.360},
    {0.25, 15.024, 0.6337, 2.526, 4.473},
    {0.3, 14.701, 0.6190, 2.144, 3.777},
    {0.4, 13.917, 0.5943, 1.632, 2.761},
});

/// CornerNeck::opening, 1/rad and 1/rad^2, of all widths: the same decks with large displacements
/// to 0.6 rad, of the hyperelastic material that *ELASTIC is there (linear in Green's strain).
inline constexpr std::array<double, 2> kCornerNeckOpening = {0.35, -0.25};

}  // namespace kirireel
