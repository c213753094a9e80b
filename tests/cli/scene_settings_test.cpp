// Scene files through the command line's own options.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/cli/command_line.h"
#include "sim/base/error.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;

class SceneSettingsTest : public testing::Test {
 protected:
  cli::RecordOrder parse(const std::string& scene, const std::vector<std::string>& more = {}) {
    std::ofstream(folder_ / "scene.toml") << scene;
    std::vector<std::string> arguments = {"record", folder_.path().string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return std::get<cli::RecordOrder>(cli::parseCommandLine(arguments));
  }

  std::string refusal(const std::string& scene) {
    try {
      parse(scene);
    } catch (const InputError& error) {
      const std::string message = error.what();
      return message.substr(std::min(message.size(), message.find("scene.toml")));
    }
    return "accepted";
  }

  test::TemporaryFolder folder_;
};

TEST_F(SceneSettingsTest, KeysAreOptions) {
  const cli::RecordOrder order = parse(
      "[model]\nthickness = 0.1\npin = [0, 3]\nlink = [[0, 1, 2, 3]]\n"
      "[environment]\ngravity = [0, 0, -10]\nground = true\ncontacts = \"all\"\n"
      "[actuation]\nactuation = \"expansion\"\nspring_stiffness = 25\nno_adaptive = true\n"
      "[solver]\nseed = 7\n[stop]\nduration = 3\n[[timeline]]\nat = 1\nquit = true\n");
  EXPECT_EQ(order.scene.brick.thickness, 0.1);
  EXPECT_EQ(order.request.parts.pinned, (std::vector<int>{0, 3}));
  EXPECT_EQ(order.request.parts.links.front(), (std::array<int, 4>{0, 1, 2, 3}));
  EXPECT_EQ(order.scene.environment.gravity, Vector3(0, 0, -10));
  EXPECT_TRUE(order.scene.environment.ground.has_value());
  EXPECT_EQ(order.scene.environment.contacts, scene::ContactFilter::All);
  EXPECT_EQ(order.scene.actuation.drive, scene::Drive::Expansion);
  EXPECT_EQ(order.scene.springs.springStiffness, 25);
  EXPECT_FALSE(order.scene.springs.adaptive);
  EXPECT_EQ(order.scene.solver.seed, 7u);
  EXPECT_EQ(order.scene.stop.duration, 3);
  EXPECT_EQ(order.scene.timeline.size(), 1u);
}

TEST_F(SceneSettingsTest, IncludeVideos) {
  const cli::RecordOrder order =
      parse("[recording]\nvideo = \"run.webm\"\ntitle = \"Fan\"\nhold = 1.5\n");
  EXPECT_EQ(order.settings.videoFile, "run.webm");
  EXPECT_EQ(order.settings.title, "Fan");
  EXPECT_EQ(order.settings.hold, 1.5);
}

TEST_F(SceneSettingsTest, TheCommandLineHasPriority) {
  const cli::RecordOrder order = parse("[actuation]\nspring_stiffness = 25\nforce_damping = 20\n",
                                       {"--spring_stiffness", "50"});
  EXPECT_EQ(order.scene.springs.springStiffness, 50);
  EXPECT_EQ(order.scene.springs.forceDamping, 20);
}

TEST_F(SceneSettingsTest, AnotherFileReplacesTheModelsOwn) {
  std::ofstream(folder_ / "other.toml") << "[stop]\nduration = 5\n";
  const cli::RecordOrder order = parse("[stop]\nduration = 3\n[solver]\nseed = 9\n",
                                       {"--scene", (folder_ / "other.toml").string()});
  EXPECT_EQ(order.scene.stop.duration, 5);
  EXPECT_EQ(order.scene.solver.seed, 1u);
}

TEST_F(SceneSettingsTest, FalseDoesNotSetASwitch) {
  EXPECT_FALSE(parse("[environment]\nground = false\n").scene.environment.ground.has_value());
}

TEST_F(SceneSettingsTest, UnknownKeysSuggestTheNearest) {
  EXPECT_EQ(refusal("[environment]\nbrick_frictoin = 0.3\n"),
            "scene.toml:2:18: error: [environment] has no key brick_frictoin, did you mean "
            "brick_friction?; see kirireel record --help");
}

TEST_F(SceneSettingsTest, UnknownKeysSuggestOnesOfOtherTables) {
  EXPECT_THAT(refusal("[stop]\nthicknes = 0.3\n"), HasSubstr("did you mean thickness?"));
}

TEST_F(SceneSettingsTest, SimulateChecksAndIgnoresKeysOfRecord) {
  std::ofstream(folder_ / "scene.toml") << "[recording]\nlength = 4\n[camera]\nview = \"iso\"\n";
  const std::string folder = folder_.path().string();
  EXPECT_NO_THROW(cli::parseCommandLine({"simulate", folder}));
  std::ofstream(folder_ / "scene.toml") << "[recording]\nlength = 0\n";
  EXPECT_THROW(cli::parseCommandLine({"simulate", folder}), InputError);
}

TEST_F(SceneSettingsTest, KeysInTheWrongTableNameTheRightOne) {
  EXPECT_EQ(refusal("[environment]\nseed = 3\n"),
            "scene.toml:2:8: error: seed belongs in [solver], not in [environment]");
}

TEST_F(SceneSettingsTest, WrongValuesAreTheOptionsErrorsWithTheirPlace) {
  EXPECT_THAT(refusal("[solver]\n\nsolver = \"magic\"\n"),
              HasSubstr("scene.toml:3:10: error: --solver: 'magic' is not allowed; give direct"));
  EXPECT_THAT(refusal("[model]\nthickness = -1\n"), HasSubstr("scene.toml:2:13: error: --thick"));
  EXPECT_THAT(refusal("[model]\nthickness = true\n"), HasSubstr("thickness needs a value"));
  EXPECT_THAT(refusal("[environment]\nground = 3\n"),
              HasSubstr("error: ground: '3' is not allowed; give true or false"));
  EXPECT_THAT(refusal("[model]\npin = [1, -2]\n"), HasSubstr("--pin: '1,-2' is not allowed"));
}

}  // namespace
}  // namespace kirireel
