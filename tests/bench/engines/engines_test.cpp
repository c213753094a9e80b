#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "tests/bench/engines/other_rows.h"
#include "tests/support/engine_checks.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;

TEST(OtherEngines, ForcesAccelerateAsNewtonSays) {
  test::expectForcesAccelerate(bench::kChipmunk, 1e-10);
  test::expectForcesAccelerate(bench::kMujoco, 1e-10);
  test::expectForcesAccelerate(bench::kBox2d, 1e-3);  // single precision
}

TEST(OtherEngines, DampingLeavesItsShareOfTheVelocity) {
  for (const study::Engine& engine : {bench::kChipmunk, bench::kBox2d, bench::kMujoco}) {
    test::expectDampingLeavesItsShare(engine);
  }
}

TEST(OtherEngines, OpenASheetLikeTheDirectSolver) {
  const scene::Scene scene = study::sheetScene(2, true, model::JointFace::Bottom);
  const std::vector<model::Tile> opened = test::openedSheet(scene);
  for (const study::Engine& engine : {bench::kChipmunk, bench::kBox2d, bench::kMujoco}) {
    test::expectOpensSheet(engine, scene, opened);
  }
}

study::Table tableOf(const study::Study& study) {
  study::Table table;
  table.caption.study = study.name;
  table.columns.push_back({"case", ""});
  table.columns.insert(table.columns.end(), study.columns.begin(), study.columns.end());
  return table;
}

TEST(OtherRows, HaveTheStudysNameColumnsAndFindingsAgainstOurs) {
  const study::Study& own = study::studyNamed("moving");
  const study::Study& others = bench::otherStudies()[1];
  ASSERT_EQ(others.name, own.name);
  study::Table ours = tableOf(own);
  const auto row = [](const char* engine, double cpu, double error) {
    return study::Row{"",
                      engine,
                      "plane",
                      "100",
                      "240",
                      "1",
                      "1",
                      "0",
                      study::cell(cpu),
                      "0",
                      study::cell(error)};
  };
  ours.rows = {row("direct", 2, 1e-3)};
  study::Table theirs = tableOf(others);
  theirs.rows = {row("box2d", 5, 1e-2)};
  ASSERT_EQ(theirs.columns.size(), ours.columns.size());
  const std::vector<study::Finding> found = bench::comparedWith(others, ours).findings(theirs);
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found[0].name, "box2d_plane_100_least_cost");
  EXPECT_DOUBLE_EQ(found[0].value, 2.5);
  for (const study::Finding& finding : found) EXPECT_THAT(finding.name, HasSubstr("box2d"));
}

TEST(OtherRows, AreNotComparedWithAnotherExtentOrMachine) {
  study::Table own;
  own.caption = {"moving", "full", "", "Other processor, 4 cores, Linux", ""};
  const auto messageOf = [&own](study::Extent extent) -> std::string {
    try {
      bench::requireComparable(own, extent);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(messageOf(study::Extent::Quick),
            "error: the table of moving is of a full study, not of a quick one; make it again with "
            "kirireel study moving --quick");
  EXPECT_EQ(messageOf(study::Extent::Full),
            "error: the table of moving is from another machine: Other processor, 4 cores, Linux; "
            "make it again with kirireel study moving");
  own.caption.machine = study::machineText();
  EXPECT_EQ(messageOf(study::Extent::Full), "");
}

}  // namespace
}  // namespace kirireel
