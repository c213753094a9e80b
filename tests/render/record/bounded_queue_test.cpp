#include <atomic>
#include <future>
#include <numeric>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/record/pipeline.h"
#include "sim/base/error.h"

namespace kirireel {
namespace {

TEST(BoundedQueue, GivesEverythingInOrder) {
  record::BoundedQueue<int> queue(3);
  std::jthread producer([&] {
    for (int i = 0; i < 1000; ++i) queue.push(i);
    queue.close();
  });
  std::vector<int> taken;
  while (const std::optional<int> value = queue.pop()) taken.push_back(*value);
  std::vector<int> expected(1000);
  std::iota(expected.begin(), expected.end(), 0);
  EXPECT_EQ(taken, expected);
}

TEST(BoundedQueue, BreaksItsPromisesWhenItIsStopped) {
  record::BoundedQueue<std::promise<int>> queue(2);
  std::promise<int> promise;
  std::future<int> value = promise.get_future();
  queue.push(std::move(promise));
  queue.stop();
  EXPECT_THROW(value.get(), std::future_error);
}

TEST(BoundedQueue, NeverHoldsMoreThanItsCapacity) {
  record::BoundedQueue<int> queue(2);
  std::atomic<int> pushed = 0;
  std::jthread producer([&] {
    for (int i = 0; i < 10; ++i) {
      queue.push(i);
      ++pushed;
    }
    queue.close();
  });
  for (int taken = 0; queue.pop(); ++taken) EXPECT_LE(pushed, taken + 3);
}

TEST(BoundedQueue, StopEndsAllWaits) {
  record::BoundedQueue<int> full(1);
  full.push(0);
  record::BoundedQueue<int> empty(1);
  std::jthread producer([&] { EXPECT_FALSE(full.push(1)); });
  std::jthread consumer([&] { EXPECT_FALSE(empty.pop()); });
  full.stop();
  empty.stop();
  producer.join();
  consumer.join();
  EXPECT_FALSE(full.pop());
  EXPECT_TRUE(full.isStopped());
}

TEST(TaskGroup, ThrowsTheErrorOfAnyStageAndStopsTheOthers) {
  record::BoundedQueue<int> never(1);
  record::TaskGroup tasks([&] { never.stop(); });
  tasks.start([&] { never.pop(); });
  tasks.start([] { throw OutputError("the disk is full"); });
  EXPECT_THROW(tasks.finish(), OutputError);
}

TEST(TaskGroup, StopsItsStagesWhenItIsDestroyed) {
  record::BoundedQueue<int> never(1);
  record::TaskGroup tasks([&] { never.stop(); });
  tasks.start([&] { never.pop(); });
}

}  // namespace
}  // namespace kirireel
