#include "render/export/output_folder.h"

#include <string>

#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

TEST(FolderLock, IsHeldByOneAtATime) {
  const test::TemporaryFolder folder;
  const auto hold = [&folder] { const exports::FolderLock lock(folder.path()); };
  {
    const exports::FolderLock lock(folder.path());
    EXPECT_THROW(hold(), OutputError);
  }
  EXPECT_NO_THROW(hold());
}

TEST(NumberedNames, AreThoseThatSomeNumberGets) {
  const auto frame = [](int number) { return exports::frameFile(number).string(); };
  for (const char* name : {"frames/frame_00000.png", "frames/frame_123456.png"}) {
    EXPECT_TRUE(exports::isNumbered(name, frame)) << name;
  }
  for (const char* name : {"frames/frame_0.png", "frames/frame_00000.svg", "frame_00000.png",
                           "frames/frame_.png", "", "frames/frame_99999999999999999999.png"}) {
    EXPECT_FALSE(exports::isNumbered(name, frame)) << name;
  }
}

TEST(FrameFile, SortsByNumber) {
  EXPECT_EQ(exports::frameFile(0), "frames/frame_00000.png");
  EXPECT_LT(exports::frameFile(99).string(), exports::frameFile(100).string());
  EXPECT_LT(exports::frameFile(9999).string(), exports::frameFile(10000).string());
}

}  // namespace
}  // namespace kirireel
