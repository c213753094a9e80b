#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/output/output_folder.h"
#include "sim/base/error.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;
using testing::StrEq;
using testing::ThrowsMessage;

/// All files in a folder and below, with their content.
std::map<std::string, std::string> contentsOf(const fs::path& folder) {
  std::map<std::string, std::string> contents;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    contents[entry.path().lexically_relative(folder).string()] = test::bytesOf(entry.path());
  }
  return contents;
}

/// The record of these files in a folder.
std::string recordOf(const fs::path& folder, const std::vector<std::string>& names) {
  output::FileList files;
  for (const std::string& name : names) files[name] = output::digestOf(folder, name);
  return output::contentsText(files);
}

class FileSetTest : public testing::Test {
 protected:
  /// Leaves a run of these files.
  void leaveRun(const std::map<std::string, std::string>& contents) const {
    output::FileSet files(folder_.path(), output::kSummary);
    std::vector<std::string> names;
    for (const auto& [name, text] : contents) {
      test::writeText(files.stage() / name, text);
      names.push_back(name);
    }
    files.commit(recordOf(files.stage(), names));
  }

  /// The same without its record.
  std::map<std::string, std::string> found() const {
    auto contents = contentsOf(folder_.path());
    contents.erase(output::kSummary);
    return contents;
  }

  using Contents = std::map<std::string, std::string>;
  test::TemporaryFolder folder_;
};

TEST_F(FileSetTest, ReplacesAnEarlierRunAltogether) {
  leaveRun({{"a.txt", "old"}, {"frames/1.png", "old"}, {"talk.webm", "old"}});
  test::writeText(folder_ / "frames/own.png", "theirs");
  leaveRun({{"a.txt", "new"}, {"b.txt", "new"}});
  EXPECT_EQ(found(), (Contents{{"a.txt", "new"}, {"b.txt", "new"}, {"frames/own.png", "theirs"}}));
  leaveRun({{"frames/1.png", "new"}});
  fs::remove(folder_ / "frames/own.png");
  leaveRun({{"a.txt", "newest"}});
  EXPECT_FALSE(fs::exists(folder_ / "frames"));
}

TEST_F(FileSetTest, ChangesNothingUntilItIsComplete) {
  leaveRun({{"a.txt", "old"}});
  const auto before = contentsOf(folder_.path());
  {
    output::FileSet files(folder_.path(), output::kSummary);
    test::writeText(files.stage() / "a.txt", "half");
    test::writeText(files.stage() / "checkpoint/state.h5", "state");
    // The state after a killed program.
    auto during = contentsOf(folder_.path());
    std::erase_if(during, [](const auto& file) { return file.first.starts_with(".unfinished/"); });
    EXPECT_EQ(during, before);
  }
  EXPECT_EQ(test::bytesOf(folder_ / ".unfinished/checkpoint/state.h5"), "state");
  EXPECT_FALSE(fs::exists(folder_ / ".unfinished/a.txt"));
  output::FileSet(folder_.path(), output::kSummary).dropCheckpoint();
  EXPECT_EQ(contentsOf(folder_.path()), before);
  EXPECT_FALSE(fs::exists(folder_ / ".unfinished"));
}

TEST_F(FileSetTest, OverwritesNoForeignFiles) {
  leaveRun({{"a.txt", "old"}, {"b.txt", "old"}});
  test::writeText(folder_ / "b.txt", "edited");
  test::writeText(folder_ / "c.txt", "theirs");
  const auto before = contentsOf(folder_.path());
  const auto isRequested = [](const std::string& name) { return name.ends_with(".txt"); };
  {
    const output::FileSet files(folder_.path(), output::kSummary);
    EXPECT_THAT([&] { files.requireFree(isRequested); },
                ThrowsMessage<InputError>(StrEq(
                    folder_.path().string() +
                    ": error: b.txt, c.txt would be overwritten, but no earlier run wrote them in "
                    "this form; move them away, or choose another folder with --out")));
  }
  EXPECT_EQ(contentsOf(folder_.path()), before);
}

TEST_F(FileSetTest, RefusesLinksAndFoldersUnderItsNames) {
  test::writeText(folder_ / "theirs/f.png", "theirs");
  fs::create_symlink(folder_ / "theirs/f.png", folder_ / "a.txt");
  fs::create_directory(folder_ / "b.txt");
  fs::create_symlink(folder_ / "nowhere", folder_ / "c.txt");
  fs::create_directory_symlink(folder_ / "theirs", folder_ / "frames");
  const output::FileSet files(folder_.path(), output::kSummary);
  const auto isRequested = [](const std::string& name) {
    return name.ends_with(".txt") || name == "frames/";
  };
  EXPECT_THAT([&] { files.requireFree(isRequested); },
              ThrowsMessage<InputError>(testing::HasSubstr(
                  "error: a.txt, b.txt, c.txt and 1 more would be overwritten")));
  fs::remove(folder_ / "frames");
  fs::create_directory(folder_ / "frames");
  EXPECT_NO_THROW(files.requireFree([](const std::string& name) { return name == "frames/"; }));
}

TEST_F(FileSetTest, MovesNothingIfForeignFilesAppear) {
  const auto leave = [this] { leaveRun({{"a.txt", "new"}, {"b.txt", "new"}}); };
  {
    output::FileSet files(folder_.path(), output::kSummary);
    test::writeText(files.stage() / "a.txt", "new");
    test::writeText(files.stage() / "b.txt", "new");
    test::writeText(folder_ / "b.txt", "theirs");
    EXPECT_THROW(files.commit(recordOf(files.stage(), {"a.txt", "b.txt"})), InputError);
  }
  EXPECT_FALSE(fs::exists(folder_ / "a.txt"));
  EXPECT_EQ(test::bytesOf(folder_ / "b.txt"), "theirs");
  // The run is complete, but the disk is full.
  EXPECT_THROW(leave(), InputError);
  fs::remove(folder_ / "b.txt");
  { const output::FileSet files(folder_.path(), output::kSummary); }
  EXPECT_EQ(found(), (Contents{{"a.txt", "new"}, {"b.txt", "new"}}));
}

TEST_F(FileSetTest, ContinuesMovingAfterAKill) {
  leaveRun({{"a.txt", "old"}, {"b.txt", "old"}, {"c.txt", "old"}});
  // Half moved: a.txt is in place, b.txt and the record are not.
  const fs::path stage = folder_ / ".unfinished";
  test::writeText(stage / "a.txt", "new");
  test::writeText(stage / "b.txt", "new");
  test::writeText(stage / "summary.json", recordOf(stage, {"a.txt", "b.txt"}));
  test::writeText(
      stage / "kirireel.txt",
      "Kirireel works here. It moves whole files out of this folder and removes all others.\n");
  fs::rename(stage / "a.txt", folder_ / "a.txt");
  { const output::FileSet files(folder_.path(), output::kSummary); }
  EXPECT_EQ(found(), (Contents{{"a.txt", "new"}, {"b.txt", "new"}}));
}

TEST_F(FileSetTest, ContinuesMovingAfterAnError) {
  leaveRun({{"a.obj", "run"}});
  test::writeText(folder_.path() / "sub", "a foreign file in place of a folder");
  {
    output::FileSet files(folder_.path(), output::kContents);
    test::writeText(files.stage() / "b.obj", "export");
    test::writeText(files.stage() / "sub" / "c.obj", "export");
    EXPECT_THROW(files.commit(std::vector<std::string>{"b.obj", "sub/c.obj"}), OutputError);
  }
  EXPECT_TRUE(fs::exists(folder_.path() / "b.obj"));
  fs::remove(folder_.path() / "sub");
  // Files that were moved before the error are known as ours: the next export may replace them.
  {
    output::FileSet files(folder_.path(), output::kContents);
    EXPECT_TRUE(fs::exists(folder_.path() / "sub" / "c.obj"));
    test::writeText(files.stage() / "b.obj", "again");
    files.commit(std::vector<std::string>{"b.obj"});
  }
  EXPECT_EQ(test::bytesOf(folder_.path() / "b.obj"), "again");
  EXPECT_FALSE(fs::exists(folder_.path() / output::kUnfinished));
}

TEST_F(FileSetTest, KeepsAForeignHiddenFolder) {
  test::writeText(folder_ / ".unfinished/notes.txt", "theirs");
  EXPECT_THAT(
      [this] { const output::FileSet files(folder_.path(), output::kSummary); },
      ThrowsMessage<InputError>(testing::HasSubstr(
          "error: .unfinished would be overwritten, but no earlier run wrote it in this form")));
  EXPECT_EQ(found(), (Contents{{".unfinished/notes.txt", "theirs"}}));
}

TEST_F(FileSetTest, AddsToTheFilesOfARun) {
  leaveRun({{"a.txt", "run"}});
  for (const char* text : {"first", "second"}) {
    output::FileSet files(folder_.path(), output::kContents);
    test::writeText(files.stage() / "a.txt", text);
    test::writeText(files.stage() / (text + std::string(".obj")), text);
    files.commit(std::vector<std::string>{"a.txt", text + std::string(".obj")});
  }
  EXPECT_EQ(test::bytesOf(folder_ / "a.txt"), "second");
  EXPECT_EQ(output::listedFiles(folder_ / "contents.json").size(), 3U);
  // The next run replaces both.
  leaveRun({{"b.txt", "new"}});
  EXPECT_EQ(found(), (Contents{{"b.txt", "new"}}));
}

TEST_F(FileSetTest, ReportsWhyAFolderCannotBeMade) {
  test::writeText(folder_ / "file", "");
  for (const fs::path& place : {folder_ / "file", folder_ / "file" / "in"}) {
    EXPECT_THAT([&] { const output::FileSet files(place, output::kSummary); },
                ThrowsMessage<OutputError>(StrEq(
                    place.string() +
                    ": error: the folder cannot be created (Not a directory). Choose another")));
  }
}

}  // namespace
}  // namespace kirireel
