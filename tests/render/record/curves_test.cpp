#include "render/record/curves.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/picture/png.h"
#include "sim/base/error.h"
#include "sim/base/files.h"
#include "tests/support/files.h"
#include "tests/support/program.h"

namespace kirireel {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr double kNone = NAN;

/// Three samples of four groups; one of them has no values.
trajectory::RunCurves someCurves() {
  return {
      {0, 0.5, 1},
      {{"Size", "m", false, {{"width", "width_m", {1, 1.5, 2}}, {"depth", "depth_m", {0, 0, 0}}}},
       {"Poisson's ratio", "", false, {{"ratio", "poissons_ratio", {kNone, -1, -1}}}},
       {"Target error", "m", true, {{"error", "target_error_m", {kNone, kNone, kNone}}}},
       {"Joint gap", "m", true, {{"gap", "joint_gap_m", {0, 1e-13, 0.1}}}}}};
}

/// One run, by time.
record::PlottedRun someRun(const std::string& name = "run") {
  return {name, someCurves().groups, {"simulated time, s", {0, 0.5, 1}}};
}

std::string plotted(picture::PageFormat format) {
  return record::plotCurves({someRun()}, format, {.width = 180, .dotsPerInch = 100});
}

TEST(CurvesTable, HasAllDigitsAndEmptyFields) {
  EXPECT_EQ(record::curvesTable(someCurves(), {0, 0.1, 1}),
            "time_s,progress,width_m,depth_m,poissons_ratio,target_error_m,joint_gap_m\n"
            "0,0,1,0,,,0\n"
            "0.5,0.1,1.5,0,-1,,1e-13\n"
            "1,1,2,0,-1,,0.1\n");
}

TEST(CurvesPlot, NamesWhatItShowsAndNothingElse) {
  const std::string svg = plotted(picture::PageFormat::Svg);
  for (const char* text : {">Size, m<", ">width<", ">depth<", ">Poisson's ratio<", ">Joint gap, m<",
                           ">simulated time, s<", ">1e-13<"}) {
    EXPECT_THAT(svg, HasSubstr(text));
  }
  EXPECT_THAT(svg, Not(HasSubstr("Target error")));
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
}

TEST(CurvesPlot, HasTheSameBytesEachTime) {
  for (const picture::PageFormat format :
       {picture::PageFormat::Svg, picture::PageFormat::Pdf, picture::PageFormat::Png}) {
    EXPECT_EQ(plotted(format), plotted(format));
  }
}

TEST(CurvesPlot, IsAsWideAsItIsToBe) {
  const test::TemporaryFolder folder;
  writeTextFile(folder / "curves.png", plotted(picture::PageFormat::Png));
  const picture::Frame frame = picture::readPng(folder / "curves.png");
  EXPECT_EQ(frame.size.width, 709);  // 180 mm at 100 dots an inch
  EXPECT_EQ(frame.at(0, 0), (picture::Colour{255, 255, 255}));
  int blue = 0;
  for (int y = 0; y < frame.size.height; ++y) {
    for (int x = 0; x < frame.size.width; ++x)
      blue += frame.at(x, y).blue > frame.at(x, y).red + 60;
  }
  EXPECT_GT(blue, 300);  // measured 1300: three lines, each across half of the figure
}

TEST(CurvesPlot, SaysThatThereIsNothing) {
  record::PlottedRun run = someRun();
  run.groups = {run.groups[2]};
  EXPECT_THROW(record::plotCurves({run}, picture::PageFormat::Svg, {}), InputError);
}

TEST(CurvesPlot, NamesRunsThatShareADiagram) {
  record::PlottedRun soft = someRun("soft"), stiff = someRun("stiff");
  soft.groups = stiff.groups = {soft.groups[0], soft.groups[3]};
  const std::string svg = record::plotCurves({soft, stiff}, picture::PageFormat::Svg, {});
  for (const char* text : {">soft, width<", ">stiff, depth<", ">soft<", ">stiff<"}) {
    EXPECT_THAT(svg, HasSubstr(text));
  }
  EXPECT_THAT(svg, Not(HasSubstr(">gap<")));
}

TEST(Curves, AreSelectedByGroupOrColumn) {
  const trajectory::RunCurves curves = someCurves();
  EXPECT_EQ(record::selectCurves(curves, {}).size(), 4U);
  const auto chosen = record::selectCurves(curves, {"joint_gap", "depth", "poissons_ratio"});
  ASSERT_EQ(chosen.size(), 3U);
  EXPECT_EQ(chosen[0].name, "Joint gap");
  EXPECT_EQ(chosen[1].name, "Size");
  ASSERT_EQ(chosen[1].curves.size(), 1U);
  EXPECT_EQ(chosen[1].curves[0].column, "depth_m");
  EXPECT_EQ(record::selectCurves(curves, {"size"})[0].curves.size(), 2U);
  try {
    record::selectCurves(curves, {"gapp"});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), StartsWith("error: --curves: there is no curve 'gapp'; give some of "
                                         "size, width, depth, poissons_ratio, "));
  }
}

TEST(CurvesPlot, HasTextInItsPdf) {
  if (!test::hasProgram("pdftotext")) {
    GTEST_SKIP() << "no pdftotext here; scripts/setup --with-tools installs poppler-utils";
  }
  const test::TemporaryFolder folder;
  writeTextFile(folder / "curves.pdf", plotted(picture::PageFormat::Pdf));
  const std::string text = test::outputOf("pdftotext " + (folder / "curves.pdf").string() + " -");
  EXPECT_THAT(text, HasSubstr("Size, m"));
  EXPECT_THAT(text, HasSubstr("simulated time, s"));
}

}  // namespace
}  // namespace kirireel
