// Options that contradict each other, from the command line and from scene files.
#include <gtest/gtest.h>

#include "render/cli/command_line.h"
#include "sim/base/error.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

std::string refusal(std::vector<std::string> options) {
  options.insert(options.begin(), {"record", "fan"});
  try {
    cli::parseCommandLine(options);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Contradictions, NameWhatAnOptionNeeds) {
  EXPECT_EQ(refusal({"--solver", "bullet", "--joint-ratio", "1e3"}),
            "error: --joint-ratio works only with --solver direct. Add --solver direct or "
            "remove --joint-ratio");
  EXPECT_EQ(refusal({"--path", "straight", "--guide-time", "2"}),
            "error: --guide-time works only with --path guided. Add --path guided or remove "
            "--guide-time");
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"--path", "straight", "--joint-ratio", "1e3"},
       "--joint-ratio works only with --path auto, --path continuation or --path guided."},
      {{"--path", "guided", "--solver", "bullet"},
       "--path guided works only with --solver direct."},
      {{"--path", "guided", "--cm_expansion"}, "--path guided works only with --actuation target."},
      {{"--solver", "bullet", "--pin", "0"}, "--pin works only with --solver direct."},
      {{"--solver", "bullet", "--link", "0,0,2,1"}, "--link works only with --solver direct."},
      {{"--iterations", "90"}, "--iterations works only with --solver bullet."},
      {{"--solver", "bullet", "--tolerance", "1e-4"},
       "--tolerance works only with --solver direct."},
      {{"--tolerance", "1e-4", "--substeps", "2"}, "--substeps works only with --tolerance 0."},
      {{"--tolerance", "1e-4", "--path", "guided"}, "--path guided moves tiles in fixed steps"},
      {{"--measure-time-error", "--path", "guided"},
       "--path guided moves tiles in fixed steps and has no --measure-time-error."},
      {{"--boundary-size", "3"}, "--boundary-size works only with --actuation boundary."},
      {{"--cm_expansion", "--boundary-aspect", "3"},
       "--boundary-aspect works only with --actuation boundary."},
      {{"--density", "900"}, "--density works only with --mass prism."},
      {{"--pace", "even", "--speed", "0.5"}, "--speed works only with --pace real."},
      {{"--length", "5", "--pace", "real"}, "--length works only with --pace even."},
      {{"--length", "5", "--speed", "0.5"}, "--length is for an even pace and --speed for real "},
  };
  for (const auto& [options, start] : cases) {
    EXPECT_TRUE(refusal(options).starts_with("error: " + start)) << refusal(options);
  }
}

TEST(Contradictions, NameEquivalentOptions) {
  EXPECT_EQ(
      refusal({"--spring-frequency", "3", "--spring-stiffness", "25", "--torque-stiffness", "25"}),
      "error: --spring-frequency and --spring-stiffness with --torque-stiffness are equivalent. "
      "Use only one of them");
  EXPECT_EQ(refusal({"--damping-ratio", "1", "--force-damping", "25", "--torque-damping", "1"}),
            "error: --damping-ratio and --force-damping with --torque-damping are equivalent. Use "
            "only one "
            "of them");
  EXPECT_EQ(refusal({"--damping-ratio", "1", "--spring-stiffness", "25"}), "accepted");
  EXPECT_EQ(refusal({"--spring-frequency", "3", "--torque-stiffness", "25"}), "accepted");
  EXPECT_EQ(refusal({"--damping-ratio", "1", "--force-damping", "25"}), "accepted");
}

TEST(Contradictions, AcceptConsistentOptions) {
  EXPECT_EQ(refusal({"--path", "guided", "--guide-time", "2", "--joint-ratio", "1e3"}), "accepted");
  EXPECT_EQ(refusal({"--solver", "bullet", "--iterations", "90"}), "accepted");
  EXPECT_EQ(refusal({"--actuation", "boundary", "--boundary-size", "3"}), "accepted");
  EXPECT_EQ(refusal({"--mass", "prism", "--density", "900"}), "accepted");
}

TEST(Contradictions, AreFoundInSceneFilesToo) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "run.toml") << "[actuation]\nguide_time = 2\n";
  EXPECT_EQ(refusal({"--scene", (folder / "run.toml").string()}),
            "error: --guide-time works only with --path guided. Add --path guided or remove "
            "--guide-time");
  std::ofstream(folder / "run.toml") << "[actuation]\nguide_time = 2\npath = \"guided\"\n";
  EXPECT_EQ(refusal({"--scene", (folder / "run.toml").string()}), "accepted");
}

}  // namespace
}  // namespace kirireel
