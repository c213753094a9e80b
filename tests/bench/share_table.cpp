#include <limits>

#include <fmt/format.h>

#include "sim/base/interruption.h"
#include "sim/mechanics/step_system.h"
#include "tests/bench/joint_tables.h"

namespace kirireel::bench {
namespace {

/// CPU microseconds of one call, of many.
template <typename Call>
double microseconds(const Call& call) {
  int count = 0;
  const double start = threadCpuSeconds();
  double used = 0;
  while (used < 0.1) {
    call();
    ++count;
    used = threadCpuSeconds() - start;
  }
  return 1e6 * used / count;
}

template <int D>
void printShares(int side) {
  const scene::Scene scene = sheetScene(side, D == 3, scene::SolverKind::Direct);
  const std::vector<brick::Brick> bricks = brick::makeBricks(scene.model.tiles, scene.brick);
  const Motion motion{brick::startPoses(scene.model.tiles, bricks),
                      std::vector<Velocity>(bricks.size())};
  const run::TargetSprings springs(bricks, *scene.model.target, {}, scene.springs);
  mechanics::StepSystem<D> system(bricks, brick::makePivots(scene.model.joints, bricks),
                                  model::tileSize(scene.model));
  std::vector<brick::Load> loads(bricks.size());
  const double load = microseconds([&] {
    for (std::size_t i = 0; i < bricks.size(); ++i) {
      loads[i] = springs.load(static_cast<int>(i), motion.poses[i], 1);
    }
  });
  const double set = microseconds([&] {
    system.setStep(motion, loads, scene.solver.timestep, std::numeric_limits<double>::infinity());
    system.placeJoints(motion.poses);
  });
  const double factor = microseconds([&] { system.factor({}); });
  Eigen::VectorXd right = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(D * bricks.size()));
  const double solve = microseconds([&] { system.solveInPlace(right.setOnes()); });
  const double gaps = microseconds([&] { system.jointGaps(motion.poses); });
  fmt::print("{:<16}{:>12.1f}{:>12.1f}{:>12.1f}{:>12.1f}{:>12.1f}\n",
             fmt::format("{0} x {0} {1}", side, D == 3 ? "planar" : "space"), load, set, factor,
             solve, gaps);
}

}  // namespace

void printShareTable() {
  fmt::print("\nOne step's parts, CPU microseconds a call (factor includes filling the matrix)\n");
  fmt::print("{:<16}{:>12}{:>12}{:>12}{:>12}{:>12}\n", "sheet", "springs", "assembly", "factor",
             "solve", "gaps");
  for (const int side : {10, 20, 40}) printShares<3>(side);
  for (const int side : {10, 20, 40}) printShares<6>(side);
}

}  // namespace kirireel::bench
