#include "sim/base/error.h"

#include <gtest/gtest.h>

namespace kirireel {
namespace {

TEST(FileLocation, ShowsWhatIsKnown) {
  EXPECT_EQ(toString({"a/b.txt"}), "a/b.txt");
  EXPECT_EQ(toString({"a/b.txt", 17}), "a/b.txt:17");
  EXPECT_EQ(toString({"a/b.txt", 17, 8}), "a/b.txt:17:8");
  EXPECT_EQ(toString({"a/b.txt", 0, 8}), "a/b.txt");
}

TEST(InputError, StartsWithItsPlace) {
  EXPECT_STREQ(inputErrorAt({"a.txt", 1, 2}, "what; how").what(), "a.txt:1:2: error: what; how");
}

}  // namespace
}  // namespace kirireel
