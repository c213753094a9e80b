#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "sim/generate/lattice.h"
#include "sim/run/mechanism_path.h"
#include "sim/run/state_interpolator.h"
#include "sim/trajectory/measures.h"

namespace kirireel {
namespace {

/// Rotating squares, and their exact states by opening angle.
class ExactSheet {
 public:
  explicit ExactSheet(bool inPlane = true)
      : tilt_(inPlane ? Quaternion::Identity() : rotationFromVector({0.3, -0.4, 0.1})) {
    subject_.model = generate::makeTessellation(shape_);
    subject_.model.tiles = tilesAt(0);
    subject_.model.target = tilesAt(shape_.targetAngle);
    subject_.bricks = brick::makeBricks(subject_.model.tiles, subject_.brickRule);
  }

  const trajectory::Subject& subject() const { return subject_; }

  trajectory::Sample sample(double angle) const {
    trajectory::Sample sample;
    sample.time = angle;
    sample.poses = brick::startPoses(subject_.model.tiles, subject_.bricks);
    for (std::size_t i = 0; i < sample.poses.size(); ++i) {
      const bool isEven = (i / 4 + i % 4) % 2 == 0;
      const Vector3 turn(0, 0, isEven ? -angle / 2 : angle / 2);
      sample.poses[i].rotation = tilt_ * rotationFromVector(turn) * tilt_.conjugate();
    }
    const std::vector<brick::Brick> there = brick::makeBricks(tilesAt(angle), subject_.brickRule);
    const Poses moved = brick::startPoses(tilesAt(angle), there);
    for (std::size_t i = 0; i < moved.size(); ++i) sample.poses[i].position = moved[i].position;
    return sample;
  }

  double gap(const Poses& poses) const {
    return trajectory::jointGap(brick::makePivots(subject_.model.joints, subject_.bricks), poses)
        .max;
  }

 private:
  std::vector<model::Tile> tilesAt(double angle) const {
    std::vector<model::Tile> tiles = generate::tessellationTiles(shape_, angle);
    for (model::Tile& tile : tiles) {
      for (Vector3& vertex : tile.vertices) vertex = tilt_ * vertex;
    }
    return tiles;
  }

  generate::TessellationShape shape_;
  Quaternion tilt_;
  trajectory::Subject subject_;
};

/// The largest difference between two states in the distance of any two bricks, metres.
double shapeDifference(const Poses& a, const Poses& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const double apart = (a[i].position - a[k].position).norm();
      largest = std::max(largest, std::abs(apart - (b[i].position - b[k].position).norm()));
    }
  }
  return largest;
}

// Oracle: the mechanism's exact motion, which contains every closed state.
TEST(StateInterpolator, ClosesTheJointsOfStatesBetween) {
  for (const bool inPlane : {true, false}) {
    const ExactSheet sheet(inPlane);
    const trajectory::Sample from = sheet.sample(0.4), to = sheet.sample(0.8);
    ASSERT_LT(sheet.gap(from.poses), 1e-14);
    EXPECT_GT(sheet.gap(interpolate(from.poses, to.poses, 0.5)), 0.005);  // measured 0.0062
    run::StateInterpolator interpolator(sheet.subject());
    const trajectory::Sample middle = interpolator.between(from, to, 0.5);
    EXPECT_LT(sheet.gap(middle.poses), 1e-12);  // measured 1e-15
    EXPECT_EQ(middle.jointGap, sheet.gap(middle.poses));
    EXPECT_DOUBLE_EQ(middle.time, 0.6);
    const double angle = turnBetween(middle.poses[0].rotation, middle.poses[1].rotation).norm();
    EXPECT_NEAR(angle, 0.6, 0.02);  // measured 0.587
    // The exact state of that angle, after the best motion of the whole sheet.
    EXPECT_LT(shapeDifference(middle.poses, sheet.sample(angle).poses), 1e-11);  // measured 1e-14
  }
}

TEST(StateInterpolator, GivesTheSamplesThemselvesAtBothEnds) {
  const ExactSheet sheet;
  const trajectory::Sample from = sheet.sample(0.4), to = sheet.sample(0.8);
  run::StateInterpolator interpolator(sheet.subject());
  EXPECT_EQ(run::pathDistance(sheet.subject().bricks, interpolator.between(from, to, 0).poses,
                              from.poses),
            0);
  EXPECT_EQ(
      run::pathDistance(sheet.subject().bricks, interpolator.between(from, to, 1).poses, to.poses),
      0);
}

TEST(StateInterpolator, LeavesOpenJointsAsOpenAsTheSamplesAre) {
  const ExactSheet sheet;
  trajectory::Sample from = sheet.sample(0.4), to = sheet.sample(0.4);
  for (trajectory::Sample* sample : {&from, &to}) sample->poses[0].position.x() += 1e-3;
  run::StateInterpolator interpolator(sheet.subject());
  EXPECT_NEAR(interpolator.between(from, to, 0.5).jointGap, 1e-3, 1e-12);
}

TEST(StateInterpolator, KeepsThePositionsOfPinnedTiles) {
  const ExactSheet sheet;
  trajectory::Sample from = sheet.sample(0.4), to = sheet.sample(0.8);
  const Pose held = from.poses[5];
  for (trajectory::Sample* sample : {&from, &to}) {
    const Quaternion turn = held.rotation * sample->poses[5].rotation.conjugate();
    const Vector3 pivot = sample->poses[5].position;
    for (Pose& pose : sample->poses) {
      pose.position = held.position + turn * (pose.position - pivot);
      pose.rotation = turn * pose.rotation;
    }
    sample->pinned = {5};
  }
  run::StateInterpolator interpolator(sheet.subject());
  const trajectory::Sample middle = interpolator.between(from, to, 0.3);
  EXPECT_LT(sheet.gap(middle.poses), 1e-12);
  EXPECT_LT((middle.poses[5].position - held.position).norm(), 1e-15);
  EXPECT_LT(middle.poses[5].rotation.angularDistance(held.rotation), 1e-7);
}

// The cubic through four closed states: its joint gaps are of the fourth order in the turn.
TEST(StateInterpolator, MomentsBetweenAreNearlyClosed) {
  const ExactSheet sheet;
  run::StateInterpolator interpolator(sheet.subject());
  for (const double turn : {0.01, 0.04}) {
    const trajectory::Sample from = sheet.sample(0.4), to = sheet.sample(0.4 + 2 * turn);
    const std::vector<Poses> moments = interpolator.momentsBetween(from.poses, to.poses);
    ASSERT_EQ(moments.size(), 10u);
    // Measured 0.0204 turn^4.
    for (const Poses& poses : moments) EXPECT_LT(sheet.gap(poses), 0.025 * std::pow(turn, 4));
    const Poses middle = interpolator.between(from, to, 5.0 / 11).poses;
    EXPECT_LT(shapeDifference(moments[4], middle), 0.02 * std::pow(turn, 4));
  }
  EXPECT_TRUE(
      interpolator.momentsBetween(sheet.sample(0.4).poses, sheet.sample(0.6).poses).empty());
}

// Between two branches of the mechanism there is no closed state near the linear interpolation.
TEST(StateInterpolator, TakesTheNearerSampleIfNoClosedStateIsBetween) {
  const ExactSheet sheet;
  const trajectory::Sample from = sheet.sample(1.2), to = sheet.sample(-1.2);
  run::StateInterpolator interpolator(sheet.subject());
  for (const double share : {0.2, 0.5, 0.8}) {
    EXPECT_LT(sheet.gap(interpolator.between(from, to, share).poses), 1e-9);
  }
}

}  // namespace
}  // namespace kirireel
