// Sheets under grips against other programs. Skipped if these are not installed.
#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/cli/run_program.h"
#include "tests/support/program.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

using test::kPython;

/// So many consecutive numbers from the first, separated by commas.
std::string listed(int first, int count) {
  std::string list;
  for (int k = 0; k < count; ++k) list += fmt::format("{}{}", k ? "," : "", first + k);
  return list;
}

/// A scene in which some tiles are held along x, one of them along y too, and others are moved.
std::string squeezed(const std::string& held, const std::string& moved, double move,
                     const std::string& model) {
  return fmt::format(
      "[model]\nno_align = true\n{}\n"
      "[[grip]]\ntiles = [{}]\nmove = {{x = 0}}\n"
      "[[grip]]\ntile = 0\nmove = {{y = 0}}\n"
      "[[grip]]\ntiles = [{}]\nmove = {{x = {}}}\n",
      model, held, moved, move);
}

// 8 x 8 irregular quads on necks under compression, state by state, against SciPy's minimiser of
// the independent energy of ligament_minimiser.py.
TEST(ProgramLoad, FindsTheEquilibriaOfScipysMinimiser) {
  if (test::outputOf(fmt::format("{} -c 'import scipy; print(1)'", kPython)).empty()) {
    GTEST_SKIP() << "install python3-scipy to check equilibria with its minimisers";
  }
  const TemporaryFolder scratch;
  const std::string model = scratch / "quads", run = scratch / "run",
                    scene = scratch / "scene.toml";
  runKirireel({"generate", "quads", "--columns", "8", "--rows", "8", "--start-angle", "40", model});
  writeText(scene, squeezed(listed(0, 8), listed(56, 8), -0.8,
                            "ligaments = true\nhinge_neck = \"0.02,0.1,1e6,0.3\"\n"
                            "thickness = 0.02\n"));
  const ProgramEnd end = runKirireel({"simulate", model, "--scene", scene, "--out", run});
  ASSERT_EQ(end.exitCode, 0) << end.err;
  const ProgramEnd checked =
      runTool(kPython, {KIRIREEL_SOURCE_DIR "/tests/cli/ligament_minimiser.py", model, run, "0.02",
                        "0.1", "1e6", "0.3", "0.02", "8"});
  ASSERT_EQ(checked.exitCode, 0) << checked.err;
  std::istringstream misses(checked.out);
  double places = 1, energies = 1, forces = 1;
  misses >> places >> energies >> forces;
  EXPECT_LT(places, 1e-10) << checked.out;    // metres; measured 8e-15
  EXPECT_LT(energies, 1e-10) << checked.out;  // measured 6e-15
  EXPECT_LT(forces, 1e-9) << checked.out;     // measured 1e-11
}

/// Results of bar_and_hinge.py for a run.
struct BarsAndHinges {
  double forces = 1, energies = 1;  ///< differences, fractions of the largest
  double softest = 0;               ///< the smallest stiffness, N/m
  double largest = 0;               ///< force, N
};

BarsAndHinges checkedByBarsAndHinges(const char* which) {
  const TemporaryFolder scratch;
  const std::string script = KIRIREEL_SOURCE_DIR "/tests/cli/bar_and_hinge.py";
  const std::string folder = scratch.path(), run = scratch / "run";
  EXPECT_EQ(runTool(kPython, {script, "make", which, folder}).exitCode, 0);
  const ProgramEnd end = runKirireel(
      {"simulate", folder + "/model.fold", "--scene", folder + "/scene.toml", "--out", run});
  EXPECT_EQ(end.exitCode, 0) << end.err;
  const ProgramEnd checked = runTool(kPython, {script, "check", which, folder, run});
  EXPECT_EQ(checked.exitCode, 0) << checked.err;
  std::istringstream output(checked.out);
  BarsAndHinges found;
  output >> found.forces >> found.energies >> found.softest >> found.largest;
  return found;
}

bool hasNumpy() {
  return !test::outputOf(fmt::format("{} -c 'import numpy; print(1)'", kPython)).empty();
}

// A Miura sheet of 3 x 3 cells under tension, with bending tiles, against the bars and hinges of
// bar_and_hinge.py.
TEST(ProgramLoad, PullsAMiuraSheetLikeBarsAndHinges) {
  if (!hasNumpy()) GTEST_SKIP() << "install python3-numpy to check origami with bars and hinges";
  const BarsAndHinges found = checkedByBarsAndHinges("miura");
  EXPECT_LT(found.forces, 1e-8);     // measured 7e-9
  EXPECT_LT(found.energies, 1e-10);  // measured 2e-15
  EXPECT_GT(found.softest, 0);
}

// A storey of a Kresling tower that is pressed until it snaps through.
TEST(ProgramLoad, SnapsAKreslingTowerLikeBarsAndHinges) {
  if (!hasNumpy()) GTEST_SKIP() << "install python3-numpy to check origami with bars and hinges";
  const BarsAndHinges found = checkedByBarsAndHinges("kresling");
  EXPECT_LT(found.forces, 1e-10);    // measured 1.3e-12, at a bifurcation
  EXPECT_LT(found.energies, 1e-10);  // measured 1e-15
  EXPECT_LT(found.softest, 0);
}

// A Miura sheet stays stable. A Kresling tower has unstable modes along its path.
TEST(ProgramLoad, PlotsItsLoadCurve) {
  if (!hasNumpy()) GTEST_SKIP() << "install python3-numpy to make origami";
  const TemporaryFolder scratch;
  const std::string script = KIRIREEL_SOURCE_DIR "/tests/cli/bar_and_hinge.py";
  const std::string folder = scratch.path(), run = scratch / "run";
  for (const std::string which : {"miura", "kresling"}) {
    EXPECT_EQ(runTool(kPython, {script, "make", which, folder}).exitCode, 0);
    runKirireel(
        {"simulate", folder + "/model.fold", "--scene", folder + "/scene.toml", "--out", run});
    const ProgramEnd plotted = runKirireel({"curves", run, "--plot", "svg"});
    EXPECT_EQ(plotted.exitCode, 0) << plotted.err;
    EXPECT_THAT(plotted.err, Not(HasSubstr("no energies and forces")));
    const std::string svg = readText(run + "/curves.svg");
    EXPECT_THAT(svg, HasSubstr(which == "miura" ? ">Force, N<" : ">Force, N (dashed: unstable)<"));
    EXPECT_THAT(svg, HasSubstr(">displacement of the grip, m<"));
    EXPECT_THAT(svg, HasSubstr(">Size, m<"));
    EXPECT_EQ(runKirireel({"curves", run, "--plot", "svg", "--curves", "load_curve"}).exitCode, 0);
    EXPECT_THAT(readText(run + "/curves.svg"), Not(HasSubstr("simulated time, s")));
  }
  // A run without grips has no load curve.
  const std::string other = scratch / "other";
  runKirireel({"simulate", shippedModel("tessellation_4x4").string(), "--out", other});
  EXPECT_THAT(runKirireel({"curves", other, "--plot", "svg", "--curves", "load_curve"}).err,
              HasSubstr("there is no curve 'load_curve'"));
}

/// A flat sheet that is pulled along x by its last tiles, its first ones held.
struct PulledSheet {
  std::vector<std::string> generated = {"tessellation"};  ///< arguments of `generate`
  std::string held = listed(0, 4);                        ///< held tiles, the first along y too
  std::string moved = listed(12, 4);                      ///< moved tiles
  double move = 0.3;                                      ///< metres
};

/// The differences between forces of such a sheet in CalculiX and here, relative.
double missOfNecks(double width, double length, const std::vector<std::string>& cut,
                   const std::string& joints, const PulledSheet& sheet = {}) {
  const TemporaryFolder scratch;
  const std::string model = scratch / "sheet", run = scratch / "run",
                    scene = scratch / "scene.toml";
  std::vector<std::string> generate = {"generate"};
  generate.insert(generate.end(), sheet.generated.begin(), sheet.generated.end());
  generate.push_back(model);
  runKirireel(generate);
  writeText(scene, squeezed(sheet.held, sheet.moved, sheet.move,
                            fmt::format("hinge_neck = \"{},{},1e9,0.3\"\nthickness = 0.02\n{}"
                                        "[actuation]\nload_steps = 100\n",
                                        width, length, joints)));
  const ProgramEnd end = runKirireel({"simulate", model, "--scene", scene, "--out", run});
  // The tiles next to wide necks overlap a little, because the run has no contacts.
  const bool isOverlapping = end.out.find("tiles overlap by up to") != std::string::npos;
  EXPECT_EQ(end.exitCode, isOverlapping ? 3 : 0) << end.out << end.err;
  std::vector<std::string> words = {"export",
                                    run,
                                    "--format",
                                    "inp",
                                    "--states",
                                    "initial",
                                    "--joints",
                                    "neck",
                                    "--neck-width",
                                    fmt::format("{}", width),
                                    "--plane-stress",
                                    "--elements-per-edge",
                                    "2"};
  words.insert(words.end(), cut.begin(), cut.end());
  EXPECT_EQ(runKirireel(words).exitCode, 0);
  const ProgramEnd pulled = runTool(
      kPython, {KIRIREEL_SOURCE_DIR "/tests/cli/neck_pull.py", run + "/sheet_mesh.inp", "0.02",
                "1e9", "0.3", sheet.held, sheet.moved, fmt::format("{}", sheet.move), "3", run});
  EXPECT_EQ(pulled.exitCode, 0) << pulled.err;
  double largest = 0;
  std::istringstream lines(pulled.out);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    double place = 0, requested = 0, own = 0;
    if (words >> place >> requested >> own)
      largest = std::max(largest, std::abs(own / requested - 1));
  }
  return pulled.out.empty() ? 1 : largest;
}

// Sheets on necks without a length, with the stiffness of the table, and on slender ones, with the
// force over opening of decks.
TEST(ProgramNecks, OpenLikeDecksInCalculix) {
  for (const char* program : {"ccx", "gmsh"}) {
    if (!test::hasProgram(program)) GTEST_SKIP() << "install " << program << " to check necks";
  }
  // Measured: 0.044, 0.046, 0.010.
  for (const double width : {0.05, 0.1, 0.2}) {
    EXPECT_LT(missOfNecks(width, 0, {}, ""), 0.1) << width;
  }
  EXPECT_LT(missOfNecks(0.04, 0.2, {"--neck-length", "0.2", "--kerf", "0.002"}, ""), 0.05);
}

// Tiles with corners of 60 degrees.
TEST(ProgramNecks, OpenTrianglesLikeDecksInCalculix) {
  for (const char* program : {"ccx", "gmsh"}) {
    if (!test::hasProgram(program)) GTEST_SKIP() << "install " << program << " to check necks";
  }
  const PulledSheet triangles{
      {"triangles", "--columns", "3", "--rows", "3"}, listed(0, 3), listed(15, 3), 0.15};
  // Measured: 0.043, 0.037.
  for (const double width : {0.05, 0.1}) {
    EXPECT_LT(missOfNecks(width, 0, {}, "", triangles), 0.1) << width;
  }
}

// Tiles with corners of 120 degrees next to others of 60.
TEST(ProgramNecks, OpenHexagonsLikeDecksInCalculix) {
  for (const char* program : {"ccx", "gmsh"}) {
    if (!test::hasProgram(program)) GTEST_SKIP() << "install " << program << " to check necks";
  }
  const PulledSheet hexagons{
      {"hexagons", "--columns", "3", "--rows", "3"}, "0,3,6", "14,15,16", 0.15};
  // Measured: 0.026, 0.011.
  for (const double width : {0.05, 0.1}) {
    EXPECT_LT(missOfNecks(width, 0, {}, "", hexagons), 0.05) << width;
  }
}

}  // namespace
}  // namespace kirireel
