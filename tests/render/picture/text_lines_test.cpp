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

TEST(WrapText, BreaksAtSpacesOfAFullLine) {
  EXPECT_THAT(picture::wrapText("one two three", bytes, 7), ElementsAre("one two", "three"));
  EXPECT_THAT(picture::wrapText("one two three", bytes, 6), ElementsAre("one", "two", "three"));
  EXPECT_THAT(picture::wrapText("one two three", bytes, 100), ElementsAre("one two three"));
}

TEST(WrapText, BreaksAtEveryLineFeed) {
  EXPECT_THAT(picture::wrapText("one\ntwo three\n\nfour", bytes, 9),
              ElementsAre("one", "two three", "", "four"));
  EXPECT_THAT(picture::wrapText("", bytes, 9), ElementsAre(""));
}

TEST(WrapText, LeavesLongWordsWhole) {
  EXPECT_THAT(picture::wrapText("a Tessellierung b", bytes, 5),
              ElementsAre("a", "Tessellierung", "b"));
}

}  // namespace
}  // namespace kirireel
