#include "sim/model/neck_stiffness.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace kirireel
