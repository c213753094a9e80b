#include "sim/scene/scene_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/files.h"

namespace kirireel {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class SceneFileTest : public testing::Test {
 protected:
  scene::SceneFile read(const std::string& text) {
    std::ofstream(folder_ / "scene.toml") << text;
    return scene::readSceneFile(folder_ / "scene.toml");
  }

  /// The message for a refused file, from the file's own name.
  std::string refusal(const std::string& text) {
    try {
      read(text);
    } catch (const InputError& error) {
      const std::string message = error.what();
      return message.substr(std::min(message.size(), message.find("scene.toml")));
    }
    return "accepted";
  }

  test::TemporaryFolder folder_;
};

TEST_F(SceneFileTest, ReturnsSettingsAsText) {
  const scene::SceneFile file = read(
      "[environment]\ngravity = [0, 0, -9.81]\nground = true\nbrick_friction = 0.30\n"
      "[model]\nlink = [[0, 1, 2, 3], [1, 1, 2, 2]]\n[camera]\nview = \"top\"\n");
  ASSERT_EQ(file.settings.size(), 5u);
  const auto find = [&](const std::string& key) {
    return *std::find_if(file.settings.begin(), file.settings.end(),
                         [&](const scene::SceneSetting& setting) { return setting.key == key; });
  };
  EXPECT_EQ(find("gravity").table, "environment");
  EXPECT_THAT(find("gravity").values, ElementsAre("0,0,-9.81"));
  EXPECT_EQ(find("gravity").where.line, 2);
  EXPECT_TRUE(find("ground").isSwitch);
  EXPECT_THAT(find("brick_friction").values, ElementsAre("0.3"));
  EXPECT_THAT(find("link").values, ElementsAre("0,1,2,3", "1,1,2,2"));
  EXPECT_THAT(find("view").values, ElementsAre("top"));
}

TEST_F(SceneFileTest, ReadsEveryKindOfTimelineEntry) {
  const scene::Timeline timeline = read(R"(
[[timeline]]
at = 2
pin = [3, 4]
[[timeline]]
after = 0.5
pause = 1.5
[[timeline]]
at = "rest"
unpin = "all"
[[timeline]]
at = "target"
target = "model"
[[timeline]]
error_below = 1e-3
forces = "off"
[[timeline]]
progress = 0.5
drag = {tile = 2, vertex = 1, path = [[0, 0, 1], [1, 0, 1]], seconds = 3, stiffness = 7}
[[timeline]]
target = "half.txt"
[[timeline]]
snapshot = true
[[timeline]]
export = true
[[timeline]]
reset = true
[[timeline]]
quit = true
)")
                                       .timeline;
  using namespace scene::timeline;
  ASSERT_EQ(timeline.size(), 11u);
  EXPECT_EQ(timeline[0].when.kind, scene::Trigger::Kind::AtTime);
  EXPECT_EQ(timeline[0].when.value, 2);
  EXPECT_THAT(std::get<Pin>(timeline[0].action).tiles, ElementsAre(3, 4));
  EXPECT_EQ(timeline[0].where.line, 2);
  EXPECT_EQ(timeline[1].when.value, 0.5);
  EXPECT_EQ(std::get<Pause>(timeline[1].action).seconds, 1.5);
  EXPECT_EQ(timeline[2].when.kind, scene::Trigger::Kind::AtRest);
  EXPECT_TRUE(std::get<Unpin>(timeline[2].action).tiles.empty());
  EXPECT_EQ(timeline[3].when.kind, scene::Trigger::Kind::AtTarget);
  EXPECT_TRUE(std::get<GoTo>(timeline[3].action).file.empty());
  EXPECT_EQ(timeline[4].when.kind, scene::Trigger::Kind::ErrorBelow);
  EXPECT_FALSE(std::get<Forces>(timeline[4].action).on);
  EXPECT_EQ(timeline[5].when.kind, scene::Trigger::Kind::ProgressAbove);
  const Drag& drag = std::get<Drag>(timeline[5].action);
  EXPECT_EQ(drag.tile, 2);
  EXPECT_EQ(drag.vertex, 1);
  EXPECT_EQ(drag.path.back(), Vector3(1, 0, 1));
  EXPECT_EQ(drag.seconds, 3);
  EXPECT_EQ(drag.stiffness, 7);
  EXPECT_EQ(drag.damping, 50);
  // Files are relative to the scene file. No time means immediately.
  EXPECT_EQ(std::get<GoTo>(timeline[6].action).file, folder_ / "half.txt");
  EXPECT_EQ(timeline[6].when.kind, scene::Trigger::Kind::After);
  EXPECT_EQ(timeline[6].when.value, 0);
  EXPECT_EQ(scene::actionName(timeline[7].action), "snapshot");
  EXPECT_EQ(scene::actionName(timeline[10].action), "quit");
}

TEST_F(SceneFileTest, RefusesDeepOrLongFiles) {
  std::string parts = "a";
  for (int k = 0; k < 100000; ++k) parts += ".a";
  EXPECT_EQ(refusal("[model]\n" + parts + " = 1\n"),
            "scene.toml:2: error: a key or a text has 64 dots here. Use fewer");
  EXPECT_EQ(refusal("# " + std::string(100, '.') + "\n[model]\npin = [0]\n"), "accepted");
  EXPECT_EQ(refusal("[model]\npin = " + std::string(20, '[') + std::string(20, ']') + "\n"),
            "scene.toml:2:22: error: tables and arrays are nested more than 16 deep here. Remove "
            "brackets");
  std::string obstacles;
  for (int k = 0; k < 1001; ++k) obstacles += "[[obstacle]]\nshape = \"sphere\"\nradius = 1\n";
  EXPECT_THAT(refusal(obstacles), HasSubstr("error: there are 1001 obstacles, but at most 1000 are "
                                            "allowed. Combine several in one mesh"));
  std::filesystem::resize_file(folder_ / "scene.toml", (8u << 20) + 1);
  EXPECT_THAT([&] { scene::readSceneFile(folder_ / "scene.toml"); },
              testing::ThrowsMessage<InputError>(
                  HasSubstr("scene.toml: error: the file has 8388609 bytes, but at most 8388608 "
                            "are allowed; name a scene file, like scene.toml")));
}

TEST_F(SceneFileTest, RefusesTablesWithoutAKey) {
  for (const std::string table : {"[/]", "[=", "[[*]]", "[ ]", "[.", "[\u00e9", "\u00e9 = 1"}) {
    EXPECT_THAT(refusal(table + "\n"), HasSubstr("error: this is not TOML: ")) << table;
  }
}

TEST_F(SceneFileTest, ShowsForeignKeysShort) {
  const std::string message = refusal("\"\\n" + std::string(5000, 'k') + "\" = 1\n");
  EXPECT_THAT(message, HasSubstr("error: ?kkk"));
  EXPECT_LT(message.size(), 250U);
}

TEST_F(SceneFileTest, UnknownTablesSuggestTheNearest) {
  EXPECT_EQ(
      refusal("[enviroment]\nground = true\n"),
      "scene.toml:1:2: error: unknown table enviroment, did you mean environment?; there are "
      "model, environment, actuation, solver, stop, camera, style, recording, timeline, obstacle, "
      "velocity, grip");
}

TEST_F(SceneFileTest, UnknownTimelineKeysSuggestTheNearest) {
  EXPECT_THAT(refusal("[[timeline]]\npins = [1]\n"),
              HasSubstr("scene.toml:2:1: error: unknown key of a timeline entry pins, did you mean "
                        "pin?; there are after, at, drag, "));
  EXPECT_THAT(refusal("[[timeline]]\ndrag = {tile = 1, path = [[0,0,0]], second = 2}\n"),
              HasSubstr("unknown key of a drag second, did you mean seconds?"));
}

TEST_F(SceneFileTest, RefusesInvalidTimelines) {
  const auto entry = [&](const std::string& text) { return refusal("[[timeline]]\n" + text); };
  const std::string no = " is not allowed; give ";
  EXPECT_EQ(entry("at = -1\nquit = true\n"),
            "scene.toml:2:6: error: -1" + no +
                "a number of seconds, from 0 to 1e6, \"rest\" or \"target\"");
  EXPECT_THAT(entry("at = \"resting\"\nquit = true\n"),
              HasSubstr("error: \"resting\"" + no + "a number of seconds"));
  EXPECT_THAT(entry("at = nan\nquit = true\n"), HasSubstr(no));
  EXPECT_THAT(entry("pin = [1.5]\n"), HasSubstr(no + "a tile number"));
  EXPECT_THAT(entry("pin = [-1]\n"), HasSubstr(no + "a tile number"));
  EXPECT_THAT(entry("pin = []\n"), HasSubstr(no + "a list of tile numbers"));
  EXPECT_THAT(entry("drag = {tile = 1}\n"), HasSubstr(no + "a table, {tile = 3, path ="));
  EXPECT_THAT(entry("drag = {tile = 1, path = [[0, 0, nan]]}\n"),
              HasSubstr(no + "a number, at most 1e+09"));
  EXPECT_THAT(entry("drag = {tile = 1, path = [[0, 0]]}\n"), HasSubstr(no + "a point [x, y, z]"));
  EXPECT_THAT(entry("progress = 2\nquit = true\n"), HasSubstr(no + "a share from 0 to 1"));
  EXPECT_THAT(entry("forces = true\n"), HasSubstr(no + "\"on\" or \"off\""));
  EXPECT_THAT(entry("quit = false\n"), HasSubstr(no + "true"));
  EXPECT_THAT(entry("at = 1\n"), HasSubstr("this entry has 1 times and 0 actions. It needs"));
  EXPECT_THAT(entry("at = 1\nafter = 1\nquit = true\n"), HasSubstr("has 2 times and 1 actions"));
}

TEST_F(SceneFileTest, RefusesInvalidToml) {
  EXPECT_THAT(refusal("[model\nthickness = 1\n"),
              HasSubstr("scene.toml:1:7: error: this is not TOML"));
  EXPECT_THAT(refusal("thickness = 1\n"),
              HasSubstr("thickness is in no table; write it below its table, such as [model]"));
  EXPECT_THAT(refusal("model = 1\n"), HasSubstr("give a table, [model]"));
  EXPECT_THAT(refusal("[model]\nthickness = 1979-05-27\n"),
              HasSubstr("error: a date or time is not allowed; give a number, a text, true, "
                        "false or an array"));
  EXPECT_THROW(scene::readSceneFile(folder_ / "other.toml"), InputError);
}

TEST_F(SceneFileTest, ReadsObstacles) {
  std::ofstream(folder_ / "wall.obj") << "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
  const std::vector<scene::Obstacle> obstacles = read(R"(
[[obstacle]]
shape = "box"
size = [1, 2, 3]
position = [0, 0, -1]
rotation = [90, 0, 90]
friction = 0.25
[[obstacle]]
shape = "sphere"
radius = 0.5
[[obstacle]]
shape = "mesh"
file = "wall.obj"
position = [0, 0, 4]
)")
                                                     .obstacles;
  ASSERT_EQ(obstacles.size(), 3u);
  EXPECT_EQ(obstacles[0].size, Vector3(1, 2, 3));
  EXPECT_EQ(obstacles[0].friction, 0.25);
  // x first, then z: the box's y axis points up, its z axis along the world's x.
  EXPECT_TRUE((obstacles[0].pose.rotation * Vector3::UnitY()).isApprox(Vector3::UnitZ()));
  EXPECT_TRUE((obstacles[0].pose.rotation * Vector3::UnitZ()).isApprox(Vector3::UnitX()));
  EXPECT_EQ(obstacles[1].shape, scene::Obstacle::Shape::Sphere);
  EXPECT_EQ(obstacles[1].radius, 0.5);
  EXPECT_EQ(obstacles[1].friction, 0.5);
  EXPECT_EQ(scene::obstacleFaces(obstacles[2]).front().vertices[2], Vector3(1, 1, 4));
}

TEST_F(SceneFileTest, MeshesOfObstaclesHaveTheirOwnUnitOrThatOfTheModel) {
  for (const auto& [unit, expected] : {std::pair{"", 0.0254}, {"# unit mm\n", 0.001}}) {
    std::ofstream(folder_ / "rock.obj") << unit << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    scene::Scene scene = scene::openScene();
    scene.environment.obstacles =
        read("[[obstacle]]\nshape = \"mesh\"\nfile = \"rock.obj\"\n").obstacles;
    scene::scaleLengths(scene, 0.0254);  // a model in inches
    EXPECT_EQ(scene.environment.obstacles[0].mesh[0].vertices[1], Vector3(expected, 0, 0)) << unit;
  }
}

TEST_F(SceneFileTest, RefusesInvalidObstacles) {
  EXPECT_EQ(refusal("[[obstacle]]\nshape = \"cone\"\n"),
            "scene.toml:2:9: error: an obstacle needs shape = \"box\", \"sphere\" or \"mesh\"");
  EXPECT_EQ(
      refusal("[[obstacle]]\nshape = \"box\"\n"),
      "scene.toml:1:1: error: a box needs size. A box has size, a sphere radius, a mesh file");
  EXPECT_THAT(refusal("[[obstacle]]\nshape = \"sphere\"\nradius = 1\nsize = [1, 1, 1]\n"),
              HasSubstr("error: a sphere has no size. "));
  EXPECT_THAT(refusal("[[obstacle]]\nshape = \"box\"\nsize = [1, 0, 1]\n"),
              HasSubstr("scene.toml:3:8: error: [1, 0, 1] is not allowed; give three positive "
                        "lengths"));
  EXPECT_THROW(read("[[obstacle]]\nshape = \"mesh\"\nfile = \"no.obj\"\n"), InputError);
  EXPECT_THAT(refusal("[obstacle]\nshape = \"box\"\n"),
              HasSubstr("give tables, each under [[obstacle]]"));
}

TEST_F(SceneFileTest, ReadsSpeedsOfTheStart) {
  const scene::SceneFile file = read(
      "[[velocity]]\nlinear = [1, 0, -2.5]\n\n[[velocity]]\ntiles = [0, 3]\nangular = [0, 0, 1]\n");
  ASSERT_EQ(file.velocities.size(), 2u);
  EXPECT_TRUE(file.velocities[0].tiles.empty());
  EXPECT_EQ(file.velocities[0].linear, Vector3(1, 0, -2.5));
  EXPECT_EQ(file.velocities[0].angular, Vector3::Zero());
  EXPECT_THAT(file.velocities[1].tiles, ElementsAre(0, 3));
  EXPECT_EQ(file.velocities[1].angular, Vector3(0, 0, 1));
}

TEST_F(SceneFileTest, RefusesInvalidSpeeds) {
  EXPECT_THAT(
      refusal("[[velocity]]\ntiles = [0]\n"),
      HasSubstr("needs linear = [x, y, z] in lengths per second, angular in rad/s, or both"));
  EXPECT_THAT(refusal("[[velocity]]\nlinear = [1, 2]\n"), HasSubstr("three lengths per second"));
  EXPECT_THAT(refusal("[[velocity]]\nlinaer = [1, 2, 3]\n"), HasSubstr("linear"));
  EXPECT_THAT(refusal("[velocity]\nlinear = [1, 2, 3]\n"), HasSubstr("[[velocity]]"));
}

}  // namespace
}  // namespace kirireel
