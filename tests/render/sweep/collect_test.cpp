#include "render/sweep/collect.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/trajectory/array_file.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

using ::testing::ElementsAre;

class CollectTest : public testing::Test {
 protected:
  void finish(const std::string& name, const std::string& summary, const std::string& reason = "") {
    std::optional<sweep::RunClaim> claim = sweep::RunClaim::take(folder_.path(), name, false);
    if (!summary.empty()) std::ofstream(claim->folder() / "summary.json") << summary;
    claim->finish({!reason.empty(), reason, {}});
  }

  /// Runs a, b and c with k = 1, 2 and 3.
  sweep::Gathered gatherThree() const {
    return sweep::gather(
        {folder_.path(),
         3,
         {"k"},
         [](std::uint64_t index) { return std::string(1, "abc"[index]); },
         [](std::uint64_t index) { return std::vector<std::string>{std::to_string(index + 1)}; }});
  }

  const test::TemporaryFolder folder_;
};

constexpr const char* kSummary =
    "{\"settings\": {\"model\": {\"thickness\": 0.3}}, \"outcome\": \"settled\", \"accuracy\": "
    "{\"joint_gap_max\": 0.5, \"rigid_bound\": null},"
    " \"cost\": {\"steps\": 7, \"wall_seconds\": 1.5}}";

TEST_F(CollectTest, ListsFailedRunsNextToDoneOnes) {
  finish("c", kSummary);
  finish("a", "", "no such \"sheet\", sorry");
  const sweep::Gathered gathered = gatherThree();
  EXPECT_EQ(gathered.failed, 1U);
  EXPECT_EQ(gathered.missing, 1U);
  ASSERT_EQ(gathered.runs.size(), 2U);
  EXPECT_TRUE(gathered.runs[0].failed);
  EXPECT_EQ(gathered.runs[1].name, "c");
  EXPECT_THAT(gathered.runs[1].values, ElementsAre("3"));
  EXPECT_EQ(gathered.runs[1].thickness, 0.3);
  EXPECT_EQ(sweep::csvText(gathered.results),
            "run,k,status,reason,outcome,end_time,tile_count,joint_count,path_kind,joint_gap_max,"
            "rigid_bound,steps,halved_steps,unconverged_steps\n"
            "a,1,failed,\"no such \"\"sheet\"\", sorry\",,,,,,,,,,\n"
            "c,3,done,,settled,,,,,0.5,,7,,\n");
  EXPECT_EQ(sweep::csvText(gathered.costs),
            "run,cpu_seconds_search,cpu_seconds_deploy,cpu_seconds_render,cpu_seconds_encode,"
            "wall_seconds,peak_memory_bytes\n"
            "c,,,,,1.5,\n");
}

TEST_F(CollectTest, TablesOfFailedRunsHaveNoMeasures) {
  finish("a", "", "no such sheet");
  const sweep::Gathered gathered = gatherThree();
  EXPECT_EQ(sweep::csvText(gathered.results), "run,k,status,reason\na,1,failed,no such sheet\n");
}

TEST_F(CollectTest, ArraysHoldNumbersAndTexts) {
  finish("a", "", "no such sheet");
  finish("c", kSummary);
  const std::filesystem::path file = folder_ / "table.h5";
  sweep::writeTableArrays(gatherThree().results, file);
  const trajectory::ArrayReader reader(file);
  EXPECT_THAT(reader.doubles("k"), ElementsAre(1, 3));
  EXPECT_THAT(reader.texts("status"), ElementsAre("failed", "done"));
  EXPECT_TRUE(std::isnan(reader.doubles("joint_gap_max")[0]));
  EXPECT_EQ(reader.doubles("joint_gap_max")[1], 0.5);
  EXPECT_THAT(reader.textAttribute("/", "columns"), testing::StartsWith("run,k,status,reason"));
}

TEST_F(CollectTest, ReportsWhichSummaryIsDamaged) {
  finish("b", "{");
  EXPECT_THAT([&] { gatherThree(); },
              testing::ThrowsMessage<InputError>(
                  testing::EndsWith("b/summary.json: error: this is not the summary of a run; "
                                    "remove its folder to run it again")));
}

}  // namespace
}  // namespace kirireel
