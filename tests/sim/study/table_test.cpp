#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/study/study.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

study::Table sampleTable() {
  study::Table table;
  table.caption = {"scaling", "quick", "kirireel study scaling --quick", "a machine, 2 cores",
                   "1.0"};
  table.columns = {{"case", ""}, {"tiles", "number of tiles"}, {"note", ""}};
  table.rows = {{"a", study::cell(25), ""},
                {"b", study::cell(1.0 / 3), study::cell(std::string("x, y\nz"))}};
  return table;
}

study::Table readBack(const std::string& text) {
  const test::TemporaryFolder folder;
  std::ofstream(folder.path() / "table.csv") << text;
  return study::readCsv(folder.path() / "table.csv");
}

TEST(StudyTable, ReadsBackWhatItWrote) {
  const study::Table written = sampleTable();
  const study::Table read = readBack(study::csvText(written));
  EXPECT_EQ(read.caption, written.caption);
  EXPECT_EQ(read.rows, written.rows);
  EXPECT_EQ(read.columns[1].name, "tiles");
  EXPECT_EQ(study::csvText(read), study::csvText(written));
}

TEST(StudyTable, CellsHoldNoSeparators) {
  EXPECT_EQ(sampleTable().rows[1][2], "x; y z");
  EXPECT_EQ(study::cell(1.0 / 3), "0.33333");
  EXPECT_EQ(study::cell(std::nan("")), "");
  EXPECT_EQ(study::cell(true), "yes");
}

TEST(StudyTable, NumbersAreFoundByColumn) {
  const study::Table table = sampleTable();
  EXPECT_EQ(table.number(table.rows[0], "tiles"), 25);
  EXPECT_TRUE(std::isnan(table.number(table.rows[0], "note")));
  EXPECT_TRUE(std::isnan(table.number(table.rows[1], "note")));
  EXPECT_EQ(table.text(table.rows[1], "case"), "b");
}

TEST(StudyTable, ReportsWhichColumnIsMissing) {
  const study::Table table = sampleTable();
  try {
    table.number(table.rows[0], "gap_m");
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "error: the table of scaling has no column gap_m; make it again with kirireel "
                 "study scaling");
  }
}

TEST(StudyTable, ReportsWhichRowIsRagged) {
  try {
    readBack("# study: scaling\ncase,tiles\na,1\nb\n");
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("table.csv:4: error: 1 cells, but the table has 2 columns; remove this "
                          "line"));
  }
}

TEST(StudyTable, ReportsWhichFileIsMissing) {
  try {
    study::readCsv("/nowhere/scaling.csv");
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "/nowhere/scaling.csv: error: cannot be read; kirireel study makes it");
  }
}

}  // namespace
}  // namespace kirireel
