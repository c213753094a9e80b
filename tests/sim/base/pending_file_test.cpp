#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>

#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <unistd.h>

#include "sim/base/error.h"
#include "sim/base/files.h"
#include "tests/support/refusal.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;

class PendingFileTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "kirireel-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
  }
  void TearDown() override { fs::remove_all(folder_); }

  static std::string read(const fs::path& file) {
    std::ifstream stream(file);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  fs::path folder_;
};

TEST_F(PendingFileTest, AppearsOnlyWhenCommitted) {
  PendingFile pending(folder_ / "deployment.mp4");
  EXPECT_EQ(pending.path(), folder_ / "deployment.part.mp4");
  std::ofstream(pending.path()) << "whole";
  EXPECT_FALSE(fs::exists(pending.finalPath()));
  pending.commit();
  EXPECT_EQ(read(pending.finalPath()), "whole");
  EXPECT_FALSE(fs::exists(pending.path()));
}

TEST_F(PendingFileTest, LeavesNothingWithoutCommit) {
  {
    PendingFile pending(folder_ / "a.txt");
    std::ofstream(pending.path()) << "half";
  }
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(PendingFileTest, KeepsTheOldFileWhenTheNewOneFails) {
  writeTextFile(folder_ / "a.txt", "old");
  { PendingFile pending(folder_ / "a.txt"); }
  EXPECT_EQ(read(folder_ / "a.txt"), "old");
}

TEST_F(PendingFileTest, RefusesAFolderThatIsNotThere) {
  const fs::path missing = folder_ / "missing";
  EXPECT_EQ(test::refusalOf<OutputError>([&] { writeTextFile(missing / "a.txt", "text"); }),
            missing.string() +
                ": error: cannot write in this folder (No such file or directory). Choose another "
                "folder");
}

TEST_F(PendingFileTest, RefusesAFolderWithoutPermission) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  fs::permissions(folder_, fs::perms::owner_read | fs::perms::owner_exec);
  const std::string message =
      test::refusalOf<OutputError>([&] { writeTextFile(folder_ / "a.txt", "text"); });
  fs::permissions(folder_, fs::perms::owner_all);
  EXPECT_EQ(message,
            folder_.string() +
                ": error: cannot write in this folder (Permission denied). Choose another folder");
}

TEST_F(PendingFileTest, ReportsWhenItCannotBePutInPlace) {
  fs::create_directory(folder_ / "a.txt");
  std::ofstream(folder_ / "a.txt" / "inside") << "x";
  EXPECT_EQ(test::refusalOf<OutputError>([&] { writeTextFile(folder_ / "a.txt", "text"); }),
            (folder_ / "a.txt").string() + ": error: cannot be put in place (Is a directory)");
}

TEST_F(PendingFileTest, ReplacesLinksAndLeavesWhatTheyLeadTo) {
  std::ofstream(folder_ / "elsewhere") << "theirs";
  for (const char* name : {"a.txt", "a.part.txt"}) {
    fs::create_symlink(folder_ / "elsewhere", folder_ / name);
  }
  writeTextFile(folder_ / "a.txt", "ours");
  EXPECT_EQ(read(folder_ / "elsewhere"), "theirs");
  EXPECT_EQ(read(folder_ / "a.txt"), "ours");
  EXPECT_FALSE(fs::is_symlink(folder_ / "a.txt"));
  EXPECT_TRUE(fs::is_symlink(folder_ / "a.part.txt"));
  EXPECT_FALSE(fs::exists(folder_ / "a.part2.txt"));
}

/// Limits the size of files, as on a full disk.
class SmallFiles {
 public:
  explicit SmallFiles(rlim_t bytes) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit = {bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~SmallFiles() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, signalBefore_);
  }
  SmallFiles(const SmallFiles&) = delete;
  SmallFiles& operator=(const SmallFiles&) = delete;

 private:
  rlimit before_ = {};
  void (*signalBefore_)(int) = std::signal(SIGXFSZ, SIG_IGN);
};

TEST_F(PendingFileTest, ReportsWhenTheFileCannotGrow) {
  const auto write = [&] {
    const SmallFiles limit(3);
    writeTextFile(folder_ / "a.txt", "text");
  };
  EXPECT_EQ(
      test::refusalOf<OutputError>(write),
      (folder_ / "a.txt").string() +
          ": error: cannot be written (File too large); free some space or choose another folder");
  EXPECT_TRUE(fs::is_empty(folder_));
}

}  // namespace
}  // namespace kirireel
