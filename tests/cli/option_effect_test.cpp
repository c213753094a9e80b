// Options without an effect next to others are refused with the reason.
#include "render/cli/option_effect.h"

#include <map>

#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/cli/command_line.h"
#include "sim/base/error.h"
#include "tests/support/files.h"
#include "tests/support/refusal.h"

namespace kirireel {
namespace {

using Words = std::vector<std::string>;

std::string refusalOfWords(const Words& words) {
  return test::refusalOf([&] { cli::parseCommandLine(words); });
}

/// A command line on which the option has no effect, and words that give it an effect.
struct Case {
  Words idle;
  Words remedy;  // "-X" removes X
};

Words operator+(Words words, const Words& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

Words without(Words words, const std::string& word) {
  std::erase(words, word);
  return words;
}

/// By option and reason, as in optionEffects().
std::multimap<std::string, Case> cases(const test::TemporaryFolder& folder) {
  std::multimap<std::string, Case> all;
  const Words record = {"record", "fan"};
  std::ofstream(folder / "grips.toml") << "[[grip]]\ntile = 0\nmove = {x = 1}\n";
  const Words pulled = record + Words{"--scene", (folder / "grips.toml").string()};
  const std::map<std::string, Words> grid = {
      {"--grid", {"2x2"}},         {"--letters", {}},     {"--arrows", {}},
      {"--column-heads", {"a,b"}}, {"--width", {"90mm"}}, {"--font-size", {"7pt"}},
      {"--figure", {"svg"}},       {"--svg", {}},         {"--snapshots", {"time"}}};
  for (const auto& [option, value] : grid) {
    const Words size = option == "--font-size" ? Words{"--width", "90mm"} : Words{};
    all.insert({option, {record + Words{"--no-snapshots", option} + value, {"-"}}});
  }
  for (const auto& [option, value] :
       std::map<std::string, Words>{{"--captions", {"time"}}, {"--scale-bar", {}}}) {
    all.insert({option, {record + Words{"--no-snapshots", "--no-video", option} + value, {"-"}}});
  }
  all.insert({"--dpi", {record + Words{"--no-snapshots", "--dpi", "300"}, {"-"}}});
  const Words several = {"render", "a", "b", "--out", "c"};
  all.insert({"--frames-at", {several + Words{"--frames-at", "0"}, {"b"}}});
  for (const auto& [option, value] : std::map<std::string, Words>{{"--no-snapshots", {}},
                                                                  {"--fps", {"30"}},
                                                                  {"--length", {"5"}},
                                                                  {"--hold", {"1"}},
                                                                  {"--title", {"A"}},
                                                                  {"--subtitle", {"A"}},
                                                                  {"--progress-bar", {}},
                                                                  {"--inset", {"radius"}},
                                                                  {"--crf", {"20"}},
                                                                  {"--preset", {"slow"}},
                                                                  {"--encoder", {"libx264"}}}) {
    all.insert({option, {several + Words{option} + value, {"--video", "b.mp4"}}});
  }
  for (const std::string option : {"--same-view", "--same-scale"}) {
    all.insert({option, {Words{"render", "a", "--out", "c", option}, {"d"}}});
  }
  for (const auto& [option, value] : std::map<std::string, Words>{{"--video", {"a.mp4"}},
                                                                  {"--crf", {"20"}},
                                                                  {"--preset", {"slow"}},
                                                                  {"--encoder", {"libx264"}},
                                                                  {"--length", {"5"}},
                                                                  {"--hold", {"1"}},
                                                                  {"--title", {"A"}},
                                                                  {"--subtitle", {"A"}},
                                                                  {"--progress-bar", {}},
                                                                  {"--inset", {"radius"}},
                                                                  {"--painters", {"2"}}}) {
    all.insert({option, {record + Words{"--no-video", option} + value, {"-"}}});
  }
  all.insert({"--fps", {{"render", "run", "--no-video", "--fps", "30"}, {"-"}}});
  all.insert(
      {"--preset", {record + Words{"--video", "a.gif", "--preset", "slow"}, {"--video", "a.mp4"}}});
  all.insert({"--transparent",
              {record + Words{"--video", "a.mp4", "--transparent"}, {"--video", "a.webm"}}});
  for (const auto& [option, value] : std::map<std::string, Words>{
           {"--colour-map", {"cividis"}}, {"--colour-least", {"0"}}, {"--colour-most", {"1"}}}) {
    all.insert({option, {record + Words{option} + value, {"--colour", "error"}}});
  }
  for (const std::string option : {"--brick-colour", "--back-colour"}) {
    all.insert(
        {option, {record + Words{"--colour", "shape", option, "teal"}, {"--colour", "plain"}}});
  }
  for (const auto& [option, value] :
       std::map<std::string, Words>{{"--outline-colour", {"teal"}}, {"--outline-width", {"2"}}}) {
    all.insert({option, {record + Words{"--no-outlines", option} + value, {"-"}}});
  }
  all.insert({"--distance",
              {record + Words{"--projection", "parallel", "--distance", "5"},
               {"--projection", "perspective"}}});
  const Words nothing = record + Words{"--no-snapshots", "--no-video"};
  all.insert({"Style", {nothing + Words{"--theme", "dark"}, {"--frames"}}});
  all.insert({"Camera", {nothing + Words{"--zoom", "2"}, {"--frames"}}});
  const Words stl = {"export", "run", "--format", "stl"};
  const Words inp = {"export", "run", "--format", "inp"};
  all.insert({"--joints",
              {{"export", "run", "--format", "obj", "--joints", "neck"}, {"--format", "stl"}}});
  all.insert({"--shells", {stl + Words{"--joints", "neck", "--shells"}, {"--format", "msh"}}});
  for (const auto& [option, value] : std::map<std::string, Words>{{"--elements-per-edge", {"2"}},
                                                                  {"--element-size", {"0.1"}},
                                                                  {"--elements-through", {"2"}},
                                                                  {"--linear", {}},
                                                                  {"--shells", {}}}) {
    all.insert({option, {stl + Words{option} + value, {"--format", "msh"}}});
  }
  all.insert({"--patch-radius", {stl + Words{"--joints", "patch", "--patch-radius", "0.1"}, {}}});
  all.insert(
      {"--plane-stress", {stl + Words{"--joints", "neck", "--plane-stress"}, {"--format", "msh"}}});
  for (const std::string option : {"--neck-width", "--neck-length", "--neck-radius", "--kerf"}) {
    all.insert({option,
                {{"export", "run", "--format", "dxf", option, "0.1"},
                 {"--format", "inp", "--joints", "neck"}}});
  }
  all.insert({"--patch-radius", {inp + Words{"--patch-radius", "0.1"}, {"--joints", "patch"}}});
  for (const std::string option : {"--neck-width", "--neck-length", "--neck-radius", "--kerf"}) {
    all.insert({option, {inp + Words{option, "0.1"}, {"--joints", "neck"}}});
  }
  all.insert({"--elements-per-edge",
              {inp + Words{"--element-size", "1", "--elements-per-edge", "4"}, {}}});
  all.insert({"--elements-through", {inp + Words{"--shells", "--elements-through", "2"}, {"-"}}});
  all.insert({"--shells", {inp + Words{"--joints", "neck", "--shells", "--plane-stress"}, {}}});
  all.insert({"--sets", {stl + Words{"--sets", "none"}, {"--format", "msh"}}});
  for (const auto& [option, value] : std::map<std::string, Words>{{"--deck-solver", {"abaqus"}},
                                                                  {"--youngs", {"1e9"}},
                                                                  {"--poisson", {"0.2"}},
                                                                  {"--deck-density", {"900"}},
                                                                  {"--deck-unit", {"mm-N"}},
                                                                  {"--drive", {"all"}},
                                                                  {"--buckle", {}},
                                                                  {"--periodic", {}},
                                                                  {"--deck-contacts", {"0"}},
                                                                  {"--state-map", {}},
                                                                  {"--check", {}}}) {
    all.insert(
        {option, {Words{"export", "run", "--format", "msh", option} + value, {"--format", "inp"}}});
  }
  all.insert({"--hinge-width", {stl + Words{"--hinge-width", "0.1"}, {"--format", "svg"}}});
  all.insert({"--states",
              {{"export", "run", "--format", "glb", "--states", "final"}, {"--format", "obj"}}});
  for (const auto& [option, value] : std::map<std::string, Words>{{"--against", {"opening"}},
                                                                  {"--width", {"85"}},
                                                                  {"--font-size", {"7"}},
                                                                  {"--curves", {"size"}},
                                                                  {"--column", {"a.csv:b"}}}) {
    all.insert({option, {Words{"curves", "run", option} + value, {"--plot", "svg"}}});
  }
  all.insert({"--dpi", {{"curves", "run", "--plot", "svg", "--dpi", "300"}, {"--plot", "png"}}});
  all.insert(
      {"--brick-friction",
       {record + Words{"--contacts", "none", "--brick-friction", "0.3"}, {"--contacts", "all"}}});
  all.insert({"--load-steps", {record + Words{"--load-steps", "3"}, {}}});
  all.insert({"Springs to the target",
              {record + Words{"--actuation", "none", "--spring-stiffness", "25"},
               {"--actuation", "target"}}});
  for (const Words& dynamic : std::vector<Words>{{"--path", "straight"},
                                                 {"--gravity", "-1"},
                                                 {"--actuation", "none"},
                                                 {"--hinge-stiffness", "1"},
                                                 {"--solver", "bullet"}}) {
    all.insert({"--walk-time", {record + Words{"--walk-time", "3"} + dynamic, {}}});
  }
  all.insert({"--walk-time",
              {record + Words{"--path", "straight", "--walk-time", "3"}, {"--path", "auto"}}});
  for (const Words& touchless :
       std::vector<Words>{{"--actuation", "expansion"}, {"--solver", "bullet"}, {"--pin", "0"}}) {
    all.insert({"--brick-friction",
                {record + Words{"--brick-friction", "0.3"} + touchless, {"--contacts", "all"}}});
  }
  for (const auto& [option, value] : std::map<std::string, std::string>{
           {"--timestep", "0.01"}, {"--seed", "2"}, {"--tolerance", "0"}}) {
    all.insert(
        {option, {record + Words{"--path", "continuation", option, value}, {"--path", "dynamic"}}});
    all.insert({option, {record + Words{"--to", "closed", option, value}, {"--to", "auto"}}});
    all.insert({option, {pulled + Words{option, value}, {}}});
  }
  for (const auto& [option, value] : std::map<std::string, std::string>{
           {"--actuation", "target"}, {"--path", "continuation"}, {"--joint-ratio", "10"}}) {
    all.insert({option, {pulled + Words{option, value}, {}}});
  }
  for (const Words& requested :
       std::vector<Words>{{"--path", "straight"}, {"--path", "guided"}, {"--solver", "bullet"}}) {
    all.insert({"--search-effort",
                {record + Words{"--search-effort", "2"} + requested,
                 {"--path", "auto", "--solver", "direct"}}});
  }
  return all;
}

/// The words that switch something off, which a remedy "-X" removes.
const Words kSwitches = {"--no-snapshots", "--no-video", "--no-outlines", "--shells"};

TEST(OptionEffects, AreEachRefusedWithTheirReason) {
  const test::TemporaryFolder folder;
  const std::multimap<std::string, Case> all = cases(folder);
  for (const cli::OptionEffect& effect : cli::optionEffects()) {
    SCOPED_TRACE(std::string(effect.option) + " " + effect.reason);
    const auto [first, last] = all.equal_range(std::string(effect.option));
    const std::string expected =
        fmt::format(" has no effect {}. {} or remove ", effect.reason, effect.remedy);
    EXPECT_TRUE(std::any_of(first, last, [&](const auto& entry) {
      return refusalOfWords(entry.second.idle).find(expected) != std::string::npos;
    })) << "no case has this message";
  }
}

TEST(OptionEffects, AreAcceptedWithWhatTheyNeed) {
  const test::TemporaryFolder folder;
  for (const auto& [option, example] : cases(folder)) {
    SCOPED_TRACE(fmt::format("{}", fmt::join(example.idle, " ")));
    EXPECT_THAT(refusalOfWords(example.idle), testing::HasSubstr(" has no effect "));
    if (example.remedy.empty()) continue;
    Words words = example.idle;
    if (example.remedy.front() == "-") {
      for (const std::string& word : kSwitches) words = without(words, word);
      if (option == "--font-size") words = words + Words{"--width", "90mm"};
    } else if (example.remedy.front() == "b") {
      words = without(words, "b");
    } else {
      words = words + example.remedy;
      // Formats add up; this removes all but the last.
      const auto format = std::ranges::find(words, "--format");
      if (words.front() == "export" && example.remedy.front() == "--format")
        words.erase(format, format + 2);
    }
    EXPECT_EQ(refusalOfWords(words), "accepted");
  }
}

// A scene file may hold settings for several uses.
TEST(OptionEffects, AreCheckedForTypedOptions) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "run.toml") << "[environment]\nbrick_friction = 0.3\ncontacts = \"none\"\n"
                                        "[style]\ncolour_map = \"cividis\"\n";
  const Words record = {"record", "fan", "--scene", (folder / "run.toml").string()};
  EXPECT_EQ(refusalOfWords(record), "accepted");
  EXPECT_EQ(refusalOfWords(record + Words{"--brick-friction", "0.2"}),
            "error: --brick-friction has no effect without contacts. Use --contacts all or remove "
            "--brick-friction");
}

// PyKirigami accepts all combinations of its options.
TEST(OptionEffects, AreNotCheckedForPyKirigami) {
  EXPECT_EQ(refusalOfWords(
                {"record", "--model", "fan", "--actuation", "none", "--spring_stiffness", "25"}),
            "accepted");
}

}  // namespace
}  // namespace kirireel
