#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/record/pace.h"

namespace kirireel {
namespace {

using ::testing::ElementsAre;

const std::vector<double> kTimes = {0, 0.1, 0.2, 0.3, 0.4, 0.5};
/// Accelerated motion.
const record::MotionCurve kMotion(kTimes, {0, 1, 4, 9, 16, 25});

using Unit = record::FrameChoice::Unit;

TEST(ChooseFrames, TakesTheNearestSamples) {
  EXPECT_THAT(record::chooseFrames(kTimes, kMotion, {{0.26, Unit::Seconds}, {0.04, Unit::Seconds}}),
              ElementsAre(0, 3));
  EXPECT_THAT(record::chooseFrames(kTimes, kMotion, {{0.6, Unit::Share}, {1, Unit::Share}}),
              ElementsAre(4, 5));
}

TEST(ChooseFrames, TakesEachOnce) {
  EXPECT_THAT(record::chooseFrames(kTimes, kMotion, {{0.3, Unit::Seconds}, {0.36, Unit::Share}}),
              ElementsAre(3));
}

}  // namespace
}  // namespace kirireel
