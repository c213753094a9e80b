// Implements deploy(), from a scene to its result.
//
// 1. Open choices (drive, thickness) are taken from the model. Planar sheets are rotated into the
//    horizontal plane. Invalid scenes are rejected.
// 2. A scene with grips is followed through its equilibria and ends here (loading.cpp).
// 3. The target is checked: whether rigid tiles reach it, the nearest states with closed joints,
//    and the bricks that would overlap there.
// 4. A kinematic scene takes a path of the mechanism (planner.cpp), which is played back.
// 5. Any other scene is run by its dynamics (dynamic_path.cpp).
//
// The search has one budget of counted work (search_budget.h): all machines select the same path.
// Checkpoints store the result of the trial of step 5, and the state of the run between its steps.
#include "sim/deploy/deployment.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/error.h"
#include "sim/base/interruption.h"
#include "sim/deploy/plane_motion.h"
#include "sim/path/closing.h"
#include "sim/path/dynamic_path.h"
#include "sim/path/planner.h"
#include "sim/path/target_warnings.h"
#include "sim/run/assembled_state.h"
#include "sim/run/dynamics.h"
#include "sim/run/geometric_path.h"
#include "sim/run/mechanism_path.h"
#include "sim/run/rest.h"
#include "sim/run/run.h"
#include "sim/run/run_drive.h"
#include "sim/run/run_figures.h"
#include "sim/scene/scene_needs.h"
#include "sim/scene/scene_parts.h"
#include "sim/scene/settings.h"
#include "sim/statics/loading.h"
#include "sim/trajectory/sheet.h"

namespace kirireel::deploy {
namespace {

// Names of the searches in progress reports.
constexpr const char* kAssembling = "the state nearest to the target";
constexpr const char* kClosing = "the path beyond full extension";

/// An entry after the end of the run is an error.
void requireInTime(const scene::Timeline& timeline, double duration) {
  for (const scene::TimelineEntry& entry : timeline) {
    if (entry.when.kind != scene::Trigger::Kind::AtTime || entry.when.value <= duration) continue;
    throw inputErrorAt(
        entry.where,
        fmt::format("this entry is at {:g} s, but the run lasts at most {:g} s. Raise `duration`",
                    entry.when.value, duration));
  }
}

/// With dynamics, tiles only bend between their parts: nothing stretches.
void requireBending(const scene::Scene& scene, const brick::PairForces& forces) {
  if (!scene.hinges.panels) return;
  if (scene::sceneNeeds(scene).planar.on) {
    throw InputError("error: bending tiles leave their plane. Remove `planar = on` or `panels`");
  }
  if (!forces.empty()) return;
  throw InputError(
      "error: `panels` bends only split tiles and folds in dynamic runs, but the scene has "
      "neither. Split "
      "tiles (`split_tiles = all`), or give folds a length scale (`panels = E,NU,LENGTH`). Tiles "
      "that also stretch need a [[grip]] in scene.toml");
}

/// Tiles that stay rigid although they have a material.
std::string rigidTilesWarning(const scene::Scene& scene) {
  if (!scene.hinges.panels) return "";
  const auto isWhole = [](const model::Tile& tile) { return tile.vertices.size() > 3; };
  const auto count = std::ranges::count_if(scene.model.tiles, isWhole);
  if (count == 0) return "";
  return fmt::format(
      "{} of {} tiles have more than three corners and stay rigid. `split_tiles` lets them bend",
      count, scene.model.tiles.size());
}

void requireSense(const scene::Scene& scene, double sampleInterval) {
  if (!(sampleInterval > 0) || !std::isfinite(sampleInterval)) {
    throw InputError(fmt::format("the time between samples is {} s, but must be finite and > 0",
                                 sampleInterval));
  }
  scene::requireRanges(scene);
  requireInTime(scene.timeline, scene.stop.duration);
  if (scene.model.tiles.empty())
    throw InputError("the model has no tiles; add one to vertices.txt");
  const std::vector<brick::Brick> bricks = brick::makeBricks(scene.model.tiles, scene.brick);
  // Invalid input must throw here, before a search that may take minutes.
  if (scene.grips.empty()) {
    requireBending(scene, scene::dynamicTies(scene, bricks).pairForces);
  } else {
    static_cast<void>(scene::hingeSprings(scene, bricks));
  }
  static_cast<void>(run::makeDriveForce(scene, bricks));
}

/// Results of the path search.
struct Search {
  run::AssembledState nearest;
  std::vector<run::BlockingPair> blocking;
  std::vector<std::string> warnings;
  path::PlannedPath planned;
  path::DynamicPath dynamic;  ///< if there is no planned path
  double misfit = 0;          ///< misfit of the tiles, metres; 0 if the path is exact
};

/// Throws if there is no target and the joints leave no motion that the given forces could drive.
void requireMotion(const scene::Scene& scene, const path::PlannedPath& planned) {
  const run::MechanismPath& path = planned.path->path;
  const double tile = model::tileSize(scene.model);
  if (path.isCutShort || path.endsAtOpenJoints) return;
  if (run::farthestMove(path.states.front(), path.states.back(), tile) > 0) return;
  const trajectory::Freedom freedom =
      scene::sceneNeeds(scene).planar.on ? trajectory::Freedom::Plane : trajectory::Freedom::Space;
  const trajectory::Mobility left =
      trajectory::mobility(scene.model, scene.model.tiles, freedom, scene.brick.thickness);
  if (!left.isCounted || left.freedoms > 0) return;
  requireDriveOutOfPlane(scene);
  throw InputError(
      "error: nothing can drive this model. It has no target, and its joints allow only rigid "
      "motions of the whole sheet. Set `target`, other joints (`joints_file`), or a load "
      "(`gravity`, [[timeline]] or [[velocity]] in scene.toml)");
}

/// The misfit of tiles whose corners nearly coincide but whose redundant joints do not hold
/// exactly, as in designs from an optimiser; metres. 0 if they do, or if it is unknown.
double mechanismMisfit(const scene::Scene& scene) {
  if (scene.model.rounding > 0) return 0;
  const trajectory::Mobility found = trajectory::mobility(
      scene.model, scene.model.tiles,
      scene::sceneNeeds(scene).planar.on ? trajectory::Freedom::Plane : trajectory::Freedom::Space,
      scene.brick.thickness);
  if (found.areBounds || found.largestDropped <= model::kClosedShare) return 0;
  return std::max(found.largestDropped * model::tileSize(scene.model),
                  model::largestJointGap(scene.model.joints, scene.model.tiles));
}

/// The path to full extension. Tiles with a misfit keep that tolerance, unless exact joints lead
/// farther.
void extend(const scene::Scene& scene, run::SearchBudget& budget, const run::TrialObserver& watch,
            Search& found) {
  found.planned = path::planExtension(scene, budget, watch);
  const double misfit = mechanismMisfit(scene);
  if (misfit == 0) return;
  scene::Scene loose = scene;
  loose.model.rounding = misfit;
  path::PlannedPath other = path::planExtension(loose, budget, watch);
  if (!path::isCollisionFree(loose, *other.path)) return;
  const bool isFree = path::isCollisionFree(scene, *found.planned.path);
  if (isFree && path::extendsFarther(*found.planned.path, *other.path)) return;
  found.planned = std::move(other);
  found.misfit = misfit;
}

/// Continues from full extension to the second compact state, if the scene requests it.
void closeAgain(const scene::Scene& scene, run::SearchBudget& budget,
                const run::TrialObserver& watch, Search& found) {
  if (scene.path.to != scene::Destination::Closed || found.planned.isCutShort) return;
  scene::Scene fitted = scene;
  if (found.misfit > 0) fitted.model.rounding = found.misfit;
  run::GeometricPath& path = *found.planned.path;
  path::continueUntilClosed(
      fitted, budget,
      [&](double share) {
        return watch({kClosing, share});
      },
      path);
  found.planned.isCutShort = path.path.isCutShort;
}

/// Checks the target, and searches a path of the mechanism if the scene is kinematic.
/// `mustBeClosed`: see path::planPath().
void search(const scene::Scene& scene, run::SearchBudget& budget, const run::TrialObserver& watch,
            Search& found, bool mustBeClosed = false) {
  watch({kAssembling, 0});
  found.warnings = path::targetWarnings(scene);
  if (std::string rigid = rigidTilesWarning(scene); !rigid.empty()) {
    found.warnings.push_back(std::move(rigid));
  }
  for (const std::string& warning : found.warnings) watch({kAssembling, 0, warning});
  found.nearest = run::assembleAtTarget(scene, [&] { return watch({kAssembling, 0}); });
  if (const std::string far = path::reachWarning(scene, found.nearest); !far.empty()) {
    found.warnings.push_back(far);
    watch({kAssembling, budget.share(), far});
  }
  scene::Scene touching = scene;
  touching.environment.contacts = path::contactsIfOn(scene.environment.contacts);
  found.blocking = run::blockingPairs(touching, found.nearest.restPoses);
  const scene::PathKind kind = scene.path.kind;
  const bool isClosing = scene.path.to == scene::Destination::Closed;
  if (kind != scene::PathKind::Auto && kind != scene::PathKind::Continuation) {
    if (!isClosing) return;
    throw InputError(
        "error: `to = closed` needs a kinematic path. Remove `path` or use `path = continuation`");
  }
  if (std::string reason; !scene::isQuasiStatic(scene, reason)) {
    if (isClosing) {
      throw InputError(fmt::format(
          "error: `to = closed` supports kinematic scenes only, but {}. Remove it", reason));
    }
    if (kind == scene::PathKind::Continuation) {
      throw InputError(
          fmt::format("error: `path = continuation` supports kinematic scenes only, but {}. Remove "
                      "it or use `path = dynamic`",
                      reason));
    }
    found.planned.trouble = reason;
  } else if (scene.model.target) {
    found.planned = path::planPath(scene, found.nearest, budget, watch, mustBeClosed);
  } else {
    extend(scene, budget, watch, found);
    requireMotion(scene, found.planned);
    closeAgain(scene, budget, watch, found);
  }
}

/// Warns if bricks overlapped in a run without contacts.
void addOverlapWarning(const scene::Scene& scene, run::DeploymentResult& result) {
  const double tile = model::tileSize(scene.model);
  const double grown = result.accuracy.penetrationGrownMax;
  if (result.needs.contacts.on || grown <= run::kAllowedOverlap * tile) return;
  result.warnings.push_back(fmt::format(
      "bricks overlapped by up to {} in a run without contacts. `contacts = all` prevents overlaps",
      model::lengthInTiles(grown, scene.model)));
}

/// Factor on the tolerance in the run that measures the error in time. Coarse steps end at samples,
/// so a tenth of the tolerance can give the same steps and no difference.
constexpr double kFinerShare = 0.01;
/// Factor on the timestep of this run if the first one missed its tolerance: steps of first order
/// have an error that depends on the timestep only.
constexpr double kFinerStep = 0.1;
/// Samples within this time are simultaneous, seconds.
constexpr double kSameSample = 1e-9;

/// The largest distance of a vertex (top or bottom) between two states, metres.
double farthestVertex(const std::vector<brick::Brick>& bricks, const Poses& a, const Poses& b) {
  double largest = 0;
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    for (const auto* face : {&bricks[i].bottom, &bricks[i].top}) {
      for (const Vector3& point : *face) {
        largest = std::max(largest, (a[i].apply(point) - b[i].apply(point)).norm());
      }
    }
  }
  return largest;
}

/// Runs the scene with dynamics along the chosen path.
run::DeploymentResult runDynamics(const scene::Scene& scene, const path::DynamicPath& choice,
                                  const run::AssembledState& nearest,
                                  const run::RunObservers& watch, run::Checkpoints* checkpoints) {
  scene::Scene chosen = scene;
  chosen.path = choice.path;
  const std::optional<run::GeometricPath>& guide = choice.guide.path;
  run::Run run(chosen, nearest, watch, checkpoints, guide ? &guide->path : nullptr);
  run::DeploymentResult result = run.finish();
  if (!run.seesAllPairs()) {
    result.warnings.push_back(fmt::format(
        "too many bricks are in one place. The overlap is the largest of the first {} pairs",
        trajectory::maxPairs(scene.model.tiles.size())));
  }
  const scene::TargetSpringSettings& springs = scene.springs;
  const bool isGuided = choice.path.kind == scene::PathKind::Guided;
  if (isGuided && (springs.dampingRatio < 1 || springs.forceDamping || springs.torqueDamping)) {
    result.warnings.push_back(
        "the springs that guide the tiles are critically damped: the given damping of springs does "
        "not apply to them. It applies with `path = straight`");
  }
  result.pathReason = choice.reason + (result.pathReason.empty() ? "" : "; " + result.pathReason);
  return result;
}

/// Runs the scene twice, the second time with finer steps. The error in time is the largest
/// distance of a vertex between both runs, over their common samples.
run::DeploymentResult runTwice(const scene::Scene& scene, const path::DynamicPath& choice,
                               const run::AssembledState& nearest, const run::RunObservers& watch,
                               run::Checkpoints* checkpoints) {
  std::vector<std::pair<double, Poses>> samples;
  run::RunObservers keeping = watch;
  keeping.sample = [&](const trajectory::Sample& sample) {
    samples.emplace_back(sample.time, sample.poses);
    return watch.sample(sample);
  };
  run::DeploymentResult result = runDynamics(scene, choice, nearest, keeping, checkpoints);
  scene::Scene chosen = scene;
  chosen.path = result.path;
  if (!run::keepsTolerance(chosen) || result.outcome == run::Outcome::Interrupted) return result;
  scene::Scene finer = scene;
  finer.solver.tolerance *= kFinerShare;
  const StepReport& took = result.cost.took;
  if (took.touchingTime + took.singularTime > 0) finer.solver.timestep *= kFinerStep;
  const std::vector<brick::Brick> bricks = brick::makeBricks(scene.model.tiles, scene.brick);
  double largest = 0;
  std::size_t next = 0;
  const auto compare = [&](const trajectory::Sample& sample) {
    while (next < samples.size() && samples[next].first < sample.time - kSameSample) ++next;
    if (next < samples.size() && samples[next].first <= sample.time + kSameSample) {
      largest = std::max(largest, farthestVertex(bricks, samples[next].second, sample.poses));
    }
    return next < samples.size();
  };
  const run::DeploymentResult again =
      runDynamics(finer, choice, nearest, {watch.sampleInterval, compare, {}}, nullptr);
  result.timeError = largest / model::tileSize(scene.model);
  result.cost.cpuSeconds += again.cost.cpuSeconds;
  return result;
}

/// Takes the planned path, or chooses a dynamic path and adapts the scene's contacts to it.
void selectPath(scene::Scene& scene, Search& found, run::SearchBudget& budget,
                const run::TrialObserver& watch, std::optional<run::TrialEnd>& straightPull) {
  if (found.planned.path) {
    std::string warning = path::overlapWarning(scene, found.planned);
    if (warning.empty()) return;
    watch({kAssembling, budget.share(), warning});
    found.warnings.push_back(std::move(warning));
    return;
  }
  if (scene.path.kind == scene::PathKind::Auto) scene.path.kind = scene::PathKind::Dynamic;
  found.dynamic = path::chooseDynamicPath(scene, found.nearest, budget, watch, straightPull);
  scene.environment.contacts = found.dynamic.contacts;
  if (!found.planned.trouble.empty())
    found.dynamic.reason += "; dynamics: " + found.planned.trouble;
}

/// Whether the budget was spent before the search found a path without faults.
bool isCutShort(const Search& found, const run::DeploymentResult& result, bool isOverlapping) {
  const bool isBest = found.planned.path && result.accuracy.jointOpeningMax == 0 &&
                      result.atTarget.value_or(true) && !isOverlapping;
  return (found.planned.isCutShort || found.dynamic.guide.isCutShort) && !isBest;
}

/// Records why a run does not count as successful, also in its reason. `grown`: the overlap that
/// counts, metres.
void addShortfall(const scene::Scene& scene, const Search& found, double grown,
                  run::DeploymentResult& result) {
  if (result.outcome == run::Outcome::Interrupted || result.outcome == run::Outcome::Diverged)
    return;
  std::vector<std::string> faults;
  const double tile = model::tileSize(scene.model);
  const bool isOverlapping = grown > run::kAllowedOverlap * tile;
  if (isOverlapping) {
    faults.push_back(
        fmt::format("bricks overlap by up to {}", model::lengthInTiles(grown, scene.model)));
  }
  const bool isExact = found.planned.path && !found.planned.path->hasCompliantJoints;
  if (isExact && result.accuracy.jointGapEnd > run::kAllowedOpening * tile) {
    faults.push_back(fmt::format(
        "joints are open by {} at the end, because the tiles do not fit each other. Correct their "
        "corners, or use `joint_ratio`",
        model::lengthInTiles(result.accuracy.jointGapEnd, scene.model)));
  }
  if (isCutShort(found, result, isOverlapping)) {
    faults.push_back("the search for a path spent its budget. Raise `search_effort`");
    result.warnings.push_back(faults.back());
  }
  const std::string further = fmt::format("{}", fmt::join(faults, "; "));
  if (!faults.empty()) result.reason += "; " + further;
  const bool isAtEnd = result.outcome != run::Outcome::Locked && result.atTarget != false;
  result.shortfall = isAtEnd ? further : result.reason;
  result.trajectory.events.back().text = run::endText(result.outcome, result.reason);
}

/// Whether a flat sheet should search a path through space. This applies to kinematic paths to a
/// target that open joints or overlap in the plane.
bool mayLeavePlane(const scene::Scene& given, const scene::Scene& scene, const Search& found) {
  std::string reason;
  const scene::PathKind kind = given.path.kind;
  const bool isGeometry = kind == scene::PathKind::Auto || kind == scene::PathKind::Continuation;
  if (given.solver.planar || !given.model.target || !isGeometry ||
      !scene::sceneNeeds(given).planar.on || !scene::isQuasiStatic(given, reason)) {
    return false;
  }
  if (!found.planned.path) return false;
  const run::GeometricPath& path = *found.planned.path;
  const bool isRounded =
      path.path.isRounded || std::isfinite(run::roundedJointStiffness(scene.model));
  const bool mayOpen = isRounded || given.path.jointsAreCompliant();
  return !path::isCollisionFree(scene, path) || (path.hasCompliantJoints && !mayOpen);
}

/// Replaces scene and path by those in space, if the path there keeps joints closed and has no
/// overlaps. The search has its own budget: otherwise a sheet that stays in its plane would be
/// affected.
void leavePlane(const scene::Scene& given, scene::Scene& scene, Search& found,
                const run::TrialObserver& watch) {
  scene::Scene inSpace = given;
  inSpace.spaceReason = "only a path in space keeps joints closed without overlaps";
  run::SearchBudget budget;
  Search other;
  search(inSpace, budget, watch, other, true);
  const std::optional<run::GeometricPath>& path = other.planned.path;
  if (!path || !path::isCollisionFree(inSpace, *path)) return;
  if (path->evaluation.opening > run::kAllowedOpening * model::tileSize(given.model)) return;
  scene = inSpace;
  found = std::move(other);
}

/// An interrupted search has no path: only the start is shown.
void abandonSearch(scene::Scene& scene, Search& found) {
  found.planned.path.reset();
  found.dynamic = {scene.path, "the search for a path was interrupted"};
  found.dynamic.path.kind = scene::PathKind::Straight;
  scene::ContactFilter& contacts = scene.environment.contacts;
  if (contacts == scene::ContactFilter::Auto) contacts = scene::ContactFilter::None;
}

/// Runs a scene whose plane, if it is planar, is already horizontal.
run::DeploymentResult deployAsItLies(const scene::Scene& given, double sampleInterval,
                                     const run::SampleObserver& observer,
                                     const run::TrialObserver& searching,
                                     run::Checkpoints* checkpoints) {
  scene::Scene scene = given;
  requireSense(scene, sampleInterval);
  if (scene.solver.kind == scene::SolverKind::Bullet) checkpoints = nullptr;
  if (!scene.grips.empty()) return statics::followGrips(scene, sampleInterval, observer);
  leaveLockedPlane(scene);
  double ownSeconds = 0;
  double& searchSeconds = checkpoints ? checkpoints->searchSeconds() : ownSeconds;
  const double startSeconds = threadCpuSeconds() - searchSeconds;
  run::SearchBudget budget;
  bool shouldContinue = true;
  std::optional<run::TrialEnd> ownTrial;
  std::optional<run::TrialEnd>& straightPull = checkpoints ? checkpoints->straightPull() : ownTrial;
  bool isSaved = straightPull.has_value();
  const run::TrialObserver watchSearch = [&](const run::SearchNews& news) {
    shouldContinue = shouldContinue && (!searching || searching(news));
    searchSeconds = threadCpuSeconds() - startSeconds;
    const bool isNew = checkpoints && straightPull && !isSaved;
    if (isNew && (!shouldContinue || checkpoints->isDue())) {
      checkpoints->save({});
      isSaved = true;
    }
    return shouldContinue;
  };
  Search found;
  try {
    const InterruptionCatcher catcher;
    search(scene, budget, watchSearch, found);
    if (found.misfit > 0) scene.model.rounding = found.misfit;
    const scene::Scene whole = scene;
    selectPath(scene, found, budget, watchSearch, straightPull);
    if (mayLeavePlane(whole, scene, found)) leavePlane(whole, scene, found, watchSearch);
  } catch (const Interrupted&) {
    shouldContinue = false;
    abandonSearch(scene, found);
  }
  searchSeconds = threadCpuSeconds() - startSeconds;
  // A search that ended early ends the run at its start, possibly on another path.
  if (!shouldContinue) checkpoints = nullptr;
  run::OverlapWatch overlaps(given);
  const run::SampleObserver takeSample = [&](const trajectory::Sample& sample) {
    overlaps.observe(sample.poses);
    return observer(sample) && shouldContinue;
  };
  run::DeploymentResult result =
      found.planned.path
          ? run::playBack(scene, *found.planned.path, found.nearest, sampleInterval, takeSample)
          : (scene.solver.measuresTimeError ? runTwice : runDynamics)(
                scene, found.dynamic, found.nearest, {sampleInterval, takeSample, {}}, checkpoints);
  const bool isContactOpen = given.environment.contacts == scene::ContactFilter::Auto;
  if (isContactOpen && !found.planned.path) addOverlapWarning(scene, result);
  result.blocking = std::move(found.blocking);
  path::PlannedPath& planned = found.planned.path ? found.planned : found.dynamic.guide;
  result.candidates = std::move(planned.candidates);
  found.warnings.insert(found.warnings.end(), result.warnings.begin(), result.warnings.end());
  result.warnings = std::move(found.warnings);
  addShortfall(scene, found, overlaps.grown(result.accuracy), result);
  result.cost.searchWork = budget.spent();
  result.cost.searchLimit = budget.all();
  result.cost.cpuSecondsSearch = searchSeconds;
  return result;
}

// A planar sheet in another plane is run in the axes of its frame. All directions of the result are
// rotated back here, and nowhere else.

trajectory::Sample inWorld(const model::SheetFrame& frame, trajectory::Sample sample) {
  sample.poses = model::toWorld(frame, std::move(sample.poses));
  if (!sample.mechanics) return sample;
  const Matrix3 turn = frame.axes();
  for (Vector3& force : sample.mechanics->jointForces) force = turn * force;
  for (trajectory::Hold& hold : sample.mechanics->holds) {
    hold.force = turn * hold.force;
    hold.moment = turn * hold.moment;
    hold.point = frame.toWorld(hold.point);
  }
  return sample;
}

void turnToWorld(const model::SheetFrame& frame, const scene::Scene& scene,
                 run::DeploymentResult& result) {
  for (trajectory::FigureState& state : result.trajectory.figureStates) {
    state.poses = model::toWorld(frame, std::move(state.poses));
  }
  if (result.loadCurve) {
    for (mechanics::Equilibrium& state : result.loadCurve->states) {
      state.poses = model::toWorld(frame, std::move(state.poses));
    }
  }
  scene::Scene modelled = scene;
  if (result.needs.planar.on) {
    result.needs.planar = scene::sceneNeeds(scene).planar;
  } else {
    modelled.spaceReason = result.needs.planar.reason;
  }
  static_cast<trajectory::Subject&>(result.trajectory) = trajectory::subjectOf(modelled);
}

}  // namespace

run::DeploymentResult deployUnkept(const scene::Scene& given, double sampleInterval,
                                   const run::SampleObserver& observer,
                                   const run::TrialObserver& searching,
                                   run::Checkpoints* checkpoints) {
  scene::Scene scene = given;
  scene::fillFromModel(scene);
  const std::optional<model::SheetFrame> frame = scene::ownAxes(scene);
  if (!frame) return deployAsItLies(scene, sampleInterval, observer, searching, checkpoints);
  const run::SampleObserver turned = [&](const trajectory::Sample& sample) {
    return observer(inWorld(*frame, sample));
  };
  run::DeploymentResult result =
      deployAsItLies(scene::inAxes(*frame, scene), sampleInterval, turned, searching, checkpoints);
  turnToWorld(*frame, scene, result);
  return result;
}

run::DeploymentResult deploy(const scene::Scene& scene, double sampleInterval,
                             const run::SampleObserver& observer,
                             const run::TrialObserver& searching) {
  std::vector<trajectory::Sample> samples;
  run::DeploymentResult result = deployUnkept(
      scene, sampleInterval,
      [&](const trajectory::Sample& sample) {
        samples.push_back(sample);
        return !observer || observer(sample);
      },
      searching);
  result.trajectory.samples = std::move(samples);
  return result;
}

}  // namespace kirireel::deploy
