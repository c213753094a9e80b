// A square that becomes a disk, against its motion in closed form (exact_motion.h). The mechanism
// has one degree of freedom. A state of a run is compared with the exact state at the same angle
// between two tiles, moved onto it by the best fit.
#include <algorithm>
#include <cmath>

#include "sim/base/geometry.h"
#include "sim/study/exact_sheet.h"
#include "sim/study/stepped_scene.h"
#include "sim/study/study.h"
#include "sim/trajectory/exact_motion.h"

namespace kirireel::study {
namespace {

// A stiffer pull along straight lines locks this mechanism on its path.
constexpr double kDiskStiffness = 25;
constexpr double kRowEvery = 2 * kDegree;
// Near both closed states the sheet is singular: tiles may have other motions there.
constexpr double kSingular = 5;  // degrees

/// A state of the run, at an angle.
struct State {
  double time = 0;
  double angle = 0;  // of tile 1 relative to tile 0, radians, >= 0
  double gap = 0;
  std::vector<model::Tile> tiles;
};

// States of one run, at equal steps of the angle.
std::vector<State> deployed(const scene::Scene& scene, const Method& method, double seconds) {
  SteppedScene run(scene, method);
  std::vector<State> states;
  const int steps = static_cast<int>(seconds * method.rate);
  for (int step = 1; step <= steps; ++step) {
    run.advance();
    State state{step / double(method.rate), openingAngle(run.motion().poses), run.gap(),
                run.tiles()};
    // Rows at equal steps of the angle, not of time: the run is fast in the middle and slow at its
    // ends.
    const double next = states.empty() ? 0 : states.back().angle + kRowEvery;
    if (state.angle >= next || step == steps) states.push_back(std::move(state));
  }
  return states;
}

// Deploys with a method and compares each kept state with the exact path at its own angle.
std::vector<Row> deployAndCompare(const Method& method, double seconds) {
  scene::Scene scene = familyScene("square-to-disk");
  scene.springs.springStiffness = kDiskStiffness;
  const std::vector<State> states = deployed(scene, method, seconds);
  const trajectory::ExactMotion motion = trajectory::ExactMotion::find(scene.model).value();
  std::vector<Row> rows;
  for (const State& state : states) {
    const std::vector<model::Tile> exact = motion.nearest(state.angle, state.tiles);
    const double radius = trajectory::largestRadius(state.tiles);
    rows.push_back({method.engine.name, cell(state.time), cell(state.angle / kDegree), cell(radius),
                    cell(std::abs(radius - trajectory::largestRadius(exact))),
                    cell(trajectory::vertexDistance(state.tiles, exact).largest), cell(state.gap)});
  }
  return rows;
}

// One case per method. A quick study ends earlier on the path.
std::vector<StudyCase> squareToDiskCases(Extent extent) {
  const double seconds = extent == Extent::Quick ? 3 : 6;
  std::vector<StudyCase> made;
  for (const Method& method : {Method{kDirect}, bulletBaseline()}) {
    made.push_back({toString(method), [=] { return deployAndCompare(method, seconds); }});
  }
  return made;
}

/// The largest value of a column in an engine's rows, near the closed states or elsewhere.
double largest(const Table& table, const std::string& engine, const std::string& column,
               bool singular) {
  return table.largest(column, engine, [&](const Row& row) {
    const double angle = table.number(row, "angle_deg");
    return (angle < kSingular || angle > 180 - kSingular) == singular;
  });
}

// Errors near the closed states are listed separately.
std::vector<Finding> squareToDiskFindings(const Table& table) {
  const std::string bullet = "sequential impulse";
  return {{"direct_radius_error", largest(table, "direct", "radius_error_m", false),
           "largest error of our radius from 5 to 175 degrees, metres"},
          {"direct_radius_error_closed", largest(table, "direct", "radius_error_m", true),
           "the same nearer to the closed states, which are singular, metres"},
          {"direct_vertex_error", largest(table, "direct", "vertex_error_m", false),
           "largest vertex error of the direct solver from 5 to 175 degrees, metres"},
          {"bullet_radius_error", largest(table, bullet, "radius_error_m", false),
           "largest error of Bullet's radius from 5 to 175 degrees, metres"},
          {"bullet_vertex_error", largest(table, bullet, "vertex_error_m", false),
           "largest error of a vertex of Bullet's, metres"}};
}

}  // namespace

Study squareToDiskStudy() {
  return {"square2disk",
          "a square that becomes a disk, against its motion in closed form",
          {{"engine", "solver of the joints"},
           {"time_s", "simulated seconds"},
           {"angle_deg", "by which tile 1 has turned against tile 0, degrees"},
           {"radius_m", "largest distance of a vertex from the mean of all, metres"},
           {"radius_error_m", "from the exact motion at the same angle, metres"},
           {"vertex_error_m", "largest distance of a vertex from the exact motion, metres"},
           {"gap_m", "largest joint gap, metres"}},
          squareToDiskCases,
          squareToDiskFindings};
}

}  // namespace kirireel::study
