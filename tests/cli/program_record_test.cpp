// A whole recording with the real program, checked by other programs.
#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "sim/base/files.h"
#include "tests/cli/run_program.h"

namespace kirireel {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;

/// One recording for the tests below.
class Recording : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    end_ = runKirireel({"record", shippedModel("tessellation_4x4").string(), "--out", path(""),
                        "--size", "320x240", "--fps", "30", "--grid", "2x2", "--frames"});
    summary_ = Json::parse(readText(path("summary.json")), nullptr, /*allow_exceptions=*/false);
  }
  static void TearDownTestSuite() { delete folder_; }

  static std::string path(const std::string& name) { return (*folder_ / name).string(); }

  static inline TemporaryFolder* folder_ = nullptr;
  static inline ProgramEnd end_;
  static inline Json summary_;
};

TEST_F(Recording, EndsWell) {
  EXPECT_EQ(end_.exitCode, 0) << end_.err;
  EXPECT_EQ(end_.err, "");  // no progress line without a terminal
  EXPECT_THAT(end_.out, MatchesRegex("tessellation_4x4: target reached, error [0-9.e-]+ m\n"
                                     "16 tiles, 24 joints, planar; kinematic path, no overlaps\n"
                                     "joints closed to [0-9.e-]+ m\n"
                                     "[0-9]+ files in .* \\([0-9.]+ s\\)\n"));
}

TEST_F(Recording, LeavesEveryFileAndNoOther) {
  const std::vector<std::string> files = filesIn(folder_->path());
  for (const char* name :
       {"deployment.mp4", "snapshots.png", "initial.obj", "initial.ply", "final.obj", "final.ply",
        "final_vertices.txt", "trajectory.h5", "summary.json", "frames/frame_00000.png"}) {
    EXPECT_THAT(files, Contains(name));
  }
  std::vector<std::string> listed = summary_["files"];
  std::sort(listed.begin(), listed.end());
  EXPECT_EQ(files, listed);
}

TEST_F(Recording, VideoIsWhatPlayersExpect) {
  const ProgramEnd probe =
      runTool("ffprobe", {"-v", "error", "-count_frames", "-select_streams", "v:0", "-show_entries",
                          "stream=codec_name,width,height,pix_fmt,color_range,color_space,"
                          "r_frame_rate,nb_read_frames",
                          "-of", "default=noprint_wrappers=1", path("deployment.mp4")});
  ASSERT_EQ(probe.exitCode, 0) << "ffprobe is in the package ffmpeg: scripts/setup --with-tools";
  for (const char* fact : {"codec_name=h264", "width=320", "height=240", "pix_fmt=yuv420p",
                           "color_range=tv", "color_space=bt709", "r_frame_rate=30/1"}) {
    EXPECT_THAT(probe.out, HasSubstr(fact));
  }
  const int frames = summary_["video_frames"];
  EXPECT_THAT(probe.out, HasSubstr(fmt::format("nb_read_frames={}\n", frames)));
  EXPECT_EQ(frames, 8 * 30);  // --length and --fps
}

TEST_F(Recording, LastFrameDecodesToTheLastPicture) {
  const int frames = summary_["video_frames"];
  const int held = 15;  // --hold at both ends, with one picture each
  const std::string last = path(fmt::format("frames/frame_{:05}.png", frames - 1 - 2 * held));
  const ProgramEnd psnr =
      runTool("ffmpeg", {"-v", "info", "-i", path("deployment.mp4"), "-i", last, "-lavfi",
                         fmt::format("[0:v]select=eq(n\\,{})[v];[1:v]scale=out_color_matrix=bt709:"
                                     "out_range=tv,format=yuv420p[p];[v][p]psnr",
                                     frames - 1),
                         "-frames:v", "1", "-f", "null", "-"});
  const std::size_t at = psnr.err.find("average:");
  ASSERT_NE(at, std::string::npos) << psnr.err;
  EXPECT_GT(std::stod(psnr.err.substr(at + 8)), 35) << psnr.err;
}

TEST_F(Recording, MeshesHoldEveryBrick) {
  const ProgramEnd info = runTool("assimp", {"info", path("final.obj")});
  ASSERT_EQ(info.exitCode, 0) << "assimp is in the package assimp-utils";
  EXPECT_THAT(info.out, testing::ContainsRegex("Meshes: +16\n"));
}

TEST_F(Recording, SummaryHasTheKeysThatScriptsRelyOn) {
  for (const char* key : {"joint_gap_max", "joint_gap_mean", "joint_gap_end", "joint_opening_max",
                          "target_error_start", "target_error_end", "target_error_min",
                          "rigid_bound", "assembled_error", "penetration_max"}) {
    EXPECT_TRUE(summary_["accuracy"].contains(key)) << key;
  }
  for (const char* key : {"steps", "cpu_seconds_deploy", "cpu_seconds_render", "cpu_seconds_encode",
                          "wall_seconds", "peak_memory_bytes"}) {
    EXPECT_GT(summary_["cost"][key], 0) << key;
  }
  for (const char* key : {"planar", "contacts", "ground"}) {
    EXPECT_TRUE(summary_["needs"][key]["on"].is_boolean()) << key;
    EXPECT_NE(summary_["needs"][key]["reason"], "") << key;
  }
  for (const char* key : {"outcome", "reason", "model", "settings", "versions", "files"}) {
    EXPECT_TRUE(summary_.contains(key)) << key;
  }
  EXPECT_EQ(summary_["outcome"], "settled");
}

TEST_F(Recording, ReachesTheTargetWithClosedJoints) {
  EXPECT_LT(summary_["accuracy"]["target_error_end"], 1e-4);  // 1.0e-7
  EXPECT_LT(summary_["accuracy"]["joint_gap_max"], 1e-10);    // 1.0e-12
}

TEST_F(Recording, EndStateServesAsATarget) {
  const TemporaryFolder model;
  for (const char* name : {"vertices.txt", "constraints.txt"}) {
    std::filesystem::copy(shippedModel("tessellation_4x4") / name, model / name);
  }
  std::filesystem::copy(path("final_vertices.txt"), model / "target.txt");
  const ProgramEnd end =
      runKirireel({"simulate", model.path().string(), "--out", (model / "out").string()});
  EXPECT_EQ(end.exitCode, 0) << end.err;
}

/// The bytes of each file of a short run with so many threads that draw.
std::map<std::string, std::string> filesOfRun(const std::string& threads,
                                              const std::vector<std::string>& options) {
  const TemporaryFolder scratch;
  std::vector<std::string> call = {"LP_NUM_THREADS=" + threads, KIRIREEL_PROGRAM, "record", "--out",
                                   scratch.path().string(),     "--size",         "160x120"};
  call.insert(call.end(), options.begin(), options.end());
  const ProgramEnd end = runTool("env", call);
  EXPECT_THAT(end.exitCode, testing::AnyOf(0, kEndedShort)) << end.err;
  std::map<std::string, std::string> files;
  for (const std::string& name : filesIn(scratch.path())) files[name] = readText(scratch / name);
  files["summary.json"] = lastingSummary(scratch.path()).dump();
  return files;
}

void expectTheSameBytesInFiveRuns(const std::vector<std::string>& options) {
  const std::map<std::string, std::string> first = filesOfRun("0", options);
  for (const char* threads : {"1", "2", "4", "2"}) {
    const std::map<std::string, std::string> files = filesOfRun(threads, options);
    EXPECT_EQ(files.size(), first.size());
    for (const auto& [name, bytes] : first) {
      const auto same = files.find(name);
      EXPECT_TRUE(same != files.end() && same->second == bytes)
          << name << " with " << threads << " threads";
    }
  }
}

TEST(Record, LeavesTheSameBytesWithAnyNumberOfThreads) {
  expectTheSameBytesInFiveRuns({shippedModel("tessellation_4x4").string(), "--duration", "0.5"});
}

TEST(Record, LeavesTheSameBytesIfBricksTouchInSpace) {
  expectTheSameBytesInFiveRuns({shippedModel("cap").string(), "--duration", "0.1", "--path",
                                "straight", "--contacts", "all"});
}

TEST(Record, ReplacesOnlyAnEarlierRun) {
  const TemporaryFolder scratch;
  const std::vector<std::string> words = {"record", shippedModel("tessellation_4x4").string(),
                                          "--out", scratch.path().string(), "--no-video"};
  ASSERT_EQ(runKirireel(words).exitCode, 0);
  writeText(scratch / "notes.txt", "old");
  std::vector<std::string> fewer = words;
  fewer.insert(fewer.end(), {"--no-snapshots", "--no-meshes"});
  const ProgramEnd end = runKirireel(fewer);
  EXPECT_EQ(end.exitCode, 0) << end.err;
  EXPECT_THAT(filesIn(scratch.path()),
              ElementsAre("final_vertices.txt", "notes.txt", "summary.json", "trajectory.h5"));
}

TEST(Record, GoesToOutNameByDefault) {
  const TemporaryFolder scratch;
  ProgramSetting setting;
  setting.folder = scratch.path();
  const ProgramEnd end =
      runKirireel({"simulate", shippedModel("tessellation_4x4").string()}, setting);
  EXPECT_EQ(end.exitCode, 0) << end.err;
  EXPECT_THAT(filesIn(scratch / "out" / "tessellation_4x4"),
              ElementsAre("final_vertices.txt", "summary.json", "trajectory.h5"));
}

TEST(Simulate, ReportsThatASpellingSelectsOtherConstants) {
  const TemporaryFolder scratch;
  const ProgramEnd end = runKirireel({"simulate", shippedModel("tessellation_4x4").string(),
                                      "--no_collision", "--out", (scratch / "out").string()});
  EXPECT_THAT(end.out, HasSubstr("contacts on; PyKirigami's constants, by --no_collision\n"));
}

TEST(Record, JsonOnStandardOutputIsTheSummary) {
  const TemporaryFolder scratch;
  const ProgramEnd end = runKirireel({"simulate", shippedModel("tessellation_4x4").string(),
                                      "--out", scratch.path().string(), "--json"});
  EXPECT_EQ(end.out, readText(scratch / "summary.json"));
}

TEST(Generate, MakesAModelThatRecords) {
  const TemporaryFolder scratch;
  const std::string model = (scratch / "mine").string();
  EXPECT_EQ(runKirireel({"generate", "tessellation", model, "--columns", "3", "--rows", "2"}).out,
            model + ": 6 tiles, 7 joints\n");
  const ProgramEnd end = runKirireel({"simulate", model, "--out", (scratch / "out").string()});
  EXPECT_EQ(end.exitCode, 0) << end.err;
}

TEST(Generate, ShippedModelsComeFromIt) {
  const TemporaryFolder scratch;
  const std::string model = (scratch / "tessellation_4x4").string();
  ASSERT_EQ(runKirireel({"generate", "tessellation", model}).exitCode, 0);
  for (const std::string& name : filesIn(model)) {
    EXPECT_EQ(readText(scratch / "tessellation_4x4" / name),
              readText(shippedModel("tessellation_4x4") / name))
        << name;
  }
}

}  // namespace
}  // namespace kirireel
