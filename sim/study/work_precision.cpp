// CPU time against error for settings of engines, on a sheet of 100 squares that opens from the
// closed state.
//
// There are three errors: the largest joint gap of any step; the error of shape, against the exact
// sheet at the same angle (beyond 0.04 radians, because the closed state is singular); and the
// error in time, against the limit of short steps (exact_sheet.cpp). Findings compare an engine
// with the direct solver: the cost of its tightest setting, the smallest ratio of
// costs at no larger gap, the largest ratio of gaps at no larger cost.
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include <fmt/format.h>

#include "sim/study/exact_sheet.h"
#include "sim/study/stepped_scene.h"
#include "sim/study/study.h"

namespace kirireel::study {
namespace {

constexpr int kSide = 10;
constexpr int kSamplesASecond = 15;  // divides every rate
constexpr int kFineRate = 1920;      // of the coarsest of the three reference runs
constexpr double kStartAngle = 0.04;
// A longer run is stopped here. Its figures are those of the part done.
constexpr double kBudget = 20;  // CPU seconds
constexpr double kQuickBudget = 3;
// Shorter runs are repeated, because times scatter. The shortest time counts.
constexpr double kTimedFor = 0.3;  // CPU seconds
constexpr int kMaxRuns = 5;

struct Job {
  Method method;
  bool planar = true;
  model::JointFace face = model::JointFace::Both;
  double seconds = 2;
  double budget = kBudget;
};

/// Result of one run.
struct Measured {
  SheetPath path;
  double cpuSeconds = 0;
  double simulated = 0;   // seconds
  double gap = 0;         // largest
  double shapeError = 0;  // largest beyond kStartAngle
};

// One run with its gaps and errors. Only the cost of the steps counts.
Measured runOnce(const Job& job) {
  SteppedScene run(sheetScene(kSide, job.planar, job.face), job.method);
  Measured measured;
  const int steps = static_cast<int>(std::lround(job.seconds * job.method.rate));
  const int perSample = job.method.rate / kSamplesASecond;
  int step = 0;
  while (step < steps && run.seconds() < job.budget && run.isFinite()) {
    run.advance();
    ++step;
    measured.gap = std::max(measured.gap, run.gap());
    if (step % perSample != 0) continue;
    measured.path.push_back(run.tiles());
    const double angle = openingAngle(run.motion().poses);
    if (angle < kStartAngle) continue;
    const double error = sheetError(kSide, angle, measured.path.back()).largest;
    measured.shapeError = std::max(measured.shapeError, error);
  }
  // If the sheet flies apart, the errors are NaN.
  if (!run.isFinite()) measured.gap = measured.shapeError = std::nan("");
  measured.cpuSeconds = run.seconds();
  measured.simulated = static_cast<double>(step) / job.method.rate;
  return measured;
}

/// The sheet's states over time, as the limit of short fixed steps.
SheetPath referencePath(double seconds) {
  const auto pathAt = [&](int rate) {
    return runOnce({{kDirect, rate}, true, model::JointFace::Both, seconds}).path;
  };
  return limitOfSteps(pathAt(kFineRate), pathAt(2 * kFineRate), pathAt(4 * kFineRate));
}

/// Computed once for all methods.
const SheetPath& referenceFor(double seconds) {
  static std::map<double, SheetPath> made;
  const auto found = made.find(seconds);
  if (found != made.end()) return found->second;
  return made.emplace(seconds, referencePath(seconds)).first->second;
}

// One row of the table.
std::vector<Row> measure(const Job& job) {
  const Measured measured = minTimed([&] { return runOnce(job); }, kMaxRuns, kTimedFor);
  const double error =
      std::isnan(measured.gap) ? measured.gap : pathError(measured.path, referenceFor(job.seconds));
  const Method& method = job.method;
  return {{method.engine.name, job.planar ? "plane" : "space",
           cell(job.face == model::JointFace::Both ? 2 : 1), cell(method.rate),
           cell(method.substeps), cell(method.iterations), cell(method.jointCorrection),
           cell(method.tolerance), cell(measured.simulated),
           cell(1e3 * measured.cpuSeconds / measured.simulated), cell(measured.gap),
           cell(measured.shapeError), cell(error)}};
}

// Bullet's correction of 0.8 instead of the default closes gaps faster, which may add energy.
std::vector<Method> allMethods(Extent extent) {
  std::vector<Method> methods;
  const auto add = [&](const std::vector<Method>& more) {
    methods.insert(methods.end(), more.begin(), more.end());
  };
  for (const int rate : {15, 30, 60, 120, 240, 480, 960}) methods.push_back({kDirect, rate});
  for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
    methods.push_back({.engine = kDirect, .rate = 60, .tolerance = tolerance});
  }
  add(sweepMethods(kSequentialImpulse, extent));
  methods.push_back({kSequentialImpulse, 240, 20, 200, 0.8});
  if (extent == Extent::Full) methods.push_back({kSequentialImpulse, 240, 20, 1000, 0.8});
  add(sweepMethods(kNncg, extent));
  add(sweepMethods(kMultiBody, extent));
  // If pivoting fails, Bullet iterates instead.
  methods.push_back({kDantzig, 240, 1, 50});
  return methods;
}

// Every method in the plane and in space.
std::vector<SheetMethod> workPrecisionSheets(Extent extent) {
  std::vector<SheetMethod> sheets;
  for (const bool planar : {true, false}) {
    for (const Method& method : allMethods(extent)) sheets.push_back({method, planar});
  }
  return sheets;
}

// A quick study has shorter runs. In the plane, one point joint per hinge is sufficient for
// engines, and cheapest.
StudyCase workPrecisionCase(const SheetMethod& sheet, Extent extent) {
  const auto& [method, planar, side] = sheet;
  const bool quick = extent == Extent::Quick;
  const bool one = planar && method.engine != kDirect;
  const Job job{method, planar, one ? model::JointFace::Bottom : model::JointFace::Both,
                quick ? 1.0 : 2.0, quick ? kQuickBudget : kBudget};
  return {fmt::format("{} {} {}", toString(method), planar ? "plane" : "space",
                      one ? "points" : "hinges"),
          [job] { return measure(job); }};
}

/// One row as a point of cost and error.
struct CostPoint {
  std::string engine;
  double rate = 0;
  double cpu = 0;
  double gap = 0;
};

// The rows of one motion as points of cost and gap.
std::vector<CostPoint> pointsOf(const Table& table, const std::string& motion) {
  std::vector<CostPoint> points;
  for (const Row& row : table.rows) {
    if (table.text(row, "motion") != motion) continue;
    const CostPoint point{table.text(row, "engine"), table.number(row, "rate"),
                          table.number(row, "cpu_ms_per_s"), table.number(row, "gap_m")};
    // Runs that fly apart are not on a front.
    if (std::isfinite(point.cpu) && std::isfinite(point.gap)) points.push_back(point);
  }
  return points;
}

bool isOurs(const CostPoint& point) {
  return point.engine == kDirect.name;
}

using Belongs = std::function<bool(const CostPoint&)>;

/// CPU time of the setting with the smallest gap, over the direct solver's at the same step.
double tightestOverOurs(const std::vector<CostPoint>& points, const Belongs& belongs) {
  const CostPoint* tightest = nullptr;
  for (const CostPoint& point : points) {
    if (belongs(point) && (!tightest || point.gap < tightest->gap)) tightest = &point;
  }
  for (const CostPoint& point : points) {
    if (tightest && isOurs(point) && point.rate == tightest->rate) return tightest->cpu / point.cpu;
  }
  return std::nan("");
}

/// The smallest ratio, over all settings, of CPU time to our cheapest setting with no larger gap.
double leastOverOurs(const std::vector<CostPoint>& points, const Belongs& belongs) {
  double least = std::nan("");
  for (const CostPoint& point : points) {
    if (!belongs(point)) continue;
    double ours = std::nan("");
    for (const CostPoint& other : points) {
      if (isOurs(other) && other.gap <= point.gap) ours = std::fmin(ours, other.cpu);
    }
    least = std::fmin(least, point.cpu / ours);
  }
  return least;
}

/// The largest ratio of our gap to that of a setting with at least our cost.
double gapAtEqualCost(const std::vector<CostPoint>& points, const Belongs& belongs) {
  double largest = std::nan("");
  for (const CostPoint& point : points) {
    if (!belongs(point)) continue;
    double ours = std::nan("");
    for (const CostPoint& other : points) {
      if (isOurs(other) && other.cpu <= point.cpu) ours = std::fmin(ours, other.gap);
    }
    largest = std::fmax(largest, ours / point.gap);
  }
  return largest;
}

// Three figures for one engine: its cost to come near our gap, and our gap at its cost.
void addComparison(std::vector<Finding>& found, const std::vector<CostPoint>& points,
                   const std::string& motion, const std::string& engine, const Belongs& belongs) {
  const std::string title = fmt::format("{}_{}", engine, motion);
  found.push_back(
      {title + "_tightest_cost", tightestOverOurs(points, belongs),
       "CPU time of its setting with the smallest gap, over the direct solver at the same step"});
  found.push_back({title + "_least_cost", leastOverOurs(points, belongs),
                   "smallest of all its settings: CPU time over our cheapest with no larger gap"});
  found.push_back({title + "_gap_at_equal_cost", gapAtEqualCost(points, belongs),
                   "largest of all its settings: our gap over its gap for no more CPU time"});
}

std::vector<Finding> workPrecisionFindings(const Table& table) {
  std::vector<Finding> found;
  for (const std::string motion : {"plane", "space"}) {
    const std::vector<CostPoint> points = pointsOf(table, motion);
    const std::vector<std::string> others = otherEngines(table, motion);
    addComparison(found, points, motion, "bullet", [&others](const CostPoint& point) {
      return !isOurs(point) && std::ranges::find(others, point.engine) == others.end();
    });
    for (const std::string& engine : others) {
      addComparison(found, points, motion, engine,
                    [&engine](const CostPoint& point) { return point.engine == engine; });
    }
  }
  return found;
}

}  // namespace

Study workPrecisionStudy(const SheetMethods& methods) {
  return {
      "work-precision",
      "CPU time against joint gap and position, 100 squares from closed",
      {{"engine", "solver of the joints"},
       {"motion", "plane or space"},
       {"points", "point joints that the engine has for each hinge"},
       {"rate", "steps a simulated second"},
       {"substeps", "in each step"},
       {"iterations", "in each substep"},
       {"correction", "part of a gap that Bullet takes back in a substep"},
       {"tolerance", "tolerance of the direct solver's steps in time, tiles; 0 for fixed steps"},
       {"simulated_s", "simulated seconds; less than planned if the run was stopped early"},
       {"cpu_ms_per_s", "CPU time per simulated second, milliseconds"},
       {"gap_m", "largest joint gap of all steps, metres; none if the sheet flew apart"},
       {"shape_error_m",
        "largest distance of a vertex from the exact sheet at the same opening angle, metres"},
       {"way_error_m",
        "largest distance of a vertex from its exact position at that time, metres"}},
      sheetCases(methods, workPrecisionCase),
      workPrecisionFindings};
}

Study workPrecisionStudy() {
  return workPrecisionStudy(workPrecisionSheets);
}

}  // namespace kirireel::study
