// The shipped scenes: timelines, pins, drags, obstacles.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "sim/trajectory/measures.h"
#include "sim/trajectory/trajectory_file.h"
#include "tests/cli/run_program.h"
#include "tests/support/trajectories.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;

/// A finished `kirireel simulate`.
struct Simulated {
  ProgramEnd end;
  nlohmann::json summary;
  trajectory::Trajectory run;
};

class Scenes : public testing::Test {
 protected:
  Simulated simulate(const std::filesystem::path& model, const std::vector<std::string>& options) {
    std::vector<std::string> arguments = {"simulate", model.string(), "--out",
                                          (scratch_ / "out").string()};
    arguments.insert(arguments.end(), options.begin(), options.end());
    Simulated done{runKirireel(arguments), {}, {}};
    EXPECT_THAT(done.end.exitCode, testing::AnyOf(0, kEndedShort)) << done.end.err;
    done.summary = nlohmann::json::parse(readText(scratch_ / "out/summary.json"));
    done.run = test::readTrajectory(scratch_ / "out/trajectory.h5");
    return done;
  }

  Simulated simulateScene(const std::string& model, const std::string& scene,
                          std::vector<std::string> options = {}) {
    const std::filesystem::path file =
        std::filesystem::path(KIRIREEL_SOURCE_DIR) / "data/scenes" / scene;
    options.insert(options.end(), {"--scene", file.string()});
    return simulate(shippedModel(model), options);
  }

  /// Runs the model half-way, then from the start through that state to the target, and compares
  /// the end with that of the direct path.
  double waypointDetour(const std::filesystem::path& model) {
    writeText(scratch_ / "half.toml", "[[timeline]]\nprogress = 0.5\nquit = true\n");
    simulate(model, {"--scene", (scratch_ / "half.toml").string()});
    std::filesystem::copy(scratch_ / "out/final_vertices.txt", scratch_ / "half.txt");
    const trajectory::Trajectory direct = simulate(model, {}).run;
    const Simulated chain =
        simulate(model, {"--duration", "60", "--target", (scratch_ / "half.txt").string(),
                         "--target", (model / "target.txt").string()});
    EXPECT_EQ(chain.summary["outcome"], "settled");
    return trajectory::targetError(brick::bottomTiles(direct.bricks, direct.samples.back().poses),
                                   chain.run.bricks, chain.run.samples.back().poses);
  }

  TemporaryFolder scratch_;
};

/// The tilt of the most tilted brick out of the start's plane, radians.
double largestTilt(const trajectory::Sample& sample) {
  double largest = 0;
  for (const Pose& pose : sample.poses) {
    largest = std::max(largest, 2 * std::hypot(pose.rotation.x(), pose.rotation.y()));
  }
  return largest;
}

TEST_F(Scenes, PauseAndPinReachesTheDisk) {
  const Simulated done = simulateScene("square_to_disk", "square_to_disk.toml");
  EXPECT_EQ(done.summary["outcome"], "settled");
  const auto& accuracy = done.summary["accuracy"];
  EXPECT_LT(accuracy["target_error_end"], 1e-3);                // measured 9.4e-10
  EXPECT_LT(accuracy["penetration_outside_pivots_max"], 5e-5);  // measured 1.5e-5
  std::vector<std::string> events;
  for (const trajectory::Event& event : done.run.events) events.push_back(event.text);
  ASSERT_EQ(events.size(), 6u);
  EXPECT_THAT(events[1], HasSubstr("pin tiles 0, 4, 20, 24"));
  EXPECT_THAT(events[4], HasSubstr("unpin"));
}

TEST_F(Scenes, ADragOpensTheFan) {
  const Simulated done = simulateScene("fan", "fan.toml");
  EXPECT_EQ(done.summary["outcome"], "settled");
  // The open fan is singular: its approach to rest becomes slower and slower. Measured 3.8e-5.
  EXPECT_LT(done.summary["accuracy"]["target_error_end"], 1e-4);
  // Only the drag moves the corner tile. The pinned one stays.
  const trajectory::Sample& dragged = done.run.samples[120];  // at its release
  const trajectory::Sample& start = done.run.samples.front();
  const Vector3 hand(2.5, -0.17, 0.01);
  EXPECT_LT((dragged.poses[35].position - hand).norm(),
            0.5 * (start.poses[35].position - hand).norm());  // measured 0.47
  EXPECT_EQ(dragged.poses[0].position, start.poses[0].position);
}

// Stiff springs oscillate hundreds of times per second. Videos have fewer frames.
TEST_F(Scenes, SamplesMayBeDenserThanFramesOfAVideo) {
  writeText(scratch_ / "wave.toml",
            "[model]\nhinge_stiffness = 1e5\nno_align = true\n[actuation]\nactuation = \"none\"\n"
            "[environment]\nlinear_damping = 0\nangular_damping = 0\ncontacts = \"none\"\n"
            "[solver]\nplanar = \"on\"\ntolerance = 1e-6\n[stop]\nduration = 0.05\n"
            "[[velocity]]\ntiles = [0]\nangular = [0, 0, 1]\n");
  const std::string model = scratch_ / "sheet";
  runKirireel(
      {"generate", "tessellation", "--columns", "2", "--rows", "2", "--start-angle", "30", model});
  const std::string scene = scratch_ / "wave.toml";
  const Simulated wave = simulate(model, {"--scene", scene, "--fps", "2000"});
  ASSERT_EQ(wave.run.samples.size(), 101u) << wave.end.err;
  EXPECT_NEAR(wave.run.samples[1].time, 5e-4, 1e-12);
  const ProgramEnd refused =
      runKirireel({"record", model, "--scene", scene, "--fps", "278", "--out", scratch_ / "video"});
  EXPECT_EQ(refused.exitCode, 2);
  EXPECT_THAT(refused.err, HasSubstr("error: --fps 278 is not possible; give 1 to 240, or remove "
                                     "the video (--no-video)"));
}

TEST_F(Scenes, ASheetThatLocksInItsPlaneDeploysThroughSpace) {
  const Simulated planar = simulateScene("nonrigid", "nonrigid.toml", {"--planar", "on"});
  EXPECT_EQ(planar.end.exitCode, kEndedShort);
  EXPECT_EQ(planar.summary["outcome"], "locked");
  EXPECT_THAT(planar.summary["reason"].get<std::string>(), HasSubstr("short of the target"));
  const Simulated space = simulateScene("nonrigid", "nonrigid.toml");
  EXPECT_EQ(space.end.exitCode, 0) << space.end.err;
  EXPECT_EQ(space.summary["outcome"], "settled");
  EXPECT_LT(space.summary["accuracy"]["target_error_end"], 1e-9);  // measured 2e-12
  EXPECT_LT(space.summary["accuracy"]["penetration_outside_pivots_max"], 2e-3);
  // Between steps. Measured 1.1e-4; 3.7e-4 with steps of 1/240 s, which ends with exit code 3.
  EXPECT_LT(space.summary["accuracy"]["penetration_grown_max"], 1.4e-4);
  double largest = 0;
  for (const trajectory::Sample& sample : space.run.samples)
    largest = std::max(largest, largestTilt(sample));
  EXPECT_GT(largest, 0.2);                                 // measured 0.31: 18 degrees
  EXPECT_LT(largestTilt(space.run.samples.back()), 1e-9);  // measured 7e-15
}

TEST_F(Scenes, ASheetDrapesOverABall) {
  const Simulated done = simulateScene("quad_tessellation", "drape.toml");
  EXPECT_EQ(done.summary["needs"]["obstacles"]["on"], true);
  EXPECT_EQ(done.summary["settings"]["environment"]["obstacles"][0]["shape"], "sphere");
  EXPECT_FALSE(done.run.obstacles.empty());
  const Vector3 centre(0.1, 0.05, -2.1);
  for (const Pose& pose : done.run.samples.back().poses) {
    EXPECT_GT((pose.position - centre).norm(), 2);
  }
}

TEST_F(Scenes, OverlapsOfASwingAreReportedOnce) {
  const Simulated done =
      simulate(shippedModel("tessellation_4x4"),
               {"--actuation", "none", "--gravity", "0,-1,0", "--pin", "0", "--duration", "2"});
  EXPECT_EQ(done.end.exitCode, kEndedShort);
  EXPECT_THAT(done.end.out.substr(0, done.end.out.find('\n')),
              testing::MatchesRegex("tessellation_4x4: still moving after 2 s, at [0-9.]+ m/s at "
                                    "most; bricks overlap by up to [0-9.]+ m .[0-9.]+ tiles.; exit "
                                    "code 3"));
}

TEST_F(Scenes, AWaypointChangesNothingAtTheEnd) {
  EXPECT_LT(waypointDetour(shippedModel("cylinder")), 1e-6);  // measured 1.3e-12
}

TEST_F(Scenes, AWaypointChangesNothingAtTheEndOfThePublishedCylinder) {
  const auto folder =
      std::filesystem::path(KIRIREEL_SOURCE_DIR).parent_path() / "shared/models/cylinder";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  EXPECT_LT(waypointDetour(folder), 1e-6);  // measured 5.5e-12
}

}  // namespace
}  // namespace kirireel
