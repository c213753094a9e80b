#include <algorithm>

#include <gtest/gtest.h>

#include "sim/base/state_tape.h"
#include "sim/contacts/contact_finder.h"
#include "tests/sim/contacts/prisms.h"

namespace kirireel {
namespace {

using test::Chance;

TEST(MotionBound, IsReachedByNoPoint) {
  Chance chance(1);
  double closest = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const Pose from = chance.pose(0.1);
    Pose to = from;
    const double size = std::pow(10, 3 * chance.next());
    to.position += 0.1 * size * chance.vector();
    to.rotation = (rotationFromVector(size * chance.vector()) * to.rotation).normalized();
    const Vector3 point = chance.vector().normalized();
    const double moved = (to.apply(point) - from.apply(point)).norm();
    const double bound = contacts::motionBound(from, to, 1);
    EXPECT_LE(moved, bound + 1e-12);
    closest = std::max(closest, moved / bound);
  }
  EXPECT_GT(closest, 0.9);  // the bound is tight; measured 0.99
}

std::vector<brick::Brick> prisms(int count) {
  std::vector<brick::Brick> bricks;
  for (int i = 0; i < count; ++i) bricks.push_back(test::prism(3 + i % 4, 0.3, 0.1));
  return bricks;
}

Poses scattered(Chance& chance, int count, double spread) {
  Poses poses;
  for (int i = 0; i < count; ++i) poses.push_back(chance.pose(spread));
  return poses;
}

// A state recorded before the first update has no boxes, and keeps none of a later update.
TEST(NearPairs, PlayAStateFromBeforeTheFirstUpdate) {
  Chance chance(3);
  const std::vector<brick::Brick> bricks = prisms(10);
  const Poses poses = scattered(chance, 10, 0.1);
  contacts::NearPairs unused(bricks), used(bricks);
  StateTape tape;
  unused.transfer(tape);
  ASSERT_TRUE(used.update(poses, poses));
  ASSERT_FALSE(used.pairs().empty());
  StateTape played(tape.numbers());
  used.transfer(played);
  EXPECT_TRUE(used.pairs().empty());
  EXPECT_TRUE(used.update(poses, poses));
  EXPECT_FALSE(used.pairs().empty());
}

TEST(NearPairs, ContainEveryPairWhoseBoxesOverlap) {
  // Second method: all boxes against all.
  Chance chance(2);
  const std::vector<brick::Brick> bricks = prisms(40);
  Poses start = scattered(chance, 40, 2);
  contacts::NearPairs near(bricks);
  int found = 0, reused = 0;
  for (int step = 0; step < 100; ++step) {
    Poses end = start;
    for (Pose& pose : end) pose.position += 0.004 * chance.vector();
    reused += near.update(start, end) ? 0 : 1;
    for (int a = 0; a < 40; ++a) {
      for (int b = a + 1; b < 40; ++b) {
        const auto box = [&](int brick, const Pose& pose) {
          Eigen::AlignedBox3d all;
          for (const Vector3& point : bricks[brick].bottom) all.extend(pose.apply(point));
          for (const Vector3& point : bricks[brick].top) all.extend(pose.apply(point));
          return all;
        };
        if (!box(a, end[a]).intersects(box(b, end[b]))) continue;
        ++found;
        const auto& pairs = near.pairs();
        EXPECT_TRUE(std::binary_search(pairs.begin(), pairs.end(), std::pair(a, b)));
      }
    }
    start = end;
  }
  EXPECT_GT(found, 500);
  EXPECT_GT(reused, 20);
}

TEST(NearPairs, DependOnlyOnTheLastBoxes) {
  Chance chance(3);
  const std::vector<brick::Brick> bricks = prisms(40);
  Poses poses = scattered(chance, 40, 1);
  contacts::NearPairs whole(bricks);
  std::unique_ptr<contacts::NearPairs> resumed;
  int found = 0;
  for (int step = 0; step < 100; ++step) {
    const Poses start = poses;
    for (Pose& pose : poses) pose.position += 0.05 * chance.vector();
    found += whole.update(start, poses) ? 1 : 0;
    if (resumed) {
      resumed->update(start, poses);
      EXPECT_EQ(whole.pairs(), resumed->pairs()) << step;
    }
    if (step % 10 != 5) continue;
    StateTape tape;
    tape.transfer(whole);
    StateTape played(tape.numbers());
    resumed = std::make_unique<contacts::NearPairs>(bricks);
    resumed->update(start, start);
    played.transfer(*resumed);
    EXPECT_EQ(whole.pairs(), resumed->pairs()) << step;
  }
  EXPECT_GT(found, 20);
}

}  // namespace
}  // namespace kirireel
