#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/generate/families.h"
#include "sim/trajectory/trajectory_file.h"

namespace kirireel {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;

constexpr double kSpeed = 0.5;  // m/s
constexpr double kTurn = 2;     // rad/s

/// Two bricks: one is at rest, the other moves along x and rotates about z, both evenly.
trajectory::Sample evenMotion(double time) {
  trajectory::Sample sample;
  sample.time = time;
  sample.poses = {Pose(), {{kSpeed * time, 1, 2}, rotationFromVector({0, 0, kTurn * time})}};
  sample.jointGap = 0.1 * time;
  sample.pinned = {0};
  sample.steps = {{time, 1, 2, 3, 4, 5, 6, 7}};
  return sample;
}

trajectory::SampleTable evenTable(int count) {
  trajectory::SampleTable table;
  for (int k = 0; k < count; ++k) table.append(evenMotion(0.25 * k));
  return table;
}

TEST(SampleTable, KeepsSamplesAsTheyWere) {
  const trajectory::SampleTable table = evenTable(4);
  ASSERT_EQ(table.size(), 4U);
  const trajectory::Sample expected = evenMotion(0.5);
  const trajectory::Sample found = table.sample(2);
  EXPECT_EQ(found.time, expected.time);
  EXPECT_EQ(found.poses[1].position, expected.poses[1].position);
  EXPECT_EQ(found.poses[1].rotation.coeffs(), expected.poses[1].rotation.coeffs());
  EXPECT_EQ(found.jointGap, expected.jointGap);
  EXPECT_EQ(found.pinned, expected.pinned);
  ASSERT_EQ(found.steps.size(), 1U);
  EXPECT_EQ(found.steps[0].took.factorizations, 7);
}

TEST(SampleTable, HasOneArrayForEachQuantity) {
  const trajectory::SampleTable table = evenTable(2);
  EXPECT_THAT(table.times(), ElementsAre(0, 0.25));
  EXPECT_EQ(table.positions().size(), 2U * 2 * 3);
  EXPECT_EQ(table.positions()[9], kSpeed * 0.25);  // of sample 1, brick 1
  EXPECT_EQ(table.rotations()[0], 1);              // w first
  EXPECT_THAT(table.jointGaps(), ElementsAre(0, 0.025));
}

TEST(SampleTable, VelocitiesOfEvenMotionAreExact) {
  const std::vector<double> velocities = evenTable(5).velocities();
  ASSERT_EQ(velocities.size(), 5U * 2 * 6);
  for (int sample = 0; sample < 5; ++sample) {
    const double* resting = &velocities[static_cast<std::size_t>(sample) * 12];
    const double* moving = resting + 6;
    for (int k = 0; k < 6; ++k) EXPECT_EQ(resting[k], 0);
    EXPECT_NEAR(moving[0], kSpeed, 1e-14);
    EXPECT_NEAR(moving[5], kTurn, 1e-14);  // 4e-16 measured
  }
}

TEST(SampleTable, OneSampleDoesNotMove) {
  EXPECT_THAT(evenTable(1).velocities(), Each(0));
}

TEST(TrajectoryInMemory, ReadsAsOneFromAFile) {
  trajectory::Subject subject;
  subject.model =
      generate::generateModel(generate::familyNamed("tessellation"), {{"columns", 2}, {"rows", 1}});
  trajectory::TrajectoryEnd end;
  end.events = {{0.5, "something"}};
  const auto samples = std::make_shared<trajectory::SampleTable>(evenTable(3));
  const trajectory::TrajectoryReader run(subject, end, samples);
  EXPECT_EQ(run.subject().model.name, "tessellation");
  EXPECT_THAT(run.times(), ElementsAre(0, 0.25, 0.5));
  EXPECT_EQ(run.steps().size(), 3U);
  EXPECT_EQ(run.end().events, end.events);
  EXPECT_EQ(run.sample(1).poses[1].position, evenMotion(0.25).poses[1].position);
}

}  // namespace
}  // namespace kirireel
