// scripts/plot-sweep on tables of sweeps.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/cli/run_program.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kScript = KIRIREEL_SOURCE_DIR "/scripts/plot-sweep";

constexpr const char* kTwoByTwo =
    "run,rows,thickness,path,end_time\n"
    "a,1,0.01,straight,1.5\nb,1,0.02,straight,2.5\nc,2,0.01,straight,3.5\nd,2,0.02,straight,\n";

class PlotSweep : public testing::Test {
 protected:
  ProgramEnd plot(const std::string& table, const std::vector<std::string>& options = {}) {
    writeText(folder_ / "table.csv", table);
    std::vector<std::string> arguments = {(folder_ / "table.csv").string()};
    const std::vector<std::string> columns = {
        "--x", "thickness", "--y", "rows", "--measure", "end_time", "--out", picture().string()};
    arguments.insert(arguments.end(), columns.begin(), columns.end());
    arguments.insert(arguments.end(), options.begin(), options.end());
    return runTool(kScript, arguments);
  }

  std::filesystem::path picture() const { return folder_ / "plot.svg"; }

  const TemporaryFolder folder_;
};

TEST_F(PlotSweep, FullGridsAreCellsAndOthersDots) {
  ProgramEnd end = plot(kTwoByTwo + std::string("e,2,0.02,guided,4.5\n"), {"--log", "x,measure"});
  EXPECT_EQ(end.exitCode, 0) << end.err;
  EXPECT_THAT(readText(picture()), HasSubstr("id=\"QuadMesh_1\""));
  end = plot(kTwoByTwo);
  EXPECT_EQ(end.exitCode, 0) << end.err;
  EXPECT_THAT(readText(picture()), Not(HasSubstr("id=\"QuadMesh_1\"")));
  EXPECT_THAT(readText(picture()), HasSubstr("id=\"PathCollection_1\""));
}

TEST_F(PlotSweep, RunsWithTheSameParametersNeedASelection) {
  const std::string table = kTwoByTwo + std::string("e,1,0.010,guided,4.5\n");
  EXPECT_EQ(plot(table).err,
            "plot-sweep: several runs have thickness 0.01 and rows 1; choose among them with "
            "--where PARAMETER=VALUE\n");
  EXPECT_EQ(plot(table, {"--where", "path=straight", "--where", "rows=1.0"}).exitCode, 0);
  EXPECT_THAT(plot(table, {"--where", "path"}).err, HasSubstr("path is not PARAMETER=VALUE"));
}

TEST_F(PlotSweep, ReportsWhatIsMissing) {
  EXPECT_THAT(plot("run,rows,end_time\n").err,
              HasSubstr("has no column thickness; there are run, rows, end_time"));
  EXPECT_EQ(plot("run,rows,thickness,end_time\na,1,0.1,\n").err,
            "plot-sweep: no run has numbers in thickness, rows, end_time\n");
  EXPECT_EQ(plot("run,rows,thickness,end_time\na,1,0,3\n", {"--log", "x"}).err,
            "plot-sweep: x has values <= 0; remove it from --log\n");
  const ProgramEnd end = runTool(kScript, {"none.csv", "--x", "a", "--y", "b", "--measure", "c"});
  EXPECT_THAT(end.err, HasSubstr("none.csv: No such file or directory; give the table of a sweep"));
}

}  // namespace
}  // namespace kirireel
