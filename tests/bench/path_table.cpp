#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "tests/bench/joint_tables.h"

namespace kirireel::bench {
namespace {

constexpr double kSeconds = 2;
constexpr int kSamplesASecond = 30;
constexpr int kFinestRate = 1920;

/// States of a run, and its cost.
struct Path {
  std::vector<std::vector<model::Tile>> tiles;  // one entry per sample
  double milliseconds = 0;                      // CPU, per simulated second
};

Path followPath(scene::Scene scene, int rate) {
  scene.solver.timestep = 1.0 / rate;
  study::SteppedScene run(scene);
  Path path;
  const int steps = static_cast<int>(kSeconds * rate);
  for (int step = 1; step <= steps; ++step) {
    run.advance();
    if (step % (rate / kSamplesASecond) != 0) continue;
    path.tiles.push_back(brick::bottomTiles(run.bricks(), run.motion().poses));
  }
  path.milliseconds = 1e3 * run.seconds() / kSeconds;
  return path;
}

double farthestApart(const std::vector<model::Tile>& a, const std::vector<model::Tile>& b) {
  double farthest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t k = 0; k < a[i].vertices.size(); ++k) {
      farthest = std::max(farthest, (a[i].vertices[k] - b[i].vertices[k]).norm());
    }
  }
  return farthest;
}

void printPathRows(const NamedScene& named) {
  const Path finest = followPath(named.scene, kFinestRate);
  const double tile = model::tileSize(named.scene.model);
  for (const int rate : {960, 480, 240, 120, 60, 30}) {
    const Path path = followPath(named.scene, rate);
    double largest = 0;
    for (std::size_t k = 0; k < path.tiles.size(); ++k) {
      largest = std::max(largest, farthestApart(path.tiles[k], finest.tiles[k]));
    }
    const double last = farthestApart(path.tiles.back(), finest.tiles.back());
    fmt::print("{:<24}{:>8}{:>14.1e}{:>12.1e}{:>16.2f}\n", named.name, fmt::format("1/{}", rate),
               largest / tile, last / tile, path.milliseconds);
    std::fflush(stdout);
  }
}

}  // namespace

void printPathTable(const std::vector<NamedScene>& models) {
  fmt::print(
      "\nThe path in time, {} s, against steps of 1/{} s (largest distance of any vertex, in "
      "tiles)\n",
      kSeconds, kFinestRate);
  fmt::print("{:<24}{:>8}{:>14}{:>12}{:>16}\n", "model", "step", "along it", "at the end",
             "CPU ms / s");
  printPathRows({"sheet 10 x 10", sheetScene(10, true, scene::SolverKind::Direct)});
  for (const NamedScene& model : models) {
    if (model.name == "square2disk" || model.name == "cylinder") printPathRows(model);
  }
}

}  // namespace kirireel::bench
