// Requests to end, through the real program.
#include <csignal>
#include <cstring>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/cli/run_program.h"

namespace kirireel {
namespace {

/// Records into `out`, sends the signal when the file `sign` exists, and expects a video up to this
/// time.
void expectInterruptedVideo(int signal, const std::string& sign,
                            const std::vector<std::string>& options) {
  const TemporaryFolder scratch;
  const std::string out = (scratch / "out").string();
  std::vector<std::string> arguments = {
      "record", shippedModel("tessellation_4x4").string(), "--size", "320x240", "--out", out};
  arguments.insert(arguments.end(), options.begin(), options.end());
  RunningProgram program(arguments, {});
  ASSERT_TRUE(waitFor(out + sign));
  program.sendSignal(signal);
  const ProgramEnd end = program.wait();
  EXPECT_EQ(end.exitCode, 4) << end.err;
  EXPECT_THAT(end.out, testing::HasSubstr("interrupted"));
  const auto summary = nlohmann::json::parse(readText(out + "/summary.json"));
  EXPECT_EQ(summary["outcome"], "interrupted");
  EXPECT_THAT(summary["reason"].get<std::string>(),
              testing::StartsWith(std::string("interrupted by SIG") + sigabbrev_np(signal)));
  const ProgramEnd probe =
      runTool("ffprobe", {"-v", "error", "-count_frames", "-show_entries", "stream=nb_read_frames",
                          "-of", "csv=p=0", out + "/deployment.mp4"});
  EXPECT_EQ(probe.err, "");
  EXPECT_EQ(std::stoi(probe.out), summary["video_frames"]);
}

// Too many frames to wait for: with heavy damping, the bricks move all the time.
const std::vector<std::string> kLongPainting = {"--fps", "240", "--force-damping", "1e6"};
// Too many steps to wait for.
const std::vector<std::string> kLongDeployment = {"--solver", "bullet", "--substeps", "10000"};
// The first trial of a path already has too many steps to wait for.
const std::vector<std::string> kLongTrial = {"--timestep", "1e-7"};

TEST(Interrupt, WhilePaintingLeavesAPlayableVideo) {
  expectInterruptedVideo(SIGINT, "/.unfinished/deployment.part.mp4", kLongPainting);
}

TEST(Interrupt, WhileDeployingLeavesAPlayableVideo) {
  expectInterruptedVideo(SIGINT, "", kLongDeployment);
}

TEST(Interrupt, WhileSearchingAPathLeavesAPlayableVideo) {
  expectInterruptedVideo(SIGINT, "", kLongTrial);
}

TEST(Terminate, IsTreatedAsAnInterrupt) {
  expectInterruptedVideo(SIGTERM, "/.unfinished/deployment.part.mp4", kLongPainting);
}

TEST(Hangup, IsTreatedAsAnInterrupt) {
  expectInterruptedVideo(SIGHUP, "", kLongTrial);
}

TEST(Hangup, IsIgnoredWhereItWasIgnoredBefore) {
  const TemporaryFolder scratch;
  const std::string out = (scratch / "out").string();
  RunningProgram program({KIRIREEL_PROGRAM, "simulate", shippedModel("tessellation_4x4").string(),
                          "--timestep", "1e-7", "--out", out},
                         {.executable = "nohup"});
  ASSERT_TRUE(waitFor(out));
  program.sendSignal(SIGHUP);
  program.sendSignal(SIGTERM);
  EXPECT_EQ(program.wait().exitCode, 4);
  EXPECT_EQ(nlohmann::json::parse(readText(out + "/summary.json"))["reason"],
            "interrupted by SIGTERM");
}

TEST(Interrupt, OfAStudyKeepsTheFinishedRows) {
  const TemporaryFolder scratch;
  RunningProgram program({"study", "tessellation", "--quick", "--out", scratch.path().string()},
                         {});
  ASSERT_TRUE(waitFor(scratch / "tessellation.csv"));
  program.sendSignal(SIGINT);
  const ProgramEnd end = program.wait();
  EXPECT_EQ(end.exitCode, 4) << end.err;
  EXPECT_THAT(end.err,
              testing::HasSubstr("interrupted; --resume continues after the finished rows"));
  EXPECT_THAT(readText(scratch / "tessellation.csv"),
              testing::HasSubstr("\ndirect 1/240 s plane,"));
  EXPECT_FALSE(std::filesystem::exists(scratch / "tessellation.json"));
}

}  // namespace
}  // namespace kirireel
