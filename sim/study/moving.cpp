// Work against precision in time for a sheet in motion: springs pull squares open from 5 degrees,
// for half a second. The error is the largest distance of a vertex from its exact position at that
// time. The reference is the limit of fixed steps of first order with closed joints. Their error is
// a power series in the step, and three runs remove two of its terms. Steps to a tolerance are
// another integrator with the same limit.
#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "sim/study/exact_sheet.h"
#include "sim/study/stepped_scene.h"
#include "sim/study/study.h"

namespace kirireel::study {
namespace {

constexpr double kSeconds = 0.5;
constexpr double kFirstAngle = 5 * kDegree;
constexpr int kStatesASecond = 15;    // divides every rate
constexpr int kReferenceRate = 1920;  // of the coarsest of three runs
constexpr double kTimedSeconds =
    0.5;  // of CPU: shorter runs are repeated, the shortest time counts
constexpr int kMaxTimes = 9;

/// Result of one run. If the sheet flies apart in an engine, the errors are NaN.
struct MovingRun {
  SheetPath states;
  double cpuSeconds = 0;
  double gap = 0;
};

// One run of a method over kSeconds, with the tiles at the time of each state.
MovingRun runMoving(const SheetMethod& job) {
  // In the plane engines get one point joint per hinge, which is sufficient and cheapest.
  const bool isPoint = job.planar && job.method.engine != kDirect;
  scene::Scene scene =
      sheetScene(job.side, job.planar, isPoint ? model::JointFace::Bottom : model::JointFace::Both,
                 kFirstAngle);
  SteppedScene run(scene, job.method);
  MovingRun result;
  const int steps = static_cast<int>(std::lround(kSeconds * job.method.rate));
  const int perState = job.method.rate / kStatesASecond;
  for (int step = 1; step <= steps && run.isFinite(); ++step) {
    run.advance();
    result.gap = std::max(result.gap, run.gap());
    // Every rate is a multiple of the states' rate: all runs have states at the same times.
    if (step % perState == 0) result.states.push_back(run.tiles());
  }
  if (!run.isFinite()) result.gap = std::nan("");
  result.cpuSeconds = run.seconds();
  return result;
}

// The exact motion, up to the third order of 1/1920 s.
SheetPath limitOfFixedSteps(int side) {
  const auto statesAt = [&](int rate) { return runMoving({{kDirect, rate}, true, side}).states; };
  return limitOfSteps(statesAt(kReferenceRate), statesAt(2 * kReferenceRate),
                      statesAt(4 * kReferenceRate));
}

/// Computed once for all methods.
const SheetPath& movingReference(int side) {
  static std::map<int, SheetPath> made;
  const auto [found, isNew] = made.try_emplace(side);
  if (isNew) found->second = limitOfFixedSteps(side);
  return found->second;
}

// One row of the table.
std::vector<Row> measureMoving(const SheetMethod& job) {
  const MovingRun run = minTimed([&] { return runMoving(job); }, kMaxTimes, kTimedSeconds);
  const Method& method = job.method;
  return {{method.engine.name, job.planar ? "plane" : "space", cell(job.side * job.side),
           cell(method.rate), cell(method.substeps), cell(method.iterations),
           cell(method.tolerance), cell(1e3 * run.cpuSeconds / kSeconds), cell(run.gap),
           cell(std::isnan(run.gap) ? run.gap : pathError(run.states, movingReference(job.side)))}};
}

// Ours with fixed steps from 1/30 s down, and with steps of up to 1/30 s to a tolerance in tiles.
void addOurs(std::vector<Method>& methods) {
  for (const int rate : {30, 45, 60, 90, 120, 240, 480, 960}) methods.push_back({kDirect, rate});
  for (const double tolerance : {1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 1e-4, 1e-5, 1e-6}) {
    methods.push_back({.engine = kDirect, .rate = 30, .tolerance = tolerance});
  }
}

// Bullet has no planar mode. The rates are multiples of kStatesASecond.
std::vector<Method> movingMethods(bool planar, Extent extent) {
  std::vector<Method> methods;
  addOurs(methods);
  if (planar) return methods;
  for (const Engine& engine : {kSequentialImpulse, kNncg, kMultiBody}) {
    methods.push_back({engine, 240, 1, 10});
    methods.push_back({engine, 960, 1, 50});
    if (extent == Extent::Full) methods.push_back({engine, 240, 20, 50});
  }
  return methods;
}

std::vector<SheetMethod> movingSheets(Extent extent) {
  std::vector<SheetMethod> sheets;
  for (const int side : {10, 20}) {
    if (side > 10 && extent == Extent::Quick) continue;
    for (const bool planar : {true, false}) {
      for (const Method& method : movingMethods(planar, extent)) {
        sheets.push_back({method, planar, side});
      }
    }
  }
  return sheets;
}

// Names of cases must differ, because a resumed study identifies cases by name.
StudyCase movingCase(const SheetMethod& sheet, Extent /*extent*/) {
  const Method& method = sheet.method;
  const std::string rate = method.engine == kDirect ? "" : fmt::format(" 1/{} s", method.rate);
  return {fmt::format("{}{} {} {}", toString(method), rate, sheet.planar ? "plane" : "space",
                      sheet.side * sheet.side),
          [sheet] { return measureMoving(sheet); }};
}

/// The smallest ratio, over all settings of an engine, of its CPU time to our cheapest setting with
/// no larger error in time.
double leastCostAtEqualError(const Table& table, const std::string& engine,
                             const std::string& motion, const std::string& tiles) {
  double least = std::nan("");
  const auto isOf = [&](const Row& row, const std::string& name) {
    return table.text(row, "engine") == name && table.text(row, "motion") == motion &&
           table.text(row, "tiles") == tiles;
  };
  for (const Row& row : table.rows) {
    if (!isOf(row, engine)) continue;
    double ours = std::nan("");
    for (const Row& other : table.rows) {
      if (!isOf(other, "direct")) continue;
      if (table.number(other, "error_m") > table.number(row, "error_m")) continue;
      ours = std::fmin(ours, table.number(other, "cpu_ms_per_s"));
    }
    least = std::fmin(least, table.number(row, "cpu_ms_per_s") / ours);
  }
  return least;
}

// One figure for each engine, motion and size. NaN if rows are absent.
std::vector<Finding> movingFindings(const Table& table) {
  std::vector<std::string> inSpace = {"sequential impulse", "nncg", "multibody"};
  std::ranges::copy(otherEngines(table, "space"), std::back_inserter(inSpace));
  const std::vector<std::pair<std::string, std::vector<std::string>>> engines = {
      {"plane", otherEngines(table, "plane")}, {"space", inSpace}};
  std::vector<Finding> found;
  for (const char* tiles : {"100", "400"}) {
    for (const auto& [motion, names] : engines) {
      for (const std::string& engine : names) {
        std::string word = engine;
        std::ranges::replace(word, ' ', '_');
        found.push_back({fmt::format("{}_{}_{}_least_cost", word, motion, tiles),
                         leastCostAtEqualError(table, engine, motion, tiles),
                         "smallest of all its settings: CPU time over our cheapest with no larger "
                         "error in time"});
      }
    }
  }
  return found;
}

}  // namespace

Study movingStudy(const SheetMethods& methods) {
  return {
      "moving",
      "CPU time against error in time while all of a sheet moves, 100 and 400 squares",
      {{"engine", "solver of the joints"},
       {"motion", "plane or space"},
       {"tiles", "squares of the sheet"},
       {"rate", "steps a simulated second"},
       {"substeps", "in each step"},
       {"iterations", "in each substep"},
       {"tolerance", "tolerance of the direct solver's steps in time, tiles; 0 for fixed steps"},
       {"cpu_ms_per_s", "CPU time per simulated second, milliseconds"},
       {"gap_m", "largest joint gap of all steps, metres; none if the sheet flew apart"},
       {"error_m", "largest distance of a vertex from its exact position at that time, metres"}},
      sheetCases(methods, movingCase),
      movingFindings};
}

Study movingStudy() {
  return movingStudy(movingSheets);
}

}  // namespace kirireel::study
