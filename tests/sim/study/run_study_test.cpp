#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "sim/base/error.h"
#include "sim/study/study.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A study that counts how often its cases are run.
struct CountingStudy {
  int runs = 0;
  Study study{"counting",
              "counts",
              {{"count", "of runs"}},
              [this](Extent extent) {
                std::vector<StudyCase> cases;
                for (const char* name : {"a", "b", "c"}) {
                  if (extent == Extent::Quick && cases.size() == 2) break;
                  cases.push_back({name, [this] {
                                     ++runs;
                                     return std::vector<Row>{{cell(runs)}, {cell(10 * runs)}};
                                   }});
                }
                return cases;
              },
              [](const Table& table) {
                return std::vector<Finding>{
                    {"last", table.number(table.rows.back(), "count"), "of all counts"}};
              }};
};

StudySettings settingsIn(const test::TemporaryFolder& folder, bool resume) {
  StudySettings settings;
  settings.folder = folder.path() / "results";
  settings.resume = resume;
  settings.command = "kirireel study counting";
  settings.versions = "kirireel 1";
  return settings;
}

bool always(const std::string&, std::size_t, std::size_t) {
  return true;
}

TEST(RunStudy, LeavesTableAndFindings) {
  const test::TemporaryFolder folder;
  CountingStudy counting;
  const StudySettings settings = settingsIn(folder, false);
  const Table table = runStudy(counting.study, settings, always);
  const Table read = readCsv(settings.folder / "counting.csv");
  EXPECT_EQ(read.rows, table.rows);
  EXPECT_THAT(read.rows.front(), ElementsAre("a", "1"));
  EXPECT_EQ(read.caption.command, "kirireel study counting");
  EXPECT_EQ(read.caption.machine, machineText());
  EXPECT_THAT(read.caption.versions, HasSubstr("kirireel 1, bullet 3."));
  std::ifstream stream(settings.folder / "counting.json");
  const auto json = nlohmann::json::parse(stream);
  EXPECT_EQ(json["findings"][0]["value"], 30);
  EXPECT_EQ(json["caption"]["extent"], "full");
}

TEST(RunStudy, ResumesAfterTheFinishedCases) {
  const test::TemporaryFolder folder;
  CountingStudy counting;
  const StudySettings settings = settingsIn(folder, true);
  const auto untilB = [](const std::string& name, std::size_t, std::size_t) { return name != "b"; };
  EXPECT_EQ(runStudy(counting.study, settings, untilB).rows.size(), 2U);
  EXPECT_EQ(readCsv(settings.folder / "counting.csv").rows.size(), 2U);
  std::vector<std::string> asked;
  const Table table =
      runStudy(counting.study, settings, [&](const std::string& name, std::size_t, std::size_t) {
        asked.push_back(name);
        return true;
      });
  EXPECT_THAT(asked, ElementsAre("b", "c"));
  EXPECT_EQ(counting.runs, 3);
  EXPECT_EQ(table.rows.size(), 6U);
}

TEST(RunStudy, StartsAnewUnlessToldToResume) {
  const test::TemporaryFolder folder;
  CountingStudy counting;
  runStudy(counting.study, settingsIn(folder, false), always);
  runStudy(counting.study, settingsIn(folder, false), always);
  EXPECT_EQ(counting.runs, 6);
}

TEST(RunStudy, DoesNotMixQuickAndFull) {
  const test::TemporaryFolder folder;
  CountingStudy counting;
  StudySettings settings = settingsIn(folder, true);
  runStudy(counting.study, settings, always);
  settings.extent = Extent::Quick;
  try {
    runStudy(counting.study, settings, always);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("counting.csv: error: this is a full study, which a quick one cannot "
                          "resume; use the same options or another --out"));
  }
}

TEST(RunStudy, DoesNotResumeWhatAnotherVersionMade) {
  const test::TemporaryFolder folder;
  CountingStudy counting;
  const StudySettings settings = settingsIn(folder, true);
  std::filesystem::create_directory(settings.folder);
  std::ofstream(settings.folder / "counting.csv") << "# extent: full\ncase,count,more\na,1,2\n";
  try {
    runStudy(counting.study, settings, always);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("counting.csv: error: 3 columns, but this version's study "
                                        "has 2; leave --resume out"));
  }
}

TEST(RunStudy, UnknownStudyGetsTheNearest) {
  try {
    studyNamed("scalling");
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("error: no study scalling, did you mean scaling?; there "
                                        "are "));
  }
}

TEST(RunStudy, CasesOfEveryStudyHaveNamesOfTheirOwn) {
  for (const Study& study : studies()) {
    for (const Extent extent : {Extent::Quick, Extent::Full}) {
      std::vector<std::string> names;
      for (const StudyCase& studyCase : study.cases(extent)) names.push_back(studyCase.name);
      std::sort(names.begin(), names.end());
      EXPECT_EQ(std::adjacent_find(names.begin(), names.end()), names.end()) << study.name;
      EXPECT_THAT(names, testing::Not(IsEmpty()));
      for (const std::string& name : names) EXPECT_EQ(name, cell(name)) << study.name;
    }
  }
}

}  // namespace
}  // namespace kirireel
