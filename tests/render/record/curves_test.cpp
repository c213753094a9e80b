#include "render/record/curves.h"

#include <algorithm>
#include <cmath>
#include <regex>

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/picture/label.h"
#include "render/picture/png.h"
#include "sim/base/error.h"
#include "sim/base/files.h"
#include "sim/generate/lattice.h"
#include "sim/trajectory/trajectory_file.h"
#include "tests/support/files.h"
#include "tests/support/png.h"
#include "tests/support/program.h"
#include "tests/support/trajectories.h"

namespace kirireel {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr double kNone = NAN;

/// Three samples of five groups; two of them have no line.
trajectory::RunCurves someCurves() {
  return {
      {0, 0.5, 1},
      {{"Size", "m", false, {{"width", "width_m", {1, 1.5, 2}}, {"depth", "depth_m", {0, 0, 0}}}},
       {"Poisson's ratio", "", false, {{"ratio", "poissons_ratio", {kNone, -1, -1}}}},
       {"Target error", "m", true, {{"error", "target_error_m", {kNone, kNone, kNone}}}},
       {"Porosity", "", false, {{"porosity", "porosity", {1e-16, kNone, kNone}}}},
       {"Joint gap", "m", true, {{"gap", "joint_gap_m", {0, 1e-13, 0.1}}}}}};
}

/// One run, by time.
record::PlottedRun someRun(const std::string& name = "run") {
  return {name, someCurves().groups, {"simulated time, s", {0, 0.5, 1}}};
}

std::string plotted(picture::PageFormat format) {
  return record::plotCurves({someRun()}, format, {.width = 180, .dotsPerInch = 100});
}

/// Five states with a limit of the load in the middle, unstable beyond it. The first grip holds.
mechanics::LoadCurve someLoadCurve() {
  mechanics::LoadCurve curve{{{"grip 1 x"}, {"grip 2 x"}, {"grip 2 turn", true}}, 1, {}};
  for (const int k : {0, 1, 2, 3, 4}) {
    mechanics::Equilibrium& state = curve.states.emplace_back();
    const double force = k * (4.0 - k);
    state.displacements = {1e-17 * k, 0.5 * k, 0.1 * k};
    state.forces = {-force, force, 2 * force};
    state.unstableModes = k > 2 ? 1 : 0;
    if (k == 2) state.turning = mechanics::Turning::LoadLimit;
  }
  return curve;
}

/// The number of separate lines in a colour.
std::ptrdiff_t linesIn(const std::string& svg, const std::string& colour) {
  std::ptrdiff_t count = 0;
  const std::string stroke = "<path fill=\"none\" stroke=\"" + colour + "\"";
  for (std::size_t at = svg.find(stroke); at != std::string::npos; at = svg.find(stroke, at + 1)) {
    const auto first = svg.begin() + static_cast<std::ptrdiff_t>(at);
    count += std::count(first, first + static_cast<std::ptrdiff_t>(svg.find("/>", at) - at), 'M');
  }
  return count;
}

/// Seven curves in six colours, and one for comparison.
TEST(CurvesPlot, DashLinesOfARepeatedColourAndReferences) {
  record::PlottedRun run = someRun();
  trajectory::CurveGroup& group = run.groups[0];
  group.curves.clear();
  for (int k = 0; k < 7; ++k) {
    group.curves.push_back({fmt::format("c{}", k), "c", {0, 1.0 + k, 2.0 + k}});
  }
  group.curves[3].isReference = true;
  const std::string svg = record::plotCurves({run}, picture::PageFormat::Svg, {});
  EXPECT_THAT(svg, HasSubstr("c6 (dashed)"));
  EXPECT_THAT(svg, HasSubstr("c3 (dashed)"));
  EXPECT_THAT(svg, Not(HasSubstr("c0 (dashed)")));
  EXPECT_GT(linesIn(svg, "#2b64a6"), 10);  // one line and the dashes of another
  EXPECT_GT(linesIn(svg, "#943e82"), 10);
  EXPECT_EQ(linesIn(svg, "#46464c"), 1);
}

TEST(LoadCurves, AreForcesOverDisplacements) {
  const std::vector<record::PlottedRun> runs = record::loadCurvesOf("run", someLoadCurve(), 1);
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_EQ(runs[0].groups[0].name, "Force");
  EXPECT_EQ(runs[0].groups[0].curves[0].name, "grip 2 x");
  EXPECT_THAT(runs[0].abscissa.values, ElementsAre(0, 0.5, 1, 1.5, 2));
  EXPECT_THAT(runs[0].groups[0].curves[0].values, ElementsAre(0, 3, 4, 3, 0));
  EXPECT_THAT(runs[0].isDashed, ElementsAre(false, false, true, true));
  EXPECT_EQ(runs[1].groups[0].name, "Moment");
  EXPECT_THAT(runs[1].groups[0].curves[0].values, ElementsAre(0, 6, 8, 6, 0));
}

TEST(LoadCurves, HaveTheUnitOfTheModel) {
  const LengthUnit unit = *findLengthUnit("mm");
  const std::vector<record::PlottedRun> runs =
      record::loadCurvesOf("run", someLoadCurve(), 1, unit);
  EXPECT_EQ(runs[0].abscissa.title, "displacement of the grip, mm");
  EXPECT_THAT(runs[0].abscissa.values, ElementsAre(0, 500, 1000, 1500, 2000));
  EXPECT_EQ(runs[1].abscissa.values.back(), someLoadCurve().states.back().displacements[2]);
}

// The path back: a turning ends the part whose number of unstable modes it has.
TEST(LoadCurves, AreDashedBetweenTurnings) {
  mechanics::LoadCurve curve = someLoadCurve();
  curve.states[2].unstableModes = 1;
  std::ranges::reverse(curve.states);
  for (const int modes : {0, 1}) {
    curve.states[2].unstableModes = modes;
    EXPECT_THAT(record::loadCurvesOf("run", curve, 1)[0].isDashed,
                ElementsAre(true, true, false, false));
  }
}

TEST(LoadCurves, ShowUnstablePartsAsDashes) {
  mechanics::LoadCurve curve = someLoadCurve();
  std::vector<record::PlottedRun> runs = record::loadCurvesOf("run", curve, 1);
  runs.push_back(someRun());
  const std::string svg = record::plotCurves(runs, picture::PageFormat::Svg, {});
  for (const char* text : {">Force, N (dashed: unstable)<", ">displacement of the grip, m<",
                           ">Moment, N m (dashed: unstable)<", ">rotation of the grip, rad<",
                           ">Size, m<", ">simulated time, s<"}) {
    EXPECT_THAT(svg, HasSubstr(text));
  }
  // Blue: force, moment, width, ratio and gap. Half of the first two is dashed.
  EXPECT_GT(linesIn(svg, "#2b64a6"), 5 + 2 * 10);
  for (mechanics::Equilibrium& state : curve.states) state.unstableModes = 0;
  runs = record::loadCurvesOf("run", curve, 1);
  runs.push_back(someRun());
  const std::string stable = record::plotCurves(runs, picture::PageFormat::Svg, {});
  EXPECT_EQ(linesIn(stable, "#2b64a6"), 5);
  EXPECT_THAT(stable, HasSubstr(">Force, N<"));
}

TEST(LoadCurves, OfSeveralRunsShareADiagram) {
  std::vector<record::PlottedRun> runs;
  for (const char* name : {"soft", "stiff"}) {
    for (record::PlottedRun& run : record::loadCurvesOf(name, someLoadCurve(), 1)) {
      runs.push_back(std::move(run));
    }
    runs.push_back(someRun(name));
  }
  const std::string svg = record::plotCurves(runs, picture::PageFormat::Svg, {});
  for (const char* text : {">soft, grip 2 x<", ">stiff, grip 2 x<", ">soft, grip 2 turn<"}) {
    EXPECT_THAT(svg, HasSubstr(text));
  }
}

TEST(CurvesTable, HasAllDigitsAndEmptyFields) {
  EXPECT_EQ(record::curvesTable(someCurves(), {0, 0.1, 1}),
            "time_s,progress,width_m,depth_m,poissons_ratio,target_error_m,porosity,joint_gap_m\n"
            "0,0,1,0,,,1e-16,0\n"
            "0.5,0.1,1.5,0,-1,,,1e-13\n"
            "1,1,2,0,-1,,,0.1\n");
}

TEST(CurvesPlot, NamesWhatItShowsAndNothingElse) {
  const std::string svg = plotted(picture::PageFormat::Svg);
  for (const char* text : {">Size, m<", ">width<", ">depth<", ">Poisson's ratio<", ">Joint gap, m<",
                           ">simulated time, s<"}) {
    EXPECT_THAT(svg, HasSubstr(text));
  }
  EXPECT_THAT(svg, Not(HasSubstr("Target error")));
  EXPECT_THAT(svg, Not(HasSubstr("Porosity")));
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
}

TEST(CurvesPlot, LogarithmicAxesBeginAboveRounding) {
  // An error that falls from 0.1 to rounding.
  record::PlottedRun run = someRun();
  const auto svgOf = [&run](double middle, double last, double rounding) {
    run.groups = {{"Error", "m", true, {{"error", "error_m", {0.1, middle, last}}}}};
    run.rounding = rounding;
    return record::plotCurves({run}, picture::PageFormat::Svg, {});
  };
  const std::string measured = svgOf(0.01, 2e-19, 1e-4);
  EXPECT_THAT(measured, HasSubstr(">1e-4<"));
  EXPECT_THAT(measured, Not(HasSubstr(">1e-5<")));
  EXPECT_THAT(measured, Not(HasSubstr("rounding")));
  const std::string wide = svgOf(0.01, 2e-19, 1e-12);  // at most six decades
  EXPECT_THAT(wide, HasSubstr(">1e-7<"));
  EXPECT_THAT(wide, Not(HasSubstr(">1e-9<")));
  run.groups = {{"Gap", "m", true, {{"gap", "gap_m", {1e-17, 3e-16, 2e-16}}}}};
  EXPECT_THAT(record::plotCurves({run}, picture::PageFormat::Svg, {}),
              HasSubstr(">Gap, m (only rounding)<"));
}

TEST(CurvesPlot, HasTheSameBytesEachTime) {
  for (const picture::PageFormat format :
       {picture::PageFormat::Svg, picture::PageFormat::Pdf, picture::PageFormat::Png}) {
    EXPECT_EQ(plotted(format), plotted(format));
  }
}

TEST(CurvesPlot, HasTheRequestedWidth) {
  const test::TemporaryFolder folder;
  writeTextFile(folder / "curves.png", plotted(picture::PageFormat::Png));
  const picture::Frame frame = test::readPng(folder / "curves.png");
  EXPECT_EQ(frame.size.width, 709);  // 180 mm at 100 dots an inch
  EXPECT_EQ(frame.at(0, 0), (picture::Colour{255, 255, 255}));
  int blue = 0;
  for (int y = 0; y < frame.size.height; ++y) {
    for (int x = 0; x < frame.size.width; ++x)
      blue += frame.at(x, y).blue > frame.at(x, y).red + 60;
  }
  EXPECT_GT(blue, 300);  // measured 1300: three lines, each across half of the figure
}

TEST(CurvesPlot, ReportsThatThereAreNoCurves) {
  record::PlottedRun run = someRun();
  run.groups = {run.groups[2]};
  EXPECT_THROW(record::plotCurves({run}, picture::PageFormat::Svg, {}), InputError);
}

TEST(CurvesPlot, NamesRunsThatShareADiagram) {
  record::PlottedRun soft = someRun("soft"), stiff = someRun("stiff");
  soft.groups = stiff.groups = {soft.groups[0], soft.groups[4]};
  const std::string svg = record::plotCurves({soft, stiff}, picture::PageFormat::Svg, {});
  for (const char* text : {">soft, width<", ">stiff, depth<", ">soft<", ">stiff<"}) {
    EXPECT_THAT(svg, HasSubstr(text));
  }
  EXPECT_THAT(svg, Not(HasSubstr(">gap<")));
}

/// A text in an SVG file, as a box: letters are up to 0.75 em high and 0.22 em below the baseline.
struct SvgText {
  std::string text;
  Eigen::AlignedBox2d box;
};

std::vector<SvgText> textsOf(const std::string& svg) {
  std::vector<SvgText> texts;
  const std::regex pattern(
      "<text x=\"([-0-9.]+)\" y=\"([-0-9.]+)\" font-size=\"([0-9]+)\"[^>]*>([^<]*)<");
  for (std::sregex_iterator found(svg.begin(), svg.end(), pattern), end; found != end; ++found) {
    const double x = std::stod((*found)[1]), y = std::stod((*found)[2]);
    const int em = std::stoi((*found)[3]);
    const double width = picture::LabelWriter(em).width((*found)[4]);
    texts.push_back({(*found)[4], Eigen::AlignedBox2d(Eigen::Vector2d(x, y - 0.75 * em),
                                                      Eigen::Vector2d(x + width, y + 0.22 * em))});
  }
  return texts;
}

/// The points of lines in the colours of curves, at most a pixel apart.
std::vector<Eigen::Vector2d> curvePointsOf(const std::string& svg) {
  std::vector<Eigen::Vector2d> points;
  const std::regex paths(
      "<path fill=\"none\" stroke=\"#(?:2b64a6|c2571a|3d8b5f)\"[^>]* d=\"([^\"]*)\"");
  const std::regex pairs("([ML]?) ?([-0-9.]+)[ ,]([-0-9.]+)");
  for (std::sregex_iterator path(svg.begin(), svg.end(), paths), end; path != end; ++path) {
    const std::string data = (*path)[1];
    Eigen::Vector2d last = Eigen::Vector2d::Zero();
    for (std::sregex_iterator pair(data.begin(), data.end(), pairs); pair != end; ++pair) {
      const Eigen::Vector2d point(std::stod((*pair)[2]), std::stod((*pair)[3]));
      const double steps = (*pair)[1] == "M" ? 0 : std::ceil((point - last).norm());
      for (double k = 1; k <= steps; ++k) points.push_back(last + k / steps * (point - last));
      last = point;
    }
  }
  return points;
}

/// Texts are on the page and cover neither each other nor curves. At 40 mm the names of three runs
/// have no free place among these curves.
TEST(CurvesPlot, TextsAreApart) {
  std::vector<record::PlottedRun> runs;
  for (const char* name : {"r_heart_um", "r_tri_up_mm", "r_isl_side_km"}) {
    record::PlottedRun run{name, {}, {"share of the motion", {}}};
    std::vector<double> rising, ratios, waves;
    for (int k = 0; k <= 40; ++k) {
      const double at = k / 40.0, shift = 0.3 * static_cast<double>(runs.size());
      run.abscissa.values.push_back(at);
      rising.push_back(1000 * (at + shift));
      ratios.push_back(-1.2 + 0.01 * at * (1 - shift));
      waves.push_back(std::sin(12 * at + shift));  // in all corners
    }
    run.groups = {{"Opening", "degrees", false, {{"mean", "opening_mean_deg", rising}}},
                  {"Poisson's ratio", "", false, {{"ratio", "poissons_ratio", ratios}}},
                  {"Force on held tiles", "N", false, {{"pins", "pin_force_N", waves}}}};
    runs.push_back(std::move(run));
  }
  for (const double width : {60.0, 90.0, 180.0}) {
    SCOPED_TRACE(width);
    const std::string svg =
        record::plotCurves(runs, picture::PageFormat::Svg, {.width = width, .dotsPerInch = 300});
    const std::vector<SvgText> texts = textsOf(svg);
    const std::vector<Eigen::Vector2d> points = curvePointsOf(svg);
    EXPECT_GT(texts.size(), 25U);
    EXPECT_GT(points.size(), 900U);
    for (std::size_t k = 0; k < texts.size(); ++k) {
      const Eigen::AlignedBox2d& box = texts[k].box;
      EXPECT_GE(box.min().x(), 0) << texts[k].text;
      EXPECT_LE(box.max().x(), width / 25.4 * 300 + 1) << texts[k].text;
      for (std::size_t other = 0; other < k; ++other) {
        EXPECT_FALSE(box.intersects(texts[other].box))
            << texts[k].text << " and " << texts[other].text;
      }
      const bool isCovered = std::ranges::any_of(
          points, [&box](const Eigen::Vector2d& point) { return box.contains(point); });
      EXPECT_FALSE(isCovered) << texts[k].text;
    }
  }
}

TEST(Curves, AreSelectedByGroupOrColumn) {
  const trajectory::RunCurves curves = someCurves();
  EXPECT_EQ(record::selectCurves(curves.groups, {}).size(), 5U);
  const auto chosen = record::selectCurves(curves.groups, {"joint_gap", "depth", "poissons_ratio"});
  ASSERT_EQ(chosen.size(), 3U);
  EXPECT_EQ(chosen[0].name, "Joint gap");
  EXPECT_EQ(chosen[1].name, "Size");
  ASSERT_EQ(chosen[1].curves.size(), 1U);
  EXPECT_EQ(chosen[1].curves[0].column, "depth_m");
  EXPECT_EQ(record::selectCurves(curves.groups, {"size"})[0].curves.size(), 2U);
  const auto both = record::selectCurves(curves.groups, {"depth", "joint_gap", "width", "depth"});
  ASSERT_EQ(both.size(), 2U);
  ASSERT_EQ(both[0].curves.size(), 2U);
  EXPECT_EQ(both[0].curves[1].name, "width");
  try {
    record::selectCurves(curves.groups, {"gapp"});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), StartsWith("error: --curves: there is no curve 'gapp'; give some of "
                                         "size, width, depth, poissons_ratio, "));
  }
}

/// Runs in folders, each with a model in a unit.
class CurvesInUnits : public ::testing::Test {
 protected:
  std::unique_ptr<record::NamedRun> recorded(const std::string& name, const LengthUnit& unit) {
    scene::Scene scene;
    scene.model = generate::makeTessellation({.columns = 2, .rows = 2});
    for (auto* tiles : {&scene.model.tiles, &*scene.model.target}) {
      for (model::Tile& tile : *tiles) {
        for (Vector3& vertex : tile.vertices) vertex *= unit.metres;
      }
    }
    scene.model.unit = unit;
    trajectory::Trajectory trajectory{trajectory::subjectOf(scene)};
    for (int k = 0; k <= 2; ++k) {
      trajectory::Sample sample;
      sample.time = k;
      sample.poses = brick::startPoses(scene.model.tiles, trajectory.bricks);
      sample.poses[0].position.x() -= unit.metres * k;
      sample.jointGap = 1e-17 * unit.metres;
      trajectory.samples.push_back(sample);
    }
    std::filesystem::create_directories(folder_ / name);
    test::writeTrajectory(trajectory, folder_ / name / "trajectory.h5");
    return std::make_unique<record::NamedRun>(record::openRun(folder_ / name / "trajectory.h5"));
  }

  test::TemporaryFolder folder_;
};

TEST_F(CurvesInUnits, AreInTheUnitOfTheModel) {
  std::vector<record::NamedRun> runs;
  runs.push_back(std::move(*recorded("small", *findLengthUnit("um"))));
  const record::PlottedRun small = record::plottedRuns(runs, {.selected = {"size", "area"}})[0];
  EXPECT_EQ(small.groups[0].unit, "µm");
  EXPECT_EQ(small.groups[1].unit, "µm²");
  EXPECT_NEAR(small.groups[0].curves[0].values[0], 2, 1e-9);
  EXPECT_NEAR(small.groups[0].curves[0].values[2], 4, 1e-9);
  const record::PlottedRun inset =
      record::plottedCurve(*runs[0].reader, "width", record::CurvesAgainst::Time, "--inset");
  EXPECT_EQ(inset.groups[0].unit, "µm");
  EXPECT_NEAR(inset.groups[0].curves[0].values[2], 4, 1e-9);
  // Several units: that of the first.
  runs.push_back(std::move(*recorded("large", *findLengthUnit("km"))));
  const std::vector<record::PlottedRun> both = record::plottedRuns(runs, {.selected = {"width"}});
  EXPECT_EQ(both[0].groups[0].unit, "µm");
  EXPECT_EQ(both[1].groups[0].unit, "µm");
  EXPECT_NEAR(both[1].groups[0].curves[0].values[0], 2e9, 1);
}

TEST_F(CurvesInUnits, OnlyRoundingIsShownOnRequest) {
  std::vector<record::NamedRun> runs;
  runs.push_back(std::move(*recorded("run", {})));
  const auto hasGap = [&](const record::CurvesSettings& settings) {
    return std::ranges::any_of(
        record::plottedRuns(runs, settings)[0].groups,
        [](const trajectory::CurveGroup& group) { return group.name == "Joint gap"; });
  };
  EXPECT_FALSE(hasGap({}));
  EXPECT_TRUE(hasGap({.selected = {"joint_gap"}}));
}

TEST_F(CurvesInUnits, RunsOfASweepAreNamedByTheirInputs) {
  std::vector<record::NamedRun> runs;
  for (const std::string rows : {"4", "8"}) {
    const std::string folder = "hash" + rows;
    recorded(folder, {});
    const std::string inputs = R"({"model": "cap", "rows": ")" + rows + "\"}";
    writeTextFile(folder_ / folder / "run.json", R"({"status": "done", "inputs": )" + inputs + "}");
    runs.push_back(record::openRun(folder_ / folder / "trajectory.h5"));
  }
  const std::vector<record::PlottedRun> plotted = record::plottedRuns(runs, {});
  EXPECT_EQ(plotted[0].name, "rows 4");
  EXPECT_EQ(plotted[1].name, "rows 8");
  runs.pop_back();
  EXPECT_EQ(record::plottedRuns(runs, {})[0].name, "hash4");
  writeTextFile(folder_ / "hash4" / "run.json", "[1, {]");
  EXPECT_TRUE(record::openRun(folder_ / "hash4" / "trajectory.h5").inputs.empty());
}

TEST_F(CurvesInUnits, TableOfASweepHasItsParameterAsAxis) {
  std::vector<record::NamedRun> runs;
  runs.push_back(std::move(*recorded("run", {})));
  const std::filesystem::path table = folder_ / "sweep.csv";
  writeTextFile(table, "run,rows,outcome,end_time\n1a,4,settled,2.5\n2b,8,settled,3\n");
  const auto plotOf = [&](const char* column) {
    return record::plottedRuns(runs, {.columns = {{table, column}}}).back();
  };
  EXPECT_EQ(plotOf("end_time").abscissa.title, "rows");
  EXPECT_THAT(plotOf("end_time").abscissa.values, ElementsAre(4, 8));
  EXPECT_THAT(plotOf("end_time").groups[0].curves[0].values, ElementsAre(2.5, 3));
  try {
    plotOf("outcome");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("sweep.csv: error: the column outcome has no numbers"));
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
