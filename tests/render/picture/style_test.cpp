#include "render/picture/style.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace kirireel {
namespace {

/// One key light from directly above, with a brightness that can be computed by hand.
picture::Style plainStyle() {
  picture::Style style;
  style.ambient = 0.5;
  style.key = {Vector3::UnitZ(), 0.4};
  style.fill = {Vector3::UnitX(), 0.2};
  return style;
}

TEST(FaceColour, AddsAmbientAndBothLights) {
  const picture::Colour base{100, 200, 50, 255};
  // Facing the key: 0.9; facing the fill: 0.7; away from both: 0.5; between them 0.5 + 0.6 /
  // sqrt 2.
  EXPECT_EQ(picture::faceColour(Vector3::UnitZ(), base, plainStyle()),
            (picture::Colour{90, 180, 45, 255}));
  EXPECT_EQ(picture::faceColour(Vector3::UnitX(), base, plainStyle()),
            (picture::Colour{70, 140, 35, 255}));
  EXPECT_EQ(picture::faceColour(-Vector3::UnitZ(), base, plainStyle()),
            (picture::Colour{50, 100, 25, 255}));
  EXPECT_EQ(picture::faceColour(Vector3(1, 0, 1).normalized(), base, plainStyle()),
            (picture::Colour{92, 185, 46, 255}));
}

TEST(FaceColour, StopsAtWhite) {
  picture::Style style = plainStyle();
  style.ambient = 3;
  EXPECT_EQ(picture::faceColour(Vector3::UnitY(), {100, 200, 0}, style),
            (picture::Colour{255, 255, 0}));
}

TEST(Style, BacksAreMutedTintsOfTheFront) {
  const picture::BrickColours plain;
  EXPECT_EQ(plain.bottom, picture::shadesOf(plain.top).bottom);
  const auto colourfulness = [](picture::Colour colour) {
    const auto [least, most] = std::minmax({colour.red, colour.green, colour.blue});
    return most - least;
  };
  std::vector<picture::Colour> fronts = {{0, 0, 0}, {255, 255, 255}, {0, 128, 128}, {200, 40, 40}};
  for (int kind = 0; kind < 7; ++kind) fronts.push_back(picture::kindColour(kind));
  for (const picture::Colour front : fronts) {
    const picture::Colour back = picture::shadesOf(front).bottom;
    EXPECT_LE(colourfulness(back), 0.55 * colourfulness(front) + 1);  // measured 0.51
    EXPECT_GE(picture::contrastOf(front, back), 1.3);                 // measured 1.32 to 1.66
  }
  // As for the scales: 3 between a tile and the page. Measured 3.21 and 5.54.
  EXPECT_GE(picture::contrastOf(plain.bottom, picture::Style().background), 3);
  EXPECT_GE(picture::contrastOf(plain.bottom, picture::darkStyle().background), 3);
}

TEST(Style, HasUnitLights) {
  const picture::Style style;
  EXPECT_NEAR(style.key.direction.norm(), 1, 1e-15);
  EXPECT_NEAR(style.fill.direction.norm(), 1, 1e-15);
  EXPECT_NEAR(style.shadowSource.norm(), 1, 1e-15);
}

TEST(GroundPlate, SurroundsThePoints) {
  const std::vector<Vector3> points = {Vector3(1, 2, 3), Vector3(5, 4, -3)};
  const picture::GroundPlate plate = picture::groundUnder(points, -0.5);
  EXPECT_EQ(plate.height, -0.5);
  EXPECT_EQ(plate.centre, Eigen::Vector2d(3, 3));
  EXPECT_GT(plate.halfSize, 20);  // the points' diagonal is 7.5
}

}  // namespace
}  // namespace kirireel
