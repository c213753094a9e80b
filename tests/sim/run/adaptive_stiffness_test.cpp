#include <gtest/gtest.h>

#include "sim/run/forces.h"
#include "tests/support/physics.h"

namespace kirireel {
namespace {

using test::kStep;

/// Reports steps of one length from time 0 on.
class Observer {
 public:
  explicit Observer(run::AdaptiveStiffness& stiffness, double step = kStep)
      : stiffness_(stiffness), step_(step) {}

  void observe(double error) { stiffness_.observe(error, ++count_ * step_, step_); }

 private:
  run::AdaptiveStiffness& stiffness_;
  double step_;
  int count_ = 0;
};

void stall(run::AdaptiveStiffness& stiffness, int steps) {
  Observer observer(stiffness);
  for (int i = 0; i < steps; ++i) observer.observe(1);
}

TEST(AdaptiveStiffness, DoublesAfterSixtyStepsWithoutImprovement) {
  run::AdaptiveStiffness stiffness(true);
  Observer observer(stiffness);
  observer.observe(1);  // the first error is the one to beat
  for (int i = 0; i < 59; ++i) observer.observe(1);
  EXPECT_EQ(stiffness.factor(), 1);
  observer.observe(1);
  EXPECT_EQ(stiffness.factor(), 2);
}

TEST(AdaptiveStiffness, CountsTimeNotSteps) {
  run::AdaptiveStiffness stiffness(true);
  Observer observer(stiffness, 0.1);
  for (int i = 0; i < 3; ++i) observer.observe(1);
  EXPECT_EQ(stiffness.factor(), 1);
  observer.observe(1);
  EXPECT_EQ(stiffness.factor(), 2);
}

/// When the stiffness doubles for an error of exp(-t^2) down to exp(-1/4), reported in steps of
/// this length.
double momentOfDoubling(double step) {
  run::AdaptiveStiffness stiffness(true);
  stiffness.observe(1, 0, 0);
  for (double time = step; time < 0.7; time += step) {
    const double fallen = std::min(time, 0.5);
    stiffness.observe(std::exp(-fallen * fallen), time, step);
  }
  return stiffness.nextMoment();
}

TEST(AdaptiveStiffness, DoublesAtAMomentThatStepsDoNotMove) {
  // The last improvement: the greatest k with 0.995^k above exp(-1/4).
  const double rate = -std::log(0.995);
  const double last = std::sqrt(std::floor(0.25 / rate) * rate);
  EXPECT_NEAR(momentOfDoubling(1e-3), last + 0.25, 1e-6);      // measured 2.4e-7
  EXPECT_NEAR(momentOfDoubling(1.0 / 60), last + 0.25, 1e-4);  // measured 5.5e-5
}

TEST(AdaptiveStiffness, TimeThatIsNotReportedDoesNotCount) {
  run::AdaptiveStiffness stiffness(true);
  stiffness.observe(1, 0.1, 0.1);
  stiffness.observe(1, 0.2, 0.1);
  EXPECT_DOUBLE_EQ(stiffness.nextMoment(), 0.35);
  stiffness.observe(1, 5.1, 0.1);  // forces were off from 0.2 to 5 s
  EXPECT_DOUBLE_EQ(stiffness.nextMoment(), 5.15);
}

TEST(AdaptiveStiffness, HalfAPercentIsAnImprovement) {
  run::AdaptiveStiffness stiffness(true);
  Observer observer(stiffness);
  for (int i = 0; i < 600; ++i) observer.observe(std::pow(0.994, i));
  EXPECT_EQ(stiffness.factor(), 1);
}

TEST(AdaptiveStiffness, SmallerChangesAreNoImprovement) {
  run::AdaptiveStiffness stiffness(true);
  Observer observer(stiffness);
  for (int i = 0; i < 200; ++i) observer.observe(1 - 1e-5 * i);
  EXPECT_GT(stiffness.factor(), 1);
}

TEST(AdaptiveStiffness, EndsAtSixteen) {
  run::AdaptiveStiffness stiffness(true);
  EXPECT_FALSE(stiffness.exhausted());
  stall(stiffness, 2000);
  EXPECT_EQ(stiffness.factor(), 16);
  EXPECT_TRUE(stiffness.exhausted());
  stiffness.stiffen();
  EXPECT_EQ(stiffness.factor(), 16);
}

TEST(AdaptiveStiffness, StiffensOnRequest) {
  run::AdaptiveStiffness stiffness(true);
  stiffness.stiffen();
  EXPECT_EQ(stiffness.factor(), 2);
}

TEST(AdaptiveStiffness, DisabledStaysAtOne) {
  run::AdaptiveStiffness stiffness(false);
  EXPECT_TRUE(stiffness.exhausted());
  stall(stiffness, 2000);
  stiffness.stiffen();
  EXPECT_EQ(stiffness.factor(), 1);
}

}  // namespace
}  // namespace kirireel
