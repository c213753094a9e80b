// The hard cases: singular starts, redundant and inconsistent joints, extreme masses, thicknesses,
// stiffnesses and steps, friction with a known solution, contacts in narrow gaps, a large sheet;
// and inputs that must be rejected.

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/deploy/deployment.h"
#include "sim/generate/families.h"
#include "sim/generate/lattice.h"
#include "sim/study/exact_sheet.h"
#include "sim/study/stepped_scene.h"
#include "sim/study/study.h"

namespace kirireel::study {
namespace {

/// A sheet, compared with the exact one at the same angle.
HardTrial sheetTrial(std::string name, std::string tried, int side, bool planar) {
  HardTrial trial{std::move(name), std::move(tried), sheetScene(side, planar)};
  trial.errorMeaning = "from the exact sheet at that angle";
  trial.error = [side](const SteppedScene& run, double) {
    return sheetError(side, openingAngle(run.motion().poses), run.tiles()).largest;
  };
  return trial;
}

/// A family's model with contacts, compared with its target.
HardTrial contactTrial(std::string name, std::string tried, const std::string& family,
                       double thickness) {
  HardTrial trial{std::move(name), std::move(tried), familyScene(family)};
  trial.scene.brick.thickness = thickness;
  trial.scene.environment.contacts = scene::ContactFilter::All;
  trial.errorMeaning = "from the target at the end";
  trial.error = [target = *trial.scene.model.target](const SteppedScene& run, double) {
    return trajectory::targetError(target, run.bricks(), run.motion().poses);
  };
  return trial;
}

/// Identical numbers in all standard libraries, [-1, 1).
class Noise {
 public:
  // An integer in [0, 2^32), shifted by its middle, over 2^31.
  double next() { return generator_() / 2147483648.0 - 1; }
  // A random vector in the plane, each component up to `size` metres.
  Vector3 inPlane(double size) {
    const double x = next();
    return size * Vector3(x, next(), 0);
  }

 private:
  std::mt19937 generator_{1};
};

// The rows of each hinge three times: the rank does not change.
HardTrial redundantHinges() {
  HardTrial trial = sheetTrial("redundant hinges", "every hinge three times; 20 x 20", 20, false);
  const std::vector<model::Joint> once = trial.scene.model.joints;
  for (int copy = 0; copy < 2; ++copy) {
    trial.scene.model.joints.insert(trial.scene.model.joints.end(), once.begin(), once.end());
  }
  return trial;
}

/// Tiles that are moved apart a little: joints are open at the start.
HardTrial inconsistentData() {
  HardTrial trial = sheetTrial("inconsistent data",
                               "tiles 1e-3 out of place; joints open at the start", 6, false);
  Noise noise;
  for (model::Tile& tile : trial.scene.model.tiles) {
    const Vector3 move = noise.inPlane(1e-3);
    for (Vector3& vertex : tile.vertices) vertex += move;
  }
  return trial;
}

/// Shapes that fit each other in no state: the joints must not open by more than the noise.
HardTrial noisyShapes(double size) {
  HardTrial trial{fmt::format("noise {:g}", size),
                  fmt::format("every vertex {:g} off; shapes that fit no more", size),
                  sheetScene(6, true)};
  Noise noise;
  for (model::Tile& tile : trial.scene.model.tiles) {
    for (Vector3& vertex : tile.vertices) vertex += noise.inPlane(size);
  }
  trial.errorMeaning = "joint gap";
  trial.error = [](const SteppedScene& run, double) { return run.gap(); };
  return trial;
}

// Masses of neighbours differ by a million: every joint has one light and one heavy brick.
HardTrial massRatio() {
  HardTrial trial =
      sheetTrial("mass ratio 1e6", "every other tile a million times as heavy", 6, false);
  trial.bricks = brick::makeBricks(trial.scene.model.tiles, trial.scene.brick);
  for (std::size_t i = 0; i < trial.bricks.size(); i += 2) {
    trial.bricks[i].mass *= 1e6;
    trial.bricks[i].inertia *= 1e6;
  }
  return trial;
}

// The pivots of a joint's two faces are a thickness apart. In thin bricks their rows are nearly
// dependent. In thick bricks they are far from the centres of mass.
HardTrial thickness(double metres) {
  HardTrial trial = sheetTrial(fmt::format("thickness {:g}", metres),
                               fmt::format("bricks {:g} thick; tiles 1 wide", metres), 6, false);
  trial.scene.brick.thickness = metres;
  return trial;
}

// An explicit step of 1/240 s would diverge at a far smaller stiffness.
HardTrial stiffness() {
  HardTrial trial = sheetTrial("stiffness 1e5", "k_f and k_tau 1e5; hardly any damping", 6, false);
  trial.scene.springs.springStiffness = trial.scene.springs.torqueStiffness = 1e5;
  trial.scene.springs.forceDamping = trial.scene.springs.torqueDamping = 0.1;
  return trial;
}

// An implicit step has no stability limit. It must hold the joints at any length.
HardTrial longStep(int rate) {
  HardTrial trial =
      sheetTrial(fmt::format("step 1/{} s", rate), fmt::format("a step of 1/{} s", rate), 6, false);
  trial.rate = rate;
  trial.seconds = 2;
  return trial;
}

// A tenth of a second: this case tests only the size.
HardTrial hugeSheet() {
  HardTrial trial = sheetTrial("10000 tiles", "a sheet of 100 x 100", 100, true);
  trial.seconds = 0.1;
  return trial;
}

/// A brick slides down a slope with the acceleration that friction leaves.
HardTrial sliding() {
  // Accelerations, m/s^2: standard gravity down, and a pull along the ground above friction's limit
  // 0.3 x 9.81. The brick slides from the start.
  constexpr double kDown = 9.81;
  constexpr double kAlong = 5;
  constexpr double kFriction = 0.3;
  HardTrial trial{"sliding", "a brick slides down a slope with friction 0.3", sheetScene(1, false)};
  trial.scene.model.target.reset();
  scene::Environment& environment = trial.scene.environment;
  // Tilted gravity instead of a tilted ground. With the acceleration a = kAlong - kFriction kDown
  // the brick has moved by a t^2 / 2.
  environment.gravity = {kAlong, 0, -kDown};
  environment.ground = scene::Ground{0, kFriction};
  environment.linearDamping = environment.angularDamping = 0;
  trial.errorMeaning = "from a t^2 / 2";
  trial.error = [start = trial.scene.model.tiles](const SteppedScene& run, double time) {
    const double distance = (run.tiles()[0].vertices[0] - start[0].vertices[0]).x();
    return std::abs(distance - 0.5 * (kAlong - kFriction * kDown) * time * time);
  };
  return trial;
}

}  // namespace

// Noise from below the rounding of a file to a thousandth of a tile; a thickness of a
// ten-thousandth and of two tiles. A quick study omits the largest sheet.
std::vector<HardTrial> hardTrials(bool quick) {
  std::vector<HardTrial> trials;
  trials.push_back(sheetTrial("compact start", "closed; singular; 10 x 10 in space", 10, false));
  trials.push_back(redundantHinges());
  trials.push_back(inconsistentData());
  for (const double size : {1e-9, 1e-6, 1e-3}) trials.push_back(noisyShapes(size));
  for (const double metres : {1e-4, 2.0}) trials.push_back(thickness(metres));
  trials.push_back(massRatio());
  trials.push_back(stiffness());
  for (const int rate : {60, 30, 15}) trials.push_back(longStep(rate));
  trials.push_back(sliding());
  trials.push_back(
      contactTrial("wedging", "bricks of a cap that collide on the path", "cap", 0.05));
  trials.push_back(
      contactTrial("moebius turn", "a thin band that twists past itself", "moebius", 0.005));
  if (!quick) trials.push_back(hugeSheet());
  return trials;
}

// Each must end in an InputError. The scene is valid except for one modification.
std::vector<Refusal> refusals() {
  const auto deployed = [](const std::function<void(scene::Scene&)>& spoil) {
    return [spoil] {
      scene::Scene scene = sheetScene(2, true);
      spoil(scene);
      deploy::deploy(scene, 0.1, {});
    };
  };
  return {
      {"no step", "a timestep of 0", deployed([](scene::Scene& s) { s.solver.timestep = 0; })},
      {"no number", "a duration that is not a number", deployed([](scene::Scene& s) {
         s.stop.duration = std::numeric_limits<double>::quiet_NaN();
       })},
      {"no velocity left", "damping of 1 a second",
       deployed([](scene::Scene& s) { s.environment.linearDamping = 1; })},
      {"no tiles", "a model without tiles", deployed([](scene::Scene& s) { s.model = {}; })},
      {"pins in Bullet", "a link in Bullet", deployed([](scene::Scene& s) {
         s.solver.kind = scene::SolverKind::Bullet;
         s.model.joints.push_back(model::makeLink(s.model.tiles, {0, 0}, {3, 2}));
       })},
      {"a million tiles", "a sheet of 1000 x 1000",
       [] {
         generate::TessellationShape shape;
         shape.columns = shape.rows = 1000;
         generate::makeTessellation(shape);
       }},
      {"no such parameter", "a fan with a radius; it has two",
       [] {
         generate::generateModel(generate::familyNamed("fan"), {{"radius", 3}});
       }},
  };
}

// ------------------------------------------------------------------------------------------------
// Hard cases, each run with our solver and with Bullet as in PyKirigami, with the same limits. A
// run passes if it stays finite, its joints do not open by more than a thousandth of a tile, its
// energy does not grow, and bricks do not overlap by more than a fiftieth of a tile. Invalid inputs
// must be rejected with a message. A case that exceeds its budget of CPU time is stopped and
// evaluated at that point.

namespace {

// Limits of a run that passes. Lengths in tiles.
constexpr double kGapAllowed = 1e-3;
constexpr double kGrowthAllowed = 1e-3;  // of the energy in a step, relative to the start
constexpr double kOverlapAllowed = 0.02;

/// The deepest overlap outside shared corners, in tiles. 0 without contacts.
double overlapNow(const SteppedScene& run, const scene::Scene& scene) {
  if (scene.environment.contacts == scene::ContactFilter::None) return 0;
  return trajectory::deepestPenetrationOutsidePivots(
             run.bricks(), run.pivots(), scene.environment.pivotZone, run.motion().poses)
             .depth /
         model::tileSize(scene.model);
}

// A finite run with fewer steps than requested exceeded its CPU time.
std::string outcomeOf(const Stability& stability, int steps) {
  if (!stability.finite) return "diverged";
  return stability.steps < steps ? "cut off" : "done";
}

// One row: the result of a method on a hard case.
std::vector<Row> tryOut(const HardTrial& trial, Method method, double budget) {
  method.rate = trial.rate;
  scene::Scene scene = trial.scene;
  scene.solver.timestep = 1.0 / trial.rate;
  // Cases may have their own bricks (masses). Otherwise the scene makes them.
  SteppedScene run(
      scene,
      trial.bricks.empty() ? brick::makeBricks(scene.model.tiles, scene.brick) : trial.bricks,
      dynamicsMaker(method));
  const int steps = static_cast<int>(std::lround(trial.seconds * trial.rate));
  const Stability stability = watchStability(run, steps, budget);
  const double tile = model::tileSize(scene.model);
  // From fractions of the model's size to fractions of a tile.
  const double gap = stability.gap * run.size() / tile;
  const double overlap = overlapNow(run, scene);
  const double time = static_cast<double>(stability.steps) / trial.rate;
  const double error = stability.finite ? trial.error(run, time) : std::nan("");
  const bool held = stability.finite && gap <= kGapAllowed && stability.growth <= kGrowthAllowed &&
                    overlap <= kOverlapAllowed;
  return {{trial.tried, method.engine.name, outcomeOf(stability, steps), cell(time), cell(error),
           trial.errorMeaning, cell(gap), cell(std::max(0.0, stability.growth)), cell(overlap),
           cell(stability.unconverged), cell(1e3 * run.seconds() / time), cell(held)}};
}

// One row: whether an input was rejected, and with which message.
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

// Each trial once with each solver, then each input that must be rejected.
std::vector<StudyCase> hardCasesCases(Extent extent) {
  const bool quick = extent == Extent::Quick;
  const double budget = quick ? 3 : 30;
  std::vector<StudyCase> made;
  for (const HardTrial& trial : hardTrials(quick)) {
    for (const Method& method : {Method{kDirect}, bulletBaseline()}) {
      made.push_back({fmt::format("{} {}", trial.name, method.engine.name),
                      [=] { return tryOut(trial, method, budget); }});
    }
  }
  for (const Refusal& refusal : refusals()) {
    made.push_back({refusal.name, [refusal] { return expectRefusal(refusal); }});
  }
  return made;
}

/// The number of an engine's rows with this value in a column.
double count(const Table& table, const std::string& engine, const std::string& column,
             const std::string& text) {
  double found = 0;
  for (const Row& row : table.rows) {
    const bool matches = table.text(row, column).starts_with(text);
    if (table.text(row, "engine") == engine && matches) ++found;
  }
  return found;
}

// Only counts: the rows contain the cases.
std::vector<Finding> hardCasesFindings(const Table& table) {
  const std::string bullet = "sequential impulse";
  return {{"direct_diverged", count(table, "direct", "outcome", "diverged"),
           "runs of the direct solver"},
          {"direct_not_held", count(table, "direct", "held", "no"), "runs of the direct solver"},
          {"direct_held", count(table, "direct", "held", "yes"),
           "runs of the direct solver, refusals included"},
          {"bullet_diverged", count(table, bullet, "outcome", "diverged"), "runs of Bullet"},
          {"bullet_not_held", count(table, bullet, "held", "no"), "runs of Bullet"},
          {"bullet_held", count(table, bullet, "held", "yes"), "runs of Bullet"},
          {"not_refused", count(table, "direct", "outcome", "not refused"),
           "senseless inputs that were not refused"}};
}

}  // namespace

Study hardCasesStudy() {
  return {"hard-cases",
          "hard cases for joint solvers: the direct solver and Bullet",
          {{"tried", "what is hard"},
           {"engine", "solver of the joints"},
           {"outcome", "done; cut off by its time; diverged; refused with this message"},
           {"simulated_s", "seconds"},
           {"error_m", "at the end, metres"},
           {"error_of", "what the error measures"},
           {"gap_tiles", "largest joint gap, in tiles"},
           {"growth", "largest growth of the energy in a step, relative to that at the start"},
           {"overlap_tiles", "deepest overlap at the end outside shared corners, in tiles"},
           {"unconverged", "steps whose contacts or joints missed their tolerance"},
           {"cpu_ms_per_s", "CPU time per simulated second, milliseconds"},
           {"held", "finite; gap at most 1e-3; growth at most 1e-3; overlap at most 0.02"}},
          hardCasesCases,
          hardCasesFindings};
}

}  // namespace kirireel::study
