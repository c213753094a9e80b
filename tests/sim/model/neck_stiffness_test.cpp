#include <gtest/gtest.h>

#include "sim/model/stiffness.h"

namespace kirireel {
namespace {

TEST(NeckStiffness, LiesBetweenADeepCrackAndABeam) {
  const double youngs = 2e9, thickness = 0.003, width = 0.02;
  const auto stiffness = [&](double length) {
    return neckStiffness(youngs, thickness, width, length);
  };
  // Without length, by Tada, Paris and Irwin. Measured: 1.004.
  EXPECT_NEAR(stiffness(0) / (youngs * thickness * width * width / 15.8), 1, 0.01);
  const auto beam = [&](double length) {
    return youngs * thickness * width * width * width / (12 * length);
  };
  // Tiles give at its ends, by 1.26 widths together. Measured: 1.0000 and 1.0002.
  EXPECT_NEAR(stiffness(0.1) / beam(0.1 + 1.26 * width), 1, 0.002);
  EXPECT_NEAR(stiffness(100 * width) / beam(101.26 * width), 1, 0.002);
  double last = stiffness(0);
  for (int k = 1; k <= 300; ++k) {
    EXPECT_LT(stiffness(0.1 * k * width), last) << k;
    last = stiffness(0.1 * k * width);
  }
}

TEST(NeckStiffness, WithoutLengthIsThatOfItsTiles) {
  const double youngs = 2e9, thickness = 0.003, side = 0.5, sheet = youngs * thickness;
  double stretch = 0, shear = 0, axis = 1;
  for (const double share : {0.001, 0.0125, 0.02, 0.05, 0.12, 0.2, 0.33, 0.4}) {
    const CornerNeck neck = cornerNeck(youngs, thickness, share * side, side);
    // A deep crack's bending, and softer tiles as it is narrower. Measured: 1.006 to 1.135.
    const double crack = sheet * share * share * side * side / 15.8;
    EXPECT_NEAR(neck.bending / crack, 1, share > 0.2 ? 0.14 : 0.04) << share;
    EXPECT_GT(neck.stretch, stretch) << share;
    EXPECT_GT(neck.shear, shear) << share;
    EXPECT_LT(neck.axis / (share * side), axis) << share;
    stretch = neck.stretch;
    shear = neck.shear;
    axis = neck.axis / (share * side) + 1e-12;
    EXPECT_DOUBLE_EQ(neckAxis(share * side, 0, side), neck.axis);
  }
  // A long neck turns about its middle.
  EXPECT_NEAR(neckAxis(0.01, 10, 1), 0.005, 1e-5);
}

}  // namespace
}  // namespace kirireel
