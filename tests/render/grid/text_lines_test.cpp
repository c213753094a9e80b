#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/picture/label.h"

namespace kirireel {
namespace {

using ::testing::ElementsAre;

/// Every byte is one wide.
double bytes(const std::string& text) {
  return static_cast<double>(text.size());
}

TEST(WrapText, BreaksAtSpacesWhereALineIsFull) {
  EXPECT_THAT(wrapText("one two three", bytes, 7), ElementsAre("one two", "three"));
  EXPECT_THAT(wrapText("one two three", bytes, 6), ElementsAre("one", "two", "three"));
  EXPECT_THAT(wrapText("one two three", bytes, 100), ElementsAre("one two three"));
}

TEST(WrapText, BreaksAtEveryLineFeed) {
  EXPECT_THAT(wrapText("one\ntwo three\n\nfour", bytes, 9),
              ElementsAre("one", "two three", "", "four"));
  EXPECT_THAT(wrapText("", bytes, 9), ElementsAre(""));
}

TEST(WrapText, LeavesLongWordsWhole) {
  EXPECT_THAT(wrapText("a Tessellierung b", bytes, 5), ElementsAre("a", "Tessellierung", "b"));
}

TEST(WidestLine, IsTheWidthOfTheWidest) {
  EXPECT_EQ(widestLine({"one", "three", ""}, bytes), 5);
  EXPECT_EQ(widestLine({}, bytes), 0);
}

}  // namespace
}  // namespace kirireel
