// From our own drawing to runs, decks and other files.
#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "sim/base/files.h"
#include "tests/cli/run_program.h"
#include "tests/support/program.h"

namespace kirireel {
namespace {

using testing::HasSubstr;

const std::string kSlots = KIRIREEL_SOURCE_DIR "/docs/drawings/squares_slots.svg";

nlohmann::json necksOf(const std::string& model, const std::vector<std::string>& options = {}) {
  std::vector<std::string> words = {"inspect", model, "--json"};
  words.insert(words.end(), options.begin(), options.end());
  const ProgramEnd end = runKirireel(words);
  EXPECT_EQ(end.exitCode, 0) << end.err;
  return nlohmann::json::parse(end.out).at("necks");
}

TEST(ProgramDrawings, KeepTheirNecksThroughFiles) {
  const nlohmann::json drawn = necksOf(kSlots);
  EXPECT_EQ(drawn.at("count"), 24);
  EXPECT_NEAR(drawn.at("width")[0].get<double>(), 0.00115, 1e-6);
  EXPECT_NEAR(drawn.at("kerf")[0].get<double>(), 0.0003, 1e-7);
  EXPECT_THAT(runKirireel({"inspect", kSlots}).out, HasSubstr("\nnecks: 24, 1.15 mm wide, "
                                                              "0.3 mm long, kerf 0.3 mm\n"));
  const TemporaryFolder scratch;
  for (const std::string name : {"sheet.fold", "sheet"}) {
    const std::string file = scratch / name;
    ASSERT_EQ(runKirireel({"convert", kSlots, file}).exitCode, 0);
    std::vector<std::string> options;
    if (name == "sheet") options = {"--unit", "mm"};
    EXPECT_EQ(necksOf(file, options), drawn) << name;
  }
}

TEST(ProgramDrawings, GiveTheirNecksToRunsAndDecks) {
  const TemporaryFolder scratch;
  const std::string run = scratch / "run", scene = scratch / "scene.toml";
  writeText(scene,
            "[model]\nunit = \"mm\"\nhinge_neck = \"2e9\"\nligaments = true\n"
            "[[grip]]\ntiles = [0, 1, 2, 3]\nmove = {x = 0}\n"
            "[[grip]]\ntile = 0\nmove = {y = 0}\n"
            "[[grip]]\ntiles = [12, 13, 14, 15]\nmove = {x = 4}\n");
  const ProgramEnd load = runKirireel({"simulate", kSlots, "--scene", scene, "--out", run});
  // Without contacts the pulled tiles overlap by 0.12 tile, which a run reports.
  ASSERT_EQ(load.exitCode, 3) << load.err;
  EXPECT_THAT(readTextFile(run + "/load_curve.csv", ""), HasSubstr("grip_3_x_force_N"));
  if (!test::hasProgram("gmsh")) GTEST_SKIP() << "install gmsh to make decks with necks";
  const ProgramEnd deck = runKirireel(
      {"export", run, "--format", "inp", "--joints", "neck", "--plane-stress", "--linear"});
  ASSERT_EQ(deck.exitCode, 0) << deck.err;
  // Half a kerf of each neck is removed material.
  EXPECT_THAT(readTextFile(run + "/sheet_mesh.inp", ""),
              HasSubstr("in one piece: necks 0.001 m wide and 0.0003 m long, fillets of "
                        "0. m,\n** kerf 0.0003 m.\n"));
}

TEST(ProgramDrawings, WithoutNecksNameTheOptions) {
  const TemporaryFolder scratch;
  EXPECT_EQ(
      runKirireel({"simulate", shippedModel("tessellation_4x4").string(), "--hinge-neck", "2e9",
                   "--out", scratch / "run"})
          .err,
      "kirireel: error: --hinge-neck has only a material, but the model has no neck at the joint "
      "between tiles 0 and 4. Give width, length and Young's modulus, for example 0.1,0.3,2e9\n");
}

TEST(ProgramDrawings, GoToTheirSecondCompactState) {
  const TemporaryFolder scratch;
  for (const char* name : {"squares_slots.svg", "disk_slits.svg", "fan_slits.dxf"}) {
    const ProgramEnd end =
        runKirireel({"simulate", std::string(KIRIREEL_SOURCE_DIR "/docs/drawings/") + name, "--to",
                     "closed", "--out", scratch / name});
    EXPECT_EQ(end.exitCode, 0) << end.err;
    EXPECT_THAT(end.out, HasSubstr("the path ends when the tiles meet again: ")) << name;
  }
}

}  // namespace
}  // namespace kirireel
