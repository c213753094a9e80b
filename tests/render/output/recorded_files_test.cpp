#include <gtest/gtest.h>

#include "render/output/output_folder.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;

/// A folder with one file of a run, and its record.
class RecordedFilesTest : public testing::Test {
 protected:
  RecordedFilesTest() {
    fs::create_directory(folder_ / "frames");
    test::writeText(folder_ / "final.obj", "ours");
    test::writeText(folder_ / "frames/frame_00000.png", "ours too");
    output::FileList files;
    for (const char* name : {"final.obj", "frames/frame_00000.png"}) {
      files[name] = output::digestOf(folder_.path(), name);
    }
    test::writeText(folder_ / "summary.json", output::contentsText(files));
  }

  bool isForeign(const std::string& name) const {
    return output::RecordedFiles(folder_.path()).isForeign(name);
  }

  test::TemporaryFolder folder_;
};

TEST_F(RecordedFilesTest, KnowsTheFilesOfTheRecord) {
  EXPECT_FALSE(isForeign("final.obj"));
  EXPECT_FALSE(isForeign("frames/frame_00000.png"));
  EXPECT_FALSE(isForeign("summary.json"));
  EXPECT_FALSE(isForeign("final.ply"));  // not there
  EXPECT_TRUE(output::RecordedFiles(folder_.path()).isUnchanged("final.obj"));
  EXPECT_FALSE(output::RecordedFiles(folder_.path()).isUnchanged("final.ply"));
}

TEST_F(RecordedFilesTest, KnowNoOtherFiles) {
  test::writeText(folder_ / "final.ply", "theirs");
  EXPECT_TRUE(isForeign("final.ply"));
  test::writeText(folder_ / "final.obj", "OURS");  // as many bytes
  EXPECT_TRUE(isForeign("final.obj"));
  fs::remove(folder_ / "final.obj");
  fs::create_directory(folder_ / "final.obj");
  EXPECT_TRUE(isForeign("final.obj"));
}

TEST_F(RecordedFilesTest, KnowNothingWithoutASealedRecord) {
  test::writeText(folder_ / "summary.json", test::bytesOf(folder_ / "summary.json") + " ");
  EXPECT_TRUE(isForeign("final.obj"));
  EXPECT_TRUE(isForeign("summary.json"));
  fs::remove(folder_ / "summary.json");
  EXPECT_TRUE(isForeign("final.obj"));
}

TEST_F(RecordedFilesTest, AreNotSoughtThroughLinksToFolders) {
  fs::rename(folder_ / "frames", folder_ / "elsewhere");
  fs::create_directory_symlink(folder_ / "elsewhere", folder_ / "frames");
  EXPECT_TRUE(isForeign("frames/frame_00000.png"));
  // A link to a file with the same bytes may be replaced without loss.
  fs::rename(folder_ / "final.obj", folder_ / "moved.obj");
  fs::create_symlink(folder_ / "moved.obj", folder_ / "final.obj");
  EXPECT_FALSE(isForeign("final.obj"));
  fs::remove(folder_ / "moved.obj");
  EXPECT_TRUE(isForeign("final.obj"));
}

TEST_F(RecordedFilesTest, FollowTheNewestRecord) {
  test::writeText(folder_ / "final.obj", "exported again");
  output::FileList files;
  files["final.obj"] = output::digestOf(folder_.path(), "final.obj");
  test::writeText(folder_ / "contents.json", output::contentsText(files));
  EXPECT_FALSE(isForeign("final.obj"));
  EXPECT_FALSE(isForeign("frames/frame_00000.png"));
  EXPECT_FALSE(isForeign("contents.json"));
}

}  // namespace
}  // namespace kirireel
