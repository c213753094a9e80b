#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/record/pace.h"
#include "sim/generate/lattice.h"
#include "tests/support/files.h"
#include "tests/support/trajectories.h"

namespace kirireel {
namespace {

/// One brick that moves along x at 1 m/s and rotates about z at 1 rad/s, sampled every 0.1 s to 1
/// s.
class ReplayTest : public testing::Test {
 protected:
  ReplayTest() {
    scene::Scene scene;
    scene.model = generate::makeTessellation({.columns = 1, .rows = 1});
    trajectory::Trajectory trajectory{trajectory::subjectOf(scene)};
    for (int k = 0; k <= 10; ++k) {
      trajectory::Sample sample;
      sample.time = 0.1 * k;
      sample.poses = {{Vector3(0.1 * k, 0, 0), rotationFromVector({0, 0, 0.1 * k})}};
      trajectory.samples.push_back(sample);
    }
    test::writeTrajectory(trajectory, folder_ / "run.h5");
  }

  std::vector<double> timesOfReplay(double step, int observed = 1000) {
    const trajectory::TrajectoryReader run(folder_ / "run.h5");
    record::PictureSettings settings;
    settings.pace = record::Pace::Real;
    settings.framesPerSecond = 1;
    settings.speed = step;
    const std::vector<record::FilmedRun> runs = {
        {run, record::videoMoments(record::motionOf(run), settings)}};
    std::vector<double> times;
    const record::ProgressObserver observer = [&](const record::Progress&) {
      return --observed > 0 ? record::Interruption() : "the test";
    };
    record::replay(runs, observer, report_)([&](const record::SharedStates& states) {
      times.push_back(states->front().sample.time);
      return true;
    });
    return times;
  }

  test::TemporaryFolder folder_;
  record::PictureReport report_;
};

TEST_F(ReplayTest, StatesBetweenSamplesAreInterpolated) {
  const trajectory::TrajectoryReader run(folder_ / "run.h5");
  record::Replay states(run);
  for (const double time : {0.0, 0.3, 0.333, 0.95, 0.12, 0.31, 1.0}) {
    const trajectory::Sample sample = states.at(time);
    EXPECT_NEAR(sample.time, time, 1e-12);
    EXPECT_NEAR(sample.poses[0].position.x(), time, 1e-12);  // measured: 1.1e-16
    const Quaternion expected = rotationFromVector({0, 0, time});
    EXPECT_NEAR(sample.poses[0].rotation.angularDistance(expected), 0, 1e-7);  // measured: 2e-8
  }
}

TEST_F(ReplayTest, EndsWithTheLastSampleForAnyStep) {
  EXPECT_THAT(timesOfReplay(0.4), testing::Pointwise(testing::DoubleEq(), {0.0, 0.4, 0.8, 1.0}));
  EXPECT_EQ(timesOfReplay(0.1).size(), 11U);
  EXPECT_EQ(timesOfReplay(5).size(), 2U);
  EXPECT_FALSE(report_.stoppedAt);
}

TEST_F(ReplayTest, AShorterRunStaysAtItsEnd) {
  const trajectory::TrajectoryReader run(folder_ / "run.h5");
  const std::vector<record::FilmedRun> runs = {{run, {{0}, {0.5}, {1}}}, {run, {{0}, {0.2}}}};
  const record::ProgressObserver proceed = [](const record::Progress&) {
    return record::Interruption();
  };
  std::vector<std::pair<double, double>> times;
  record::replay(runs, proceed, report_)([&](const record::SharedStates& states) {
    times.emplace_back(states->at(0).sample.time, states->at(1).sample.time);
    return true;
  });
  EXPECT_THAT(times, testing::ElementsAre(testing::Pair(0, 0), testing::Pair(0.5, 0.2),
                                          testing::Pair(1, 0.2)));
}

TEST_F(ReplayTest, StopsWhenTheObserverRequestsIt) {
  EXPECT_EQ(timesOfReplay(0.1, 3).size(), 3U);
  EXPECT_NEAR(*report_.stoppedAt, 0.2, 1e-12);
  EXPECT_EQ(report_.stoppedBy, "the test");
}

}  // namespace
}  // namespace kirireel
