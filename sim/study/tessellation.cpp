// The rotating squares from closed to 90 degrees, against their exact motion at the same opening
// angle. Each row has the largest errors of all steps since the previous row: no step is skipped.
#include <cmath>

#include <fmt/format.h>

#include "sim/base/geometry.h"
#include "sim/study/exact_sheet.h"
#include "sim/study/stepped_scene.h"
#include "sim/study/study.h"

namespace kirireel::study {
namespace {

constexpr int kTessellationSide = 4;
// Up to this angle a sheet counts as closed: its motion is singular there.
constexpr double kStartDegrees = 2.3;  // 0.04 radians
// Weak springs give many steps per degree.
constexpr double kStiffness = 10;

// Rows of one run, one per degree.
std::vector<Row> openSheet(const SheetMethod& settings, double seconds) {
  scene::Scene scene = sheetScene(kTessellationSide, settings.planar);
  scene.springs.springStiffness = scene.springs.torqueStiffness = kStiffness;
  SteppedScene run(scene, settings.method);
  std::vector<Row> rows;
  double lastDegrees = -1;  // of the previous row
  const int steps = static_cast<int>(seconds * settings.method.rate);
  trajectory::VertexDistance worst;  // since the previous row, to include all steps
  double gap = 0;
  for (int step = 1; step <= steps; ++step) {
    run.advance();
    const double angle = openingAngle(run.motion().poses);
    const trajectory::VertexDistance error = sheetError(kTessellationSide, angle, run.tiles());
    worst = {std::max(worst.largest, error.largest), std::max(worst.mean, error.mean)};
    gap = std::max(gap, run.gap());
    if (std::abs(angle / kDegree - lastDegrees) < 1 && step < steps) continue;
    rows.push_back({settings.method.engine.name, settings.planar ? "plane" : "space",
                    cell(step / double(settings.method.rate)), cell(angle / kDegree),
                    cell(worst.largest), cell(worst.mean), cell(gap)});
    lastDegrees = angle / kDegree;
    worst = {};
    gap = 0;
  }
  return rows;
}

std::vector<SheetMethod> tessellationSheets(Extent /*extent*/) {
  return {{{kDirect}, true}, {{kDirect}, false}, {bulletBaseline(), false}};
}

StudyCase tessellationCase(const SheetMethod& sheet, Extent extent) {
  const double seconds = extent == Extent::Quick ? 5 : 10;
  return {fmt::format("{} {}", toString(sheet.method), sheet.planar ? "plane" : "space"),
          [sheet, seconds] { return openSheet(sheet, seconds); }};
}

/// The largest error of an engine's rows, up to kStartDegrees or beyond.
double largestError(const Table& table, const std::string& engine, bool atStart) {
  return table.largest("max_error_m", engine, [&](const Row& row) {
    return (table.number(row, "angle_deg") < kStartDegrees) == atStart;
  });
}

// The start is reported separately: near the closed state the motion is singular, and errors are
// larger there.
std::vector<Finding> tessellationFindings(const Table& table) {
  std::vector<Finding> found = {
      {"direct_error_start", largestError(table, "direct", true),
       "largest vertex error of the direct solver up to 2.3 degrees, metres"},
      {"direct_error_open", largestError(table, "direct", false),
       "largest vertex error of the direct solver above 2.3 degrees, metres"},
      {"direct_angle", table.largest("angle_deg", "direct", [](const Row&) { return true; }),
       "largest angle of the direct solver, degrees"},
      {"bullet_error_start", largestError(table, "sequential impulse", true),
       "largest vertex error of Bullet up to 2.3 degrees, metres"},
      {"bullet_error_open", largestError(table, "sequential impulse", false),
       "largest vertex error of Bullet above 2.3 degrees, metres"}};
  for (const char* motion : {"plane", "space"}) {
    for (const std::string& engine : otherEngines(table, motion)) {
      found.push_back(
          {fmt::format("{}_error_open", engine), largestError(table, engine, false),
           fmt::format("largest vertex error of {} above 2.3 degrees, metres", engine)});
    }
  }
  return found;
}

}  // namespace

Study tessellationStudy(const SheetMethods& methods) {
  return {"tessellation",
          "4 x 4 squares from 0 to 90 degrees against the exact motion",
          {{"engine", "solver of the joints"},
           {"motion", "plane or space"},
           {"time_s", "simulated seconds"},
           {"angle_deg", "between neighbouring tiles, degrees"},
           {"max_error_m",
            "largest distance of a vertex from the exact sheet at that angle, of all "
            "steps since the row before, metres"},
           {"mean_error_m", "mean distance of all vertices, of the worst of these steps, metres"},
           {"gap_m", "largest joint gap of these steps, metres"}},
          sheetCases(methods, tessellationCase),
          tessellationFindings};
}

Study tessellationStudy() {
  return tessellationStudy(tessellationSheets);
}

}  // namespace kirireel::study
