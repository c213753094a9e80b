#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "sim/base/error.h"
#include "sim/base/files.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

using ::testing::StrEq;
using ::testing::ThrowsMessage;

TEST(TextFile, IsReadCompletely) {
  const test::TemporaryFolder folder;
  const std::string text("a\0b\r\n", 5);
  std::ofstream(folder / "a.txt", std::ios::binary) << text;
  EXPECT_EQ(readTextFile(folder / "a.txt", "give one"), text);
}

using testing::ElementsAre;

/// The names of the files and the beginnings of their hashes.
std::vector<std::string> shortNotes(const std::vector<InputFile>& files) {
  std::vector<std::string> notes;
  for (const InputFile& file : files) {
    notes.push_back(file.path.filename().string() + " " + file.sha256.substr(0, 4));
  }
  return notes;
}

// The hashes are those that sha256sum prints of "a" and "b".
TEST(InputRecord, NotesWhatIsReadWhileItLives) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "a.txt") << "a";
  std::ofstream(folder / "b.txt") << "b";
  std::vector<InputFile> outer;
  std::vector<InputFile> inner;
  readTextFile(folder / "a.txt", "give one");
  {
    const InputRecord whole(outer);
    readTextFile(folder / "a.txt", "give one");
    const InputRecord part(inner);
    std::string text;
    openInputFile(folder / "b.txt") >> text;
    EXPECT_EQ(text, "b");
    EXPECT_THROW(readTextFile(folder / "c.txt", "give one"), InputError);
  }
  readTextFile(folder / "b.txt", "give one");
  EXPECT_THAT(shortNotes(outer), ElementsAre("a.txt ca97", "b.txt 3e23"));
  EXPECT_THAT(shortNotes(inner), ElementsAre("b.txt 3e23"));
}

TEST(InputRecord, IsPerThread) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "a.txt") << "a";
  std::vector<InputFile> files;
  const InputRecord record(files);
  std::thread([&] { readTextFile(folder / "a.txt", "give one"); }).join();
  EXPECT_TRUE(files.empty());
}

TEST(TextFile, ReportsWhyItIsNotRead) {
  const test::TemporaryFolder folder;
  const std::string file = (folder / "a.txt").string();
  const auto reading = [&file] { readTextFile(file, "give one", 3); };
  EXPECT_THAT(reading,
              ThrowsMessage<InputError>(StrEq(file + ": error: there is no such file; give one")));
  std::ofstream(folder / "a.txt") << "abcd";
  EXPECT_THAT(reading,
              ThrowsMessage<InputError>(StrEq(
                  file + ": error: the file has 4 bytes, but at most 3 are allowed; give one")));
  std::filesystem::remove(file);
  std::filesystem::create_directory(file);
  EXPECT_THAT(reading, ThrowsMessage<InputError>(
                           StrEq(file + ": error: this is not a text file; give one")));
}

TEST(TextFile, ReportsAMissingPermission) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder / "a.txt";
  std::ofstream(file) << "a";
  std::filesystem::permissions(folder.path(), std::filesystem::perms::all);
  std::filesystem::permissions(file, std::filesystem::perms::none);
  // Root may read any file, nobody may not.
  const uid_t user = geteuid();
  ASSERT_TRUE(user != 0 || seteuid(65534) == 0);
  EXPECT_THAT([&] { readTextFile(file, "give one"); },
              ThrowsMessage<InputError>(StrEq(file.string() +
                                              ": error: the file cannot be read (Permission "
                                              "denied); check its permissions")));
  ASSERT_EQ(seteuid(user), 0);
}

}  // namespace
}  // namespace kirireel
