#include <random>

#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/formats/read_model.h"
#include "sim/generate/lattice.h"
#include "tests/support/files.h"
#include "tests/support/same_model.h"

namespace kirireel {
namespace {

using test::expectSameModel;
using test::TemporaryFolder;
namespace fs = std::filesystem;

const fs::path kSharedModels = fs::path(KIRIREEL_SOURCE_DIR) / "../shared/models";

/// The model of a folder, whose reading gives no warning.
model::Model readFolder(const fs::path& folder) {
  std::vector<std::string> warnings;
  model::Model model = formats::readModelFolder(folder, warnings);
  EXPECT_TRUE(warnings.empty()) << warnings.front();
  return model;
}

TEST(Folder, RoundTripKeepsEveryBit) {
  generate::TessellationShape shape;
  shape.length = 1.0 / 3;
  shape.startAngle = 0.1;
  model::Model model = generate::makeTessellation(shape);
  model.pulledTiles = std::vector<int>{0, 15};
  const TemporaryFolder folder;
  formats::writeModelFolder(model, folder.path() / "deep" / "model");
  const model::Model again = readFolder(folder.path() / "deep" / "model");
  EXPECT_EQ(again.name, "model");
  expectSameModel(again, model);
}

TEST(Folder, RoundTripOfLooseTile) {
  generate::TessellationShape shape;
  shape.columns = shape.rows = 1;
  model::Model model = generate::makeTessellation(shape);
  model.target.reset();
  const TemporaryFolder folder;
  formats::writeModelFolder(model, folder.path());
  EXPECT_EQ(test::bytesOf(folder.path() / "constraints.txt"), "# no joints\n");
  expectSameModel(readFolder(folder.path()), model);
}

TEST(Folder, NeverReplacesAnotherModel) {
  const TemporaryFolder folder;
  model::Model model = generate::makeTessellation({});
  model.pulledTiles = std::vector<int>{3};
  formats::writeModelFolder(model, folder.path());
  const model::Model whole = model;
  const auto expectRefused = [&](const char* name) {
    try {
      formats::writeModelFolder(model, folder.path());
      FAIL();
    } catch (const InputError& error) {
      EXPECT_EQ(
          std::string(error.what()),
          (folder.path() / name).string() +
              ": error: this file belongs to another model. Move it, or choose another folder");
    }
    expectSameModel(readFolder(folder.path()), whole);
  };
  model.pulledTiles = std::vector<int>{2};
  expectRefused("pull.txt");
  model.target.reset();
  expectRefused("target.txt");
  formats::writeModelFolder(whole, folder.path());  // the same again
  expectSameModel(readFolder(folder.path()), whole);
}

TEST(Folder, ReadsWhatOtherProgramsWrite) {
  const TemporaryFolder folder;
  folder.write("vertices.txt",
               "\xEF\xBB\xBF# tiles\r\n\r\n0 0 0\t+1 0 0  1 1 -0.0 \r\n 1e0 0 0 2 0 0 2 1 0");
  folder.write("constraints.txt", "0 1 1 0\r\n");
  folder.write("pull.txt", "1\r\n0 1");
  const model::Model model = readFolder(folder.path());
  ASSERT_EQ(model.tiles.size(), 2u);
  EXPECT_EQ(model.tiles[0].vertices[1], Vector3(1, 0, 0));
  EXPECT_EQ(model.tiles[1].vertices[2], Vector3(2, 1, 0));
  EXPECT_EQ(model.joints[0].face, model::JointFace::Bottom);
  EXPECT_EQ(model.pulledTiles, (std::vector<int>{1, 0, 1}));
}

TEST(Folder, NameIsTheFoldersHoweverItIsWritten) {
  const TemporaryFolder folder;
  formats::writeModelFolder(generate::makeTessellation({}), folder.path() / "sheet");
  EXPECT_EQ(readFolder(folder.path() / "sheet" / "").name, "sheet");
  EXPECT_EQ(readFolder(folder.path() / "sheet" / ".").name, "sheet");
}

TEST(Folder, CannotBeMadeUnderAFile) {
  const TemporaryFolder folder;
  folder.write("file", "");
  const fs::path below = folder.path() / "file" / "model";
  try {
    formats::writeModelFolder(generate::makeTessellation({}), below);
    FAIL();
  } catch (const OutputError& error) {
    EXPECT_EQ(
        std::string(error.what()),
        below.string() + ": error: the folder cannot be created (Not a directory). Choose another");
  }
}

TEST(Folder, DamagedFilesReadOrAreRefused) {
  const TemporaryFolder folder;
  const fs::path shipped = fs::path(KIRIREEL_SOURCE_DIR) / "data/tessellation_4x4";
  const std::string names[] = {"vertices.txt", "constraints.txt", "target.txt"};
  const std::string pieces[] = {"\n", " ", "-", "9", "e9", "nan", "#", "\xff", "0", "."};
  std::mt19937 random(1);
  int refused = 0;
  for (int i = 0; i < 500; ++i) {
    for (const std::string& name : names) {
      std::string text = test::bytesOf(shipped / name);
      const std::string& piece = pieces[random() % std::size(pieces)];
      if (name == names[i % 3]) text.replace(random() % text.size(), random() % 5, piece);
      folder.write(name, text);
    }
    std::vector<std::string> warnings;
    try {
      formats::readModelFolder(folder.path(), warnings);
    } catch (const InputError& error) {
      EXPECT_TRUE(std::string(error.what()).starts_with(folder.path().string()));
      ++refused;
    }
  }
  EXPECT_GT(refused, 100);
}

TEST(Folder, ReadsEverySharedModel) {
  if (!fs::exists(kSharedModels)) GTEST_SKIP() << kSharedModels << " is not there";
  int count = 0;
  for (const auto& entry : fs::directory_iterator(kSharedModels)) {
    if (!fs::exists(entry.path() / "vertices.txt")) continue;
    std::vector<std::string> warnings;
    const model::Model model = formats::readModelFolder(entry.path(), warnings);
    EXPECT_FALSE(model.tiles.empty());
    EXPECT_FALSE(model.joints.empty());
    ++count;
  }
  EXPECT_GE(count, 12);
}

}  // namespace
}  // namespace kirireel
