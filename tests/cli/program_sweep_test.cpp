// Sweeps through the real program.
#include <algorithm>
#include <csignal>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/cli/run_program.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

class SweepProgram : public testing::Test {
 protected:
  /// Runs a sweep of this text into out/ in the same folder.
  ProgramEnd sweep(const std::string& text, std::vector<std::string> options = {}) {
    writeText(folder_ / "sweep.toml", text);
    std::vector<std::string> arguments = {"sweep", (folder_ / "sweep.toml").string(), "--out",
                                          out().string()};
    arguments.insert(arguments.end(), options.begin(), options.end());
    return runKirireel(arguments);
  }

  void expectRefused(const ProgramEnd& end, const std::string& part) const {
    EXPECT_EQ(end.exitCode, 2) << end.err;
    EXPECT_EQ(std::count(end.err.begin(), end.err.end(), '\n'), 1) << end.err;
    EXPECT_THAT(end.err, HasSubstr(part));
    EXPECT_FALSE(std::filesystem::exists(out()));
  }

  std::filesystem::path out() const { return folder_ / "out"; }

  /// The records of all finished runs.
  std::vector<nlohmann::json> records() const {
    std::vector<nlohmann::json> found;
    for (const std::string& file : filesIn(out() / "runs")) {
      if (!file.ends_with("run.json")) continue;
      const std::string text = readText(out() / "runs" / file);
      if (!text.empty()) found.push_back(nlohmann::json::parse(text));  // not renamed meanwhile
    }
    return found;
  }

  const TemporaryFolder folder_;
};

constexpr const char* kSix =
    "generate = \"tessellation\"\n[base]\nrows = 1\nduration = 0.1\n"
    "[grid]\ncolumns = [2, 3]\nspring_stiffness = [10, 20, 30]\n";

TEST_F(SweepProgram, LeavesOneFolderForEachRun) {
  const ProgramEnd end = sweep(kSix, {"--jobs", "2"});
  EXPECT_EQ(end.exitCode, 0) << end.err;
  EXPECT_THAT(end.out, HasSubstr("6 runs done, 0 of them failed; 0 done before"));
  EXPECT_THAT(filesIn(out() / "runs"), SizeIs(6 * 3));
  for (const nlohmann::json& record : records()) {
    EXPECT_EQ(record["status"], "done");
    EXPECT_EQ(record["inputs"]["rows"], "1");
  }
}

TEST_F(SweepProgram, DoneRunsAreNotRepeated) {
  sweep(kSix);
  EXPECT_THAT(sweep(kSix).out, HasSubstr("0 runs done, 0 of them failed; 6 done before"));
  const std::string finer =
      "generate = \"tessellation\"\n[base]\nduration = 0.1\ncolumns = 2\nrows = 1\n"
      "[grid]\nspring_stiffness = [10, 15, 20]\n";
  EXPECT_THAT(sweep(finer).out, HasSubstr("1 runs done, 0 of them failed; 2 done before"));
}

TEST_F(SweepProgram, ChangedModelIsRunAgain) {
  runKirireel({"generate", "tessellation", (folder_ / "sheet").string(), "--columns", "2"});
  const std::string text = "model = \"sheet\"\n[grid]\nduration = [0.1, 0.2]\n";
  EXPECT_THAT(sweep(text).out, HasSubstr("2 runs done"));
  EXPECT_THAT(sweep(text).out, HasSubstr("0 runs done"));
  std::filesystem::remove_all(folder_ / "sheet");
  runKirireel({"generate", "tessellation", (folder_ / "sheet").string(), "--columns", "3"});
  EXPECT_THAT(sweep(text).out, HasSubstr("2 runs done"));
}

TEST_F(SweepProgram, EveryFileThatARunReadsCounts) {
  const auto writeRock = [this](const char* peak) {
    writeText(folder_ / "rock.obj", "v 9 9 9\nv 10 9 9\nv 9 10 9\nv 9 9 " + std::string(peak) +
                                        "\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
  };
  writeText(folder_ / "scene.toml", "[[obstacle]]\nshape = \"mesh\"\nfile = \"rock.obj\"\n");
  writeRock("10");
  const std::string text =
      "generate = \"tessellation\"\nscene = \"scene.toml\"\n[base]\npath = \"straight\"\n"
      "[grid]\nduration = [0.01, 0.02]\n";
  EXPECT_THAT(sweep(text).out, HasSubstr("2 runs done, 0 of them failed"));
  EXPECT_THAT(sweep(text).out, HasSubstr("0 runs done"));
  writeRock("10.5");
  EXPECT_THAT(sweep(text).out, HasSubstr("2 runs done"));
  // The name of a varied setting does not make another run.
  EXPECT_THAT(sweep(text + "timestep = [0.0041666666666666666]\n").out, HasSubstr("0 runs done"));
}

TEST_F(SweepProgram, ShardsDivideTheRuns) {
  EXPECT_THAT(sweep(kSix, {"--shard", "1/4"}).out, HasSubstr("2 runs done"));
  EXPECT_THAT(sweep(kSix, {"--shard", "4/4"}).out, HasSubstr("1 runs done"));
  EXPECT_THAT(sweep(kSix, {"--shard", "8/8"}).out, HasSubstr("0 runs done"));
  EXPECT_THAT(sweep(kSix).out, HasSubstr("3 runs done, 0 of them failed; 3 done before"));
}

TEST_F(SweepProgram, FailedRunsKeepTheirReason) {
  const std::string text =
      "generate = \"tessellation\"\n[base]\nduration = 0.1\ncolumns = 2\n[grid]\npin = [0, 99]\n";
  const ProgramEnd end = sweep(text);
  EXPECT_EQ(end.exitCode, 1);
  EXPECT_THAT(end.out, HasSubstr("2 runs done, 1 of them failed"));
  for (const nlohmann::json& record : records()) {
    const bool isBad = record["inputs"]["pin"] == "99";
    EXPECT_EQ(record["status"], isBad ? "failed" : "done");
    EXPECT_THAT(record["reason"].get<std::string>(), HasSubstr(isBad ? "99" : ""));
  }
  EXPECT_THAT(sweep(text).out, HasSubstr("0 runs done, 0 of them failed; 2 done before"));
  EXPECT_THAT(sweep(text, {"--retry-failed"}).out, HasSubstr("1 runs done, 1 of them failed"));
}

TEST_F(SweepProgram, HungRunsFail) {
  const ProgramEnd end = sweep(
      "generate = \"tessellation\"\n[base]\nsolver = \"bullet\"\n[grid]\nsubsteps = [10000, "
      "9999]\n",
      {"--run-limit", "0.2"});
  EXPECT_EQ(end.exitCode, 1);
  EXPECT_THAT(end.out, HasSubstr("2 runs done, 2 of them failed"));
  for (const nlohmann::json& record : records()) {
    EXPECT_EQ(record["reason"], "took longer than 0.2 s");
  }
}

TEST_F(SweepProgram, TwoAtOnceShareTheWork) {
  writeText(folder_ / "sweep.toml", kSix);
  const std::vector<std::string> arguments = {
      "sweep", (folder_ / "sweep.toml").string(), "--out", out().string(), "--jobs", "1"};
  RunningProgram first(arguments, {});
  RunningProgram second(arguments, {});
  EXPECT_EQ(first.wait().exitCode, 0);
  EXPECT_EQ(second.wait().exitCode, 0);
  EXPECT_THAT(records(), SizeIs(6));
}

TEST_F(SweepProgram, KilledAndResumedGivesTheSameTable) {
  const std::string text =
      "generate = \"tessellation\"\n[grid]\ncolumns = [4, 5]\n"
      "spring_stiffness = {from = 10, to = 1000, count = 12, scale = \"log\"}\npin = [0, 99]\n";
  EXPECT_EQ(sweep(text).exitCode, 1);
  const std::vector<std::string> names = {"sweep.csv", "sweep.h5", "sweep.png"};
  std::vector<std::string> undisturbed;
  for (const std::string& name : names) undisturbed.push_back(readText(out() / name));
  std::filesystem::remove_all(out());

  const std::vector<std::string> arguments = {
      "sweep", (folder_ / "sweep.toml").string(), "--out", out().string(), "--jobs", "2"};
  for (const std::size_t runsFirst : {1U, 10U, 20U}) {
    RunningProgram program(arguments, {});
    for (int i = 0; i < 6000 && records().size() < runsFirst; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    program.sendSignal(SIGKILL);
    EXPECT_EQ(program.wait().exitCode, -SIGKILL);
  }
  EXPECT_LT(records().size(), 48U);
  EXPECT_EQ(sweep(text, {"--jobs", "1"}).exitCode, 1);
  for (std::size_t i = 0; i < names.size(); ++i) {
    EXPECT_EQ(readText(out() / names[i]), undisturbed[i]) << names[i];
  }
}

TEST_F(SweepProgram, InterruptEndsItAndReportsHowToContinue) {
  writeText(
      folder_ / "sweep.toml",
      "generate = \"tessellation\"\n[base]\nsolver = \"bullet\"\n[grid]\nsubsteps = [10000]\n");
  RunningProgram program({"sweep", (folder_ / "sweep.toml").string(), "--out", out().string()}, {});
  for (int i = 0; i < 6000 && filesIn(out() / "runs").empty(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  program.sendSignal(SIGINT);
  const ProgramEnd end = program.wait();
  EXPECT_EQ(end.exitCode, 4);
  EXPECT_THAT(end.out, HasSubstr("interrupted; the same command continues: 0 runs done"));
  EXPECT_THAT(records(), SizeIs(0));
}

TEST_F(SweepProgram, CollectGathersFinishedRuns) {
  sweep(kSix, {"--shard", "1/2"});
  EXPECT_FALSE(std::filesystem::exists(out() / "sweep.csv"));
  const ProgramEnd end = sweep(kSix, {"--collect"});
  EXPECT_EQ(end.exitCode, 1);
  EXPECT_THAT(end.out, HasSubstr("3 runs done, 0 failed, 3 missing"));
  const std::string csv = readText(out() / "sweep.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 4);
  EXPECT_THAT(csv, testing::StartsWith("run,columns,spring_stiffness,status,reason,outcome,"));
}

TEST_F(SweepProgram, ParametersAndMeasuresHaveSeparateColumns) {
  const ProgramEnd end = sweep(
      "generate = \"stampfli-removal\"\n[base]\nduration = 0.1\n"
      "[grid]\ntiles = [30, 40]\npath = [\"straight\"]\n");
  EXPECT_EQ(end.exitCode, 0) << end.err;
  EXPECT_THAT(readText(out() / "sweep.csv"), testing::StartsWith("run,path,tiles,status,"));
}

TEST_F(SweepProgram, UnknownParameterIsNamedWithTheNearest) {
  expectRefused(sweep("generate = \"fan\"\n[grid]\nspring_stifness = [1, 2]\n"),
                "sweep.toml:3:20: error: there is no parameter spring_stifness, did you mean "
                "spring_stiffness?; see kirireel simulate --help and kirireel generate fan --help");
  expectRefused(sweep("generate = \"fan\"\n[grid]\ncolums = [1, 2]\n"), "did you mean columns?");
  expectRefused(sweep("generate = \"fans\"\n[grid]\ncolumns = [1, 2]\n"),
                "sweep.toml:1:12: error: there is no family fans, did you mean fan?; see kirireel "
                "generate --help");
  expectRefused(sweep("generate = \"fan\"\n[grid]\nout = [\"a\", \"b\"]\n"),
                "there is no parameter out");
}

TEST_F(SweepProgram, ValuesAreCheckedBeforeTheFirstRun) {
  expectRefused(sweep("generate = \"fan\"\n[grid]\nthickness = [0.1, -1]\n"),
                "sweep.toml:3:19: error: --thickness: '-1'");
  expectRefused(sweep("generate = \"fan\"\n[grid]\nground = [1, 2]\n"),
                "sweep.toml:3:11: error: ground: '1' is not allowed; give true or false");
}

TEST_F(SweepProgram, ModelIsMissing) {
  expectRefused(sweep("[grid]\nthickness = [0.1]\n"), "there is nothing to run; add model");
  expectRefused(sweep("generate = \"fan\"\n[grid]\nmodel = [\"a\"]\n"),
                "use only one of model and generate");
}

TEST_F(SweepProgram, MissingFilesAreNamedBeforeTheFirstRun) {
  expectRefused(sweep("[grid]\nmodel = [\"a\"]\n"),
                "sweep.toml:2:10: error: there is no file or "
                "folder");
  expectRefused(sweep("generate = \"fan\"\n[base]\ntarget = \"b.txt\"\n[grid]\nthickness = [1]\n"),
                "b.txt; correct the name. It is relative to the sweep file");
}

TEST_F(SweepProgram, BillionRunsNeedConfirmation) {
  expectRefused(
      sweep("generate = \"fan\"\n[grid]\nthickness = {from = 1, to = 2, count = 1000}\n"
            "density = {from = 1, to = 2, count = 1000}\nduration = {from = 1, to = 2, count = "
            "1000}\n"),
      "sweep.toml: error: these are 1e+09 runs, about 1157 days of one core at 0.1 s each; use "
      "fewer values, or add --yes");
}

TEST_F(SweepProgram, ShardOutOfRange) {
  expectRefused(sweep(kSix, {"--shard", "9/8"}),
                "--shard: '9/8' is not allowed; give a part from 1/8 to 8/8");
  expectRefused(sweep(kSix, {"--shard", "0/8"}),
                "--shard: '0/8' is not allowed; give I/N, as in 3/8: part I of N, counted from 1");
}

TEST_F(SweepProgram, FolderThatCannotBeWritten) {
  writeText(folder_ / "sweep.toml", kSix);
  // Even root cannot make folders here.
  const ProgramEnd end =
      runKirireel({"sweep", (folder_ / "sweep.toml").string(), "--out", "/proc/kirireel"});
  EXPECT_EQ(end.exitCode, 1);
  EXPECT_EQ(std::count(end.err.begin(), end.err.end(), '\n'), 1) << end.err;
  EXPECT_THAT(end.err, HasSubstr("/proc/kirireel/runs: error: the folder cannot be created"));
}

}  // namespace
}  // namespace kirireel
