/// Scenes that studies step with each of the engines they compare.
#pragma once

#include <algorithm>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/engines/brick_world.h"
#include "sim/run/dynamics.h"
#include "sim/run/forces.h"
#include "sim/scene/scene.h"
#include "sim/study/study.h"
#include "sim/trajectory/measures.h"

namespace kirireel::study {

// ------------------------------------------------------------------------------------------------
// The solvers that studies compare.

struct Method;

/// Creates a physics engine's world of bricks, each at its start pose, with the method's settings.
using WorldMaker = std::unique_ptr<engines::BrickWorld> (*)(const Method& method,
                                                            const scene::Scene& scene,
                                                            const std::vector<brick::Brick>& bricks,
                                                            const Poses& start);

/// A solver of the joints.
struct Engine {
  const char* name = "";           ///< in tables, column "engine"
  WorldMaker makeWorld = nullptr;  ///< null for our direct solver

  bool operator==(const Engine&) const = default;
};

extern const Engine kDirect;             ///< our direct solver
extern const Engine kSequentialImpulse;  ///< Bullet's default solver
extern const Engine kNncg;               ///< Bullet's conjugate gradients
extern const Engine kDantzig;            ///< Bullet's pivoting
extern const Engine kMultiBody;          ///< Bullet's multibodies, as in PyBullet; no contacts

/// An engine with its settings.
struct Method {
  Engine engine = kDirect;       ///< the engine
  int rate = 240;                ///< steps per simulated second
  int substeps = 1;              ///< of the engine per step
  int iterations = 0;            ///< per substep, for iterative engines
  double jointCorrection = 0.2;  ///< Bullet's; see BulletSettings
  /// Tolerance in time of our solver, tiles; `rate` is then that of the longest step. 0: fixed
  /// steps.
  double tolerance = 0;
};

/// The baseline as PyKirigami runs it: sequential impulses, 20 substeps of 50 iterations.
Method bulletBaseline();

/// E.g. "sequential impulse 20 x 50" (substeps x iterations) or "direct 1/60 s".
std::string toString(const Method& method);

/// Creates the dynamics that advance a scene's bricks from their start.
using DynamicsMaker = std::function<std::unique_ptr<run::Dynamics>(
    const scene::Scene&, const std::vector<brick::Brick>& bricks, const Poses& start)>;

/// An engine at 240 steps per second with various substeps and iterations. The cost of a step is
/// proportional to their product.
std::vector<Method> sweepMethods(const Engine& engine, Extent extent);

/// The maker of a method's dynamics. It may be called often, also from several threads.
DynamicsMaker dynamicsMaker(const Method& method);

// ------------------------------------------------------------------------------------------------
// A scene stepped by a study: energy, gap and cost of every step can be read.

/// The scene's bricks under springs of constant stiffness, from an assembled start with a
/// perturbation.
class SteppedScene {
 public:
  /// Uses the solver that the scene requests. Throws the errors of makeDynamics() and makeBricks().
  explicit SteppedScene(const scene::Scene& scene);
  /// Uses another solver. Its rate sets the timestep, or the longest step if it has a tolerance.
  SteppedScene(const scene::Scene& scene, const Method& method);
  /// Uses another solver and given bricks.
  SteppedScene(const scene::Scene& scene, std::vector<brick::Brick> bricks,
               const DynamicsMaker& makeSolver);
  SteppedScene(const SteppedScene&) = delete;
  SteppedScene& operator=(const SteppedScene&) = delete;

  /// Takes one step of the scene's timestep; only its cost counts in seconds().
  void advance();

  /// One per tile.
  const std::vector<brick::Brick>& bricks() const { return bricks_; }
  /// The pivots of all joints.
  const std::vector<brick::Pivot>& pivots() const { return pivots_; }
  /// The current motion.
  const Motion& motion() const { return motion_; }
  /// Report of the direct solver's steps so far.
  const StepReport& report() const { return report_; }
  /// CPU seconds spent in advance().
  double seconds() const { return seconds_; }
  /// CPU seconds for creating the solver and closing the joints.
  double setupSeconds() const { return setupSeconds_; }
  /// The largest joint gap, metres.
  double gap() const { return trajectory::jointGap(pivots_, motion_.poses).max; }
  /// The diagonal of the start, metres.
  double size() const { return size_; }
  /// The bottoms of the bricks.
  std::vector<model::Tile> tiles() const { return brick::bottomTiles(bricks_, motion_.poses); }
  /// Whether every brick is within a thousand model sizes of the origin.
  bool isFinite() const;
  /// Energy of motion, springs and gravity, joules.
  double energy() const;

 private:
  scene::Scene scene_;
  std::vector<brick::Brick> bricks_;
  std::vector<brick::Pivot> pivots_;
  Motion motion_;
  std::optional<run::TargetSprings> springs_;
  std::unique_ptr<run::Dynamics> dynamics_;
  mechanics::LoadSource loads_;
  mechanics::TimedLoads timedLoads_;
  StepReport report_;
  double size_;
  double seconds_ = 0;
  double setupSeconds_ = 0;
};

/// Results of a run with hard settings.
struct Stability {
  bool finite = true;   ///< every brick stayed within a thousand model sizes
  double growth = -1;   ///< largest growth of energy in a step, relative to that at the start
  double gap = 0;       ///< largest, relative to the model's size
  int unconverged = 0;  ///< steps
  int steps = 0;        ///< taken
};

/// Steps the scene until `steps` are done, isFinite() is false or `cpuSeconds` are used. Returns
/// the figures.
Stability watchStability(SteppedScene& run, int steps,
                         double cpuSeconds = std::numeric_limits<double>::infinity());

// ------------------------------------------------------------------------------------------------
// Scenes of generated models.

/// The model of a family with default values, its start aligned to the target; no contacts.
scene::Scene familyScene(const std::string& family);

// ------------------------------------------------------------------------------------------------
// Studies of methods on square sheets. `kirireel study` passes the direct solver's and Bullet's
// methods, a benchmark program those of other engines.

/// A method on a square sheet.
struct SheetMethod {
  Method method;       ///< the method that steps the sheet
  bool planar = true;  ///< in the plane, otherwise in space
  int side = 0;        ///< tiles per edge, in studies of several sizes
};

/// The methods of an extent, in the order of the cases.
using SheetMethods = std::function<std::vector<SheetMethod>(Extent)>;

/// Error against CPU time. Sheets have one size.
Study workPrecisionStudy(const SheetMethods& methods);
/// Precision in time of a sheet in motion. Rates are multiples of 15 steps per second.
Study movingStudy(const SheetMethods& methods);
/// How CPU time grows with the number of tiles.
Study scalingStudy(const SheetMethods& methods);
/// Rotating squares against their exact motion. Sheets have one size.
Study tessellationStudy(const SheetMethods& methods);

/// The cases of a study of sheets: one for each method.
std::function<std::vector<StudyCase>(Extent)> sheetCases(const SheetMethods& methods,
                                                         StudyCase (*makeCase)(const SheetMethod&,
                                                                               Extent));

/// The engines in the table's rows of a motion other than the direct solver and Bullet, in the
/// order of their first rows.
std::vector<std::string> otherEngines(const Table& table, const std::string& motion);

// ------------------------------------------------------------------------------------------------
// CPU times with scatter.

/// The result of a run with the smallest CPU time of several: other programs on the machine
/// disturbed it least. Runs are equal except for time. They are repeated up to `most` times in
/// total, until they took `enough` seconds together. `run` returns a struct with the field
/// cpuSeconds.
template <class Run>
auto minTimed(const Run& run, int most, double enough) {
  auto result = run();
  double spent = result.cpuSeconds;
  for (int runs = 1; runs < most && spent < enough; ++runs) {
    const double again = run().cpuSeconds;
    result.cpuSeconds = std::min(result.cpuSeconds, again);
    spent += again;
  }
  return result;
}

// ------------------------------------------------------------------------------------------------
// Scenes that are hard on joint solvers.

/// One hard case: a scene, and how its result is evaluated.
struct HardTrial {
  std::string name;                  ///< of the case, in tables
  std::string tried;                 ///< one phrase: the difficulty
  scene::Scene scene;                ///< the scene to run
  std::vector<brick::Brick> bricks;  ///< empty: made by the scene's own brick rule
  int rate = 240;                    ///< steps per simulated second
  double seconds = 1;                ///< simulated
  std::string errorMeaning;          ///< definition of `error`
  std::function<double(const SteppedScene&, double time)> error;  ///< metres
};

/// All trials that are stepped; the largest sheets only in the full study.
std::vector<HardTrial> hardTrials(bool quick);

/// An input that must be rejected.
struct Refusal {
  std::string name;           ///< of the case
  std::string tried;          ///< one phrase
  std::function<void()> run;  ///< throws InputError
};

/// Inputs that no run can use.
std::vector<Refusal> refusals();

}  // namespace kirireel::study
