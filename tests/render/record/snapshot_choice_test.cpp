#include "render/record/snapshot_choice.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/model/tessellation.h"

namespace kirireel {
namespace {

using ::testing::ElementsAre;

/// One brick that has moved along x by way(i) at sample i.
template <typename Way>
Trajectory sliding(int samples, const Way& way) {
  TessellationShape shape;
  shape.columns = shape.rows = 1;
  const std::vector<Tile> tiles = tessellationTiles(shape, 0);
  Trajectory trajectory;
  trajectory.bricks = makeBricks(tiles, {});
  for (int i = 0; i < samples; ++i) {
    Sample sample;
    sample.time = 0.1 * i;
    sample.poses = startPoses(tiles, trajectory.bricks);
    sample.poses.front().position.x() += way(i);
    trajectory.samples.push_back(sample);
  }
  return trajectory;
}

std::vector<double> wayOf(const Trajectory& trajectory) {
  WayMeter meter(trajectory.bricks);
  std::vector<double> way;
  for (const Sample& sample : trajectory.samples) way.push_back(meter.add(sample.poses));
  return way;
}

std::vector<double> timesOf(const Trajectory& trajectory) {
  std::vector<double> times;
  for (const Sample& sample : trajectory.samples) times.push_back(sample.time);
  return times;
}

TEST(TravelledWay, OfASlidingBrickIsItsDistance) {
  const Trajectory trajectory = sliding(50, [](int i) { return std::sqrt(i); });
  const std::vector<double> way = wayOf(trajectory);
  for (int i = 0; i < 50; ++i) EXPECT_NEAR(way[i], std::sqrt(i), 1e-13);  // 3.6e-15
}

TEST(TravelledWay, CountsComingBack) {
  const Trajectory trajectory = sliding(3, [](int i) { return i % 2; });
  EXPECT_NEAR(wayOf(trajectory).back(), 2, 1e-15);
}

TEST(ChooseSnapshots, ByTimeAreEquallySpaced) {
  const Trajectory trajectory = sliding(101, [](int i) { return i * i; });
  EXPECT_THAT(chooseSnapshots(timesOf(trajectory), 5), ElementsAre(0, 25, 50, 75, 100));
}

TEST(ChooseSnapshots, ByProgressShareTheWay) {
  const Trajectory trajectory = sliding(101, [](int i) { return i * i; });
  // Way i^2 of 100^2: a quarter at 50, a half at 70.7, three quarters at 86.6.
  EXPECT_THAT(chooseSnapshots(wayOf(trajectory), 5), ElementsAre(0, 50, 71, 87, 100));
}

TEST(ChooseSnapshots, AreDistinctAndEndWithTheLastEvenAtRest) {
  // All the way in the first step, then rest.
  const Trajectory trajectory = sliding(30, [](int i) { return i > 0 ? 1 : 0; });
  for (const std::vector<double>& marks : {timesOf(trajectory), wayOf(trajectory)}) {
    for (int count = 2; count <= 30; ++count) {
      const std::vector<int> chosen = chooseSnapshots(marks, count);
      ASSERT_EQ(static_cast<int>(chosen.size()), count);
      EXPECT_EQ(chosen.front(), 0);
      EXPECT_EQ(chosen.back(), 29);
      EXPECT_TRUE(std::is_sorted(chosen.begin(), chosen.end(), std::less_equal<>()));
    }
  }
}

TEST(ChooseSnapshots, OfShortTrajectoriesAreAll) {
  const Trajectory trajectory = sliding(3, [](int i) { return i; });
  EXPECT_THAT(chooseSnapshots(timesOf(trajectory), 9), ElementsAre(0, 1, 2));
  EXPECT_THAT(chooseSnapshots(timesOf(trajectory), 1), ElementsAre(2));
}

}  // namespace
}  // namespace kirireel
