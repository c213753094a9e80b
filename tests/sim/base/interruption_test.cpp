#include "sim/base/interruption.h"

#include <chrono>
#include <string>
#include <thread>

#include <gtest/gtest.h>

namespace kirireel {
namespace {

/// Looks until a check was called: at most 10 ms pass between two.
void lookForLong() {
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(30);
  while (std::chrono::steady_clock::now() < end) checkInterruption();
}

TEST(Interruption, NobodyIsAskedOutsideOfScopes) {
  EXPECT_NO_THROW(lookForLong());
}

TEST(Interruption, ScopesAreAskedFromTheOutermostOn) {
  std::string asked;
  const InterruptionScope outer([&] { asked += 'a'; });
  {
    const InterruptionScope inner([&] { asked += 'b'; });
    lookForLong();
    EXPECT_EQ(asked.substr(0, 4), "abab");
  }
  asked.clear();
  lookForLong();
  EXPECT_EQ(asked.substr(0, 2), "aa");
}

TEST(Interruption, AsksSeldomEnoughForLoopsOfAnySpeed) {
  int asked = 0;
  const InterruptionScope scope([&] { ++asked; });
  lookForLong();
  EXPECT_GE(asked, 2);
  EXPECT_LE(asked, 4);
}

TEST(Interruption, ThrowsWhatTheCheckThrows) {
  const InterruptionScope scope([] { throw Interrupted(); });
  EXPECT_THROW(lookForLong(), Interrupted);
}

TEST(Interruption, ReachesThreadsThatItIsCarriedTo) {
  const InterruptionScope scope([] { throw Interrupted(); });
  bool isEnded = false;
  std::thread([&isEnded, checks = presentChecks()] {
    const InterruptionScope carried(checks);
    try {
      lookForLong();
    } catch (const Interrupted&) {
      isEnded = true;
    }
  }).join();
  EXPECT_TRUE(isEnded);
}

TEST(Interruption, KnowsWhetherItWouldBeCaught) {
  EXPECT_FALSE(InterruptionCatcher::isThere());
  {
    const InterruptionCatcher outer;
    { const InterruptionCatcher inner; }
    EXPECT_TRUE(InterruptionCatcher::isThere());
  }
  EXPECT_FALSE(InterruptionCatcher::isThere());
}

}  // namespace
}  // namespace kirireel
