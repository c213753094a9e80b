#include "sim/base/text_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

using ::testing::StrEq;
using ::testing::ThrowsMessage;

TEST(TextFile, IsReadWhole) {
  const test::TemporaryFolder folder;
  const std::string text("a\0b\r\n", 5);
  std::ofstream(folder / "a.txt", std::ios::binary) << text;
  EXPECT_EQ(readTextFile(folder / "a.txt", "give one"), text);
}

TEST(TextFile, SaysWhyItIsNotRead) {
  const test::TemporaryFolder folder;
  const std::string file = (folder / "a.txt").string();
  const auto reading = [&file] { readTextFile(file, "give one", 3); };
  EXPECT_THAT(reading,
              ThrowsMessage<InputError>(StrEq(file + ": error: there is no such file; give one")));
  std::ofstream(folder / "a.txt") << "abcd";
  EXPECT_THAT(reading, ThrowsMessage<InputError>(StrEq(
                           file + ": error: the file has 4 bytes, at most 3 are read; give one")));
  std::filesystem::remove(file);
  std::filesystem::create_directory(file);
  EXPECT_THAT(reading, ThrowsMessage<InputError>(
                           StrEq(file + ": error: this is not a text file; give one")));
}

}  // namespace
}  // namespace kirireel
