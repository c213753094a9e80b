// Files that Kirireel did not write stay unchanged, for any name and any end of a run.
#include <csignal>
#include <map>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/cli/run_program.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using Words = std::vector<std::string>;

/// All entries of a folder: type, and content or link target.
std::map<std::string, std::string> treeOf(const fs::path& folder) {
  std::map<std::string, std::string> tree;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    std::string& shown = tree[entry.path().lexically_relative(folder).string()];
    if (entry.is_symlink())
      shown = "link to " + fs::read_symlink(entry.path()).string();
    else if (entry.is_directory())
      shown = "folder";
    else
      shown = "file " + readText(entry.path());
  }
  return tree;
}

/// The names that a run with all its options, an export and a rendering may write.
const Words kOurNames = {"summary.json",
                         "final_vertices.txt",
                         "trajectory.h5",
                         "initial.obj",
                         "initial.ply",
                         "final.obj",
                         "final.ply",
                         "deployment.mp4",
                         "snapshots.png",
                         "snapshot_01.svg",
                         "frames/frame_00000.png",
                         "state_0000.obj",
                         "state_0000.vtu",
                         "state_0000_mesh.inp",
                         "state_0000_job.inp",
                         "deployment.glb",
                         "deployment.pvd",
                         "cut_pattern.svg",
                         "state_0003_planar.obj",
                         "export_0001.obj",
                         "snapshot_0001.png"};

class Folders : public testing::Test {
 protected:
  static Words recordInto(const fs::path& out, const Words& more = {}) {
    Words words = {"record",     shippedModel("tessellation_4x4").string(),
                   "--out",      out.string(),
                   "--size",     "96x64",
                   "--fps",      "10",
                   "--duration", "0.3",
                   "--path",     "straight"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }

  static Words recordAll(const fs::path& out) {
    return recordInto(
        out, {"--frames", "--svg", "--export", "obj,vtu,inp,glb,svg,planar", "--states", "all"});
  }

  /// Expects that a command is refused in one line and nothing in the folder changes.
  void expectRefused(const Words& words, const std::string& name) const {
    const auto before = treeOf(out_);
    const ProgramEnd end = runKirireel(words);
    EXPECT_EQ(end.exitCode, 2) << words.front() << ' ' << name;
    EXPECT_THAT(end.err, HasSubstr("would be overwritten, but no earlier run wrote")) << name;
    EXPECT_EQ(std::count(end.err.begin(), end.err.end(), '\n'), 1);
    EXPECT_EQ(treeOf(out_), before) << words.front() << ' ' << name;
  }

  void emptyOut() const {
    fs::remove_all(out_);
    fs::create_directories(out_ / "frames");
  }

  TemporaryFolder scratch_;
  fs::path out_ = scratch_ / "out";
};

TEST_F(Folders, KeepForeignFilesWithOurNames) {
  for (const std::string& name : kOurNames) {
    emptyOut();
    writeText(out_ / name, "theirs");
    fs::permissions(out_ / name, fs::perms::owner_read);
    expectRefused(recordAll(out_), name);
  }
}

TEST_F(Folders, KeepForeignFoldersAndLinks) {
  const fs::path theirs = scratch_ / "theirs";
  fs::create_directory(theirs);
  writeText(theirs / "video", "theirs");
  writeText(theirs / "frame_00000.png", "theirs");
  const auto before = treeOf(theirs);
  for (const char* name : {"final.obj", "deployment.mp4", "summary.json"}) {
    emptyOut();
    fs::create_directory(out_ / name);
    writeText(out_ / name / "inside", "theirs");
    expectRefused(recordInto(out_), name);
    for (const fs::path& end : {theirs / "video", theirs, theirs / "nowhere"}) {
      emptyOut();
      fs::create_symlink(end, out_ / name);
      expectRefused(recordInto(out_), name);
    }
  }
  emptyOut();
  fs::remove(out_ / "frames");
  fs::create_directory_symlink(theirs, out_ / "frames");
  expectRefused(recordInto(out_, {"--frames"}), "frames");
  EXPECT_EQ(treeOf(theirs), before);
}

TEST_F(Folders, KeepAllOtherForeignFiles) {
  const Words names = {"notes.txt",      "deployment.part.mp4", "trajectory.part.h5",
                       "talk.webm",      "frames/own.png",      "final.part.obj",
                       "state_0000.stl", "contents.json.bak"};
  emptyOut();
  for (const std::string& name : names) writeText(out_ / name, "theirs");
  for (int k = 0; k < 2; ++k) {
    ASSERT_EQ(runKirireel(recordInto(out_, {"--frames"})).err, "");
    for (const std::string& name : names) EXPECT_EQ(readText(out_ / name), "theirs") << name;
  }
}

TEST_F(Folders, OfOtherCommandsAreKeptToo) {
  const fs::path run = scratch_ / "run";
  runKirireel(recordInto(run));
  const Words exported = {"export", run.string(), "--format", "obj,glb", "--out", out_.string()};
  const Words rendered = {
      "render", (run / "trajectory.h5").string(), "--size", "96x64", "--out", out_.string()};
  for (const char* name : {"state_initial.obj", "deployment.glb", "contents.json"}) {
    emptyOut();
    writeText(out_ / name, "theirs");
    expectRefused(exported, name);
  }
  for (const char* name : {"deployment.mp4", "snapshots.png", "contents.json"}) {
    emptyOut();
    writeText(out_ / name, "theirs");
    expectRefused(rendered, name);
  }
  for (const char* name : {"vertices.txt", "constraints.txt", "target.txt", "pull.txt"}) {
    emptyOut();
    writeText(out_ / name, "theirs");
    const auto before = treeOf(out_);
    const ProgramEnd end = runKirireel({"generate", "tessellation", out_.string()});
    EXPECT_EQ(end.exitCode, 2);
    EXPECT_EQ(
        end.err,
        "kirireel: " + (out_ / name).string() +
            ": error: this file belongs to another model. Move it, or choose another folder\n");
    EXPECT_EQ(treeOf(out_), before);
  }
}

TEST_F(Folders, AllowASecondExportAndASecondPicture) {
  runKirireel(recordInto(out_));
  const std::string trajectory = (out_ / "trajectory.h5").string();
  for (const char* format : {"obj", "obj,stl"}) {
    EXPECT_EQ(runKirireel({"export", out_.string(), "--format", format}).exitCode, 0);
    EXPECT_EQ(runKirireel({"render", trajectory, "--size", "64x64"}).exitCode, 0);
    const ProgramEnd end = runKirireel({"verify", out_.string()});
    EXPECT_EQ(end.exitCode, 0) << end.out;
  }
  writeText(out_ / "state_initial.stl", "changed");
  EXPECT_THAT(runKirireel({"verify", out_.string()}).out, HasSubstr("state_initial.stl: 7 bytes"));
  fs::remove(out_ / "state_initial.stl");
  // A new run replaces all of it.
  runKirireel(recordInto(out_, {"--thickness", "0.03"}));
  EXPECT_EQ(runKirireel({"verify", out_.string()}).exitCode, 0);
  EXPECT_FALSE(fs::exists(out_ / "state_initial.obj"));
  EXPECT_FALSE(fs::exists(out_ / "contents.json"));
}

TEST_F(Folders, LoseTheStaleFilesOfAnEarlierRun) {
  runKirireel(recordInto(out_, {"--video", "talk.webm", "--frames"}));
  ASSERT_TRUE(fs::exists(out_ / "talk.webm") && fs::exists(out_ / "frames"));
  runKirireel({"simulate", shippedModel("tessellation_4x4").string(), "--out", out_.string(),
               "--duration", "0.1", "--path", "straight"});
  EXPECT_THAT(filesIn(out_),
              testing::ElementsAre("final_vertices.txt", "summary.json", "trajectory.h5"));
  EXPECT_FALSE(fs::exists(out_ / "frames"));
}

TEST_F(Folders, KeepTheEarlierRunWhenANewOneFails) {
  runKirireel(recordInto(out_));
  const auto before = treeOf(out_);
  for (const rlim_t bytes : {1000, 5000, 30000}) {
    ProgramSetting setting;
    setting.largestFile = bytes;  // as on a full disk
    const ProgramEnd end = runKirireel(recordInto(out_, {"--thickness", "0.03"}), setting);
    EXPECT_EQ(end.exitCode, 1) << bytes;
    EXPECT_EQ(treeOf(out_), before) << bytes;
  }
  for (const char* wrong : {"--encoder", "--camera-keys"}) {
    const char* value = wrong == std::string("--encoder") ? "libx999" : "1:0:0:1,0:0:0:1";
    EXPECT_NE(runKirireel(recordInto(out_, {wrong, value})).exitCode, 0);
    EXPECT_EQ(treeOf(out_), before) << wrong;
  }
  EXPECT_EQ(runKirireel({"verify", out_.string()}).exitCode, 0);
}

TEST_F(Folders, KeepTheEarlierRunWhenANewOneIsKilled) {
  runKirireel(recordInto(out_));
  const auto before = treeOf(out_);
  for (const int milliseconds : {20, 100, 300}) {
    RunningProgram program(recordInto(out_, {"--duration", "60", "--force-damping", "1e6"}), {});
    std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
    program.sendSignal(SIGKILL);
    program.wait();
    auto after = treeOf(out_);
    std::erase_if(after, [](const auto& file) { return file.first.starts_with(".unfinished"); });
    EXPECT_EQ(after, before);
    EXPECT_EQ(runKirireel({"verify", out_.string()}).exitCode, 0);
  }
  // The same command again finds its run finished, and removes temporary files.
  EXPECT_THAT(runKirireel(recordInto(out_, {"--resume"})).out, HasSubstr("finished already"));
  EXPECT_EQ(treeOf(out_), before);
}

TEST_F(Folders, OfSweepsKeepTheirTables) {
  writeText(scratch_ / "sweep.toml",
            "generate = \"tessellation\"\n[base]\nduration = 0.01\npath = \"straight\"\n"
            "[grid]\ncolumns = [2, 3]\n");
  const Words words = {"sweep", (scratch_ / "sweep.toml").string(), "--out", out_.string()};
  ASSERT_EQ(runKirireel(words).exitCode, 0);
  ASSERT_EQ(runKirireel(words).exitCode, 0);  // the same tables, made again
  writeText(out_ / "sweep.csv", "edited by hand");
  const auto before = treeOf(out_);
  const ProgramEnd end = runKirireel(words);
  EXPECT_EQ(end.exitCode, 2);
  EXPECT_THAT(end.err, HasSubstr("error: sweep.csv would be overwritten"));
  EXPECT_EQ(treeOf(out_), before);
}

}  // namespace
}  // namespace kirireel
