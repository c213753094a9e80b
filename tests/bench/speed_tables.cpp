#include <cmath>

#include <fmt/format.h>

#include "tests/bench/joint_tables.h"

namespace kirireel::bench {
namespace {

/// Returns the direct solver's milliseconds per step.
double printSpeedRow(int side, bool planar) {
  const double direct =
      millisecondsPerStep(sheetScene(side, planar, scene::SolverKind::Direct), 240);
  const double bullet =
      millisecondsPerStep(sheetScene(side, planar, scene::SolverKind::Bullet), 240);
  fmt::print("{:<16}{:>12.4f}{:>12.3f}{:>10.1f}",
             fmt::format("{0} x {0} {1}", side, planar ? "planar" : "space"), direct, bullet,
             bullet / direct);
  if (planar) {
    // In the plane, one point joint per hinge is enough for Bullet, too.
    const scene::Scene points =
        sheetScene(side, planar, scene::SolverKind::Bullet, model::JointFace::Bottom);
    const double fewer = millisecondsPerStep(points, 240);
    fmt::print("{:>18.3f}{:>10.1f}", fewer, fewer / direct);
  }
  fmt::print("\n");
  std::fflush(stdout);
  return direct;
}

}  // namespace

void printSpeedTable() {
  fmt::print(
      "\nCPU ms a step of 1/240 s, sheets without contacts (Bullet: 20 x 50; hinges are two point"
      " joints to it)\n");
  fmt::print("{:<16}{:>12}{:>12}{:>10}{:>18}{:>10}\n", "sheet", "direct", "bullet", "ratio",
             "bullet, one point", "ratio");
  for (const bool planar : {true, false}) {
    double first = 0;
    double last = 0;
    for (const int side : {10, 20, 40}) {
      last = printSpeedRow(side, planar);
      if (side == 10) first = last;
    }
    fmt::print("growth exponent, 100 to 1,600 tiles: {:.2f}\n",
               std::log(last / first) / std::log(16));
  }
}

void printLargestStepTable() {
  constexpr int kSide = 10;
  fmt::print(
      "\nLonger steps at 100 tiles (3 s from compact; kept: 1e-8 beyond 0.04 rad, 1e-6 before)\n");
  fmt::print("{:<10}{:>8}{:>12}{:>12}{:>16}{:>10}{:>7}\n", "space", "step", "to 0.04 rad", "beyond",
             "CPU ms / s", "ratio", "kept");
  for (const bool planar : {true, false}) {
    const double bullet =
        240 * millisecondsPerStep(sheetScene(kSide, planar, scene::SolverKind::Bullet), 240);
    for (const int rate : {240, 120, 60, 30, 20, 15, 10, 5}) {
      scene::Scene scene = sheetScene(kSide, planar, scene::SolverKind::Direct);
      scene.solver.timestep = 1.0 / rate;
      const MotionError error = motionError(scene, kSide, 3);
      const double cost = rate * millisecondsPerStep(scene, 3 * rate);
      const bool kept = error.open < 1e-8 && error.compact < 1e-6;
      fmt::print("{:<10}{:>8}{:>12.1e}{:>12.1e}{:>16.3f}{:>10.1f}{:>7}\n",
                 planar ? "planar" : "space", fmt::format("1/{}", rate), error.compact, error.open,
                 cost, bullet / cost, kept ? "yes" : "no");
      std::fflush(stdout);
    }
  }
}

void printLargeSheetTable() {
  scene::Scene scene = sheetScene(100, true, scene::SolverKind::Direct);
  study::SteppedScene run(scene);
  double start = 0;
  for (int step = 0; step < 60; ++step) {
    if (step == 20) start = run.seconds();
    run.advance();
  }
  fmt::print(
      "\n10,000 tiles planar, ms a step: {:.1f} in the first 20 steps, {:.1f} in the next 40"
      " ({} halved)\n",
      1e3 * start / 20, 1e3 * (run.seconds() - start) / 40, run.report().halved);
}

}  // namespace kirireel::bench
