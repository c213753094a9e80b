// Decks of end states, run by CalculiX as they are: skipped where ccx is not installed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/cli/run_program.h"
#include "tests/support/program.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

void expectDecksToRun(const std::filesystem::path& model) {
  const ScratchFolder scratch;
  const std::string out = scratch.path().string();
  runKirireel({"simulate", model.string(), "--out", out, "--fps", "10", "--duration", "5", "--path",
               "straight"});
  for (const char* perEdge : {"1", "2"}) {
    const ProgramEnd end = runKirireel(
        {"export", out, "--format", "inp", "--states", "final", "--elements-per-edge", perEdge});
    ASSERT_EQ(end.exitCode, 0) << end.err;
    const std::string said =
        test::outputOf("cd '" + out +
                       "' && for job in state_*_job.inp; do OMP_NUM_THREADS=1 ccx -i ${job%.inp}; "
                       "done");
    EXPECT_THAT(said, HasSubstr("Job finished")) << perEdge;
    EXPECT_THAT(said, Not(HasSubstr("WARNING"))) << perEdge;
    EXPECT_THAT(said, Not(HasSubstr("ERROR"))) << perEdge;
  }
}

class ShippedEndStates : public testing::TestWithParam<const char*> {};

TEST_P(ShippedEndStates, RunInCalculix) {
  if (!test::hasProgram("ccx")) GTEST_SKIP() << "install calculix-ccx to judge decks by it";
  expectDecksToRun(shippedModel(GetParam()));
}

INSTANTIATE_TEST_SUITE_P(Command, ShippedEndStates,
                         testing::Values("tessellation_4x4", "cap", "cylinder", "moebius",
                                         "hexagons", "penrose_expanded"));

TEST(ProgramDeck, KeepsTheLimitsOfItsReaders) {
  const ScratchFolder scratch;
  const std::string out = scratch.path().string();
  runKirireel({"simulate", shippedModel("hexagons").string(), "--out", out, "--fps", "10",
               "--export", "inp", "--joints", "equation", "--quadratic"});
  // CalculiX and Abaqus read 20 characters of a number and 256 of a line, without a word.
  const std::string limits =
      "!/^\\*/ { n = split($0, words, \",\"); for (k = 1; k <= n; k++) { gsub(/ /, \"\", "
      "words[k]); "
      "if (length(words[k]) > 20) bad++; numbers++ } } "
      "length($0) > 256 { bad++ } END { print bad + 0, (numbers > 1000) }";
  EXPECT_EQ(test::outputOf("awk '" + limits + "' '" + out + "'/*.inp"), "0 1\n");
}

class PublishedEndStates : public testing::TestWithParam<const char*> {};

TEST_P(PublishedEndStates, RunInCalculix) {
  if (!test::hasProgram("ccx")) GTEST_SKIP() << "install calculix-ccx to judge decks by it";
  const auto folder =
      std::filesystem::path(KIRIREEL_SOURCE_DIR).parent_path() / "shared/models" / GetParam();
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  expectDecksToRun(folder);
}

INSTANTIATE_TEST_SUITE_P(Command, PublishedEndStates,
                         testing::Values("cylinder", "partialSphere", "mobius", "square2disk",
                                         "tess_m10_n10", "sphere-to-saddle"));

}  // namespace
}  // namespace kirireel
