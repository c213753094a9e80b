// Units of length.
#include "sim/base/length_unit.h"

#include <random>

#include <gtest/gtest.h>

namespace kirireel {
namespace {

/// By the definitions of the international yard and of the point in PostScript.
TEST(LengthUnits, HaveTheirDefinitions) {
  EXPECT_EQ(findLengthUnit("in")->metres, 0.0254);
  EXPECT_DOUBLE_EQ(findLengthUnit("ft")->metres, 12 * 0.0254);
  EXPECT_DOUBLE_EQ(findLengthUnit("pt")->metres * 72, 0.0254);
  EXPECT_EQ(findLengthUnit("furlong"), std::nullopt);
}

/// A number of at most 15 digits comes back unchanged, in every unit.
TEST(LengthUnits, KeepTheDigitsOfAFile) {
  std::mt19937 random(1);
  std::uniform_int_distribution<long> digits(-999'999'999, 999'999'999);
  for (const LengthUnit& unit : lengthUnits()) {
    for (int k = 0; k < 10000; ++k) {
      const double number = static_cast<double>(digits(random)) / 1e6;
      ASSERT_EQ(inUnit(number * unit.metres, unit), number) << unit.name;
    }
  }
}

/// Gaps can be as small as the smallest number.
TEST(LengthUnits, GiveTextsOfSmallLengths) {
  EXPECT_EQ(lengthText(5e-324, millimetre()), "4.94066e-321 mm");
  EXPECT_EQ(lengthText(5.3e-317, LengthUnit{"m", 1, 6}), "5.3e-317 m");
  EXPECT_EQ(lengthText(0.4, millimetre(), 2), "400 mm");
}

}  // namespace
}  // namespace kirireel
