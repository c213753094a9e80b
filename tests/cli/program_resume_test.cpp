// `--resume` through the real program.
#include <csignal>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "sim/base/files.h"
#include "tests/cli/run_program.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;
std::vector<std::string> recordInto(const fs::path& out, const std::vector<std::string>& more) {
  std::vector<std::string> words = {"record",     shippedModel("nonrigid").string(),
                                    "--size",     "320x240",
                                    "--duration", "0.5",
                                    "--path",     "dynamic",
                                    "--svg",      "--out",
                                    out.string()};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

void expectSameRun(const fs::path& folder, const fs::path& undisturbed) {
  EXPECT_EQ(filesIn(folder), filesIn(undisturbed));
  for (const std::string& name : filesIn(undisturbed)) {
    if (name == "summary.json") continue;
    EXPECT_TRUE(readText(folder / name) == readText(undisturbed / name)) << name;
  }
  EXPECT_EQ(lastingSummary(folder), lastingSummary(undisturbed));
}

class Resume : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    undisturbed_ = new TemporaryFolder;
    ASSERT_EQ(runKirireel(recordInto(undisturbed_->path(), {})).exitCode, kEndedShort);
  }
  static void TearDownTestSuite() { delete undisturbed_; }

  static TemporaryFolder* undisturbed_;
  TemporaryFolder scratch_;
};
TemporaryFolder* Resume::undisturbed_ = nullptr;

TEST_F(Resume, EndsLikeAnUninterruptedRunAfterAnyKill) {
  for (const int signal : {SIGTERM, SIGKILL}) {
    for (const int milliseconds : {30, 150, 400}) {
      {
        RunningProgram program(recordInto(scratch_.path(), {}), {});
        std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
        program.sendSignal(signal);
        program.wait();
      }
      const ProgramEnd end = runKirireel(recordInto(scratch_.path(), {"--resume"}));
      EXPECT_EQ(end.exitCode, kEndedShort) << end.err;
      expectSameRun(scratch_.path(), undisturbed_->path());
      fs::remove_all(scratch_.path());
    }
  }
}

/// A run of several seconds. Its first checkpoint is due after two.
class ResumeOnTheWay : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(runKirireel({"generate", "tessellation", model_, "--columns", "16", "--rows", "16"})
                  .exitCode,
              0);
  }

  std::vector<std::string> recordLongInto(const fs::path& out,
                                          const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words = {"record",   model_,       "--planar", "off",        "--path",
                                      "straight", "--timestep", "1e-4",     "--duration", "0.5",
                                      "--size",   "160x120",    "--length", "2",          "--svg",
                                      "--out",    out.string()};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }

  /// Runs until a checkpoint exists, then sends a signal. Returns the error stream.
  std::string endBy(int signal, const std::vector<std::string>& words) const {
    RunningProgram program(words, {});
    EXPECT_TRUE(waitFor(out_ / ".unfinished/checkpoint/state.h5"));
    program.sendSignal(signal);
    const ProgramEnd end = program.wait();
    EXPECT_EQ(end.exitCode, signal == SIGKILL ? -SIGKILL : 4);
    return end.err;
  }

  TemporaryFolder scratch_;
  std::string model_ = (scratch_ / "model").string();
  fs::path out_ = scratch_ / "out";
};

TEST_F(ResumeOnTheWay, ContinuesFromTheLastCheckpoint) {
  ASSERT_EQ(runKirireel(recordLongInto(scratch_ / "whole")).exitCode, kEndedShort);
  EXPECT_FALSE(fs::exists(scratch_ / "whole/.unfinished"));
  EXPECT_EQ(endBy(SIGTERM, recordLongInto(out_)), "");
  EXPECT_TRUE(fs::exists(out_ / ".unfinished/checkpoint/state.h5"));
  // The checkpoint remains after a kill.
  const auto continues =
      testing::MatchesRegex("kirireel: continues at .* s from the checkpoint in .*\n");
  endBy(SIGKILL, recordLongInto(out_, {"--resume"}));
  const ProgramEnd end = runKirireel(recordLongInto(out_, {"--resume"}));
  EXPECT_EQ(end.exitCode, kEndedShort) << end.err;
  EXPECT_THAT(end.err, continues);
  expectSameRun(out_, scratch_ / "whole");
}

TEST_F(ResumeOnTheWay, StartsAgainForAnotherOrdersCheckpoint) {
  endBy(SIGTERM, recordLongInto(out_));
  const ProgramEnd end = runKirireel(recordLongInto(out_, {"--duration", "0.02", "--resume"}));
  EXPECT_EQ(end.err,
            "kirireel: the checkpoint in " + (out_ / ".unfinished/checkpoint").string() +
                " is from another order or program version. The run starts from the beginning\n");
  EXPECT_EQ(end.exitCode, kEndedShort);
  EXPECT_FALSE(fs::exists(out_ / ".unfinished"));
}

TEST_F(ResumeOnTheWay, OnlyOnRequest) {
  endBy(SIGTERM, recordLongInto(out_));
  const ProgramEnd end = runKirireel(recordLongInto(out_, {"--duration", "0.02"}));
  EXPECT_EQ(end.err, "");
  EXPECT_FALSE(fs::exists(out_ / ".unfinished"));
}

TEST_F(Resume, LeavesAFinishedRunAsItIs) {
  fs::copy(undisturbed_->path(), scratch_.path());
  // Killed just before its end.
  fs::create_directories(scratch_ / ".unfinished/checkpoint");
  writeText(scratch_ / ".unfinished/checkpoint/state.h5", "");
  writeText(scratch_ / ".unfinished/kirireel.txt",
            "Kirireel works here. It moves whole files out of this folder and removes all "
            "others.\n");
  const std::string summary = readText(scratch_ / "summary.json");
  const ProgramEnd end = runKirireel(recordInto(scratch_.path(), {"--resume"}));
  EXPECT_EQ(end.exitCode, kEndedShort) << end.err;
  EXPECT_EQ(end.out, scratch_.path().string() + ": finished already, out_of_time\n");
  EXPECT_EQ(runKirireel(recordInto(scratch_.path(), {"--resume", "--json"})).out, summary);
  EXPECT_EQ(readText(scratch_ / "summary.json"), summary);
  EXPECT_EQ(filesIn(scratch_.path()), filesIn(undisturbed_->path()));
}

TEST_F(Resume, RepeatsARunWithAMissingFile) {
  fs::copy(undisturbed_->path(), scratch_.path());
  fs::remove(scratch_ / "final.obj");
  EXPECT_EQ(runKirireel(recordInto(scratch_.path(), {"--resume"})).exitCode, kEndedShort);
  expectSameRun(scratch_.path(), undisturbed_->path());
}

TEST_F(Resume, KeepsAChangedFile) {
  fs::copy(undisturbed_->path(), scratch_.path());
  writeText(scratch_ / "final.obj", "edited by hand");
  const ProgramEnd end = runKirireel(recordInto(scratch_.path(), {"--resume"}));
  EXPECT_EQ(end.exitCode, 2);
  EXPECT_EQ(end.err, "kirireel: " + scratch_.path().string() +
                         ": error: final.obj would be overwritten, but no earlier run wrote it in "
                         "this form; move it away, or choose another folder with --out\n");
  EXPECT_EQ(readText(scratch_ / "final.obj"), "edited by hand");
}

TEST_F(Resume, RepeatsTheRunOfAnotherOrder) {
  fs::copy(undisturbed_->path(), scratch_.path());
  const ProgramEnd end =
      runKirireel(recordInto(scratch_.path(), {"--resume", "--thickness", "0.03"}));
  EXPECT_EQ(end.exitCode, kEndedShort) << end.err;
  EXPECT_NE(lastingSummary(scratch_.path())["order"],
            lastingSummary(undisturbed_->path())["order"]);
  EXPECT_EQ(lastingSummary(scratch_.path())["settings"]["model"]["thickness"], 0.03);
}

}  // namespace
}  // namespace kirireel
