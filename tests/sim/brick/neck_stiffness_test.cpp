#include <array>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "sim/brick/stiffness.h"

namespace kirireel {
namespace {

/// The corners of two squares.
std::array<brick::NeckCorner, 2> squares(double side) {
  const brick::NeckCorner corner{std::numbers::pi / 2, side};
  return {corner, corner};
}

TEST(NeckStiffness, LiesBetweenADeepCrackAndABeam) {
  const double youngs = 2e9, thickness = 0.003, width = 0.02;
  const auto stiffness = [&](double length) {
    return brick::neckStiffness(youngs, thickness, width, length);
  };
  // Without length, by Tada, Paris and Irwin. Measured: 1.004.
  EXPECT_NEAR(stiffness(0) / (youngs * thickness * width * width / 15.8), 1, 0.01);
  const auto beam = [&](double length) {
    return youngs * thickness * width * width * width / (12 * length);
  };
  // Tiles are compliant at its ends, together like 1.26 widths of neck. Measured: 1.0000 and
  // 1.0002.
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
    const brick::CornerNeck neck =
        brick::cornerNeck(youngs, thickness, share * side, squares(side));
    // Bending at a deep crack. Tiles are more compliant at narrower necks. Measured: 1.006 to
    // 1.135.
    const double crack = sheet * share * share * side * side / 15.8;
    EXPECT_NEAR(neck.bending / crack, 1, share > 0.2 ? 0.14 : 0.04) << share;
    EXPECT_GT(neck.stretch, stretch) << share;
    EXPECT_GT(neck.shear, shear) << share;
    EXPECT_LT(neck.axis / (share * side), axis) << share;
    stretch = neck.stretch;
    shear = neck.shear;
    axis = neck.axis / (share * side) + 1e-12;
    EXPECT_DOUBLE_EQ(brick::neckAxis(share * side, 0, squares(side)), neck.axis);
  }
  // A long neck turns about its middle.
  EXPECT_NEAR(brick::neckAxis(0.01, 10, squares(1)), 0.005, 1e-5);
}

// The ends of a neck with a length are as compliant as without, except for a correction of squares.
TEST(NeckStiffness, OfAnyTilesGoesFromTheirCornersToABeam) {
  const double youngs = 2e9, thickness = 0.003, width = 0.02;
  for (const double angle : {60.0, 90.0, 120.0}) {
    const brick::NeckCorner corner{angle * std::numbers::pi / 180, 1};
    const auto stiffness = [&](double length) {
      return brick::neckStiffness(youngs, thickness, width, length, {corner, corner});
    };
    const brick::CornerNeck shut = brick::cornerNeck(youngs, thickness, width, {corner, corner});
    EXPECT_NEAR(stiffness(0) / shut.bending, 1, 1e-12);
    EXPECT_NEAR(stiffness(1e-7 * width) / shut.bending, 1, 1e-6);
    const double beam = youngs * thickness * std::pow(width, 3) / (12 * 1000 * width);
    EXPECT_NEAR(stiffness(1000 * width) / beam, 1, 3e-3);
    EXPECT_NEAR(brick::neckAxis(width, 0, {corner, corner}), shut.axis, 1e-12);
    // Squares' own table, of tiles 50 widths wide.
    if (angle != 90) continue;
    EXPECT_NEAR(stiffness(width) / brick::neckStiffness(youngs, thickness, width, width), 1, 2e-3);
  }
  // Acute tiles begin beyond the corner at the neck's ends, by L / 2 cot(60 degrees).
  const brick::NeckCorner acute{std::numbers::pi / 3, 1};
  EXPECT_NEAR(brick::neckAxis(0.001, 0.1, {acute, acute}), 0.05 / std::sqrt(3.0) + 0.0005, 3e-5);
}

TEST(NeckStiffness, FallsWithTheAnglesOfItsTiles) {
  const double width = 0.1;
  const auto neck = [&](double a, double b) {
    constexpr double kDegree = std::numbers::pi / 180;
    return brick::cornerNeck(1e9, 0.001, width, {{{a * kDegree, 1}, {b * kDegree, 1}}});
  };
  const double square = neck(90, 90).bending;
  // Decks of two triangles and of two hexagons. Measured: 2.050 and 0.718.
  EXPECT_NEAR(square / neck(60, 60).bending, 2.05, 0.02);
  EXPECT_NEAR(square / neck(120, 120).bending, 0.72, 0.01);
  for (double angle = 31; angle <= 150; ++angle) {
    EXPECT_GT(neck(angle, angle).bending, neck(angle - 1, angle - 1).bending) << angle;
    EXPECT_GT(neck(angle, angle).shear, neck(angle - 1, angle - 1).shear) << angle;
    EXPECT_LT(neck(angle, angle).axis, neck(angle - 1, angle - 1).axis) << angle;
  }
  // The compliances of two tiles add up, in either order.
  const brick::CornerNeck mixed = neck(60, 120);
  EXPECT_NEAR(2 / mixed.bending, 1 / neck(60, 60).bending + 1 / neck(120, 120).bending, 1e-12);
  EXPECT_LT(mixed.axis, neck(60, 60).axis);
  EXPECT_GT(mixed.axis, neck(120, 120).axis);
  EXPECT_DOUBLE_EQ(mixed.stretch, neck(120, 60).stretch);
  // Beyond the angles that were measured.
  EXPECT_EQ(neck(20, 20).bending, neck(30, 30).bending);
  EXPECT_EQ(neck(200, 200).bending, neck(150, 150).bending);
}

}  // namespace
}  // namespace kirireel
