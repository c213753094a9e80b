#include "render/record/output_folder.h"

#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "sim/base/error.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;

class OutputFolder : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "kirireel_test_XXXXXX").string();
    folder_ = ::mkdtemp(pattern.data());
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write(const fs::path& name) {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << "old";
  }
  bool has(const fs::path& name) const { return fs::exists(folder_ / name); }

  std::string messageOfPreparing(const fs::path& folder) {
    try {
      prepareOutputFolder(folder);
    } catch (const OutputError& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder_;
};

TEST_F(OutputFolder, IsMadeWithThoseAbove) {
  prepareOutputFolder(folder_ / "a" / "b");
  EXPECT_TRUE(fs::is_directory(folder_ / "a" / "b"));
}

TEST_F(OutputFolder, LosesFilesOfAnEarlierRunAlone) {
  const std::vector<fs::path> ours = {"trajectory.h5",
                                      "deployment.mp4",
                                      "snapshots.png",
                                      "initial.obj",
                                      "final.ply",
                                      "final_vertices.txt",
                                      "summary.json",
                                      frameFile(7),
                                      "deployment.part.mp4",
                                      "deployment.whole.part.mp4",
                                      "frames/frame_00008.part.png"};
  const std::vector<fs::path> theirs = {"notes.txt",      "vertices.txt", "target.txt",
                                        "frames/own.png", "my.mp4",       "initial.blend",
                                        "my.part.mp4"};
  for (const fs::path& name : ours) write(name);
  for (const fs::path& name : theirs) write(name);
  prepareOutputFolder(folder_);
  for (const fs::path& name : ours) EXPECT_FALSE(has(name)) << name;
  for (const fs::path& name : theirs) EXPECT_TRUE(has(name)) << name;
}

TEST_F(OutputFolder, KeepsFoldersThatBearAFilesName) {
  write("final.obj/inside.txt");
  prepareOutputFolder(folder_);
  EXPECT_TRUE(has("final.obj/inside.txt"));
}

TEST_F(OutputFolder, LosesLinksAndLeavesWhatTheyLeadTo) {
  write("theirs/frame_00001.png");
  write("theirs/video");
  fs::create_directory(folder_ / "out");
  fs::create_symlink(folder_ / "theirs/video", folder_ / "out/deployment.mp4");
  fs::create_symlink(folder_ / "theirs", folder_ / "out/final.obj");
  fs::create_symlink(folder_ / "theirs", folder_ / "out/frames");
  prepareOutputFolder(folder_ / "out");
  EXPECT_TRUE(fs::is_empty(folder_ / "out"));
  EXPECT_TRUE(has("theirs/frame_00001.png") && has("theirs/video"));
  fs::create_symlink(folder_ / "theirs", folder_ / "out/frames");
  makeFramesFolder(folder_ / "out");
  EXPECT_FALSE(fs::is_symlink(folder_ / "out/frames"));
}

TEST_F(OutputFolder, SaysWhyItCannotBeMade) {
  write("file");
  EXPECT_EQ(messageOfPreparing(folder_ / "file"),
            (folder_ / "file").string() +
                ": error: the folder cannot be made (Not a directory); choose another");
  EXPECT_EQ(messageOfPreparing(folder_ / "file" / "in"),
            (folder_ / "file" / "in").string() +
                ": error: the folder cannot be made (Not a directory); choose another");
}

TEST_F(OutputFolder, IsHeldByOneRunAtATime) {
  const auto hold = [this] { const FolderLock lock(folder_); };
  {
    const FolderLock lock(folder_);
    EXPECT_THROW(hold(), OutputError);
  }
  EXPECT_NO_THROW(hold());
}

TEST(FrameFile, SortsByNumber) {
  EXPECT_EQ(frameFile(0), "frames/frame_00000.png");
  EXPECT_LT(frameFile(99).string(), frameFile(100).string());
  EXPECT_LT(frameFile(9999).string(), frameFile(10000).string());
}

}  // namespace
}  // namespace kirireel
