#include <algorithm>

#include <fmt/format.h>

#include "tests/bench/joint_tables.h"

namespace kirireel::bench {
namespace {

constexpr double kStiffnesses[] = {1, 25, 100, 200, 2000};
constexpr double kDampings[] = {0.1, 2, 10, 50, 100};
constexpr double kStepRates[] = {960, 240, 60, 30};
constexpr double kThicknesses[] = {0.001, 0.02, 0.2, 2};
constexpr double kRunSeconds = 1;
constexpr double kMaxCpuSeconds = 3;  // the run ends if it jams

/// The worst of all combinations of one model at one step.
struct Worst {
  int runs = 0;
  int cut = 0;
  int diverged = 0;
  int grew = 0;
  double growth = -1;
  double gap = 0;
  int unconverged = 0;
  std::string where;  // combination with the largest growth of energy

  void add(const study::Stability& result, bool isCut, const std::string& combination) {
    ++runs;
    cut += isCut ? 1 : 0;
    diverged += result.finite ? 0 : 1;
    grew += result.growth > 1e-9 ? 1 : 0;
    gap = std::max(gap, result.gap);
    unconverged += result.unconverged;
    if (result.growth <= growth) return;
    growth = result.growth;
    where = combination;
  }
};

Worst worstAtStep(scene::Scene scene, double rate) {
  scene.solver.timestep = 1 / rate;
  Worst worst;
  for (const double stiffness : kStiffnesses) {
    for (const double damping : kDampings) {
      for (const double thickness : kThicknesses) {
        scene.springs.springStiffness = stiffness;
        scene.springs.forceDamping = damping;
        scene.brick.thickness = thickness;
        const int steps = static_cast<int>(std::lround(kRunSeconds * rate));
        study::SteppedScene run(scene);
        const study::Stability result = study::watchStability(run, steps, kMaxCpuSeconds);
        worst.add(result, result.finite && result.steps < steps,
                  fmt::format("k_f {}, mu_v {}, thickness {}", stiffness, damping, thickness));
      }
    }
  }
  return worst;
}

}  // namespace

void printStabilityTable(const std::vector<NamedScene>& models, bool contacts) {
  fmt::print("\nStability, {} s each, contacts {}: 100 runs a line (k_f x mu_v x thickness)\n",
             kRunSeconds, contacts ? "on" : "off");
  fmt::print("{:<24}{:>8}{:>5}{:>10}{:>7}{:>11}{:>10}{:>8}  {}\n", "model", "step", "cut",
             "diverged", "grew", "growth", "gap/size", "unconv", "largest growth at");
  for (NamedScene named : models) {
    named.scene.environment.contacts =
        contacts ? scene::ContactFilter::All : scene::ContactFilter::None;
    for (const double rate : kStepRates) {
      const Worst worst = worstAtStep(named.scene, rate);
      fmt::print("{:<24}{:>8}{:>5}{:>10}{:>7}{:>11.1e}{:>10.1e}{:>8}  {}\n", named.name,
                 fmt::format("1/{}", rate), worst.cut, worst.diverged, worst.grew, worst.growth,
                 worst.gap, worst.unconverged, worst.where);
      std::fflush(stdout);
    }
  }
}

}  // namespace kirireel::bench
