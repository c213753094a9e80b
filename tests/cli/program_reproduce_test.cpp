// scripts/reproduce on the shipped models.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/cli/run_program.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

ProgramEnd runReproduce(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {KIRIREEL_SOURCE_DIR "/scripts/reproduce"});
  return runTool("python3", arguments);
}

TEST(Reproduce, LeavesAVideoARowAndATable) {
  const TemporaryFolder scratch;
  const ProgramEnd end =
      runReproduce({"--rows", "quad_tessellation", "demo_nonrigid", "--program", KIRIREEL_PROGRAM,
                    "--out", scratch.path().string(), "--", "--size", "160x120", "--fps", "10"});
  ASSERT_EQ(end.exitCode, 0) << end.err;
  for (const char* row : {"quad_tessellation", "demo_nonrigid"}) {
    EXPECT_GT(std::filesystem::file_size(scratch / row / "deployment.mp4"), 1000u) << row;
  }
  EXPECT_THAT(readText(scratch / "table.csv"),
              StartsWith("row,outcome,error_end,assembled_error,joint_gap,joint_opening,"
                         "penetration,cpu_seconds\nquad_tessellation,settled,"));
  EXPECT_THAT(end.out, HasSubstr("\n| demo_nonrigid | settled | "));
}

TEST(Reproduce, TablesThePeersFiguresBesidePublishedModels) {
  const TemporaryFolder scratch;
  std::filesystem::copy(shippedModel("quad_tessellation"), scratch / "fan");
  const ProgramEnd end = runReproduce(
      {scratch.path().string(), "--rows", "fan", "cylinder", "--program", KIRIREEL_PROGRAM, "--out",
       (scratch / "out").string(), "--", "--size", "160x120", "--fps", "10"});
  EXPECT_EQ(end.exitCode, 1);  // a model is missing
  EXPECT_THAT(end.err, HasSubstr("reproduce: cylinder: there is no "));
  EXPECT_THAT(end.out, HasSubstr(" | - | 0.0064 | 0.0025 | 85.4 |\n"));
}

TEST(Reproduce, ListsThePapersCommandLines) {
  const ProgramEnd end = runReproduce({"models", "--list"});
  EXPECT_EQ(end.exitCode, 0);
  EXPECT_EQ(std::count(end.out.begin(), end.out.end(), '\n'), 13);
  EXPECT_THAT(end.out, HasSubstr("record --model models/sphere-to-saddle --brick_thickness 0.001 "
                                 "--auto_detect_connections --out out/reproduce/sphere_to_saddle"));
}

}  // namespace
}  // namespace kirireel
