#include "render/sweep/sweep_plan.h"

#include <limits>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kirireel {
namespace {

using ::testing::ElementsAre;

sweep::SweepAxis axis(const std::string& key, const std::vector<std::string>& texts) {
  sweep::SweepAxis made{key, {}, {}};
  for (const std::string& text : texts) made.values.push_back({text, false, {}});
  return made;
}

std::vector<std::string> texts(const sweep::SweepPlan& plan, std::uint64_t run) {
  std::vector<std::string> found;
  for (const sweep::SweepValue& value : plan.run(run)) found.push_back(value.text);
  return found;
}

TEST(Grid, HasEveryCombinationSortedByNumbers) {
  const sweep::SweepPlan plan =
      sweep::SweepPlan::grid({axis("a", {"10", "9"}), axis("b", {"x", "1e1", "2"})});
  ASSERT_EQ(plan.size(), 6U);
  EXPECT_THAT(plan.keys(), ElementsAre("a", "b"));
  EXPECT_THAT(texts(plan, 0), ElementsAre("9", "2"));
  EXPECT_THAT(texts(plan, 2), ElementsAre("9", "x"));
  EXPECT_THAT(texts(plan, 5), ElementsAre("10", "x"));
}

TEST(Grid, CountsRepeatedValuesOnce) {
  EXPECT_EQ(sweep::SweepPlan::grid({axis("a", {"1", "2", "1"})}).size(), 2U);
}

TEST(Grid, ThatIsTooLargeToCountIsReported) {
  const std::vector<std::string> ten = {"0", "1", "2", "3", "4", "5", "6", "7", "8", "9"};
  const std::vector<sweep::SweepAxis> axes(21, axis("a", ten));
  const sweep::SweepPlan plan = sweep::SweepPlan::grid(axes);
  EXPECT_EQ(plan.size(), std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(texts(plan, 12).back(), "2");
}

TEST(List, TakesValuesPlaceByPlace) {
  const sweep::SweepPlan plan =
      sweep::SweepPlan::list({axis("a", {"2", "1", "2"}), axis("b", {"5", "6", "5"})});
  ASSERT_EQ(plan.size(), 2U);
  EXPECT_THAT(texts(plan, 0), ElementsAre("1", "6"));
  EXPECT_THAT(texts(plan, 1), ElementsAre("2", "5"));
}

TEST(LatinHypercube, HasOneValueInEachPartOfEachRange) {
  const sweep::SweepRange linear{0, 50, false, false};
  const sweep::SweepRange logarithmic{1, 1e5, true, false};
  const sweep::SweepPlan plan =
      sweep::SweepPlan::latinHypercube({{"a", {}, linear}, {"b", {}, logarithmic}}, 50, 7);
  ASSERT_EQ(plan.size(), 50U);
  std::set<int> partsOfA;
  std::set<int> partsOfB;
  for (std::uint64_t run = 0; run < 50; ++run) {
    partsOfA.insert(static_cast<int>(std::stod(texts(plan, run)[0])));
    partsOfB.insert(static_cast<int>(10 * std::log10(std::stod(texts(plan, run)[1]))));
  }
  EXPECT_EQ(partsOfA.size(), 50U);
  EXPECT_EQ(partsOfB.size(), 50U);
}

TEST(LatinHypercube, DependsOnlyOnItsSeed) {
  const auto first = [](std::uint64_t seed) {
    return texts(sweep::SweepPlan::latinHypercube({{"a", {}, {0, 1, false, false}}}, 3, seed), 0);
  };
  EXPECT_EQ(first(1), first(1));
  EXPECT_NE(first(1), first(2));
}

TEST(Range, RoundsToWholeNumbersOnRequest) {
  EXPECT_EQ((sweep::SweepRange{0, 10, false, true}.at(0.26)), "3");
  EXPECT_EQ((sweep::SweepRange{1, 100, true, false}.at(0.5)), "10");
}

}  // namespace
}  // namespace kirireel
