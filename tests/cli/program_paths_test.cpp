// Unusual names, links to other places, and texts with special characters of the shell, with the
// real program.
#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/cli/run_program.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;

// A colon would make "take 2" a protocol of FFmpeg. Other characters break programs that split or
// print names.
constexpr const char* kAwkward = "take 2: \u7d19 \u00f6ffnet\n'quick' $HOME \"%s\" \\x";

std::vector<std::string> recordArguments(const fs::path& model, const fs::path& out) {
  return {"record",   model.string(), "--out",    out.string(),      "--duration",
          "0.2",      "--size",       "160x120",  "--fps",           "10",
          "--frames", "--svg",        "--export", "msh,glb,vtu,fold"};
}

TEST(AwkwardNames, OfModelAndOutputAreTakenAsTheyAre) {
  const TemporaryFolder scratch;
  const fs::path model = scratch / kAwkward / kAwkward;
  fs::create_directories(model.parent_path());
  fs::copy(shippedModel("tessellation_4x4"), model);
  ProgramSetting setting;
  setting.folder = scratch.path();  // names on the command line are relative
  const ProgramEnd end = runKirireel(
      recordArguments(fs::path(kAwkward) / kAwkward, kAwkward + std::string(" out")), setting);
  ASSERT_EQ(end.exitCode, 0) << end.err;
  const fs::path out = scratch / (kAwkward + std::string(" out"));
  EXPECT_THAT(filesIn(out), Contains("deployment.mp4"));
  EXPECT_EQ(runKirireel({"verify", out.string()}).exitCode, 0);
  EXPECT_EQ(runKirireel({"render", (out / "trajectory.h5").string(), "--size", "160x120", "--out",
                         (scratch / kAwkward / "again").string()})
                .exitCode,
            0);
  EXPECT_EQ(runKirireel({"convert", model.string(), (scratch / kAwkward / "a b\n.fold").string()})
                .exitCode,
            0);
}

TEST(AwkwardNames, MayBeAnyBytes) {
  const TemporaryFolder scratch;
  const std::string model = (scratch / "mod\xff\xfe").string();
  fs::copy(shippedModel("tessellation_4x4"), model);
  const fs::path out = scratch / "out\xff";
  const ProgramEnd end = runKirireel(recordArguments(model, out));
  EXPECT_EQ(end.exitCode, 0) << end.err;
  EXPECT_THAT(readText(out / "summary.json"), HasSubstr("\"name\": \"mod\ufffd\ufffd\""));
  EXPECT_EQ(runKirireel({"verify", out.string()}).exitCode, 0);
  EXPECT_THAT(runKirireel({"inspect", model, "--json"}).out, HasSubstr("mod\ufffd\ufffd"));
  // A name that the summary cannot store.
  const ProgramEnd video = runKirireel({"record", model, "--video", "talk\xff.webm"});
  EXPECT_EQ(video.exitCode, 2);
  EXPECT_THAT(video.err,
              HasSubstr("--video: 'talk?.webm' is not allowed; give the name of a file"));
}

TEST(AwkwardNames, AreShownInOneLine) {
  const ProgramEnd end = runKirireel({"record", "/no/such\n\x1b[31mmodel"});
  EXPECT_EQ(end.exitCode, 2);
  EXPECT_EQ(std::count(end.err.begin(), end.err.end(), '\n'), 1);
  EXPECT_THAT(end.err, HasSubstr("/no/such??[31mmodel: error: there is no such"));
}

// A user may store a large file on another disk. Links to other types are not replaced.
TEST(Links, ToARunsOwnFilesAreReplacedNotFollowed) {
  const TemporaryFolder scratch;
  const fs::path disk = scratch / "disk", out = scratch / "out";
  const auto words = recordArguments(shippedModel("tessellation_4x4"), out);
  ASSERT_EQ(runKirireel(words).exitCode, 0);
  fs::create_directory(disk);
  fs::rename(out / "trajectory.h5", disk / "trajectory.h5");
  fs::create_symlink(disk / "trajectory.h5", out / "trajectory.h5");
  const std::string kept = readText(disk / "trajectory.h5");
  EXPECT_EQ(runKirireel(words).exitCode, 0);
  EXPECT_FALSE(fs::is_symlink(out / "trajectory.h5"));
  EXPECT_TRUE(readText(disk / "trajectory.h5") == kept);
}

TEST(Links, AreReplacedByOtherCommandsToo) {
  const TemporaryFolder scratch;
  writeText(scratch / "theirs", "theirs");
  for (const char* name : {"sheet.fold", "sheet.part.fold"}) {
    fs::create_symlink(scratch / "theirs", scratch / name);
  }
  const std::string model = shippedModel("tessellation_4x4").string();
  EXPECT_EQ(runKirireel({"convert", model, (scratch / "sheet.fold").string()}).exitCode, 0);
  EXPECT_EQ(readText(scratch / "theirs"), "theirs");
  EXPECT_FALSE(fs::is_symlink(scratch / "sheet.fold"));
}

// The output folder may be a link. Files are then written to its target.
TEST(Links, ToTheOutputFolderAreFollowed) {
  const TemporaryFolder scratch;
  fs::create_directory(scratch / "disk");
  fs::create_symlink(scratch / "disk", scratch / "out");
  const ProgramEnd end =
      runKirireel({"simulate", shippedModel("tessellation_4x4").string(), "--out",
                   (scratch / "out").string(), "--duration", "0.1", "--path", "dynamic"});
  EXPECT_EQ(end.exitCode, kEndedShort) << end.err;
  EXPECT_THAT(filesIn(scratch / "disk"), Contains("summary.json"));
}

TEST(SceneTexts, AreNeverActedOn) {
  const TemporaryFolder scratch;
  const std::string made = (scratch / "made").string();
  const std::string command = "$(touch " + made + ")`touch " + made + "`|touch " + made + ";";
  const auto run = [&](const std::string& scene) {
    writeText(scratch / "scene.toml", scene);
    std::vector<std::string> words =
        recordArguments(shippedModel("tessellation_4x4"), scratch / "out");
    words.insert(words.end(), {"--scene", (scratch / "scene.toml").string()});
    return runKirireel(words);
  };
  for (const char* setting : {"[model]\ntarget", "[recording]\ngrid", "[style]\ncolour",
                              "[[obstacle]]\nshape = 'mesh'\nfile", "[[timeline]]\ntarget"}) {
    const ProgramEnd end = run(setting + std::string(" = '") + command + "'\n");
    EXPECT_EQ(end.exitCode, 2) << setting;
  }
  const ProgramEnd titled =
      runKirireel({"record", shippedModel("tessellation_4x4").string(), "--out",
                   (scratch / "out").string(), "--duration", "0.1", "--path", "dynamic", "--fps",
                   "10", "--size", "160x120", "--title", command});
  EXPECT_EQ(titled.exitCode, kEndedShort) << titled.err;
  EXPECT_FALSE(fs::exists(made));
}

}  // namespace
}  // namespace kirireel
