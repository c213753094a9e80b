#include <fmt/format.h>

#include "sim/base/interruption.h"
#include "sim/deploy/deployment.h"
#include "tests/bench/joint_tables.h"

namespace kirireel::bench {

void printGapTable(const std::vector<NamedScene>& models) {
  fmt::print("\nJoint gap over whole deployments, contacts on (gap/size: largest of any step)\n");
  fmt::print("{:<28}{:>6}{:>10}{:>12}{:>10}{:>10}{:>10}{:>10}{:>9}{:>9}{:>9}\n", "model", "tiles",
             "gap/size", "outcome", "error", "bound", "pen/tile", "ms/step", "steps", "halved",
             "unconv");
  for (const auto& [name, scene] : models) {
    const double start = threadCpuSeconds();
    const run::DeploymentResult result = deploy::deploy(
        scene, 1.0 / 60,
        [&](const trajectory::Sample&) { return threadCpuSeconds() - start < kRunBudget; });
    const run::Accuracy& accuracy = result.accuracy;
    const double steps = 240 * result.trajectory.samples.back().time;
    fmt::print("{:<28}{:>6}{:>10.1e}{:>12}{:>10.2e}{:>10.1e}{:>10.1e}{:>10.3f}{:>9}{:>9}{:>9}\n",
               name, scene.model.tiles.size(), accuracy.jointGapMax / model::modelSize(scene.model),
               run::toString(result.outcome), accuracy.targetErrorEnd, accuracy.rigidBound,
               accuracy.penetrationMax / model::tileSize(scene.model),
               1e3 * result.cost.cpuSeconds / steps, result.cost.took.steps,
               result.cost.took.halved, result.cost.took.unconverged);
    std::fflush(stdout);
  }
}

void printTessellationTable() {
  fmt::print("\nSheets from 0 to 90 degrees against the exact motion, every step of 1/240 s\n");
  fmt::print("{:<16}{:>6}{:>12}{:>12}{:>12}{:>12}{:>10}\n", "sheet", "k", "to 0.04 rad",
             "(samples)", "beyond", "gap", "angle");
  for (const bool planar : {true, false}) {
    for (const int side : {4, 10, 20, 40}) {
      // Weak springs are slow near the singular start, strong ones arrive.
      for (const double stiffness : {0.1, 100.0}) {
        scene::Scene scene = sheetScene(side, planar, scene::SolverKind::Direct);
        scene.springs.springStiffness = scene.springs.torqueStiffness = stiffness;
        const MotionError error = motionError(scene, side, side == 40 ? 1 : 3);
        fmt::print("{:<16}{:>6}{:>12.1e}{:>12}{:>12.1e}{:>12.1e}{:>10.4f}\n",
                   fmt::format("{0} x {0} {1}", side, planar ? "planar" : "space"), stiffness,
                   error.compact, error.compactSamples, error.open, error.gap, error.lastAngle);
        std::fflush(stdout);
      }
    }
  }
}

}  // namespace kirireel::bench
