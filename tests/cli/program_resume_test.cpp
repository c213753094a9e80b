// `--resume` through the real program.
#include <csignal>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/cli/run_program.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

std::vector<std::string> recordInto(const fs::path& out, const std::vector<std::string>& more) {
  std::vector<std::string> words = {"record",     shippedModel("nonrigid").string(),
                                    "--size",     "320x240",
                                    "--duration", "0.5",
                                    "--svg",      "--out",
                                    out.string()};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

/// The summary but for what may differ between runs.
Json lasting(const fs::path& folder) {
  Json summary = Json::parse(readText(folder / "summary.json"));
  for (const char* key : {"cost", "sha256"}) summary.erase(key);
  return summary;
}

void expectSameRun(const fs::path& folder, const fs::path& undisturbed) {
  EXPECT_EQ(filesIn(folder), filesIn(undisturbed));
  for (const std::string& name : filesIn(undisturbed)) {
    if (name == "summary.json") continue;
    EXPECT_TRUE(readText(folder / name) == readText(undisturbed / name)) << name;
  }
  EXPECT_EQ(lasting(folder), lasting(undisturbed));
}

class Resume : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    undisturbed_ = new ScratchFolder;
    ASSERT_EQ(runKirireel(recordInto(undisturbed_->path(), {})).exitCode, 0);
  }
  static void TearDownTestSuite() { delete undisturbed_; }

  static ScratchFolder* undisturbed_;
  ScratchFolder scratch_;
};
ScratchFolder* Resume::undisturbed_ = nullptr;

TEST_F(Resume, EndsLikeAnUndisturbedRunWheneverItWasKilled) {
  for (const int signal : {SIGTERM, SIGKILL}) {
    for (const int milliseconds : {30, 150, 400}) {
      {
        RunningProgram program(recordInto(scratch_.path(), {}), {});
        std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
        program.sendSignal(signal);
        program.wait();
      }
      const ProgramEnd end = runKirireel(recordInto(scratch_.path(), {"--resume"}));
      EXPECT_EQ(end.exitCode, 0) << end.err;
      expectSameRun(scratch_.path(), undisturbed_->path());
      fs::remove_all(scratch_.path());
    }
  }
}

TEST_F(Resume, LeavesAFinishedRunAsItIs) {
  fs::copy(undisturbed_->path(), scratch_.path());
  const std::string summary = readText(scratch_ / "summary.json");
  const ProgramEnd end = runKirireel(recordInto(scratch_.path(), {"--resume"}));
  EXPECT_EQ(end.exitCode, 0) << end.err;
  EXPECT_EQ(end.out, scratch_.path().string() + ": finished already, out_of_time\n");
  EXPECT_EQ(runKirireel(recordInto(scratch_.path(), {"--resume", "--json"})).out, summary);
  EXPECT_EQ(readText(scratch_ / "summary.json"), summary);
}

TEST_F(Resume, MakesADamagedRunAgain) {
  fs::copy(undisturbed_->path(), scratch_.path());
  writeText(scratch_ / "final.obj", "damaged");
  EXPECT_EQ(runKirireel(recordInto(scratch_.path(), {"--resume"})).exitCode, 0);
  expectSameRun(scratch_.path(), undisturbed_->path());
}

TEST_F(Resume, MakesTheRunOfAnotherOrderAgain) {
  fs::copy(undisturbed_->path(), scratch_.path());
  const ProgramEnd end =
      runKirireel(recordInto(scratch_.path(), {"--resume", "--thickness", "0.03"}));
  EXPECT_EQ(end.exitCode, 0) << end.err;
  EXPECT_NE(lasting(scratch_.path())["order"], lasting(undisturbed_->path())["order"]);
  EXPECT_EQ(lasting(scratch_.path())["settings"]["thickness"], 0.03);
}

}  // namespace
}  // namespace kirireel
