// `kirireel study` through the real program.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/cli/run_program.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;

TEST(ProgramStudy, ListsTheStudies) {
  const ProgramEnd end = runKirireel({"study", "--list"});
  EXPECT_EQ(end.exitCode, 0) << end.err;
  EXPECT_THAT(end.out, HasSubstr("scaling         cost and memory of a step"));
  EXPECT_THAT(end.out, HasSubstr("all             these one after the other"));
}

TEST(ProgramStudy, SuggestsTheNearestName) {
  const ProgramEnd end = runKirireel({"study", "tesselation"});
  EXPECT_EQ(end.exitCode, 2);
  EXPECT_THAT(end.err, HasSubstr("no study tesselation, did you mean tessellation?"));
}

TEST(ProgramStudy, NeedsAName) {
  const ProgramEnd end = runKirireel({"study"});
  EXPECT_EQ(end.exitCode, 2);
  EXPECT_THAT(end.err, HasSubstr("NAME"));
}

TEST(ProgramStudy, RefusesToResumeOtherFiles) {
  const TemporaryFolder scratch;
  writeText(scratch / "scaling.csv", "case,tiles\na,1,2\n");
  const ProgramEnd end =
      runKirireel({"study", "scaling", "--quick", "--resume", "--out", scratch.path().string()});
  EXPECT_EQ(end.exitCode, 2);
  EXPECT_THAT(end.err, HasSubstr("scaling.csv:2: error: 3 cells, but the table has 2 columns"));
}

}  // namespace
}  // namespace kirireel
