// Scenes that do not fit their model, with the real program: one line, exit code 2, no files. Runs
// that lock or diverge: a report in the summary, exit code 3 or 1.
#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/cli/run_program.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;

class BadScene : public testing::Test {
 protected:
  /// Simulates the shipped 4 x 4 sheet, with the scene file if it is not empty.
  ProgramEnd simulate(const std::string& scene, const std::vector<std::string>& options = {}) {
    std::vector<std::string> arguments = {"simulate", shippedModel("tessellation_4x4").string(),
                                          "--out", (scratch_ / "out").string()};
    if (!scene.empty()) {
      writeText(scratch_ / "run.toml", scene);
      arguments.insert(arguments.end(), {"--scene", (scratch_ / "run.toml").string()});
    }
    arguments.insert(arguments.end(), options.begin(), options.end());
    return runKirireel(arguments);
  }

  void expectRefused(const ProgramEnd& end, const std::string& part) {
    EXPECT_EQ(end.exitCode, 2) << end.err;
    EXPECT_EQ(std::count(end.err.begin(), end.err.end(), '\n'), 1) << end.err;
    EXPECT_THAT(end.err, HasSubstr(part));
    EXPECT_FALSE(std::filesystem::exists(scratch_ / "out"));
  }

  nlohmann::json summary() const {
    return nlohmann::json::parse(readText(scratch_ / "out/summary.json"));
  }

  TemporaryFolder scratch_;
};

TEST_F(BadScene, TilesThatDoNotExist) {
  expectRefused(simulate("", {"--pin", "16"}),
                "--pin: error: the model has tiles 0-15, not 16. Correct this number");
  expectRefused(simulate("", {"--fix", "1,99"}),
                "--fix: error: the model has tiles 0-15, not 99. Correct this number");
  expectRefused(simulate("", {"--link", "0,9,1,0"}),
                "--link: error: tile 0 has vertices 0-3, not 9. Correct this number");
  expectRefused(simulate("[[timeline]]\npin = [16]\n"),
                "run.toml:1:1: error: the model has tiles 0-15, not 16. Correct this number");
  expectRefused(simulate("[[timeline]]\ndrag = {tile = 0, vertex = 4, path = [[0, 0, 1]]}\n"),
                "run.toml:1:1: error: tile 0 has vertices 0-3, not 4. Correct this number");
}

TEST_F(BadScene, TargetsOfAnotherShape) {
  expectRefused(simulate("", {"--target", shippedModel("fan").string()}),
                "fan: error: the target has 36 tiles, the model 16, with different numbers of "
                "vertices. Give the same tiles in the same order");
  expectRefused(simulate("", {"--target", "nowhere.txt"}), "nowhere.txt: error: there is no such");
}

TEST_F(BadScene, PathsThroughNaN) {
  expectRefused(simulate("[[timeline]]\ndrag = {tile = 0, path = [[0, 0, 1], [nan, 0, 0]]}\n"),
                "run.toml:2:39: error: nan is not allowed; give a number, at most 1e+09 in "
                "size");
  expectRefused(simulate("[[timeline]]\nat = nan\nquit = true\n"), "run.toml:2:6: error: ");
}

TEST_F(BadScene, UnknownKeysSuggestTheNearest) {
  expectRefused(simulate("[enviroment]\nground = true\n"),
                "unknown table enviroment, did you mean environment?; there are ");
  expectRefused(simulate("[[timeline]]\nunpinn = \"all\"\n"), ", did you mean unpin?; there are ");
  expectRefused(simulate("[[obstacle]]\nshape = \"box\"\nsize = [1, 1, 1]\nposition = [0, 0, -2]\n"
                         "fricton = 1\n"),
                "run.toml:5:1: error: unknown key of an obstacle fricton, did you mean friction?");
  expectRefused(simulate("", {"--spring_stifness", "3"}), ", did you mean --spring-stiffness?");
}

TEST_F(BadScene, ALockedRunReportsIt) {
  // All tiles are pinned.
  const ProgramEnd end = simulate("", {"--pin", "0,1,2,3,4,5,6,7,8,9,10,11,12,13,14,15"});
  EXPECT_EQ(end.exitCode, kEndedShort) << end.out;
  EXPECT_EQ(summary()["outcome"], "locked");
  EXPECT_EQ(summary()["at_target"], false);
  EXPECT_THAT(summary()["reason"].get<std::string>(), HasSubstr("short of the target"));
}

// One tile is pinned, another falls beyond the limit.
TEST_F(BadScene, ADivergedRunReportsSoAndFails) {
  writeText(scratch_ / "loose/vertices.txt", "0 0 0 1 0 0 1 1 0 0 1 0\n2 0 0 3 0 0 3 1 0 2 1 0\n");
  writeText(scratch_ / "loose/constraints.txt", "# no joints\n");
  const ProgramEnd end =
      runKirireel({"simulate", (scratch_ / "loose").string(), "--out", (scratch_ / "out").string(),
                   "--gravity", "-1e6", "--pin", "0", "--actuation", "none"});
  EXPECT_EQ(end.exitCode, 1) << end.out;
  EXPECT_EQ(summary()["outcome"], "diverged");
  EXPECT_THAT(summary()["reason"].get<std::string>(),
              HasSubstr("a brick without joints left all bounds at "));
}

// A sheet may fall any distance: g t^2 / 2, with the steps of the default tolerance.
TEST_F(BadScene, AFallingSheetDoesNotDiverge) {
  simulate("", {"--gravity", "-1e6", "--actuation", "none", "--duration", "0.2"});
  EXPECT_EQ(summary()["outcome"], "out_of_time");
}

TEST_F(BadScene, ARunWhoseTimeIsUpReportsWhetherItIsAtItsTarget) {
  EXPECT_EQ(simulate("", {"--duration", "0.05", "--path", "dynamic"}).exitCode, kEndedShort);
  EXPECT_EQ(summary()["outcome"], "out_of_time");
  EXPECT_EQ(summary()["at_target"], false);
  // After 0.7 s it is 1.6e-7 m from its target, and comes to rest after 0.9 s.
  EXPECT_EQ(simulate("", {"--duration", "0.7", "--path", "dynamic"}).exitCode, 0);
  EXPECT_EQ(summary()["outcome"], "out_of_time");
  EXPECT_EQ(summary()["at_target"], true);
  // No target.
  for (const char* drive : {"none", "expansion"}) {
    EXPECT_EQ(
        simulate("", {"--duration", "0.05", "--path", "dynamic", "--actuation", drive}).exitCode, 0)
        << drive;
    EXPECT_EQ(summary()["outcome"], "out_of_time");
    EXPECT_TRUE(summary()["at_target"].is_null());
  }
}

TEST_F(BadScene, SpringsWithoutStiffnessDoNotPull) {
  EXPECT_EQ(simulate("", {"--spring-stiffness", "0", "--torque-stiffness", "0"}).exitCode, 0);
  EXPECT_EQ(summary()["path"]["reason"],
            "nothing pulls to the target; dynamics: springs or damping were given");
  EXPECT_EQ(summary()["reason"], "came to rest; nothing pulls to the target");
  EXPECT_TRUE(summary()["at_target"].is_null());
  const double moved = summary()["accuracy"]["target_error_start"].get<double>() -
                       summary()["accuracy"]["target_error_end"].get<double>();
  EXPECT_NEAR(moved, 0, 1e-4);  // of 1.39 m
}

}  // namespace
}  // namespace kirireel
