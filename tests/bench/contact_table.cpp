#include <fmt/format.h>

#include "tests/bench/joint_tables.h"

namespace kirireel::bench {
namespace {

/// Results of one solver on a model with contacts.
struct ContactRun {
  double milliseconds = 0;  // per step
  double penetration = 0;   // largest, in tile sizes
  double grown = 0;         // largest beyond the start's, without the corners that bricks share
  double gap = 0;           // largest, in model sizes
  double error = 0;         // at the end, metres
  double simulated = 0;     // seconds
  StepReport report;
};

ContactRun runContacts(scene::Scene scene, scene::SolverKind kind, double seconds) {
  scene.solver.kind = kind;
  study::SteppedScene run(scene);
  trajectory::PenetrationMeter growth(run.bricks(), run.pivots(), scene.environment.pivotZone,
                                      run.motion().poses, 0);
  ContactRun result;
  const int steps = static_cast<int>(std::lround(seconds / scene.solver.timestep));
  int done = 0;
  while (done < steps && run.seconds() < kRunBudget) {
    run.advance();
    ++done;
    result.gap = std::max(result.gap, run.gap());
    if (done % 4 != 0) continue;
    const double depth = trajectory::deepestPenetration(run.bricks(), run.motion().poses).depth;
    result.penetration = std::max(result.penetration, depth);
    result.grown = std::max(result.grown, growth.at(run.motion().poses).grown);
  }
  result.milliseconds = 1e3 * run.seconds() / done;
  result.simulated = done * scene.solver.timestep;
  result.penetration /= model::tileSize(scene.model);
  result.grown /= model::tileSize(scene.model);
  result.gap /= model::modelSize(scene.model);
  result.report = run.report();
  if (scene.model.target) {
    result.error = trajectory::targetError(*scene.model.target, run.bricks(), run.motion().poses);
  }
  return result;
}

}  // namespace

void printContactTable(const std::vector<NamedScene>& models) {
  fmt::print(
      "\nWith brick contact, up to 2 s at 1/240 s (Bullet: 20 x 50; pen: deepest overlap in tiles,"
      " pen*: beyond the start's, without the corners that joined bricks share; gap in model "
      "sizes)\n");
  fmt::print("{:<20}{:>6}{:>9}{:>9}{:>7}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}{:>8}{:>8}\n",
             "model", "to s", "ms", "bullet", "ratio", "pen", "bullet", "pen*", "bullet", "gap",
             "bullet", "error", "bullet", "halved", "unconv");
  for (const auto& [name, scene] : models) {
    const ContactRun direct = runContacts(scene, scene::SolverKind::Direct, 2);
    const ContactRun bullet = runContacts(scene, scene::SolverKind::Bullet, 2);
    fmt::print("{:<20}{:>6.2f}{:>9.3f}{:>9.2f}{:>7.1f}", name, direct.simulated,
               direct.milliseconds, bullet.milliseconds, bullet.milliseconds / direct.milliseconds);
    fmt::print("{:>9.1e}{:>9.1e}{:>9.1e}{:>9.1e}{:>9.1e}{:>9.1e}{:>9.2e}{:>9.2e}{:>8}{:>8}\n",
               direct.penetration, bullet.penetration, direct.grown, bullet.grown, direct.gap,
               bullet.gap, direct.error, bullet.error, direct.report.halved,
               direct.report.unconverged);
    std::fflush(stdout);
  }
}

}  // namespace kirireel::bench
