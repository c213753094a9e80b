#include <gtest/gtest.h>

#include "sim/mechanics/joint_solver.h"
#include "tests/support/physics.h"

namespace kirireel {
namespace {

using test::kStep;

class StandstillTest : public testing::Test {
 protected:
  /// One step in which bricks do not move, after a motion or not. Returns whether a standstill is
  /// tried.
  bool rest(bool movedBefore = false) {
    if (!standstill_.beginStep(motion_, loads_, kStep)) return false;
    if (movedBefore) standstill_.recordMotion();
    standstill_.recordStandstill();
    standstill_.endStep(motion_.poses, loads_);
    return true;
  }

  /// The number of `steps` that try a standstill.
  int tried(int steps) {
    int count = 0;
    for (int step = 0; step < steps; ++step) count += rest() ? 1 : 0;
    return count;
  }

  mechanics::Standstill standstill_;
  Motion motion_ = {Poses(2), std::vector<Velocity>(2)};
  std::vector<brick::Load> loads_ = std::vector<brick::Load>(2);
};

TEST_F(StandstillTest, AFailureInHalvesIsNotTriedAgain) {
  EXPECT_TRUE(standstill_.mayHalve());
  EXPECT_TRUE(rest());
  EXPECT_TRUE(standstill_.isWhole());
  EXPECT_EQ(tried(100), 0);
}

TEST_F(StandstillTest, AFailureAsAWholeIsTriedInHalvesAtTheTenthStep) {
  EXPECT_TRUE(rest(true));
  EXPECT_FALSE(standstill_.isWhole());
  EXPECT_TRUE(rest());  // in one piece
  EXPECT_FALSE(standstill_.mayHalve());
  EXPECT_EQ(tried(8), 0);
  EXPECT_TRUE(standstill_.beginStep(motion_, loads_, kStep));
  EXPECT_TRUE(standstill_.mayHalve());
}

TEST_F(StandstillTest, OnePartAtRestEndsHalving) {
  standstill_.beginStep(motion_, loads_, kStep);
  EXPECT_TRUE(standstill_.mayHalve());
  standstill_.recordStandstill();
  EXPECT_FALSE(standstill_.mayHalve());
}

TEST_F(StandstillTest, AnyChangeIsTried) {
  rest();
  loads_[1].force[2] = 1e-12;
  EXPECT_TRUE(rest());
  EXPECT_FALSE(rest());
  motion_.poses[0].position.x() = 1e-12;
  EXPECT_TRUE(rest());
  EXPECT_FALSE(rest());
  motion_.velocities[1].angular.z() = 1e-12;
  EXPECT_TRUE(rest());
  motion_.velocities[1].angular.z() = 0;
  EXPECT_TRUE(standstill_.beginStep(motion_, loads_, 0.5 * kStep));
}

TEST_F(StandstillTest, AForgottenStepIsTriedInHalves) {
  rest();
  standstill_.forget();
  EXPECT_TRUE(standstill_.beginStep(motion_, loads_, kStep));
  EXPECT_TRUE(standstill_.mayHalve());
}

TEST_F(StandstillTest, ComesBackFromATape) {
  rest();
  StateTape tape;
  tape.transfer(standstill_);
  StateTape played(tape.numbers());
  mechanics::Standstill other;
  played.transfer(other);
  EXPECT_TRUE(played.isOver());
  EXPECT_FALSE(other.beginStep(motion_, loads_, kStep));
}

}  // namespace
}  // namespace kirireel
