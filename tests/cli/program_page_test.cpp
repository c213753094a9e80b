// `kirireel page` for users. Tests of its pages in browsers are in tests/page.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/cli/run_program.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr int kInputWrong = 2;

class PageCommand : public testing::Test {
 protected:
  void SetUp() override {
    const ProgramEnd end = runKirireel(
        {"simulate", shippedModel("tessellation_4x4").string(), "--out", run().string()});
    ASSERT_EQ(end.exitCode, 0) << end.err;
  }

  std::filesystem::path run() const { return scratch_.path() / "run"; }

  TemporaryFolder scratch_;
};

TEST_F(PageCommand, WritesAPageThatVerifies) {
  const ProgramEnd end = runKirireel({"page", run().string()});
  ASSERT_EQ(end.exitCode, 0) << end.err;
  EXPECT_THAT(end.out, StartsWith((run() / "page.html").string() + ": "));
  EXPECT_THAT(readText(run() / "page.html"), StartsWith("<!DOCTYPE html>"));
  EXPECT_EQ(runKirireel({"verify", run().string()}).exitCode, 0);
}

TEST_F(PageCommand, IsAlsoWrittenByARun) {
  const std::filesystem::path other = scratch_.path() / "other";
  const ProgramEnd end = runKirireel(
      {"simulate", shippedModel("tessellation_4x4").string(), "--out", other.string(), "--page"});
  ASSERT_EQ(end.exitCode, 0) << end.err;
  runKirireel({"page", run().string()});
  EXPECT_EQ(readText(other / "page.html"), readText(run() / "page.html"));
}

TEST_F(PageCommand, ReportsWhatIsMissing) {
  std::filesystem::remove(run() / "trajectory.h5");
  const ProgramEnd end = runKirireel({"page", run().string()});
  EXPECT_EQ(end.exitCode, kInputWrong);
  EXPECT_EQ(end.err, "kirireel: " + (run() / "trajectory.h5").string() +
                         ": error: there is no such file. Give a trajectory.h5 from kirireel "
                         "record\n");
  EXPECT_THAT(runKirireel({"page"}).err, HasSubstr("RUN is missing, as in kirireel page RUN"));
}

TEST_F(PageCommand, RefusesWhatItCannotShow) {
  const std::string name = run().string();
  EXPECT_THAT(runKirireel({"page", name, name, name}).err,
              HasSubstr("3 runs are given, but a page shows at most 2"));
  EXPECT_THAT(runKirireel({"page", name, "--most-size", "0.5"}).err,
              HasSubstr("MB and may have 0.5; give a larger --most-size"));
  EXPECT_THAT(runKirireel({"page", name, "--samples", "1"}).err,
              HasSubstr("--samples: '1' is not allowed; give a whole number from 2 to 1e+06"));
  EXPECT_FALSE(std::filesystem::exists(run() / "page.html"));
}

TEST_F(PageCommand, TablesAndPlotsCurves) {
  const ProgramEnd end =
      runKirireel({"curves", run().string(), "--plot", "svg,png,pdf", "--against", "opening"});
  ASSERT_EQ(end.exitCode, 0) << end.err;
  EXPECT_THAT(end.out, HasSubstr((run() / "curves.pdf").string()));
  EXPECT_THAT(readText(run() / "curves.csv"), StartsWith("time_s,progress,width_m,height_m,"));
  EXPECT_THAT(readText(run() / "curves.svg"), HasSubstr(">mean opening, degrees<"));
  EXPECT_EQ(runKirireel({"verify", run().string()}).exitCode, 0);
}

TEST_F(PageCommand, KeepsForeignFiles) {
  writeText(run() / "page.html", "mine");
  EXPECT_EQ(runKirireel({"page", run().string()}).exitCode, kInputWrong);
  EXPECT_EQ(readText(run() / "page.html"), "mine");
}

}  // namespace
}  // namespace kirireel
