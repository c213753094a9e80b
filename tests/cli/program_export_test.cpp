// `kirireel export`, and its files in other programs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/cli/run_program.h"

namespace kirireel {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

/// A simulated tessellation to export from.
class ProgramExport : public testing::Test {
 protected:
  ProgramExport() {
    const ProgramEnd end = runKirireel({"simulate", shippedModel("tessellation_4x4").string(),
                                        "--out", run().string(), "--duration", "1", "--fps", "10"});
    EXPECT_EQ(end.exitCode, 0) << end.err;
  }

  std::filesystem::path run() const { return scratch_ / "run"; }
  std::filesystem::path out() const { return scratch_ / "out"; }

  ProgramEnd exported(std::vector<std::string> options) const {
    options.insert(options.begin(), {"export", run().string(), "--out", out().string()});
    return runKirireel(options);
  }

  TemporaryFolder scratch_;
};

TEST_F(ProgramExport, WritesStatesAndPrintsTheirNames) {
  const ProgramEnd end = exported({"--format", "obj,vertices", "--states", "0%,50%"});
  EXPECT_EQ(end.exitCode, 0) << end.err;
  EXPECT_THAT(filesIn(out()),
              ElementsAre("contents.json", "state_0pct.obj", "state_0pct_vertices.txt",
                          "state_50pct.obj", "state_50pct_vertices.txt"));
  EXPECT_THAT(end.out, HasSubstr("state_50pct.obj\n"));
}

TEST_F(ProgramExport, ReportsWhatIsWrongInOneLine) {
  const auto complaint = [&](const std::vector<std::string>& options) {
    const ProgramEnd end = exported(options);
    EXPECT_EQ(end.exitCode, 2);
    return end.err;
  };
  EXPECT_EQ(complaint({"--format", "obj", "--states", "9"}),
            "kirireel: error: state '9' is not in the trajectory; it goes from 0 to 1 s\n");
  EXPECT_THAT(complaint({"--format", "obj,igs"}),
              HasSubstr("--format: 'igs' is not allowed; give obj, ply, stl,"));
  EXPECT_EQ(complaint({}),
            "kirireel: error: --format is missing, as in kirireel export TRAJECTORY --format "
            "obj,inp; see kirireel export --help\n");
  EXPECT_THAT(complaint({"--format", "obj", "--states", "0,half"}),
              HasSubstr("error: 'half' is not a state; use initial,"));
  EXPECT_THAT(complaint({"--format", "inp", "--joints", "patch", "--elements-per-edge", "4",
                         "--patch-radius", "0.01"}),
              HasSubstr("use 50 elements per edge or a larger radius"));
  EXPECT_THAT(complaint({"--format", "inp", "--joints", "neck"}),
              HasSubstr("necks cannot be 0 m wide; give a positive --neck-width"));
  EXPECT_THAT(complaint({"--format", "inp", "--joints", "neck", "--neck-width", "3"}),
              HasSubstr("a --neck-width of 0.99 m does"));
  EXPECT_THAT(complaint({"--format", "inp", "--drive", "99"}),
              HasSubstr("--drive names tile 99, but the model has tiles 0 to 15"));
  EXPECT_THAT(filesIn(out()), ElementsAre());
}

TEST_F(ProgramExport, IsPartOfARun) {
  const ProgramEnd end =
      runKirireel({"simulate", shippedModel("tessellation_4x4").string(), "--out", out().string(),
                   "--duration", "0.5", "--fps", "10", "--export", "stl,svg", "--states", "100%"});
  EXPECT_EQ(end.exitCode, 0) << end.err;
  EXPECT_THAT(filesIn(out()), ElementsAre("cut_pattern.svg", "final_vertices.txt",
                                          "state_100pct.stl", "summary.json", "trajectory.h5"));
  EXPECT_THAT(readText(out() / "summary.json"), HasSubstr("\"state_100pct.stl\""));
}

TEST(ProgramRun, RefusesExportsThatTheModelCannotHaveBeforeItStarts) {
  const TemporaryFolder scratch;
  for (const char* command : {"simulate", "record"}) {
    const ProgramEnd end = runKirireel({command, shippedModel("cylinder").string(), "--out",
                                        scratch.path().string(), "--export", "obj,dxf"});
    EXPECT_EQ(end.exitCode, 2);
    EXPECT_EQ(end.err,
              "kirireel: error: the start is not flat: tile 18 reaches 3.46 m out of the plane of "
              "tile 0; only planar models have a cut pattern\n");
    EXPECT_THAT(filesIn(scratch.path()), ElementsAre());
  }
  const ProgramEnd patches = runKirireel({"simulate", shippedModel("tessellation_4x4").string(),
                                          "--out", scratch.path().string(), "--export", "inp",
                                          "--joints", "patch", "--patch-radius", "5"});
  EXPECT_EQ(patches.exitCode, 2);
  EXPECT_THAT(patches.err, HasSubstr("error: joint patches of radius 5 m overlap on tile 0"));
  EXPECT_THAT(filesIn(scratch.path()), ElementsAre());
}

TEST(ProgramRun, CompletesWithoutARequestedState) {
  const TemporaryFolder scratch;
  const ProgramEnd end =
      runKirireel({"simulate", shippedModel("tessellation_4x4").string(), "--out",
                   scratch.path().string(), "--export", "obj", "--states", "30s"});
  EXPECT_EQ(end.exitCode, 0);
  EXPECT_THAT(end.err,
              testing::StartsWith("kirireel: warning: nothing was exported: error: state '30s' is "
                                  "not in the trajectory; it goes from 0 to "));
  EXPECT_THAT(readText(scratch / "summary.json"), HasSubstr("\"left_out\": \"error: state '30s'"));
  EXPECT_THAT(filesIn(scratch.path()),
              ElementsAre("final_vertices.txt", "summary.json", "trajectory.h5"));
  EXPECT_EQ(runKirireel({"verify", scratch.path().string()}).exitCode, 0);
}

TEST_F(ProgramExport, NamesAMissingTrajectory) {
  const ProgramEnd end =
      runKirireel({"export", (scratch_ / "none.h5").string(), "--format", "obj"});
  EXPECT_EQ(end.exitCode, 2);
  EXPECT_THAT(end.err, HasSubstr("none.h5: error: "));
}

}  // namespace
}  // namespace kirireel
