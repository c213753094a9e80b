/// How much tiles give where a neck ends: the table behind neckStiffness(), made from plane stress
/// decks that CalculiX runs:
///   KIRIREEL_GOLDEN=update fea_tools_test --gtest_filter=NeckSheet.TableIsThatOfDecks
#pragma once

#include <array>

namespace kirireel {

/// One neck beside a shut slit, between two tiles 50 times as wide.
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

}  // namespace kirireel
