// Hard cases, each run with our solver and with Bullet as PyKirigami sets it, and judged by the
// same limits: a run holds where it stays finite, its joints do not open by more than a thousandth
// of a tile, its energy does not grow, and bricks do not overlap by more than a fiftieth of a tile.
// Inputs that make no sense have to be refused with a message. A case that takes longer than its
// budget of CPU time is cut off and judged by what it did.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/study/hard_trials.h"
#include "sim/study/study.h"

namespace kirireel {
namespace {

// What a run may do and still count as held. Lengths in tiles.
constexpr double kGapAllowed = 1e-3;
constexpr double kGrowthAllowed = 1e-3;  // of the energy in a step, relative to the start
constexpr double kOverlapAllowed = 0.02;

/// The deepest overlap outside shared corners, in tiles; 0 where bricks may pass through each
/// other.
double overlapNow(const SteppedScene& run, const Scene& scene) {
  if (scene.environment.contacts == ContactFilter::None) return 0;
  return deepestPenetrationOutsidePivots(run.bricks(), run.pivots(), scene.environment.pivotZone,
                                         run.motion().poses)
             .depth /
         tileSize(scene.model);
}

// A run that took fewer steps than asked for, though all was finite, ran out of its CPU time.
std::string outcomeOf(const Stability& stability, int steps) {
  if (!stability.finite) return "diverged";
  return stability.steps < steps ? "cut off" : "done";
}

// One row: what a method did with a hard case.
std::vector<Row> tryOut(const HardTrial& trial, Method method, double budget) {
  method.rate = trial.rate;
  Scene scene = trial.scene;
  scene.solver.timestep = 1.0 / trial.rate;
  // Cases with bricks of their own (masses) bring them; others get those of the scene.
  SteppedScene run(scene,
                   trial.bricks.empty() ? makeBricks(scene.model.tiles, scene.brick) : trial.bricks,
                   dynamicsMaker(method));
  const int steps = static_cast<int>(std::lround(trial.seconds * trial.rate));
  const Stability stability = watchStability(run, steps, budget);
  const double tile = tileSize(scene.model);
  // From parts of the model's size to parts of a tile.
  const double gap = stability.gap * run.size() / tile;
  const double overlap = overlapNow(run, scene);
  const double time = static_cast<double>(stability.steps) / trial.rate;
  const double error = stability.finite ? trial.error(run, time) : std::nan("");
  const bool held = stability.finite && gap <= kGapAllowed && stability.growth <= kGrowthAllowed &&
                    overlap <= kOverlapAllowed;
  return {{trial.tried, toString(method.engine), outcomeOf(stability, steps), cell(time),
           cell(error), trial.errorMeaning, cell(gap), cell(std::max(0.0, stability.growth)),
           cell(overlap), cell(stability.unconverged), cell(1e3 * run.seconds() / time),
           cell(held)}};
}

// One row: whether an input was refused, and with which message.
std::vector<Row> expectRefusal(const Refusal& refusal) {
  std::string outcome = "not refused";
  bool held = false;
  try {
    refusal.run();
  } catch (const InputError& error) {
    outcome = fmt::format("refused: {}", error.what());
    held = true;
  }
  return {{refusal.tried, "direct", cell(outcome), "", "", "", "", "", "", "", "", cell(held)}};
}

// Each trial once with each solver, then each input that must be refused.
std::vector<StudyCase> hardCasesCases(Extent extent) {
  const bool quick = extent == Extent::Quick;
  const double budget = quick ? 3 : 30;
  std::vector<StudyCase> made;
  for (const HardTrial& trial : hardTrials(quick)) {
    for (const Method& method : {Method{Engine::Direct}, bulletBaseline()}) {
      made.push_back({fmt::format("{} {}", trial.name, toString(method.engine)),
                      [=] { return tryOut(trial, method, budget); }});
    }
  }
  for (const Refusal& refusal : refusals()) {
    made.push_back({refusal.name, [refusal] { return expectRefusal(refusal); }});
  }
  return made;
}

/// How many rows of an engine have this in a column.
double count(const Table& table, const std::string& engine, const std::string& column,
             const std::string& text) {
  double found = 0;
  for (const Row& row : table.rows) {
    const bool matches = table.text(row, column).starts_with(text);
    if (table.text(row, "engine") == engine && matches) ++found;
  }
  return found;
}

// Counts alone: the rows say which case it was.
std::vector<Finding> hardCasesFindings(const Table& table) {
  const std::string bullet = "sequential impulse";
  return {{"direct_diverged", count(table, "direct", "outcome", "diverged"), "runs of ours"},
          {"direct_not_held", count(table, "direct", "held", "no"), "runs of ours"},
          {"direct_held", count(table, "direct", "held", "yes"), "runs of ours, refusals included"},
          {"bullet_diverged", count(table, bullet, "outcome", "diverged"), "runs of Bullet"},
          {"bullet_not_held", count(table, bullet, "held", "no"), "runs of Bullet"},
          {"bullet_held", count(table, bullet, "held", "yes"), "runs of Bullet"},
          {"not_refused", count(table, "direct", "outcome", "not refused"),
           "senseless inputs that were not refused"}};
}

}  // namespace

Study hardCasesStudy() {
  return {"hard-cases",
          "what is hard on a joint solver: whether it held, ours beside Bullet",
          {{"tried", "what is hard"},
           {"engine", "what held the joints"},
           {"outcome", "done; cut off by its time; diverged; refused with this message"},
           {"simulated_s", "seconds"},
           {"error_m", "at the end, metres"},
           {"error_of", "what the error measures"},
           {"gap_tiles", "largest joint gap, in tiles"},
           {"growth", "largest growth of the energy in a step, relative to that at the start"},
           {"overlap_tiles", "deepest overlap at the end outside shared corners, in tiles"},
           {"unconverged", "steps whose contacts or joints missed their tolerance"},
           {"cpu_ms_per_s", "CPU milliseconds a simulated second"},
           {"held", "finite; gap at most 1e-3; growth at most 1e-3; overlap at most 0.02"}},
          hardCasesCases,
          hardCasesFindings};
}

}  // namespace kirireel
