// The slope of a straight line through X = ln x and Y = ln y by least squares:
//   b = sum (X - mean X)(Y - mean Y) / sum (X - mean X)^2

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <malloc.h>

#include "sim/study/exact_sheet.h"
#include "sim/study/stepped_scene.h"
#include "sim/study/study.h"

namespace kirireel::study {

double fittedExponent(const std::vector<PowerPoint>& points) {
  const double count = static_cast<double>(points.size());
  double meanX = 0;
  double meanY = 0;
  for (const PowerPoint& point : points) {
    meanX += std::log(point.x) / count;
    meanY += std::log(point.y) / count;
  }
  double spread = 0;
  double slope = 0;
  for (const PowerPoint& point : points) {
    const double dx = std::log(point.x) - meanX;
    spread += dx * dx;
    slope += dx * (std::log(point.y) - meanY);
  }
  return spread > 0 ? slope / spread : std::nan("");
}

// ------------------------------------------------------------------------------------------------
// Cost and memory of a step against the number of tiles. The time of a step is an average over up
// to 240 steps from the closed state. Large sheets take fewer steps, as many as their budget
// allows. Exponents are fitted from 100 tiles, because fixed costs dominate below.

namespace {

// The first steps leave the closed state and take longer. All steps count, as in a run.
constexpr int kSteps = 240;
constexpr int kMinSteps = 3;
// Above this number costs follow a power law.
constexpr double kMinTiles = 100;

/// Bytes that the program currently holds.
double heldBytes() {
  // From glibc's statistics: blocks in use and mapped blocks, without reserved memory.
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks) + static_cast<double>(info.hblkhd);
}

// Memory is the difference of held memory after and before the run: bricks, joints, plan and
// factor.
std::vector<Row> growSheet(const SheetMethod& settings, double budget) {
  const scene::Scene scene = sheetScene(settings.side, settings.planar);
  const double before = heldBytes();
  SteppedScene run(scene, settings.method);
  int steps = 0;
  double gap = 0;
  while (steps < kSteps && (steps < kMinSteps || run.seconds() < budget)) {
    run.advance();
    gap = std::max(gap, run.gap());
    ++steps;
  }
  return {{settings.method.engine.name, settings.planar ? "plane" : "space",
           cell(settings.side * settings.side), cell(steps), cell(1e3 * run.seconds() / steps),
           cell(1e3 * run.setupSeconds()), cell((heldBytes() - before) / 1e6), cell(gap)}};
}

// Sides of the sheets: the number of tiles grows by a factor of 4, finally of 6.25. Each engine
// runs with one setting; the sweeps of 50 iterations are those of the baseline.
std::vector<SheetMethod> scalingSheets(Extent extent) {
  const bool quick = extent == Extent::Quick;
  std::vector<SheetMethod> sheets;
  const auto add = [&](const Method& method, bool planar, const std::vector<int>& sides) {
    for (const int side : sides) sheets.push_back({method, planar, side});
  };
  add({kDirect}, true, {5, 10, 20, 40, 100});
  add({kDirect}, false, quick ? std::vector{5, 10, 20, 40} : std::vector{5, 10, 20, 40, 100});
  add(bulletBaseline(), false, quick ? std::vector{5, 10, 20} : std::vector{5, 10, 20, 40, 100});
  return sheets;
}

StudyCase scalingCase(const SheetMethod& sheet, Extent extent) {
  const double budget = extent == Extent::Quick ? 1.0 : 5.0;  // CPU seconds
  return {fmt::format("{} {} {}", toString(sheet.method), sheet.planar ? "plane" : "space",
                      sheet.side * sheet.side),
          [sheet, budget] { return growSheet(sheet, budget); }};
}

// The slope of a column over the tiles, both as logarithms, for one engine and motion.
double exponent(const Table& table, const std::string& engine, const std::string& motion,
                const std::string& column) {
  std::vector<PowerPoint> points;
  for (const Row& row : table.rows) {
    const double tiles = table.number(row, "tiles");
    const bool belongs = table.text(row, "engine") == engine && table.text(row, "motion") == motion;
    if (belongs && tiles >= kMinTiles) points.push_back({tiles, table.number(row, column)});
  }
  return fittedExponent(points);
}

// In the plane a sparse direct method should need about n^1.5 of time and n log n of memory with
// nested dissection (A. George, SIAM J. Numer. Anal. 10, 1973).
std::vector<Finding> scalingFindings(const Table& table) {
  const std::string time = "ms_per_step";
  const std::string memory = "memory_mb";
  std::vector<Finding> found = {
      {"direct_exponent_plane", exponent(table, "direct", "plane", time),
       "b of CPU time = a tiles^b above 100 tiles, direct solver in the plane"},
      {"direct_exponent_space", exponent(table, "direct", "space", time),
       "the same, direct solver in space"},
      {"bullet_exponent_space", exponent(table, "sequential impulse", "space", time),
       "the same, Bullet"},
      {"direct_memory_exponent_plane", exponent(table, "direct", "plane", memory),
       "b of memory = a tiles^b, direct solver in the plane"},
      {"direct_memory_exponent_space", exponent(table, "direct", "space", memory),
       "the same, direct solver in space"}};
  for (const std::string motion : {"plane", "space"}) {
    for (const std::string& engine : otherEngines(table, motion)) {
      found.push_back({fmt::format("{}_exponent_{}", engine, motion),
                       exponent(table, engine, motion, time),
                       fmt::format("b of CPU time = a tiles^b above 100 tiles, {}", engine)});
    }
  }
  return found;
}

}  // namespace

Study scalingStudy(const SheetMethods& methods) {
  return {"scaling",
          "cost and memory of a step on sheets of 25 to 10,000 tiles",
          {{"engine", "solver of the joints"},
           {"motion", "plane or space"},
           {"tiles", "number of tiles"},
           {"steps", "number of steps of 1/240 s"},
           {"ms_per_step", "CPU time of a step, milliseconds"},
           {"setup_ms", "CPU time before the first step, milliseconds"},
           {"memory_mb", "memory of bricks, joints and solver, millions of bytes"},
           {"gap_m", "largest joint gap of all steps, metres"}},
          sheetCases(methods, scalingCase),
          scalingFindings};
}

Study scalingStudy() {
  return scalingStudy(scalingSheets);
}

}  // namespace kirireel::study
