#include "sim/base/state_tape.h"

#include <limits>

#include <gtest/gtest.h>

#include "sim/base/error.h"

namespace kirireel {
namespace {

enum class Weather { Sun, Rain };

/// Something of each kind that a state may hold.
struct Everything {
  double number = 1.0 / 3;
  double without = std::numeric_limits<double>::infinity();
  int whole = -7;
  long steps = 4'000'000'000;
  bool on = true;
  Weather weather = Weather::Rain;
  std::string text = "pin tiles 3, 1";
  std::vector<bool> flags = {true, false, true};
  std::vector<std::pair<int, int>> pairs = {{1, 2}, {3, 4}};
  Eigen::VectorXd vector = Eigen::VectorXd::LinSpaced(5, 0.1, 0.7);
  Motion motion = {{{{1, 2, 3}, rotationFromVector({0.1, 0.2, 0.3})}}, {{{4, 5, 6}, {7, 8, 9}}}};

  void transfer(StateTape& tape) {
    tape.transfer(number, without, whole, steps, on, weather, text, flags, pairs, vector, motion);
  }
};

TEST(StateTape, PlaysBackWhatWasRecorded) {
  Everything original;
  std::vector<Everything> list = {original, {}};
  StateTape tape;
  tape.transfer(list);

  StateTape played(tape.numbers());
  std::vector<Everything> back;
  played.transfer(back);
  EXPECT_TRUE(played.isOver());
  ASSERT_EQ(back.size(), 2u);
  const Everything& copy = back[0];
  EXPECT_EQ(copy.number, original.number);
  EXPECT_EQ(copy.without, original.without);
  EXPECT_EQ(copy.whole, -7);
  EXPECT_EQ(copy.steps, 4'000'000'000);
  EXPECT_TRUE(copy.on);
  EXPECT_EQ(copy.weather, Weather::Rain);
  EXPECT_EQ(copy.text, original.text);
  EXPECT_EQ(copy.flags, original.flags);
  EXPECT_EQ(copy.pairs, original.pairs);
  EXPECT_EQ(copy.vector, original.vector);
  EXPECT_EQ(copy.motion.poses[0].rotation.coeffs(), original.motion.poses[0].rotation.coeffs());
  EXPECT_EQ(copy.motion.velocities[0].angular, original.motion.velocities[0].angular);
}

TEST(StateTape, RefusesToPlayMissingEntries) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  // A list that claims more entries than there are numbers takes no memory for them.
  for (const std::vector<double>& numbers :
       std::vector<std::vector<double>>{{}, {1e15, 1}, {-1, 1}, {nan, 1}, {2, 1}}) {
    StateTape tape(numbers);
    std::vector<double> list;
    try {
      tape.transfer(list);
      FAIL() << "accepted";
    } catch (const InputError& error) {
      EXPECT_STREQ(
          error.what(),
          "error: the checkpoint holds the state of another run; remove `resume` to start again");
    }
  }
}

}  // namespace
}  // namespace kirireel
