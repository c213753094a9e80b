// Findings of studies, from tables made by hand and from their fastest cases.
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/study/stepped_scene.h"
#include "sim/study/study.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;

study::Table tableOf(const study::Study& study) {
  study::Table table;
  table.caption.study = study.name;
  table.columns.push_back({"case", ""});
  table.columns.insert(table.columns.end(), study.columns.begin(), study.columns.end());
  return table;
}

double findingOf(const study::Study& study, const study::Table& table, const std::string& name) {
  for (const study::Finding& finding : study.findings(table)) {
    if (finding.name == name) return finding.value;
  }
  ADD_FAILURE() << "no finding " << name;
  return 0;
}

/// The table with the rows of one case of the quick study.
study::Table tableOfCase(const study::Study& study, const std::string& name) {
  study::Table table = tableOf(study);
  for (const study::StudyCase& studyCase : study.cases(study::Extent::Quick)) {
    if (studyCase.name != name) continue;
    for (study::Row row : studyCase.run()) {
      row.insert(row.begin(), name);
      table.rows.push_back(row);
    }
  }
  EXPECT_FALSE(table.rows.empty()) << name;
  return table;
}

TEST(Studies, HaveNoFindingsWithoutRows) {
  for (const study::Study& study : study::studies()) {
    for (const study::Finding& finding : study.findings(tableOf(study))) {
      EXPECT_TRUE(std::isnan(finding.value) || finding.value == 0) << finding.name;
      EXPECT_FALSE(finding.meaning.empty()) << finding.name;
    }
  }
}

TEST(Studies, WorkPrecisionComparesAtEqualGapAndAtEqualCost) {
  const study::Study study = study::workPrecisionStudy();
  study::Table table = tableOf(study);
  const auto add = [&](const char* engine, int rate, double cpu, double gap) {
    table.rows.push_back({"", engine, "plane", "1", study::cell(rate), "1", "1", "0.2", "0", "1",
                          study::cell(cpu), study::cell(gap), "0", "0"});
  };
  add("direct", 60, 2, 1e-10);
  add("direct", 240, 5, 1e-12);
  add("sequential impulse", 240, 100, 1e-4);
  add("nncg", 240, 40, 1e-3);
  add("chipmunk", 240, 4, 1e-2);
  EXPECT_DOUBLE_EQ(findingOf(study, table, "bullet_plane_tightest_cost"), 20);
  EXPECT_DOUBLE_EQ(findingOf(study, table, "bullet_plane_least_cost"), 20);
  EXPECT_DOUBLE_EQ(findingOf(study, table, "bullet_plane_gap_at_equal_cost"), 1e-8);
  EXPECT_DOUBLE_EQ(findingOf(study, table, "chipmunk_plane_least_cost"), 2);
  EXPECT_DOUBLE_EQ(findingOf(study, table, "chipmunk_plane_gap_at_equal_cost"), 1e-8);
}

TEST(Studies, TessellationStaysOnTheExactMotion) {
  const study::Study study = study::tessellationStudy();
  const study::Table table = tableOfCase(study, "direct 1/240 s plane");
  EXPECT_LT(findingOf(study, table, "direct_error_start"), 1e-6);  // measured 6e-10
  EXPECT_LT(findingOf(study, table, "direct_error_open"), 1e-8);   // measured 1e-12
  EXPECT_NEAR(findingOf(study, table, "direct_angle"), 90, 0.5);   // measured 90.41: it swings
}

TEST(Studies, SquareToDiskStaysOnTheExactPath) {
  const study::Study study = study::squareToDiskStudy();
  const study::Table table = tableOfCase(study, "direct 1/240 s");
  EXPECT_LT(findingOf(study, table, "direct_radius_error"), 1e-8);         // measured 2e-12
  EXPECT_LT(findingOf(study, table, "direct_radius_error_closed"), 1e-8);  // measured 6e-12
  EXPECT_GT(table.rows.size(), 50U);
}

TEST(Studies, InvalidInputIsRefusedInOneLine) {
  for (const study::Refusal& refusal : study::refusals()) {
    SCOPED_TRACE(refusal.name);
    try {
      refusal.run();
      ADD_FAILURE() << "not refused";
    } catch (const InputError& error) {
      const std::string message = error.what();
      EXPECT_EQ(message.find('\n'), std::string::npos);
      EXPECT_GT(message.size(), 20U);
    }
  }
}

TEST(Studies, HardTrialsHaveAnErrorAndItsMeaning) {
  for (const study::HardTrial& trial : study::hardTrials(false)) {
    EXPECT_TRUE(trial.error) << trial.name;
    EXPECT_FALSE(trial.errorMeaning.empty()) << trial.name;
    EXPECT_TRUE(trial.bricks.empty() || trial.bricks.size() == trial.scene.model.tiles.size());
  }
}

}  // namespace
}  // namespace kirireel
