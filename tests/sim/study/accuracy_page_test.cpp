// docs/accuracy.md agrees with its tables, and these agree with the tables of the studies.
#include <cstdlib>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "sim/study/study.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;

const std::filesystem::path kRoot = KIRIREEL_SOURCE_DIR;

TEST(AccuracyPage, IsFilledInFromItsTables) {
  const std::string command = "'" + (kRoot / "scripts/accuracy").string() + "' --check";
  EXPECT_EQ(std::system(command.c_str()), 0);
}

TEST(AccuracyPage, FindingsFollowFromTheTables) {
  for (const study::Study& study : study::studies()) {
    SCOPED_TRACE(study.name);
    const auto file = kRoot / "docs/accuracy" / (study.name + ".json");
    study::Table table = study::readCsv(file.parent_path() / (study.name + ".csv"));
    ASSERT_EQ(table.columns.size(), study.columns.size() + 1);
    const auto kept = nlohmann::json::parse(std::ifstream(file));
    table.columns.front().meaning = kept["columns"][0]["meaning"];
    std::copy(study.columns.begin(), study.columns.end(), table.columns.begin() + 1);
    EXPECT_EQ(nlohmann::json::parse(study::studyJson(study, table)), kept);
  }
}

// Rows of engines outside the program are in separate tables.
TEST(AccuracyPage, FindingsOfOtherEnginesFollowFromBothTables) {
  int count = 0;
  for (const study::Study& study : study::studies()) {
    const auto folder = kRoot / "docs/accuracy";
    const auto file = folder / "engines" / (study.name + ".csv");
    if (!exists(file)) continue;
    SCOPED_TRACE(study.name);
    study::Table both = study::readCsv(folder / (study.name + ".csv"));
    const study::Table others = study::readCsv(file);
    both.rows.insert(both.rows.end(), others.rows.begin(), others.rows.end());
    // As JSON, without rounding and with null for NaN.
    const auto found = nlohmann::json::parse(study::studyJson(study, both))["findings"];
    std::ifstream stream(folder / "engines" / (study.name + ".json"));
    const auto kept = nlohmann::json::parse(stream);
    EXPECT_EQ(kept["rows"], nlohmann::json(others.rows));
    for (const auto& finding : kept["findings"]) {
      EXPECT_NE(std::ranges::find(found, finding), found.end()) << finding;
      ++count;
    }
  }
  EXPECT_GT(count, 10);
}

TEST(AccuracyPage, HoldsEveryRowOfTheHardCases) {
  // Independent of the script that fills in the page.
  const std::string page = test::bytesOf(kRoot / "docs/accuracy.md");
  const study::Table table = study::readCsv(kRoot / "docs/accuracy/hard-cases.csv");
  ASSERT_GT(table.rows.size(), 30U);
  for (const study::Row& row : table.rows) {
    std::string line = "|";
    for (std::size_t k = 1; k < row.size(); ++k) line += " " + row[k] + " |";
    EXPECT_THAT(page, HasSubstr(line + "\n"));
  }
  EXPECT_THAT(page, HasSubstr(table.caption.machine));
}

}  // namespace
}  // namespace kirireel
