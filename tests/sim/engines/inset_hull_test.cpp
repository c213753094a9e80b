#include <algorithm>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "sim/engines/bullet_world.h"

namespace kirireel {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// A brick on the unit circle's points at these angles; its other fields do not matter here.
brick::Brick brickOnCircle(const std::vector<double>& angles, double thickness) {
  brick::Brick brick;
  brick.thickness = thickness;
  for (const double angle : angles) {
    brick.bottom.emplace_back(std::cos(angle), std::sin(angle), 0);
    brick.top.emplace_back(std::cos(angle), std::sin(angle), thickness);
  }
  return brick;
}

/// Furthest that the hull with its margin reaches in a unit direction.
double reach(const engines::InsetHull& hull, const Vector3& direction) {
  double furthest = -std::numeric_limits<double>::infinity();
  for (const Vector3& point : hull.points) furthest = std::max(furthest, point.dot(direction));
  return furthest + hull.margin;
}

void expectSameFaces(const brick::Brick& brick) {
  const engines::InsetHull hull = engines::insetHull(brick);
  // Measured: 3e-15 at most.
  EXPECT_NEAR(reach(hull, brick.normal), brick.top[0].dot(brick.normal), 1e-14);
  EXPECT_NEAR(reach(hull, -brick.normal), -brick.bottom[0].dot(brick.normal), 1e-14);
  const std::size_t count = brick.bottom.size();
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3 edge = brick.bottom[(k + 1) % count] - brick.bottom[k];
    const Vector3 outwards = edge.cross(brick.normal).normalized();
    EXPECT_NEAR(reach(hull, outwards), brick.bottom[k].dot(outwards), 1e-14);
  }
}

TEST(InsetHull, WithItsMarginHasTheFacesOfTheBrick) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> angle(0, 2 * kPi);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<double> angles(3 + trial % 5);
    std::ranges::generate(angles, [&] { return angle(random); });
    std::ranges::sort(angles);
    expectSameFaces(brickOnCircle(angles, 0.3));
  }
}

TEST(InsetHull, TakesAFifthOfTheThicknessUpToTwoCentimetres) {
  const std::vector<double> square = {0, kPi / 2, kPi, 3 * kPi / 2};
  EXPECT_DOUBLE_EQ(engines::insetHull(brickOnCircle(square, 0.02)).margin, 0.004);
  EXPECT_DOUBLE_EQ(engines::insetHull(brickOnCircle(square, 0.1)).margin, 0.02);
  EXPECT_DOUBLE_EQ(engines::insetHull(brickOnCircle(square, 1)).margin, 0.02);
}

TEST(InsetHull, LeavesHalfOfAShortEdge) {
  // The edge between the first two points is 0.001 long.
  const brick::Brick sliver = brickOnCircle({0, 0.001, kPi}, 0.1);
  const engines::InsetHull hull = engines::insetHull(sliver);
  EXPECT_LT(hull.margin, 0.001);
  const double before = (sliver.bottom[1] - sliver.bottom[0]).norm();
  const double after = (hull.points[1] - hull.points[0]).norm();
  EXPECT_NEAR(after, 0.5 * before, 1e-15);
}

}  // namespace
}  // namespace kirireel
