// Every kind of bad input to the real program: one line on standard error, the right exit code, and
// no files.
#include <algorithm>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mount.h>
#include <unistd.h>

#include "tests/cli/run_program.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* kSquares = "0 0 0 1 0 0 1 1 0 0 1 0\n1 0 0 2 0 0 2 1 0 1 1 0\n";
constexpr const char* kJoint = "0 1 1 0 3\n";

void expectOneLine(const ProgramEnd& end, int exitCode, const std::string& part) {
  EXPECT_EQ(end.exitCode, exitCode) << end.err;
  EXPECT_EQ(std::count(end.err.begin(), end.err.end(), '\n'), 1) << end.err;
  EXPECT_TRUE(end.err.starts_with("kirireel: ")) << end.err;
  EXPECT_THAT(end.err, HasSubstr(part));
  EXPECT_EQ(end.out, "");
}

/// Records a model with these files; "absent" leaves one out.
void expectRefused(const std::string& vertices, const std::string& joints,
                   const std::string& part) {
  const TemporaryFolder scratch;
  if (vertices != "absent") writeText(scratch / "vertices.txt", vertices);
  if (joints != "absent") writeText(scratch / "constraints.txt", joints);
  const auto out = scratch / "out";
  const ProgramEnd end = runKirireel({"record", scratch.path().string(), "--out", out.string()});
  expectOneLine(end, 2, part);
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST(BadModel, OverlappingTiles) {
  const TemporaryFolder scratch;
  writeText(scratch / "vertices.txt",
            "0 0 0 1 0 0 1 1 0 0 1 0\n0.5 0 0 1.5 0 0 1.5 1 0 0.5 1 0\n"
            "1.2 0 0 2.2 0 0 2.2 1 0 1.2 1 0\n");
  writeText(scratch / "constraints.txt", "# no joints\n");
  const ProgramEnd end = runKirireel({"inspect", scratch.path().string()});
  EXPECT_EQ(end.exitCode, 0);
  EXPECT_THAT(end.err, testing::EndsWith(
                           ": warning: tiles 0 and 1 overlap by 0.5 m at the start, the deepest of "
                           "2 pairs; move them apart, or allow overlaps with --contacts none\n"));
}

TEST(BadModel, MissingFile) {
  expectRefused("absent", kJoint, "vertices.txt: error: ");
  expectRefused(kSquares, "absent", "constraints.txt: error: ");
}

TEST(BadModel, EmptyFile) {
  expectRefused("", kJoint, "vertices.txt: error: ");
}

TEST(BadModel, OddNumberOfCoordinates) {
  expectRefused("0 0 0 1 0 0 1 1\n", kJoint, "vertices.txt:1:");
}

TEST(BadModel, Letters) {
  expectRefused("0 0 0 1 0 0 1 one 0\n", kJoint, "vertices.txt:1:15: error: ");
  expectRefused(kSquares, "0 1 1 a\n", "constraints.txt:1:7: error: ");
}

TEST(BadModel, NotANumberAndHugeNumbers) {
  expectRefused("0 0 0 1 0 0 1 nan 0\n", kJoint, "vertices.txt:1:15: error: ");
  expectRefused("0 0 0 1 0 0 1 1e300 0\n", kJoint, "vertices.txt:1:15: error: ");
  expectRefused(kSquares, "0 1 99999999999999999999 0\n", "constraints.txt:1:5: error: ");
}

TEST(BadModel, IndexOutOfRange) {
  expectRefused(kSquares, "0 1 7 0\n", "constraints.txt:1:5: error: ");
  expectRefused(kSquares, "0 4 1 0\n", "constraints.txt:1:3: error: ");
}

TEST(BadModel, JointToItself) {
  expectRefused(kSquares, "0 1 0 1\n", "constraints.txt:1");
}

TEST(BadModel, TileOfTwoVertices) {
  expectRefused("0 0 0 1 0 0\n", kJoint, "vertices.txt:1");
}

TEST(BadModel, NoSuchFolder) {
  expectOneLine(runKirireel({"record", "/no/such/model"}), 2, "/no/such/model: error: ");
}

// The system cannot look up names of more than 255 bytes.
TEST(BadModel, NamesThatAreTooLong) {
  const std::string name(300, 'a');
  const std::string known = shippedModel("fan").string();
  const std::vector<std::vector<std::string>> commands = {{"inspect", name},
                                                          {"inspect", name + ".svg"},
                                                          {"simulate", name + ".toml"},
                                                          {"simulate", known, "--target", name},
                                                          {"render", name},
                                                          {"curves", name},
                                                          {"page", name},
                                                          {"verify", name},
                                                          {"sweep", name + ".toml"},
                                                          {"figure", name + ".toml"}};
  for (const std::vector<std::string>& command : commands) {
    SCOPED_TRACE(command.front());
    expectOneLine(runKirireel(command), 2, "error: ");
  }
}

TEST(BadCommandLine, EndsWithTwo) {
  expectOneLine(runKirireel({"record", "fan", "--thicknes", "1"}), 2,
                "unknown option --thicknes, did you mean --thickness?");
  expectOneLine(runKirireel({"record", "fan", "--thickness", "-1"}), 2, "--thickness: '-1'");
  expectOneLine(runKirireel({}), 2, "no command given");
}

TEST(BadCommandLine, OddVideoSizeIsRefusedBeforeTheRun) {
  const TemporaryFolder scratch;
  const auto out = scratch / "out";
  expectOneLine(runKirireel({"record", shippedModel("tessellation_4x4").string(), "--size",
                             "641x480", "--out", out.string()}),
                2, "--size 642x480");
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST(BadCommandLine, ReportsTheAllowedRange) {
  for (const char* option : {"--linear-damping", "--angular-damping"}) {
    expectOneLine(
        runKirireel({"simulate", "fan", option, "1"}), 2,
        std::string(option) + ": '1' is not allowed; give a number from 0 to less than 1");
  }
}

TEST(BadCommandLine, TitleThatNoFontCanWrite) {
  const TemporaryFolder scratch;
  // A machine with DejaVu Sans only.
  writeText(scratch / "fonts.conf",
            "<fontconfig><dir>/usr/share/fonts/truetype/dejavu</dir><cachedir>" +
                (scratch / "cache").string() + "</cachedir></fontconfig>");
  ::setenv("FONTCONFIG_FILE", (scratch / "fonts.conf").c_str(), 1);
  const auto record = [&](const std::string& title) {
    return runKirireel({"record", shippedModel("tessellation_4x4").string(), "--title", title,
                        "--out", (scratch / "out").string()});
  };
  const auto expectScript = [&](const std::string& character, const std::string& script,
                                const std::string& package) {
    expectOneLine(record(character), 2,
                  " '" + character + "' (" + script + "), character 1 of '" + character +
                      "'; remove it, or install a font that has it, for example from Debian's " +
                      package);
  };
  expectOneLine(record("caf\u00e9 \u4e2d"), 2,
                "error: --title: no font has U+4E2D '\u4e2d' (Chinese or Japanese), character 6 of "
                "'caf\u00e9 \u4e2d'; remove it, or install a font that has it, for example from "
                "Debian's fonts-noto-cjk");
  expectScript("\u3002", "Chinese or Japanese", "fonts-noto-cjk");  // in no script
  expectScript("\u304b", "Japanese", "fonts-noto-cjk");
  expectScript("\ud55c", "Korean", "fonts-noto-cjk");
  expectScript("\u0939", "Devanagari", "fonts-noto-core");
  expectScript("\u0e01", "Thai", "fonts-noto-core");
  expectScript("\u0b95", "another script", "fonts-noto-core");
  expectScript("\U0001f9e9", "a symbol or emoji", "fonts-symbola");
  expectOneLine(record("a\x07"), 2, "no font has U+0007, character 2 of 'a?'; remove it");
  ::unsetenv("FONTCONFIG_FILE");
  expectOneLine(record("caf\xe9"), 2,
                "error: --title: 'caf?' is not UTF-8; give the text in that encoding");
  EXPECT_FALSE(std::filesystem::exists(scratch / "out"));
}

TEST(BadModel, ThicknessInAnotherUnit) {
  const TemporaryFolder scratch;
  const auto complaint = [&](const char* thickness) {
    return runKirireel({"simulate", shippedModel("tessellation_4x4").string(), "--out",
                        (scratch / "out").string(), "--duration", "0.01", "--thickness", thickness})
        .err;
  };
  EXPECT_EQ(
      complaint("0.11"),
      "kirireel: tessellation_4x4: warning: bricks are 0.11 m thick, but a tile's mean edge is "
      "1 m; lengths are in metres; try --thickness 0.02\n");
  EXPECT_EQ(
      complaint("0.0009"),
      "kirireel: tessellation_4x4: warning: bricks are 0.0009 m thick, but a tile's mean edge "
      "is 1 m; lengths are in metres; try --thickness 0.02\n");
  const ProgramEnd inspected =
      runKirireel({"inspect", shippedModel("tessellation_4x4").string(), "--thickness", "0.11"});
  EXPECT_EQ(inspected.exitCode, 0);
  EXPECT_EQ(inspected.err, complaint("0.11"));
  EXPECT_EQ(complaint("0.1"), "");
  EXPECT_EQ(complaint("0.001"), "");
}

TEST(BadOutput, FolderThatCannotBeMade) {
  const TemporaryFolder scratch;
  writeText(scratch / "file", "not a folder");
  const std::string model = shippedModel("tessellation_4x4").string();
  const std::string inFile = (scratch / "file" / "out").string();
  expectOneLine(runKirireel({"record", model, "--out", inFile}), 1,
                inFile + ": error: the folder cannot be created (Not a directory)");
  const std::string onFile = (scratch / "file").string();
  expectOneLine(runKirireel({"record", model, "--out", onFile}), 1,
                onFile + ": error: the folder cannot be created");
  // Even root cannot make folders here.
  expectOneLine(runKirireel({"record", model, "--out", "/proc/kirireel"}), 1,
                "/proc/kirireel: error: the folder cannot be created");
}

std::vector<std::string> recordArguments(const std::filesystem::path& out) {
  return {"record",     shippedModel("tessellation_4x4").string(),
          "--out",      out.string(),
          "--duration", "0.2",
          "--size",     "640x480"};
}

TEST(BadOutput, FileThatCannotGrowLeavesNothingHalfWritten) {
  // Below the trajectory's size, below the pictures' size.
  for (const int size : {4000, 60000}) {
    const TemporaryFolder scratch;
    ProgramSetting setting;
    setting.largestFile = size;
    const ProgramEnd end = runKirireel(recordArguments(scratch / "out"), setting);
    expectOneLine(end, 1, "File too large");
    EXPECT_THAT(filesIn(scratch / "out"), testing::Each(testing::Not(HasSubstr(".part"))));
  }
}

/// A small memory disk, if the system allows mounting one.
class SmallDisk {
 public:
  explicit SmallDisk(std::uintmax_t bytes, unsigned long flags = 0)
      : mounted_(::mount("tmpfs", folder_.path().c_str(), "tmpfs", flags,
                         ("size=" + std::to_string(bytes)).c_str()) == 0) {}
  ~SmallDisk() {
    if (mounted_) ::umount(folder_.path().c_str());
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

  bool isMounted() const { return mounted_; }
  const std::filesystem::path& path() const { return folder_.path(); }

 private:
  TemporaryFolder folder_;
  bool mounted_;
};

// Finished files are those of a normal run, without any other files.
TEST(BadOutput, FullDiskLeavesFinishedFilesIntact) {
  const TemporaryFolder whole;
  ASSERT_EQ(runKirireel(recordArguments(whole.path())).exitCode, 0);
  std::uintmax_t needed = 0;
  for (const std::string& name : filesIn(whole.path())) {
    needed += std::filesystem::file_size(whole / name);
  }
  constexpr int kPoints = 8;
  for (int point = 1; point <= kPoints; ++point) {
    const std::uintmax_t size = needed * point / (kPoints + 1);
    const SmallDisk disk(size);
    if (!disk.isMounted()) GTEST_SKIP() << "mounting a small disk needs the superuser";
    expectOneLine(runKirireel(recordArguments(disk.path())), 1, "No space left on device");
    for (const std::string& name : filesIn(disk.path())) {
      EXPECT_TRUE(readText(disk.path() / name) == readText(whole / name)) << size << ' ' << name;
    }
  }
}

TEST(BadOutput, FolderThatCannotBeWritten) {
  const SmallDisk disk(65536, MS_RDONLY);
  if (!disk.isMounted()) GTEST_SKIP() << "mounting a small disk needs the superuser";
  expectOneLine(
      runKirireel(recordArguments(disk.path())), 1,
      disk.path().string() +
          ": error: cannot write in this folder (Read-only file system). Choose another folder");
}

TEST(BadOutput, FolderOfARunningRun) {
  const TemporaryFolder scratch;
  std::vector<std::string> slow = recordArguments(scratch.path());
  slow.insert(slow.end(), {"--solver", "bullet", "--substeps", "10000"});
  const RunningProgram first(slow, {});
  while (!std::filesystem::exists(scratch / ".unfinished/trajectory.part.h5")) ::usleep(10000);
  expectOneLine(runKirireel(recordArguments(scratch.path())), 1,
                scratch.path().string() +
                    ": error: another run is writing into this folder; wait "
                    "for its end, or choose another with --out");
}

TEST(BadSystem, MissingEncoder) {
  const TemporaryFolder scratch;
  std::vector<std::string> words = recordArguments(scratch.path());
  words.insert(words.end(), {"--encoder", "libx999"});
  expectOneLine(runKirireel(words), 1, "libavcodec has no encoder libx999 here");
  EXPECT_THAT(filesIn(scratch.path()), IsEmpty());
}

TEST(BadSystem, MissingPrograms) {
  const TemporaryFolder folder;
  const std::string run = (folder / "run").string();
  const std::string out = (folder / "out").string();
  runKirireel(
      {"simulate", shippedModel("tessellation_4x4").string(), "--duration", "0.1", "--out", run});
  const std::pair<std::string, std::string> cases[] = {
      {"--format obj,inp --joints neck --neck-width 0.1",
       "gmsh cannot be run (No such file or directory); it meshes sheets with necks: install it "
       "(Debian: apt-get install gmsh) or choose other --joints"},
      {"--format stl,step --joints neck --neck-width 0.1",
       "gmsh cannot be run (No such file or directory); it writes STEP files: install it (Debian: "
       "apt-get install gmsh) or choose another format"},
      {"--format inp --check",
       "ccx cannot be run (No such file or directory); it checks decks: install it (Debian: "
       "apt-get install calculix-ccx) or remove --check"}};
  for (const auto& [options, message] : cases) {
    std::vector<std::string> words = {
        "PATH=/nowhere", KIRIREEL_PROGRAM, "export", run, "--out", out};
    std::istringstream typed(options);
    for (std::string word; typed >> word;) words.push_back(word);
    const ProgramEnd end = runTool("env", words);
    EXPECT_EQ(end.exitCode, 2);
    EXPECT_EQ(end.err, "kirireel: error: the program " + message + "\n");
    EXPECT_FALSE(std::filesystem::exists(out));
  }
}

TEST(BadSystem, TooLittleMemory) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers need an address space without bounds";
#endif
  ProgramSetting setting;
  setting.maxMemory = 570'000'000;  // 450 MB are the program's libraries
  if (runKirireel({"--version"}, setting).exitCode != 0) {
    GTEST_SKIP() << "the libraries here are too large for this limit";
  }
  const TemporaryFolder scratch;
  const std::string model = (scratch / "model").string();
  expectOneLine(
      runKirireel({"generate", "tessellation", model, "--columns", "500", "--rows", "500"},
                  setting),
      1, "error: there is too little memory; allow more, or use fewer tiles, a smaller");
}

TEST(BadSystem, LibraryThatNeverEnds) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers want to be the first library";
#endif
  const std::string preload = "LD_PRELOAD=" KIRIREEL_ENDLESS_LIBRARY;
  const auto run = [&preload](const std::string& word) {
    return runTool("env", {preload, "timeout", "--signal=KILL", "20", KIRIREEL_PROGRAM, word});
  };
  EXPECT_EQ(run("--version").exitCode, 0);
  EXPECT_EQ(run("--no-such-option").exitCode, 2);
}

TEST(BadSystem, StandardOutputThatIsFull) {
  ProgramSetting setting;
  setting.output = "/dev/full";
  const std::string model = shippedModel("tessellation_4x4").string();
  const std::string part =
      "error: standard output cannot be written (No space left on device); the files were written";
  const TemporaryFolder scratch;
  const std::string out = (scratch / "out").string();
  expectOneLine(runKirireel({"--help"}, setting), 1, part);
  expectOneLine(runKirireel({"record", "--help"}, setting), 1, part);
  expectOneLine(runKirireel({"--version"}, setting), 1, part);
  expectOneLine(runKirireel({"inspect", model}, setting), 1, part);
  expectOneLine(runKirireel({"inspect", model, "--json"}, setting), 1, part);
  expectOneLine(runKirireel({"generate", "tessellation", (scratch / "model").string()}, setting), 1,
                part);
  // The run is still complete, and its summary is longer than the buffer.
  expectOneLine(runKirireel({"simulate", model, "--out", out, "--json"}, setting), 1, part);
  EXPECT_EQ(runKirireel({"verify", out}).exitCode, 0);
  expectOneLine(runKirireel({"verify", out}, setting), 1, part);
}

TEST(BadSystem, NoOpenGl) {
  const TemporaryFolder scratch;
  std::vector<std::string> words = recordArguments(scratch.path());
  // The driver then supports less than the required version.
  words.insert(words.begin(), {"MESA_GL_VERSION_OVERRIDE=2.1", KIRIREEL_PROGRAM});
  expectOneLine(runTool("env", words), 1, "error: cannot make an OpenGL 3.3 context off screen");
  EXPECT_THAT(filesIn(scratch.path()), IsEmpty());
}

}  // namespace
}  // namespace kirireel
