#include <gtest/gtest.h>

#include "sim/actuation/target_springs.h"

namespace kirireel {
namespace {

constexpr double kStep = 1.0 / 240;

void stall(AdaptiveStiffness& stiffness, int steps) {
  for (int i = 0; i < steps; ++i) stiffness.observe(1, kStep);
}

TEST(AdaptiveStiffness, DoublesAfterSixtyStepsWithoutImprovement) {
  AdaptiveStiffness stiffness(true);
  stall(stiffness, 1);  // the first error is the one to beat
  stall(stiffness, 59);
  EXPECT_EQ(stiffness.factor(), 1);
  stall(stiffness, 2);  // a sum of sixty steps may fall short of a quarter second by rounding
  EXPECT_EQ(stiffness.factor(), 2);
}

TEST(AdaptiveStiffness, CountsTimeNotSteps) {
  AdaptiveStiffness stiffness(true);
  stiffness.observe(1, 0.1);
  stiffness.observe(1, 0.1);
  stiffness.observe(1, 0.1);
  EXPECT_EQ(stiffness.factor(), 1);
  stiffness.observe(1, 0.1);
  EXPECT_EQ(stiffness.factor(), 2);
}

TEST(AdaptiveStiffness, HalfAPercentIsAnImprovement) {
  AdaptiveStiffness stiffness(true);
  for (int i = 0; i < 600; ++i) stiffness.observe(std::pow(0.994, i), kStep);
  EXPECT_EQ(stiffness.factor(), 1);
}

TEST(AdaptiveStiffness, LessIsNone) {
  AdaptiveStiffness stiffness(true);
  for (int i = 0; i < 200; ++i) stiffness.observe(1 - 1e-5 * i, kStep);
  EXPECT_GT(stiffness.factor(), 1);
}

TEST(AdaptiveStiffness, EndsAtSixteen) {
  AdaptiveStiffness stiffness(true);
  EXPECT_FALSE(stiffness.exhausted());
  stall(stiffness, 2000);
  EXPECT_EQ(stiffness.factor(), 16);
  EXPECT_TRUE(stiffness.exhausted());
  stiffness.stiffen();
  EXPECT_EQ(stiffness.factor(), 16);
}

TEST(AdaptiveStiffness, StiffensOnRequest) {
  AdaptiveStiffness stiffness(true);
  stiffness.stiffen();
  EXPECT_EQ(stiffness.factor(), 2);
}

TEST(AdaptiveStiffness, DisabledStaysAtOne) {
  AdaptiveStiffness stiffness(false);
  EXPECT_TRUE(stiffness.exhausted());
  stall(stiffness, 2000);
  stiffness.stiffen();
  EXPECT_EQ(stiffness.factor(), 1);
}

}  // namespace
}  // namespace kirireel
