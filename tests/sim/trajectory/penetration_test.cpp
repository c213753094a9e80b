#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "sim/generate/lattice.h"
#include "sim/trajectory/measures.h"

namespace kirireel {
namespace {

constexpr double kPi = std::numbers::pi;

brick::Brick box(double length, double width, double thickness) {
  brick::BrickRule rule;
  rule.thickness = thickness;
  return brick::makeBrick({{{0, 0, 0}, {length, 0, 0}, {length, width, 0}, {0, width, 0}}}, rule);
}

brick::Brick polygon(int corners, double radius, double thickness) {
  brick::BrickRule rule;
  rule.thickness = thickness;
  model::Tile tile;
  for (int k = 0; k < corners; ++k) {
    const double angle = 2 * kPi * k / corners;
    tile.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0);
  }
  return brick::makeBrick(tile, rule);
}

double depthOf(const brick::Brick& a, const Pose& poseA, const brick::Brick& b, const Pose& poseB) {
  return trajectory::deepestPenetration({a, b}, {poseA, poseB}).depth;
}

std::vector<Vector3> cornersOf(const brick::Brick& brick, const Pose& pose) {
  std::vector<Vector3> corners;
  for (const Vector3& point : brick.bottom) corners.push_back(pose.apply(point));
  for (const Vector3& point : brick.top) corners.push_back(pose.apply(point));
  return corners;
}

/// Distance that A must move against `direction` to separate from B.
double overlap(const std::vector<Vector3>& a, const std::vector<Vector3>& b,
               const Vector3& direction) {
  double highA = -1e9, lowB = 1e9;
  for (const Vector3& point : a) highA = std::max(highA, point.dot(direction));
  for (const Vector3& point : b) lowB = std::min(lowB, point.dot(direction));
  return highA - lowB;
}

/// The second method: the smallest overlap over many directions, the best of them refined by
/// smaller and smaller random turns. Negative when a separating direction is found.
double overlapBySampling(const std::vector<Vector3>& a, const std::vector<Vector3>& b,
                         std::mt19937& random) {
  std::normal_distribution<double> normal;
  const auto randomVector = [&] { return Vector3(normal(random), normal(random), normal(random)); };
  std::vector<std::pair<double, Vector3>> starts;
  for (int i = 0; i < 3000; ++i) {
    const Vector3 direction = randomVector().normalized();
    starts.emplace_back(overlap(a, b, direction), direction);
  }
  std::sort(starts.begin(), starts.end(),
            [](const auto& x, const auto& y) { return x.first < y.first; });
  double least = starts[0].first;
  for (int start = 0; start < 10; ++start) {
    auto [best, direction] = starts[start];
    for (double size = 0.1; size > 1e-8; size *= 0.97) {
      for (int attempt = 0; attempt < 6; ++attempt) {
        const Vector3 other = (direction + size * randomVector()).normalized();
        const double value = overlap(a, b, other);
        if (value >= best) continue;
        best = value;
        direction = other;
      }
    }
    least = std::min(least, best);
  }
  return least;
}

TEST(Penetration, OfTwoBoxesHasTheClosedForm) {
  const brick::Brick a = box(1, 1, 0.02), b = box(2, 1, 0.02);
  const Pose origin;
  // Side by side, overlapping by 0.01 along x: less than the thickness.
  EXPECT_NEAR(depthOf(a, origin, b, {{1.49, 0.3, 0}}), 0.01, 1e-15);
  // Deep overlap: the thickness is the smallest separation.
  EXPECT_NEAR(depthOf(a, origin, b, {{0.2, 0.3, 0.005}}), 0.015, 1e-15);
  // Separate.
  EXPECT_EQ(depthOf(a, origin, b, {{1.51, 0, 0}}), 0);
  EXPECT_EQ(depthOf(a, origin, b, {{0, 0, 0.03}}), 0);
}

TEST(Penetration, InOneLayerCountsWithinIt) {
  const brick::Brick a = box(1, 1, 0.02), b = box(2, 1, 0.02);
  const Pose poseB{{1.2, 0.3, 0}};
  EXPECT_NEAR(depthOf(a, {}, b, poseB), 0.3, 1e-15);
  // Slightly higher, the separation is over the top of the other.
  EXPECT_NEAR(depthOf(a, {}, b, {{1.2, 0.3, 0.001}}), 0.019, 1e-15);
  // In any plane, and turned over.
  const Quaternion turn = rotationFromVector({-1, 0.3, 2});
  const Vector3 shift(5, -7, 3);
  const Pose movedB{turn * poseB.position + shift, turn * poseB.rotation};
  EXPECT_NEAR(depthOf(a, {shift, turn}, b, movedB), 0.3, 1e-14);  // measured 4e-16
  const Pose overB{poseB.position, rotationFromVector({kPi, 0, 0})};
  EXPECT_NEAR(depthOf(a, {}, b, overB), 0.3, 1e-14);  // measured 0
}

TEST(Penetration, OfABrickThroughAnotherHasTheClosedForm) {
  // A thin upright bar through the middle of a plate: both extend beyond their overlap on two axes.
  // The smallest separation is along x: half of the plate and half of the bar.
  const brick::Brick plate = box(1, 4, 1), bar = box(0.2, 6, 0.2);
  const Pose upright{{0, 0, 0}, rotationFromVector({kPi / 2, 0, 0})};
  EXPECT_NEAR(depthOf(plate, {}, bar, upright), 0.6, 1e-15);
  const Quaternion turn = rotationFromVector({0.4, -0.7, 0.3});
  EXPECT_NEAR(depthOf(plate, {{5, 6, 7}, turn}, bar, {{5, 6, 7}, turn * upright.rotation}), 0.6,
              1e-14);
  // The same by the meter of a run.
  trajectory::PenetrationMeter meter({plate, bar}, {}, 0.05, {{{9, 0, 0}}, {}}, 0);
  EXPECT_NEAR(meter.at({{}, upright}).whole, 0.6, 1e-15);
}

// Transformation: a turned and moved state has the same overlaps, also of bricks that are nearly
// parallel, whose edges have no well-defined product.
TEST(Penetration, IsTheSameForTurnedStates) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const auto vector = [&] { return Vector3(normal(random), normal(random), normal(random)); };
  double largest = 0;
  for (int i = 0; i < 2000; ++i) {
    const brick::Brick a = polygon(3 + i % 4, 1, 0.1), b = polygon(4, 1, i % 2 == 0 ? 0.1 : 3);
    const double tilt = std::pow(10.0, -(i % 13));
    const Pose poseB{0.3 * vector(), rotationFromVector(tilt * vector())};
    const double depth = depthOf(a, {}, b, poseB);
    const Quaternion turn = rotationFromVector(vector());
    const double turned = depthOf(
        a, {{1, 2, 3}, turn}, b, {turn * poseB.position + Vector3(1, 2, 3), turn * poseB.rotation});
    largest = std::max(largest, std::abs(turned - depth));
  }
  EXPECT_LT(largest, 1e-12);  // 4e-15 by NumPy (tests/oracle/check_run.py)
}

TEST(Penetration, OfACornerInASideHasTheClosedForm) {
  const brick::Brick a = box(1, 1, 1);
  const Pose turned{{0.5 + std::sqrt(0.5) - 0.05, 0, 0}, rotationFromVector({0, 0, kPi / 4})};
  EXPECT_NEAR(depthOf(a, {}, a, turned), 0.05, 1e-14);  // measured 4e-17
}

TEST(Penetration, OfCrossedEdgesHasTheClosedForm) {
  // Two bars on edge, crossing at right angles: only the product of their long edges separates.
  const brick::Brick bar = box(10, 1, 1);
  const Pose lower{Vector3::Zero(), rotationFromVector({kPi / 4, 0, 0})};
  Pose upper{{0, 0, 2 * std::sqrt(0.5) - 0.1},
             rotationFromVector({0, 0, kPi / 2}) * rotationFromVector({kPi / 4, 0, 0})};
  EXPECT_NEAR(depthOf(bar, lower, bar, upper), 0.1, 1e-14);  // measured 3e-17
  upper.position.z() += 0.2;
  EXPECT_EQ(depthOf(bar, lower, bar, upper), 0);
}

TEST(Penetration, MatchesSampledDirections) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  int overlapping = 0;
  for (int i = 0; i < 60; ++i) {
    const brick::Brick a = polygon(3 + i % 5, 1, i % 2 == 0 ? 0.4 : 0.01);
    const brick::Brick b = polygon(3 + i % 4, 0.8, 0.3);
    const auto randomPose = [&](double reach) {
      const Quaternion turn(normal(random), normal(random), normal(random), normal(random));
      return Pose{reach * Vector3(normal(random), normal(random), normal(random)),
                  turn.normalized()};
    };
    const Pose poseA = randomPose(0.1), poseB = randomPose(0.45);
    const double found = depthOf(a, poseA, b, poseB);
    const double sampled = overlapBySampling(cornersOf(a, poseA), cornersOf(b, poseB), random);
    EXPECT_LE(found, std::max(sampled, 0.0) + 1e-12);
    EXPECT_NEAR(found, std::max(sampled, 0.0), 1e-5) << "pair " << i;  // measured 1e-6
    overlapping += found > 0 ? 1 : 0;
  }
  EXPECT_GT(overlapping, 20);
  EXPECT_LT(overlapping, 60);
}

TEST(Penetration, IsTheSameForMovedAndSwappedBricks) {
  const brick::Brick a = polygon(5, 1, 0.3), b = polygon(3, 1, 0.2);
  const Pose poseB{{0.6, 0.2, 0.1}, rotationFromVector({0.5, 1, -0.3})};
  const double depth = depthOf(a, {}, b, poseB);
  EXPECT_GT(depth, 0.05);
  EXPECT_NEAR(depthOf(b, poseB, a, {}), depth, 1e-15);
  const Quaternion turn = rotationFromVector({-1, 0.3, 2});
  const Vector3 shift(5, -7, 3);
  const Pose movedA{shift, turn}, movedB{turn * poseB.position + shift, turn * poseB.rotation};
  EXPECT_NEAR(depthOf(a, movedA, b, movedB), depth, 1e-14);  // measured 7e-16
}

TEST(Penetration, TouchingSheetsHaveOnlyRounding) {
  for (const double thickness : {0.001, 0.02, 1.0}) {
    for (const double angle : {0.0, 0.5, kPi / 2}) {
      generate::TessellationShape shape;
      shape.columns = 7;
      shape.rows = 6;
      const std::vector<model::Tile> tiles = generate::tessellationTiles(shape, angle);
      brick::BrickRule rule;
      rule.thickness = thickness;
      const std::vector<brick::Brick> bricks = brick::makeBricks(tiles, rule);
      // measured 1e-16
      EXPECT_LT(trajectory::deepestPenetration(bricks, brick::startPoses(tiles, bricks)).depth,
                1e-14);
    }
  }
}

TEST(Penetration, FindsTheDeepestPairOfASheet) {
  generate::TessellationShape shape;
  shape.columns = shape.rows = 12;
  const std::vector<model::Tile> tiles = generate::tessellationTiles(shape, 0.5);
  const std::vector<brick::Brick> bricks = brick::makeBricks(tiles, {});
  Poses poses = brick::startPoses(tiles, bricks);
  poses[40].position.x() += 0.005;
  poses[100].position.y() += 0.015;
  const trajectory::Penetration found = trajectory::deepestPenetration(bricks, poses);
  EXPECT_TRUE(found.brickA == 100 || found.brickB == 100);
  // The second method: each pair separately.
  double deepest = 0;
  for (size_t i = 0; i < bricks.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      deepest = std::max(deepest, depthOf(bricks[i], poses[i], bricks[j], poses[j]));
    }
  }
  EXPECT_EQ(found.depth, deepest);
}

TEST(Penetration, IsZeroWithoutBricks) {
  const trajectory::Penetration found = trajectory::deepestPenetration({}, {});
  EXPECT_EQ(found.depth, 0);
  EXPECT_EQ(found.brickA, -1);
}

TEST(Penetration, OutsidePivotsLeavesOutTheSharedCorners) {
  // Two squares joined at a corner, turned into each other by an angle. Whole squares: a side of
  // one has its far end in the other. Without the corners at the pivot this does not change. If
  // they are moved apart along the sides' common line until only the corners overlap, no overlap
  // remains.
  generate::TessellationShape shape;
  shape.columns = 2;
  shape.rows = 1;
  const model::Model model = generate::makeTessellation(shape);
  const std::vector<brick::Brick> bricks = brick::makeBricks(model.tiles, {});
  const std::vector<brick::Pivot> pivots = brick::makePivots(model.joints, bricks);
  Poses poses = brick::startPoses(model.tiles, bricks);
  poses[1].position.x() -= 0.01;
  EXPECT_NEAR(trajectory::deepestPenetration(bricks, poses).depth, 0.01, 1e-12);
  EXPECT_NEAR(trajectory::deepestPenetrationOutsidePivots(bricks, pivots, 0.05, poses).depth, 0.01,
              1e-12);
  const Vector3 pivot = poses[0].apply(pivots[0].pointA);
  const double side = poses[0].position.y() < pivot.y() ? 1 : -1;
  poses[1].position.y() += side * 0.97;
  EXPECT_NEAR(trajectory::deepestPenetration(bricks, poses).depth, 0.01, 1e-12);
  EXPECT_EQ(trajectory::deepestPenetrationOutsidePivots(bricks, pivots, 0.05, poses).depth, 0);
}

TEST(Penetration, AllPairsAreListedTheDeepestFirst) {
  const model::Tile square{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}};
  std::vector<model::Tile> tiles(4, square);
  const double shifts[] = {0, 0.9, 1.7, 2.8};  // overlaps 0.1, 0.2 and none
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    for (Vector3& vertex : tiles[i].vertices) vertex.x() += shifts[i];
  }
  const std::vector<brick::Brick> bricks = brick::makeBricks(tiles, {.thickness = 1});
  const Poses poses = brick::startPoses(tiles, bricks);
  const std::vector<trajectory::Penetration> all =
      trajectory::penetrationsOutsidePivots(bricks, {}, 0.05, poses, 0.05);
  ASSERT_EQ(all.size(), 2u);
  EXPECT_NEAR(all[0].depth, 0.2, 1e-12);
  EXPECT_EQ(all[0].brickA, 1);
  EXPECT_EQ(all[0].brickB, 2);
  EXPECT_NEAR(all[1].depth, 0.1, 1e-12);
  EXPECT_EQ(trajectory::deepestPenetration(bricks, poses).depth, all[0].depth);
  EXPECT_EQ(trajectory::penetrationsOutsidePivots(bricks, {}, 0.05, poses, 0.15).size(), 1u);
}

TEST(Penetration, GrowsFromWhatEachPairHadAtTheStart) {
  const model::Tile square{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}};
  std::vector<model::Tile> tiles(3, square);
  const double shifts[] = {0, 0.9, 2};  // overlaps 0.1 and none
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    for (Vector3& vertex : tiles[i].vertices) vertex.x() += shifts[i];
  }
  const std::vector<brick::Brick> bricks = brick::makeBricks(tiles, {.thickness = 1});
  Poses poses = brick::startPoses(tiles, bricks);
  trajectory::PenetrationMeter meter(bricks, {}, 0.05, poses, 1e-9);
  EXPECT_NEAR(meter.at(poses).outsidePivots, 0.1, 1e-12);
  EXPECT_NEAR(meter.at(poses).grown, 0, 1e-12);
  poses[1].position.x() += 0.13;  // the first pair parts, the second meets
  EXPECT_NEAR(meter.at(poses).outsidePivots, 0.03, 1e-12);
  EXPECT_NEAR(meter.at(poses).grown, 0.03, 1e-12);
  poses[1].position.x() -= 0.25;
  EXPECT_NEAR(meter.at(poses).outsidePivots, 0.22, 1e-12);
  EXPECT_NEAR(meter.at(poses).grown, 0.12, 1e-12);
}

/// The same figures from the functions for a single state.
trajectory::PenetrationDepths depthsOf(const std::vector<brick::Brick>& bricks,
                                       const std::vector<brick::Pivot>& pivots, double zone,
                                       const Poses& start, const Poses& poses) {
  trajectory::PenetrationDepths depths{trajectory::deepestPenetration(bricks, poses).depth};
  const auto before = trajectory::penetrationsOutsidePivots(bricks, pivots, zone, start, 0);
  for (const trajectory::Penetration& pair :
       trajectory::penetrationsOutsidePivots(bricks, pivots, zone, poses, 0)) {
    double kept = 0;
    for (const trajectory::Penetration& other : before) {
      if (other.brickA == pair.brickA && other.brickB == pair.brickB) kept = other.depth;
    }
    depths.outsidePivots = std::max(depths.outsidePivots, pair.depth);
    depths.grown = std::max(depths.grown, pair.depth - kept);
  }
  return depths;
}

// Second method: the memory of earlier states does not change a bit of the figures.
TEST(PenetrationMeter, AgreesWithSingleStates) {
  const model::Model model = generate::makeTessellation({.columns = 4, .rows = 3});
  const std::vector<brick::Brick> bricks = brick::makeBricks(model.tiles, {.thickness = 0.2});
  const std::vector<brick::Pivot> pivots = brick::makePivots(model.joints, bricks);
  const Poses start = brick::startPoses(model.tiles, bricks);
  trajectory::PenetrationMeter meter(bricks, pivots, 0.05, start, 0);
  std::mt19937_64 generator(7);
  std::normal_distribution<double> normal(0, 0.05);
  const auto vector = [&] {
    return Vector3(normal(generator), normal(generator), normal(generator));
  };
  Poses poses = start;
  trajectory::PenetrationDepths largest;
  for (int state = 0; state < 60; ++state) {
    for (Pose& pose : poses) {
      pose.position += vector();
      pose.rotation = (rotationFromVector(vector()) * pose.rotation).normalized();
    }
    const trajectory::PenetrationDepths expected = depthsOf(bricks, pivots, 0.05, start, poses);
    const trajectory::PenetrationDepths found = meter.at(poses);
    EXPECT_EQ(found.whole, expected.whole) << state;
    EXPECT_EQ(found.outsidePivots, expected.outsidePivots) << state;
    EXPECT_EQ(found.grown, expected.grown) << state;
    const trajectory::PenetrationDepths record = meter.atLeast(largest, poses);
    EXPECT_EQ(record.whole, std::max(largest.whole, expected.whole));
    EXPECT_EQ(record.outsidePivots, std::max(largest.outsidePivots, expected.outsidePivots));
    EXPECT_EQ(record.grown, std::max(largest.grown, expected.grown));
    largest = record;
  }
}

/// States of one motion between two states. Bricks are off their chords by `bulge`, metres and
/// radians.
std::vector<Poses> motionOf(const Poses& from, const Poses& to, const std::vector<Vector3>& bulge) {
  std::vector<Poses> states;
  for (int k = 0; k <= 10; ++k) {
    const double share = k / 10.0, part = 4 * share * (1 - share);
    Poses& poses = states.emplace_back(interpolate(from, to, share));
    for (std::size_t i = 0; i < poses.size(); ++i) {
      poses[i].position += part * bulge[i];
      poses[i].rotation = (rotationFromVector(part * bulge[i]) * poses[i].rotation).normalized();
    }
  }
  return states;
}

// Second method: the states one by one. Motions are long and short, straight and curved, in the
// plane (where bricks are in one layer) and in space, from flush and from open sheets.
TEST(PenetrationMeter, MeasuresAMotionLikeItsStates) {
  const model::Model model = generate::makeTessellation({.columns = 4, .rows = 3});
  const std::vector<brick::Brick> bricks = brick::makeBricks(model.tiles, {.thickness = 0.2});
  const std::vector<brick::Pivot> pivots = brick::makePivots(model.joints, bricks);
  const Poses start = brick::startPoses(model.tiles, bricks);
  constexpr double kAny = std::numeric_limits<double>::infinity();
  std::mt19937_64 generator(11);
  std::normal_distribution<double> normal(0, 1);
  for (const bool isPlanar : {true, false}) {
    const auto moved = [&](Poses poses, double length) {
      for (Pose& pose : poses) {
        const Vector3 turn(isPlanar ? 0 : normal(generator), isPlanar ? 0 : normal(generator),
                           normal(generator));
        pose.position += length * Vector3(normal(generator), normal(generator),
                                          isPlanar ? 0 : normal(generator));
        pose.rotation = (rotationFromVector(length * turn) * pose.rotation).normalized();
      }
      return poses;
    };
    for (const double open : {0.0, 0.3, 3.0}) {
      Poses from = start;
      for (Pose& pose : from) pose.position *= 1 + open;
      for (const double length : {1e-6, 1e-3, 0.03, 0.3}) {
        for (const double curved : {0.0, 0.01, 1.0}) {
          trajectory::PenetrationMeter single(bricks, pivots, 0.05, start, 0);
          trajectory::PenetrationMeter together(bricks, pivots, 0.05, start, 0);
          std::vector<Vector3> bulge;
          for (const Pose& pose : moved(Poses(bricks.size()), curved * length)) {
            bulge.push_back(isPlanar ? Vector3(0, 0, pose.position.x()) : pose.position);
          }
          const std::vector<Poses> states = motionOf(from, moved(from, length), bulge);
          std::vector<const Poses*> measured;
          for (const Poses& state : states) measured.push_back(&state);
          for (const trajectory::PenetrationDepths known :
               {trajectory::PenetrationDepths{}, {kAny, kAny, 0}, {1e-3, 1e-3, kAny}}) {
            trajectory::PenetrationDepths depths = known;
            const auto found = together.atLeastEach(known, measured);
            ASSERT_EQ(found.size(), states.size());
            for (std::size_t k = 0; k < states.size(); ++k) {
              depths = single.atLeast(depths, states[k]);
              EXPECT_EQ(found[k].whole, depths.whole) << open << length << curved << k;
              EXPECT_EQ(found[k].outsidePivots, depths.outsidePivots) << open << length << curved;
              EXPECT_EQ(found[k].grown, depths.grown) << open << length << curved << k;
            }
          }
        }
      }
    }
  }
}

// A rod swings past the edge of a plate: it overlaps in the middle of the motion only.
TEST(PenetrationMeter, SeesAnOverlapBetweenTheEndsOfAMotion) {
  const std::vector<brick::Brick> bricks = {box(1, 1, 0.1), box(2, 0.1, 0.1)};
  const Poses start = {{{0, 0, 0}, Quaternion::Identity()}, {{0, 9, 0}, Quaternion::Identity()}};
  trajectory::PenetrationMeter meter(bricks, {}, 0.05, start, 0);
  std::vector<Poses> states;
  for (int k = -5; k <= 5; ++k) {
    Poses& poses = states.emplace_back(start);
    poses[1].rotation = Quaternion(Eigen::AngleAxisd(0.02 * k, Vector3::UnitZ()));
    // The end of the rod moves on a circle that reaches 1e-6 into the plate.
    poses[1].position = Vector3(0.5 - 1e-6, 0, 0) + poses[1].rotation * Vector3(1, 0, 0);
    poses[1].position.x() += 0.06 * std::abs(std::sin(0.02 * k));
  }
  std::vector<const Poses*> measured;
  for (const Poses& state : states) measured.push_back(&state);
  const auto found = meter.atLeastEach({}, measured);
  EXPECT_EQ(found[4].grown, 0);
  EXPECT_NEAR(found[5].grown, 1e-6, 1e-12);
  EXPECT_EQ(found.back().grown, found[5].grown);
}

TEST(PenetrationMeter, ChecksFewPairsOfAHeapAndReportsIt) {
  const Poses few(1'000), many(1'500);  // 0.5 and 1.1 million pairs
  const std::vector<brick::Brick> bricks(many.size(), box(1, 1, 0.1));
  trajectory::PenetrationMeter heap(bricks, {}, 0.05, many, 1e-9);
  EXPECT_FALSE(heap.seesAllPairs());
  EXPECT_NEAR(heap.at(many).whole, 1, 1e-12);
  EXPECT_NEAR(heap.at(many).grown, 0, 1e-12);
  // In another order other pairs are checked. Their earlier overlap is not new.
  Poses moved = many;
  for (std::size_t i = 0; i < moved.size(); ++i) moved[i].position.x() = -1e-9 * double(i);
  EXPECT_NEAR(heap.at(moved).grown, 0, 1e-8);
  const std::vector<brick::Brick> fewer(few.size(), bricks.front());
  EXPECT_TRUE(trajectory::PenetrationMeter(fewer, {}, 0.05, few, 1e-9).seesAllPairs());
}

}  // namespace
}  // namespace kirireel
