// Every setting of a scene, by its description in the list of settings.
#include "sim/scene/settings.h"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

namespace kirireel {
namespace {

std::vector<scene::Setting> allSettings() {
  std::vector<scene::Setting> all;
  for (const scene::SettingGroup& group : scene::sceneSettings()) {
    all.insert(all.end(), group.settings.begin(), group.settings.end());
  }
  return all;
}

/// A valid value of a setting other than its default.
std::string otherText(const scene::Setting& setting) {
  if (!setting.words.empty()) return setting.words.back();
  if (setting.key == "gravity") return "1,-2,3";
  if (setting.key == "hinge_neck") return "0.1,0.3,2e9,0.25";
  if (setting.key == "ligament_stiffness") return "120,1.5,0.1";
  if (setting.key == "hinge_file") return "hinges.txt";
  if (setting.isSwitch) return "";
  return setting.unit == "COUNT" || setting.unit == "NUMBER" ? "7" : "0.75";
}

/// The text of a setting as on the command line: without quotes of a scene file.
std::string typed(const std::string& written) {
  std::string text;
  for (const char c : written) {
    if (c != '"' && c != '[' && c != ']' && c != ' ') text += c;
  }
  return text;
}

TEST(Settings, HaveUniqueKeys) {
  std::set<std::string> keys;
  for (const scene::Setting& setting : allSettings()) {
    EXPECT_TRUE(keys.insert(setting.key).second) << setting.key;
    EXPECT_FALSE(setting.help.empty()) << setting.key;
    EXPECT_EQ(setting.unit.empty(), setting.isSwitch) << setting.key;
  }
  EXPECT_EQ(keys.size(), 45U);
}

TEST(Settings, ReadBackWhatTheyWrite) {
  for (const scene::Setting& setting : allSettings()) {
    scene::Scene scene = scene::openScene();
    setting.read(scene, {setting.key, otherText(setting)});
    const std::string written = setting.write(scene);
    EXPECT_NE(written, "") << setting.key;
    EXPECT_NE(written, setting.write(scene::openScene())) << setting.key;
    scene::Scene again = scene::openScene();
    setting.read(again, {setting.key, typed(written)});
    EXPECT_EQ(setting.write(again), written) << setting.key;
  }
}

TEST(Settings, ChangeOnlyTheirOwnField) {
  for (const scene::Setting& changed : allSettings()) {
    scene::Scene scene = scene::openScene();
    changed.read(scene, {changed.key, otherText(changed)});
    for (const scene::Setting& other : allSettings()) {
      // A ground has a friction.
      if (other.key == changed.key || changed.key.starts_with("ground")) continue;
      EXPECT_EQ(other.write(scene), other.write(scene::openScene()))
          << changed.key << ' ' << other.key;
    }
  }
}

TEST(Settings, OfDynamicsAreReportedUnlessDefault) {
  EXPECT_EQ(scene::whyDynamics(scene::Scene{}), "");
  EXPECT_EQ(scene::whyDynamics(scene::openScene()), "");
  for (const scene::Setting& setting : allSettings()) {
    scene::Scene scene = scene::openScene();
    setting.read(scene, {setting.key, otherText(setting)});
    EXPECT_EQ(scene::whyDynamics(scene).empty(),
              setting.dynamics.empty() && setting.key != "ground_friction")
        << setting.key;
  }
}

TEST(Settings, OfCodeAreCheckedLikeThoseOfUsers) {
  EXPECT_NO_THROW(scene::requireRanges(scene::Scene{}));
  EXPECT_NO_THROW(scene::requireRanges(scene::openScene()));
  scene::Scene scene;
  scene.springs.springStiffness = NAN;
  try {
    scene::requireRanges(scene);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "error: spring_stiffness: 'nan' is not allowed; give a number from 0 to 1e+12");
  }
}

TEST(Settings, HaveConditionsThatSomeSceneMeets) {
  scene::Scene guided;
  guided.path.kind = scene::PathKind::Guided;
  scene::Scene bullet;
  bullet.solver.kind = scene::SolverKind::Bullet;
  scene::Scene necks;
  necks.hinges.neck = scene::HingeNeck{0.1, 0.1, 1e9};
  scene::Scene curve;
  curve.actuation.drive = scene::Drive::Boundary;
  curve.brick.mass = brick::MassRule::Prism;
  const scene::Scene open = scene::openScene();
  for (const scene::Setting& setting : allSettings()) {
    for (const scene::Condition& condition : setting.conditions) {
      EXPECT_TRUE(condition.holds(guided) || condition.holds(bullet) || condition.holds(necks) ||
                  condition.holds(curve) || condition.holds(open))
          << setting.key << " " << condition.needed;
    }
  }
}

}  // namespace
}  // namespace kirireel
