// Reports about unreachable targets, and about moved starts.
#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "sim/formats/read_model.h"
#include "sim/generate/lattice.h"
#include "tests/cli/run_program.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::Not;

class Targets : public testing::Test {
 protected:
  ProgramEnd simulate(const model::Model& model, std::vector<std::string> options) {
    formats::writeModelFolder(model, scratch_ / "model");
    options.insert(options.begin(), {"simulate", (scratch_ / "model").string(), "--out",
                                     (scratch_ / "out").string()});
    const ProgramEnd end = runKirireel(options);
    summary_ = nlohmann::json::parse(readText(scratch_ / "out/summary.json"));
    return end;
  }

  TemporaryFolder scratch_;
  nlohmann::json summary_;
};

TEST_F(Targets, ATargetWithOpenJointsIsReportedAsNotReached) {
  model::Model model = generate::makeTessellation({});
  for (int i = 8; i < 16; ++i) {
    for (Vector3& vertex : (*model.target)[i].vertices) vertex.x() += 1;
  }
  const ProgramEnd end = simulate(model, {"--verbose"});
  EXPECT_NE(end.exitCode, 0);
  EXPECT_THAT(end.err, HasSubstr("model: warning: the target opens its joints by 1 m (1 tiles); "
                                 "closed joints cannot reach it"));
  EXPECT_THAT(end.out, HasSubstr("locked after "));
  EXPECT_THAT(end.out, HasSubstr("warning: the target opens its joints"));
  EXPECT_THAT(end.out, HasSubstr("bounds: rigid tiles cannot come nearer than "));
  EXPECT_THAT(end.out, HasSubstr("; nearest state found with closed joints 0.5"));
  ASSERT_EQ(summary_["warnings"].size(), 2u);
  EXPECT_EQ(summary_["warnings"][0].get<std::string>().substr(0, 27),
            "the target opens its joints");
}

TEST_F(Targets, AMissedOneIsReportedInSixLines) {
  model::Model model = generate::makeTessellation({});
  for (int i = 8; i < 16; ++i) {
    for (Vector3& vertex : (*model.target)[i].vertices) vertex.x() += 1;
  }
  const ProgramEnd end = simulate(model, {});
  EXPECT_EQ(end.exitCode, kEndedShort);
  EXPECT_EQ(end.err, "");
  EXPECT_THAT(end.out,
              MatchesRegex("model: the path ends 0.5[0-9]* m short of the target: .*; exit code 3\n"
                           "(.*\n)*.*; 2 warnings: --verbose\n"));
  EXPECT_LE(std::ranges::count(end.out, '\n'), 6);
  const ProgramEnd late = simulate(model, {"--path", "dynamic", "--duration", "0.1"});
  EXPECT_THAT(late.out,
              MatchesRegex("model: still moving after 0.1 s, at [0-9.]+ m/s at most, [0-9.]+ m "
                           "from the target; exit code 3\n(.*\n)*"));
}

TEST_F(Targets, OnlyKnownErrorsInTimeAreReported) {
  const model::Model model = generate::makeTessellation({});
  const ProgramEnd guided =
      simulate(model, {"--path", "guided", "--damping-ratio", "0", "--verbose"});
  EXPECT_THAT(
      guided.out,
      HasSubstr(
          "time: critically damped springs guide the tiles in fixed steps, without a tolerance\n"));
  const ProgramEnd dynamic = simulate(model, {"--path", "dynamic", "--verbose"});
  EXPECT_THAT(dynamic.out, HasSubstr("time: tolerance 0.001 tiles per step"));
  EXPECT_THAT(dynamic.out, HasSubstr("the error of the run is not known (--measure-time-error)"));
  EXPECT_THAT(dynamic.out, Not(HasSubstr("within")));
  EXPECT_TRUE(summary_["accuracy"]["time_error"].is_null());
  const ProgramEnd measured =
      simulate(model, {"--path", "dynamic", "--measure-time-error", "--verbose"});
  EXPECT_THAT(measured.out, HasSubstr("; a hundredth of it moves vertices by at most "));
  EXPECT_GT(summary_["accuracy"]["time_error"].get<double>(), 0);
}

TEST_F(Targets, AMovedTargetIsReported) {
  model::Model model = generate::makeTessellation({});
  for (model::Tile& tile : model.tiles) {
    for (Vector3& vertex : tile.vertices) vertex.z() += 1;
  }
  const ProgramEnd moved = simulate(model, {"--duration", "0.1", "--verbose"});
  EXPECT_THAT(moved.out, HasSubstr("the target was moved by up to "));
  EXPECT_GE(summary_["alignment"]["moved"].get<double>(), 1);
  EXPECT_EQ(summary_["alignment"]["by"], "all tiles");
  const ProgramEnd kept = simulate(model, {"--duration", "0.1", "--no-align", "--verbose"});
  EXPECT_THAT(kept.out, Not(HasSubstr("the target was moved")));
  EXPECT_TRUE(summary_["alignment"].is_null());
}

TEST_F(Targets, PinnedTilesDefineTheMoveOfAStart) {
  // An alignment by all tiles would keep the pinned one 45 degrees from its target.
  const ProgramEnd end = simulate(generate::makeTessellation({}), {"--pin", "0"});
  EXPECT_EQ(end.exitCode, 0) << end.out;
  EXPECT_EQ(summary_["outcome"], "settled");
  EXPECT_LT(summary_["accuracy"]["target_error_end"].get<double>(), 1e-6);  // measured
  EXPECT_EQ(summary_["alignment"]["by"], "pinned tiles");
}

}  // namespace
}  // namespace kirireel
