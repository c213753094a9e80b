#include "sim/base/disjoint_sets.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kirireel {
namespace {

using ::testing::ElementsAre;

TEST(DisjointSets, AreNumberedByTheirLowestElements) {
  DisjointSets sets(6);
  EXPECT_THAT(sets.numbers(), ElementsAre(0, 1, 2, 3, 4, 5));
  sets.unite(5, 2);
  sets.unite(4, 1);
  sets.unite(2, 2);
  EXPECT_THAT(sets.numbers(), ElementsAre(0, 1, 2, 3, 1, 2));
  EXPECT_EQ(sets.lowestOf(5), 2);
}

TEST(DisjointSets, DoNotDependOnTheOrderOfUnions) {
  // A chain of 0, 2, 4, ... and one of 1, 3, 5, ..., linked from either end.
  constexpr int kCount = 1000;
  DisjointSets up(kCount), down(kCount);
  for (int k = 2; k < kCount; ++k) up.unite(k - 2, k);
  for (int k = kCount - 1; k >= 2; --k) down.unite(k, k - 2);
  EXPECT_EQ(up.numbers(), down.numbers());
  EXPECT_EQ(up.lowestOf(kCount - 1), 1);
  EXPECT_EQ(down.lowestOf(kCount - 2), 0);
}

}  // namespace
}  // namespace kirireel
