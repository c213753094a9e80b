// The slope of a straight line through (ln x, ln y) by least squares: b = sum (X - mean X)(Y - mean
// Y) / sum (X - mean X)^2.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <malloc.h>

#include "sim/study/exact_sheet.h"
#include "sim/study/stepped_scene.h"
#include "sim/study/study.h"

namespace kirireel::study {

// Not a number where all points have the same x, or where a logarithm does not exist.
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
// Cost and memory of a step by the number of tiles. The time of a step is an average over up to 240
// steps from the closed state on; large sheets take fewer, as many as their budget allows.
// Exponents are fitted from 100 tiles on, as fixed costs hide the law below.

namespace {

// The first steps leave the closed state and take longer; both kinds are counted, as in a run.
constexpr int kSteps = 240;
constexpr int kLeastSteps = 3;
// From here on costs follow a power law.
constexpr double kLeastTiles = 100;

struct ScalingRun {
  Method method;
  bool planar;
  int side;
  double budget;  // CPU seconds
};

/// Bytes that the program holds at present.
double heldBytes() {
  // glibc's own account: blocks in use and mapped blocks, without what the system has set aside.
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks) + static_cast<double>(info.hblkhd);
}

// Memory is what the program holds after the run less what it held before: bricks, joints, plan and
// factor.
std::vector<Row> growSheet(const ScalingRun& settings) {
  const scene::Scene scene = sheetScene(settings.side, settings.planar);
  const double before = heldBytes();
  SteppedScene run(scene, settings.method);
  int steps = 0;
  double gap = 0;
  while (steps < kSteps && (steps < kLeastSteps || run.seconds() < settings.budget)) {
    run.advance();
    gap = std::max(gap, run.gap());
    ++steps;
  }
  return {{toString(settings.method.engine), settings.planar ? "plane" : "space",
           cell(settings.side * settings.side), cell(steps), cell(1e3 * run.seconds() / steps),
           cell(1e3 * run.setupSeconds()), cell((heldBytes() - before) / 1e6), cell(gap)}};
}

// Sides of the sheets: tiles quadruple, and at last grow by 6.25 times. Each engine runs with one
// setting; the sweeps of 50 iterations are those of the baseline.
std::vector<StudyCase> scalingCases(Extent extent) {
  const bool quick = extent == Extent::Quick;
  std::vector<StudyCase> made;
  const auto add = [&](const Method& method, bool planar, const std::vector<int>& sides) {
    if (!isAvailable(method.engine)) return;
    for (const int side : sides) {
      made.push_back(
          {fmt::format("{} {} {}", toString(method), planar ? "plane" : "space", side * side), [=] {
             return growSheet({method, planar, side, quick ? 1.0 : 5.0});
           }});
    }
  };
  add({Engine::Direct}, true, {5, 10, 20, 40, 100});
  add({Engine::Direct}, false,
      quick ? std::vector{5, 10, 20, 40} : std::vector{5, 10, 20, 40, 100});
  add(bulletBaseline(), false, quick ? std::vector{5, 10, 20} : std::vector{5, 10, 20, 40, 100});
  add({Engine::Chipmunk, 240, 4, 50}, true,
      quick ? std::vector{5, 10, 20} : std::vector{5, 10, 20, 40, 100});
  return made;
}

// The slope of a column over the tiles, both as logarithms, of one engine and motion.
double exponent(const Table& table, const std::string& engine, const std::string& motion,
                const std::string& column) {
  std::vector<PowerPoint> points;
  for (const Row& row : table.rows) {
    const double tiles = table.number(row, "tiles");
    const bool belongs = table.text(row, "engine") == engine && table.text(row, "motion") == motion;
    if (belongs && tiles >= kLeastTiles) points.push_back({tiles, table.number(row, column)});
  }
  return fittedExponent(points);
}

// For sheets in the plane a sparse direct method can expect about n^1.5 of time and n log n of
// memory with nested dissection (A. George, SIAM J. Numer. Anal. 10, 1973).
std::vector<Finding> scalingFindings(const Table& table) {
  const std::string time = "ms_per_step";
  const std::string memory = "memory_mb";
  return {{"direct_exponent_plane", exponent(table, "direct", "plane", time),
           "b of CPU time = a tiles^b from 100 tiles on, ours in the plane"},
          {"direct_exponent_space", exponent(table, "direct", "space", time),
           "the same of ours in space"},
          {"bullet_exponent_space", exponent(table, "sequential impulse", "space", time),
           "the same of Bullet"},
          {"chipmunk_exponent_plane", exponent(table, "chipmunk", "plane", time),
           "the same of Chipmunk"},
          {"direct_memory_exponent_plane", exponent(table, "direct", "plane", memory),
           "b of memory = a tiles^b, ours in the plane"},
          {"direct_memory_exponent_space", exponent(table, "direct", "space", memory),
           "the same of ours in space"}};
}

}  // namespace

Study scalingStudy() {
  return {"scaling",
          "cost and memory of a step on sheets of 25 to 10,000 tiles",
          {{"engine", "what held the joints"},
           {"motion", "plane or space"},
           {"tiles", "of the sheet"},
           {"steps", "taken, of 1/240 s"},
           {"ms_per_step", "CPU milliseconds"},
           {"setup_ms", "CPU milliseconds before the first step"},
           {"memory_mb", "that bricks, joints and solver hold, millions of bytes"},
           {"gap_m", "largest joint gap of all steps, metres"}},
          scalingCases,
          scalingFindings};
}

}  // namespace kirireel::study
