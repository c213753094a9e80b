// Sheets under grips against other programs: skipped where those are not installed.
#include <sstream>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/cli/run_program.h"
#include "tests/support/program.h"

namespace kirireel {
namespace {

constexpr const char* kPython = "/usr/bin/python3";

/// A scene in which the first `column` tiles are held along x and the last ones moved.
std::string squeezed(int tiles, int column, double move, const std::string& model) {
  const auto numbers = [&](int first) {
    std::string list;
    for (int k = 0; k < column; ++k) list += fmt::format("{}{}", k ? ", " : "", first + k);
    return list;
  };
  return fmt::format(
      "[model]\nno_align = true\n{}\n"
      "[[grip]]\ntiles = [{}]\nmove = {{x = 0}}\n"
      "[[grip]]\ntile = 0\nmove = {{y = 0}}\n"
      "[[grip]]\ntiles = [{}]\nmove = {{x = {}}}\n",
      model, numbers(0), numbers(tiles - column), move);
}

// 8 x 8 irregular quads on necks under compression, state by state, against SciPy's minimiser of
// the energy that the script derives anew (ligament_minimiser.py).
TEST(ProgramLoad, FindsTheEquilibriaOfScipysMinimiser) {
  if (test::outputOf(fmt::format("{} -c 'import scipy; print(1)'", kPython)).empty()) {
    GTEST_SKIP() << "install python3-scipy to judge equilibria by its minimisers";
  }
  const ScratchFolder scratch;
  const std::string model = scratch / "quads", run = scratch / "run",
                    scene = scratch / "scene.toml";
  runKirireel({"generate", "quads", "--columns", "8", "--rows", "8", "--start-angle", "40", model});
  writeText(scene, squeezed(64, 8, -0.8,
                            "ligaments = true\nhinge_neck = \"0.02,0.1,1e6,0.3\"\n"
                            "thickness = 0.02\n"));
  const ProgramEnd end = runKirireel({"simulate", model, "--scene", scene, "--out", run});
  ASSERT_EQ(end.exitCode, 0) << end.err;
  const ProgramEnd judged =
      runTool(kPython, {KIRIREEL_SOURCE_DIR "/tests/cli/ligament_minimiser.py", model, run, "0.02",
                        "0.1", "1e6", "0.3", "0.02", "8"});
  ASSERT_EQ(judged.exitCode, 0) << judged.err;
  std::istringstream misses(judged.out);
  double places = 1, energies = 1, forces = 1;
  misses >> places >> energies >> forces;
  EXPECT_LT(places, 1e-10) << judged.out;    // metres; measured 8e-15
  EXPECT_LT(energies, 1e-10) << judged.out;  // measured 6e-15
  EXPECT_LT(forces, 1e-9) << judged.out;     // measured 1e-11
}

/// What bar_and_hinge.py says of a run.
struct BarsAndHinges {
  double forces = 1, energies = 1;  ///< by how much they miss, parts of the largest
  double softest = 0;               ///< the least stiffness, N/m
  double largest = 0;               ///< force, N
};

BarsAndHinges judgedAsBarsAndHinges(const char* which) {
  const ScratchFolder scratch;
  const std::string script = KIRIREEL_SOURCE_DIR "/tests/cli/bar_and_hinge.py";
  const std::string folder = scratch.path(), run = scratch / "run";
  EXPECT_EQ(runTool(kPython, {script, "make", which, folder}).exitCode, 0);
  const ProgramEnd end = runKirireel(
      {"simulate", folder + "/model.fold", "--scene", folder + "/scene.toml", "--out", run});
  EXPECT_EQ(end.exitCode, 0) << end.err;
  const ProgramEnd judged = runTool(kPython, {script, "judge", which, folder, run});
  EXPECT_EQ(judged.exitCode, 0) << judged.err;
  std::istringstream said(judged.out);
  BarsAndHinges found;
  said >> found.forces >> found.energies >> found.softest >> found.largest;
  return found;
}

bool hasNumpy() {
  return !test::outputOf(fmt::format("{} -c 'import numpy; print(1)'", kPython)).empty();
}

// A Miura sheet of 3 x 3 cells under tension, its tiles bending, against bars and hinges written
// anew (bar_and_hinge.py).
TEST(ProgramLoad, PullsAMiuraSheetAsBarsAndHingesDo) {
  if (!hasNumpy()) GTEST_SKIP() << "install python3-numpy to judge origami by bars and hinges";
  const BarsAndHinges found = judgedAsBarsAndHinges("miura");
  EXPECT_LT(found.forces, 1e-8);     // measured 8e-11
  EXPECT_LT(found.energies, 1e-10);  // measured 2e-15
  EXPECT_GT(found.softest, 0);
}

// A storey of a Kresling tower that is pressed until it snaps through.
TEST(ProgramLoad, SnapsAKreslingTowerAsBarsAndHingesDo) {
  if (!hasNumpy()) GTEST_SKIP() << "install python3-numpy to judge origami by bars and hinges";
  const BarsAndHinges found = judgedAsBarsAndHinges("kresling");
  EXPECT_LT(found.forces, 1e-10);    // measured 1e-13
  EXPECT_LT(found.energies, 1e-10);  // measured 1e-15
  EXPECT_LT(found.softest, 0);
}

}  // namespace
}  // namespace kirireel
