#include "render/record/pace.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "render/record/run_pictures.h"
#include "sim/deploy/deployment.h"
#include "sim/generate/lattice.h"
#include "sim/run/mechanism_path.h"
#include "sim/trajectory/measures.h"
#include "tests/support/files.h"
#include "tests/support/trajectories.h"

namespace kirireel {
namespace {

/// A run that has moved by `length` of each time.
template <typename Length>
record::MotionCurve curve(int samples, double end, const Length& length) {
  std::vector<double> times, lengths;
  for (int k = 0; k < samples; ++k) {
    times.push_back(end * k / (samples - 1));
    lengths.push_back(length(times.back()));
  }
  return {times, lengths};
}

/// Moves as 1 - exp(-20 t) for 2 s: nearly all of it in the first tenth.
record::MotionCurve snapping() {
  return curve(1001, 2, [](double time) { return 1 - std::exp(-20 * time); });
}

TEST(EasedProgress, IsATrapezoidOfSpeed) {
  EXPECT_EQ(record::easedProgress(0, 0.2), 0);
  EXPECT_EQ(record::easedProgress(1, 0.2), 1);
  EXPECT_DOUBLE_EQ(record::easedProgress(0.5, 0.2), 0.5);
  // Speed 1 / 0.8 between the ramps, half of that on average within them.
  EXPECT_DOUBLE_EQ(record::easedProgress(0.2, 0.2), 0.5 * 0.2 / 0.8);
  EXPECT_DOUBLE_EQ(record::easedProgress(0.1, 0.2), 0.125 * 0.2 / 0.8);
  EXPECT_DOUBLE_EQ(record::easedProgress(0.6, 0.2) - record::easedProgress(0.4, 0.2), 0.2 / 0.8);
  for (double share = 0; share < 0.999; share += 0.01) {
    EXPECT_GT(record::easedProgress(share + 0.01, 0.5), record::easedProgress(share, 0.5));
  }
}

TEST(MotionCurve, LeadsFromTimesToSharesAndBack) {
  const record::MotionCurve motion = curve(11, 2, [](double time) { return time * time; });
  EXPECT_DOUBLE_EQ(motion.shareAt(1.2), 0.36);
  EXPECT_DOUBLE_EQ(motion.timeAt(0.36), 1.2);
  EXPECT_EQ(motion.shareAt(-1), 0);
  EXPECT_EQ(motion.timeAt(1), 2);
}

TEST(VideoMoments, FillTheLengthWithEvenMotion) {
  record::PictureSettings settings;
  const record::MotionCurve motion = snapping();
  const std::vector<record::FrameMoment> moments = record::videoMoments(motion, settings);
  EXPECT_EQ(static_cast<int>(moments.size()) + 2 * record::heldFrames(settings), 8 * 60);
  EXPECT_EQ(moments.front().time, 0);
  EXPECT_EQ(moments.back().time, 2);
  const auto ramp = static_cast<std::size_t>(0.6 * 60);
  const double step = 1 / ((7 - 0.6) * (moments.size() - 1) / 7);
  for (std::size_t k = ramp + 1; k + ramp < moments.size(); ++k) {
    const double moved = motion.shareAt(moments[k].time) - motion.shareAt(moments[k - 1].time);
    EXPECT_NEAR(moved, step, 1e-9) << k;
    EXPECT_NEAR(moments[k].progress, motion.shareAt(moments[k].time), 1e-12);
  }
}

TEST(VideoMoments, GiveARunThatRestsNoTime) {
  // Moves for 1 s and rests for 99.
  const record::MotionCurve motion =
      curve(1001, 100, [](double time) { return std::min(time, 1.0); });
  const std::vector<record::FrameMoment> moments = record::videoMoments(motion, {});
  EXPECT_LE(moments[moments.size() - 2].time, 1);
}

TEST(VideoMoments, OfARunWithoutMotionAreOne) {
  const record::MotionCurve motion = curve(5, 1, [](double) { return 0.0; });
  EXPECT_EQ(record::videoMoments(motion, {}).size(), 1U);
  record::PictureSettings settings;
  settings.pace = record::Pace::Real;
  EXPECT_EQ(record::videoMoments(motion, settings).size(), 61U);
}

TEST(VideoMoments, AtRealPaceAreEquallyFarApartInTime) {
  record::PictureSettings settings;
  settings.pace = record::Pace::Real;
  settings.framesPerSecond = 10;
  settings.speed = 0.5;
  const std::vector<record::FrameMoment> moments = record::videoMoments(snapping(), settings);
  ASSERT_EQ(moments.size(), 41U);
  for (std::size_t k = 0; k < moments.size(); ++k) {
    EXPECT_NEAR(moments[k].time, 0.05 * static_cast<double>(k), 1e-12);
    EXPECT_NEAR(moments[k].turn, static_cast<double>(k) / 40, 1e-12);
  }
  settings.speed = 4;  // the last step is shorter
  EXPECT_EQ(record::videoMoments(snapping(), settings).back().time, 2);
  EXPECT_EQ(record::videoMoments(snapping(), settings).size(), 6U);
}

TEST(SnapshotMoments, ShareTheMotionOrTheTime) {
  const record::MotionCurve motion = curve(101, 10, [](double time) { return time * time; });
  record::PictureSettings settings;
  const std::vector<record::FrameMoment> moments = record::snapshotMoments(motion, settings, 5);
  ASSERT_EQ(moments.size(), 5U);
  for (int k = 0; k < 5; ++k) {
    EXPECT_NEAR(moments[k].progress, 0.25 * k, 1e-12);
    EXPECT_NEAR(moments[k].time, 10 * std::sqrt(0.25 * k), 0.002);  // curve of 101 points
  }
  settings.spacing = record::SnapshotSpacing::Time;
  EXPECT_DOUBLE_EQ(record::snapshotMoments(motion, settings, 5)[1].time, 2.5);
  EXPECT_EQ(record::snapshotMoments(motion, settings, 1).front().time, 10);
}

/// A deployment by dynamics, which opens fast and then creeps, in trajectory.h5.
class DynamicRun : public testing::Test {
 protected:
  DynamicRun() {
    scene::Scene scene;
    scene.model = generate::makeTessellation({});
    scene.path.kind = scene::PathKind::Straight;
    const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, {});
    test::writeTrajectory(result.trajectory, folder_ / "run.h5");
  }

  test::TemporaryFolder folder_;
};

// The required figures, measured on the painted poses.
TEST_F(DynamicRun, IsShownAtAnEvenPaceWithClosedJoints) {
  const trajectory::TrajectoryReader run(folder_ / "run.h5");
  const std::vector<record::FrameMoment> moments = record::videoMoments(record::motionOf(run), {});
  const std::vector<brick::Pivot> pivots =
      brick::makePivots(run.subject().model.joints, run.subject().bricks);
  record::Replay states(run);
  std::vector<double> moved;
  double gap = 0;
  Poses before;
  for (const record::FrameMoment& moment : moments) {
    Poses poses = states.at(moment.time).poses;
    gap = std::max(gap, trajectory::jointGap(pivots, poses).max);
    if (!before.empty()) moved.push_back(run::pathDistance(run.subject().bricks, before, poses));
    before = std::move(poses);
  }
  EXPECT_LT(gap, 1e-9);  // measured 4e-12, tiles of 1 m
  const std::size_t ramp = 36, between = moved.size() - 2 * ramp;
  double sum = 0;
  for (std::size_t k = 0; k < between; ++k) sum += moved[ramp + k];
  for (std::size_t tenth = 0; tenth < 10; ++tenth) {
    double part = 0;
    for (std::size_t k = tenth * between / 10; k < (tenth + 1) * between / 10; ++k) {
      part += moved[ramp + k];
    }
    EXPECT_NEAR(part / sum, 0.1, 0.005) << tenth;  // measured 0.0984 to 0.1011
  }
}

}  // namespace
}  // namespace kirireel
