#include <gtest/gtest.h>

#include "sim/base/error.h"

namespace kirireel {
namespace {

TEST(EditDistance, CountsKnownCases) {
  EXPECT_EQ(editDistance("kitten", "sitting"), 3);  // Levenshtein's own example
  EXPECT_EQ(editDistance("", "abc"), 3);
  EXPECT_EQ(editDistance("same", "same"), 0);
}

TEST(EditDistance, IsAMetric) {
  const std::vector<std::string> words = {"--fps", "--out", "--grid", "--gravity", "--ground", ""};
  for (const std::string& a : words) {
    for (const std::string& b : words) {
      EXPECT_EQ(editDistance(a, b), editDistance(b, a));
      EXPECT_EQ(editDistance(a, b) == 0, a == b);
      for (const std::string& c : words) {
        EXPECT_LE(editDistance(a, c), editDistance(a, b) + editDistance(b, c));
      }
    }
  }
}

TEST(Suggestion, NamesTheNearestWord) {
  const std::vector<std::string> known = {"--thickness", "--timestep", "--torque-damping"};
  EXPECT_EQ(suggestion("--thicknes", known), ", did you mean --thickness?");
  EXPECT_EQ(suggestion("--time-step", known), ", did you mean --timestep?");
}

TEST(Suggestion, IsEmptyWhenNothingIsNear) {
  EXPECT_EQ(suggestion("--colour", {"--thickness", "--fps"}), "");
  EXPECT_EQ(suggestion(std::string(101, 'a'), {std::string(100, 'a')}), "");
}

TEST(OneLine, KeepsNoControlCharacter) {
  EXPECT_EQ(oneLine("a\nb\x1b[31m\x7f"), "a?b?[31m?");
  EXPECT_EQ(oneLine("tiles of \u00c5ngstr\u00f6m"), "tiles of \u00c5ngstr\u00f6m");
}

TEST(CodePoints, AreThoseOfUtf8) {
  // Of one, two, three and four bytes.
  EXPECT_EQ(codePoints("30\u00b0 \u03b1 \u2264 \U0001d400"), U"30\u00b0 \u03b1 \u2264 \U0001d400");
  EXPECT_EQ(codePoints(""), U"");
}

TEST(CodePoints, AreAbsentForOtherBytes) {
  // A lone byte, a text that stops within a character, an overlong slash, half of a pair of UTF-16.
  for (const char* text : {"\xff", "a\xc3", "\xc0\xaf", "\xed\xa0\x80"}) {
    EXPECT_FALSE(codePoints(text)) << text;
  }
}

TEST(Shown, IsShortAndPlain) {
  EXPECT_EQ(shown("spring_stiffness"), "spring_stiffness");
  EXPECT_EQ(shown("abcdef", 5), "abcde...");
  EXPECT_EQ(shown("\xc3\x85\t"), "???");
}

}  // namespace
}  // namespace kirireel
