#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/picture/label.h"

namespace kirireel {
namespace {

using ::testing::ElementsAre;

TEST(Ticks, AreRoundAndWithinTheAxis) {
  const picture::Axis axis = picture::makeAxis({0.13, 4.2, 2}, 5);
  EXPECT_THAT(axis.texts, ElementsAre("0", "1", "2", "3", "4"));
  EXPECT_LE(axis.low, 0.13);
  EXPECT_GE(axis.high, 4.2);
  EXPECT_THAT(picture::makeAxis({-0.02, 0.031}, 4).texts,
              ElementsAre("\u22120.02", "0.00", "0.02"));
}

TEST(Ticks, HaveExponentsWhereDecimalsAreTooMany) {
  EXPECT_THAT(picture::makeAxisWithin(0, 6.3e-6, 4).texts,
              ElementsAre("0", "2e-6", "4e-6", "6e-6"));
  EXPECT_THAT(picture::makeAxisWithin(-2e-9, 1.5e-8, 4).texts,
              ElementsAre("0", "5e-9", "1e-8", "1.5e-8"));
  EXPECT_THAT(picture::makeAxisWithin(0.9e-4, 1.12e-4, 3).texts,
              ElementsAre("9e-5", "1e-4", "1.1e-4"));
  EXPECT_THAT(picture::makeAxisWithin(0, 4.1e6, 3).texts, ElementsAre("0", "2e6", "4e6"));
  EXPECT_THAT(picture::makeAxisWithin(0, 0.0041, 3).texts, ElementsAre("0.000", "0.002", "0.004"));
}

TEST(Ticks, ShowAConstantInTheMiddle) {
  const picture::Axis axis = picture::makeAxis({-1, -1 + 1e-6}, 4);
  EXPECT_NEAR(axis.shareOf(-1), 0.5, 1e-5);
  EXPECT_GE(axis.ticks.size(), 2U);
  const picture::Axis zero = picture::makeAxis({0}, 4);
  EXPECT_EQ(zero.shareOf(0), 0.5);
}

TEST(Ticks, AreDecadesOnALogarithmicAxis) {
  const picture::Axis axis = picture::makeLogarithmicAxis({0, 3e-13, 2e-6}, 4);
  EXPECT_THAT(axis.texts, ElementsAre("1e-13", "1e-11", "1e-9", "1e-7", "1e-5"));
  EXPECT_NEAR(axis.shareOf(axis.low), 0, 1e-12);
  EXPECT_NEAR(axis.shareOf(1e-5), 1, 1e-12);
  EXPECT_EQ(picture::makeLogarithmicAxis({0, 0}, 4).ticks.size(), 3U);
}

}  // namespace
}  // namespace kirireel
