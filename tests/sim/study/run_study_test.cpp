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
  study::Study study{
      "counting",
      "counts",
      {{"count", "of runs"}},
      [this](study::Extent extent) {
        std::vector<study::StudyCase> cases;
        for (const char* name : {"a", "b", "c"}) {
          if (extent == study::Extent::Quick && cases.size() == 2) break;
          cases.push_back(
              {name, [this] {
                 ++runs;
                 return std::vector<study::Row>{{study::cell(runs)}, {study::cell(10 * runs)}};
               }});
        }
        return cases;
      },
      [](const study::Table& table) {
        return std::vector<study::Finding>{
            {"last", table.number(table.rows.back(), "count"), "of all counts"}};
      }};
};

study::StudySettings settingsIn(const test::TemporaryFolder& folder, bool resume) {
  study::StudySettings settings;
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
  const study::StudySettings settings = settingsIn(folder, false);
  const study::Table table = study::runStudy(counting.study, settings, always);
  const study::Table read = study::readCsv(settings.folder / "counting.csv");
  EXPECT_EQ(read.rows, table.rows);
  EXPECT_THAT(read.rows.front(), ElementsAre("a", "1"));
  EXPECT_EQ(read.caption.command, "kirireel study counting");
  EXPECT_EQ(read.caption.machine, study::machineText());
  EXPECT_EQ(read.caption.versions, "kirireel 1");
  std::ifstream stream(settings.folder / "counting.json");
  const auto json = nlohmann::json::parse(stream);
  EXPECT_EQ(json["findings"][0]["value"], 30);
  EXPECT_EQ(json["caption"]["extent"], "full");
}

TEST(RunStudy, ResumesAfterTheFinishedCases) {
  const test::TemporaryFolder folder;
  CountingStudy counting;
  const study::StudySettings settings = settingsIn(folder, true);
  const auto untilB = [](const std::string& name, std::size_t, std::size_t) { return name != "b"; };
  EXPECT_EQ(study::runStudy(counting.study, settings, untilB).rows.size(), 2U);
  EXPECT_EQ(study::readCsv(settings.folder / "counting.csv").rows.size(), 2U);
  std::vector<std::string> asked;
  const study::Table table = study::runStudy(
      counting.study, settings, [&](const std::string& name, std::size_t, std::size_t) {
        asked.push_back(name);
        return true;
      });
  EXPECT_THAT(asked, ElementsAre("b", "c"));
  EXPECT_EQ(counting.runs, 3);
  EXPECT_EQ(table.rows.size(), 6U);
}

TEST(RunStudy, StartsAgainWithoutResume) {
  const test::TemporaryFolder folder;
  CountingStudy counting;
  study::runStudy(counting.study, settingsIn(folder, false), always);
  study::runStudy(counting.study, settingsIn(folder, false), always);
  EXPECT_EQ(counting.runs, 6);
}

TEST(RunStudy, DoesNotMixQuickAndFull) {
  const test::TemporaryFolder folder;
  CountingStudy counting;
  study::StudySettings settings = settingsIn(folder, true);
  study::runStudy(counting.study, settings, always);
  settings.extent = study::Extent::Quick;
  try {
    study::runStudy(counting.study, settings, always);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("counting.csv: error: this is a full study, which a quick one cannot "
                          "resume; use the same options or another folder"));
  }
}

TEST(RunStudy, DoesNotResumeTablesOfAnotherVersion) {
  const test::TemporaryFolder folder;
  CountingStudy counting;
  const study::StudySettings settings = settingsIn(folder, true);
  std::filesystem::create_directory(settings.folder);
  std::ofstream(settings.folder / "counting.csv") << "# extent: full\ncase,count,more\na,1,2\n";
  try {
    study::runStudy(counting.study, settings, always);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("counting.csv: error: 3 columns, but this version's study "
                                        "has 2; remove `resume`"));
  }
}

TEST(RunStudy, UnknownStudyGetsTheNearest) {
  try {
    study::studyNamed("scalling");
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("error: there is no study scalling, did you mean scaling?; choose "));
  }
}

TEST(RunStudy, CasesOfEveryStudyHaveUniqueNames) {
  for (const study::Study& study : study::studies()) {
    for (const study::Extent extent : {study::Extent::Quick, study::Extent::Full}) {
      std::vector<std::string> names;
      for (const study::StudyCase& studyCase : study.cases(extent)) names.push_back(studyCase.name);
      std::sort(names.begin(), names.end());
      EXPECT_EQ(std::adjacent_find(names.begin(), names.end()), names.end()) << study.name;
      EXPECT_THAT(names, testing::Not(IsEmpty()));
      for (const std::string& name : names) EXPECT_EQ(name, study::cell(name)) << study.name;
    }
  }
}

}  // namespace
}  // namespace kirireel
