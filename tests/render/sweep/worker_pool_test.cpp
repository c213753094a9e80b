#include "render/sweep/worker_pool.h"

#include <csignal>
#include <map>
#include <new>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "sim/base/error.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

using ::testing::ElementsAre;
using ::testing::Pair;

/// Runs jobs 0 to count - 1 and stores the reports about them.
struct PoolRun {
  std::map<std::uint64_t, std::string> lost;
  std::map<sweep::Verdict, int> verdicts;
  std::uint64_t nextJob = 0;

  bool run(std::uint64_t count, const std::function<sweep::Verdict(std::uint64_t)>& work,
           const sweep::WorkerLimits& limits = {2}) {
    return sweep::runInWorkers({[&]() -> std::optional<std::uint64_t> {
                                  if (nextJob == count) return std::nullopt;
                                  return nextJob++;
                                },
                                work,
                                [&](std::uint64_t job, const std::string& reason) {
                                  lost[job] = reason;
                                  return sweep::Verdict::Failed;
                                },
                                [&](std::optional<sweep::Verdict> verdict) {
                                  if (verdict) ++verdicts[*verdict];
                                  return true;
                                }},
                               limits);
  }
};

TEST(WorkerPool, DoesEveryJobOnce) {
  const test::TemporaryFolder folder;
  PoolRun pool;
  EXPECT_TRUE(pool.run(100, [&](std::uint64_t job) {
    const bool isNew = std::filesystem::create_directory(folder / std::to_string(job));
    return isNew ? sweep::Verdict::Done : sweep::Verdict::Failed;
  }));
  EXPECT_THAT(pool.verdicts, ElementsAre(Pair(sweep::Verdict::Done, 100)));
}

TEST(WorkerPool, CrashLosesOnlyItsOwnJob) {
  PoolRun pool;
  EXPECT_TRUE(pool.run(20, [](std::uint64_t job) {
    if (job == 3) ::_exit(7);
    if (job == 4) ::raise(SIGTRAP);
    return sweep::Verdict::Done;
  }));
  EXPECT_THAT(pool.lost, ElementsAre(Pair(3, "ended with exit code 7"),
                                     Pair(4, "ended by signal 5 (Trace/breakpoint trap)")));
  EXPECT_EQ(pool.verdicts[sweep::Verdict::Done], 18);
}

TEST(WorkerPool, ErrorEndsItsWorkerIfItCannotBeReported) {
  PoolRun pool;
  EXPECT_TRUE(pool.run(2, [](std::uint64_t job) {
    if (job == 1) return sweep::Verdict::Done;
    std::freopen("/dev/full", "w", stderr);
    throw OutputError("no room");
  }));
  EXPECT_THAT(pool.lost, ElementsAre(Pair(0, "ended with exit code 1")));
}

TEST(WorkerPool, HungJobIsEnded) {
  PoolRun pool;
  const auto work = [](std::uint64_t job) {
    while (job == 1) ::pause();
    return sweep::Verdict::Done;
  };
  EXPECT_TRUE(pool.run(3, work, {1, 0.05}));
  EXPECT_THAT(pool.lost, ElementsAre(Pair(1, "took longer than 0.05 s")));
}

TEST(WorkerPool, MemoryIsBounded) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "no memory is limited under sanitizers";
#endif
  PoolRun pool;
  const auto work = [](std::uint64_t) {
    try {
      const std::vector<char> large(1 << 30);
      return sweep::Verdict::Done;
    } catch (const std::bad_alloc&) {
      return sweep::Verdict::Failed;
    }
  };
  EXPECT_TRUE(pool.run(1, work, {1, 3600, 512 << 20}));
  EXPECT_THAT(pool.verdicts, ElementsAre(Pair(sweep::Verdict::Failed, 1)));
}

TEST(WorkerPool, KilledJobIsTriedOnceMore) {
  const test::TemporaryFolder folder;
  PoolRun pool;
  EXPECT_TRUE(pool.run(5, [&](std::uint64_t job) {
    const bool isFirst = std::filesystem::create_directory(folder / std::to_string(job));
    if (job == 4 || (job == 2 && isFirst)) ::raise(SIGKILL);
    return sweep::Verdict::Done;
  }));
  EXPECT_THAT(pool.lost, ElementsAre(Pair(4, "ended by signal 9 (Killed)")));
  EXPECT_EQ(pool.verdicts[sweep::Verdict::Done], 4);
}

TEST(WorkerPool, EndsAllWhenTheWatcherRequestsIt) {
  const auto begin = [next = 0]() mutable { return std::optional<std::uint64_t>(next++); };
  const auto hang = [](std::uint64_t) {
    while (true) ::pause();
    return sweep::Verdict::Done;
  };
  const auto lose = [](std::uint64_t, const std::string&) { return sweep::Verdict::Failed; };
  EXPECT_FALSE(sweep::runInWorkers({begin, hang, lose, [](auto) { return false; }}, {2}));
}

}  // namespace
}  // namespace kirireel
