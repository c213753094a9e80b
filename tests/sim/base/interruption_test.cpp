#include "sim/base/interruption.h"

#include <chrono>
#include <string>
#include <thread>

#include <gtest/gtest.h>

namespace kirireel {
namespace {

/// Calls the check for 30 ms of CPU time. At most 10 ms pass between two checks, so at least two
/// are counted. Returns the time between them, milliseconds.
double checkFor30Milliseconds() {
  const auto start = std::chrono::steady_clock::now();
  const double end = threadCpuSeconds() + 0.03;
  while (threadCpuSeconds() < end) checkInterruption();
  const std::chrono::duration<double, std::milli> passed = std::chrono::steady_clock::now() - start;
  return passed.count();
}

TEST(Interruption, NoCheckIsCalledOutsideOfScopes) {
  EXPECT_NO_THROW(checkFor30Milliseconds());
}

TEST(Interruption, ChecksAreCalledFromTheOutermostOn) {
  std::string asked;
  const InterruptionScope outer([&] { asked += 'a'; });
  {
    const InterruptionScope inner([&] { asked += 'b'; });
    checkFor30Milliseconds();
    EXPECT_EQ(asked.substr(0, 4), "abab");
  }
  asked.clear();
  checkFor30Milliseconds();
  EXPECT_EQ(asked.substr(0, 2), "aa");
}

TEST(Interruption, ChecksSeldomEnoughForLoopsOfAnySpeed) {
  int asked = 0;
  const InterruptionScope scope([&] { ++asked; });
  const double passed = checkFor30Milliseconds();
  EXPECT_GE(asked, 2);
  EXPECT_LE(asked, passed / 10 + 1);
}

TEST(Interruption, ThrowsWhatTheCheckThrows) {
  const InterruptionScope scope([] { throw Interrupted(); });
  EXPECT_THROW(checkFor30Milliseconds(), Interrupted);
}

TEST(Interruption, ReachesThreadsThatItIsCarriedTo) {
  const InterruptionScope scope([] { throw Interrupted(); });
  bool isEnded = false;
  std::thread([&isEnded, checks = presentChecks()] {
    const InterruptionScope carried(checks);
    try {
      checkFor30Milliseconds();
    } catch (const Interrupted&) {
      isEnded = true;
    }
  }).join();
  EXPECT_TRUE(isEnded);
}

TEST(Interruption, ReportsWhetherItWouldBeCaught) {
  EXPECT_FALSE(InterruptionCatcher::exists());
  {
    const InterruptionCatcher outer;
    { const InterruptionCatcher inner; }
    EXPECT_TRUE(InterruptionCatcher::exists());
  }
  EXPECT_FALSE(InterruptionCatcher::exists());
}

}  // namespace
}  // namespace kirireel
