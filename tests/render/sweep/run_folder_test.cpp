#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/sweep/collect.h"
#include "sim/base/error.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

class RunFolderTest : public testing::Test {
 protected:
  std::optional<sweep::RunClaim> take(bool retryFailed = false) const {
    return sweep::RunClaim::take(folder_.path(), "abc", retryFailed);
  }
  std::filesystem::path finished() const { return folder_ / "abc"; }

  const test::TemporaryFolder folder_;
};

TEST_F(RunFolderTest, IsFinishedIfItIsComplete) {
  std::optional<sweep::RunClaim> claim = take();
  ASSERT_TRUE(claim);
  std::ofstream(claim->folder() / "summary.json") << "{}";
  EXPECT_FALSE(std::filesystem::exists(finished()));
  claim->finish({false, "", {{"columns", "4"}}});
  const auto record = sweep::readRunRecord(finished());
  ASSERT_TRUE(record);
  EXPECT_FALSE(record->failed);
  EXPECT_EQ(record->inputs.at(0).second, "4");
  EXPECT_TRUE(std::filesystem::exists(finished() / "summary.json"));
  EXPECT_FALSE(std::filesystem::exists(finished() / "lock"));
  EXPECT_FALSE(take());
}

TEST_F(RunFolderTest, BelongsToOneAtATime) {
  const std::optional<sweep::RunClaim> claim = take();
  ASSERT_TRUE(claim);
  EXPECT_FALSE(take());
}

TEST_F(RunFolderTest, LeftoversOfAKilledRunAreCleared) {
  {
    const std::optional<sweep::RunClaim> killed = take();
    std::ofstream(killed->folder() / "half.txt") << "half";
  }
  const std::optional<sweep::RunClaim> claim = take();
  ASSERT_TRUE(claim);
  EXPECT_FALSE(std::filesystem::exists(claim->folder() / "half.txt"));
}

TEST_F(RunFolderTest, ClearedRunKeepsItsRecord) {
  std::optional<sweep::RunClaim> claim = take();
  std::ofstream(claim->folder() / "half.txt") << "half";
  claim->clear();
  claim->finish({true, "no room", {}});
  EXPECT_FALSE(std::filesystem::exists(finished() / "half.txt"));
  EXPECT_EQ(sweep::readRunRecord(finished())->reason, "no room");
}

TEST_F(RunFolderTest, FailedRunsAreRepeatedOnRequest) {
  take()->finish({true, "no such sheet", {}});
  EXPECT_FALSE(take());
  std::optional<sweep::RunClaim> again = take(true);
  ASSERT_TRUE(again);
  EXPECT_EQ(sweep::readRunRecord(finished())->reason, "no such sheet");
  again->finish({false, "", {}});
  EXPECT_FALSE(sweep::readRunRecord(finished())->failed);
  EXPECT_FALSE(take(true));
}

TEST_F(RunFolderTest, ReportsWhenARecordIsDamaged) {
  std::filesystem::create_directory(finished());
  std::ofstream(finished() / "run.json") << "{";
  EXPECT_THAT([&] { take(); }, testing::ThrowsMessage<InputError>(testing::EndsWith(
                                   "abc/run.json: error: this is not the record of a run; remove "
                                   "its folder to run it again")));
}

}  // namespace
}  // namespace kirireel
