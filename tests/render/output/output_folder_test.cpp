#include "render/output/output_folder.h"

#include <string>

#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

TEST(FolderLock, IsHeldByOneAtATime) {
  const test::TemporaryFolder folder;
  const auto hold = [&folder] { const output::FolderLock lock(folder.path()); };
  {
    const output::FolderLock lock(folder.path());
    EXPECT_THROW(hold(), OutputError);
  }
  EXPECT_NO_THROW(hold());
}

TEST(NumberedNames, AreThoseThatSomeNumberGets) {
  const auto frame = [](int number) { return output::frameFile(number).string(); };
  for (const char* name : {"frames/frame_00000.png", "frames/frame_123456.png"}) {
    EXPECT_TRUE(output::isNumbered(name, frame)) << name;
  }
  for (const char* name : {"frames/frame_0.png", "frames/frame_00000.svg", "frame_00000.png",
                           "frames/frame_.png", "", "frames/frame_99999999999999999999.png"}) {
    EXPECT_FALSE(output::isNumbered(name, frame)) << name;
  }
}

TEST(FrameFile, SortsByNumber) {
  EXPECT_EQ(output::frameFile(0), "frames/frame_00000.png");
  EXPECT_LT(output::frameFile(99).string(), output::frameFile(100).string());
  EXPECT_LT(output::frameFile(9999).string(), output::frameFile(10000).string());
}

}  // namespace
}  // namespace kirireel
