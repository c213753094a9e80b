#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/sweep/collect.h"

namespace kirireel {
namespace {

using ::testing::ElementsAre;

TEST(Captions, HaveFewDigits) {
  EXPECT_THAT(
      sweep::captionsOf({"spring_stiffness", "rows"}, {{"12.7427499", "4"}, {"1000", "12345"}}),
      ElementsAre("spring stiffness 12.7, rows 4", "spring stiffness 1000, rows 12345"));
  EXPECT_THAT(sweep::captionsOf({"path", "gravity"}, {{"straight", "0,0,-9.81"}}),
              ElementsAre("path straight, gravity 0,0,-9.81"));
}

TEST(Captions, DistinguishNearValues) {
  EXPECT_THAT(sweep::captionsOf({"k"}, {{"1.00011"}, {"1.00012"}, {"2.5"}}),
              ElementsAre("k 1.00011", "k 1.00012", "k 2.5"));
  EXPECT_THAT(sweep::captionsOf({"k"}, {{"0.123456"}, {"0.123456"}}),
              ElementsAre("k 0.123", "k 0.123"));
  EXPECT_THAT(sweep::captionsOf({"k"}, {{"1.0"}, {"1.00"}}), ElementsAre("k 1.0", "k 1.00"));
}

}  // namespace
}  // namespace kirireel
