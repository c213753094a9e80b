// Selects the path of a run with dynamics.
//
// The first rule of chooseDynamicPath() that applies decides. Most of them are cases in which a
// search is useless, or in which a force other than the pull drives the deployment. Otherwise a
// straight pull is tried, as a complete run with the steps of the deployment. What arrives here
// also arrives there. If it does not arrive, or bricks overlap, the planner searches a kinematic
// path (planner.cpp), and springs guide the tiles along its states. Joints that open on this path
// are compliant in the run, and close again at its end.
#include "sim/path/dynamic_path.h"

#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "sim/run/arrival.h"
#include "sim/run/dynamics.h"
#include "sim/run/run.h"
#include "sim/run/run_figures.h"
#include "sim/scene/scene_needs.h"

namespace kirireel::path {

namespace {

constexpr const char* kStraightPull = "straight pull";

// Duration of the test for jammed exact joints, seconds.
constexpr double kJamTime = 0.5;
// Joints are jammed if most steps, and at least this many, failed at the shortest length (two whole
// steps).
constexpr long kJammedSteps = 512;
// Time between two checks of overlaps, seconds.
constexpr double kCheckTime = 1.0 / 60;
// Duration of the guide in periods of the springs.
constexpr double kGuidedPeriods = 12;

// Whether so many steps fail to converge that exact joints are jammed.
bool isJammed(const run::DeployCost& cost) {
  return cost.took.unconverged > kJammedSteps && 2 * cost.took.unconverged > cost.took.steps;
}

/// A scene without ground, gravity and obstacles, in the axes of its sheet. Without gravity, a flat
/// sheet may be planar; see scene::ownAxes().
class BareScene {
 public:
  explicit BareScene(const scene::Scene& given) : scene(given) {
    scene.environment.ground.reset();
    scene.environment.gravity.setZero();
    scene.environment.obstacles.clear();
    frame_ = scene::ownAxes(scene);
    if (frame_) scene = scene::inAxes(*frame_, scene);
  }

  Poses inAxes(Poses poses) const {
    return frame_ ? model::toFrame(*frame_, std::move(poses)) : poses;
  }
  Poses inWorld(Poses poses) const {
    return frame_ ? model::toWorld(*frame_, std::move(poses)) : poses;
  }
  run::AssembledState inAxes(run::AssembledState state) const {
    state.poses = inAxes(std::move(state.poses));
    state.restPoses = inAxes(std::move(state.restPoses));
    return state;
  }

  scene::Scene scene;

 private:
  std::optional<model::SheetFrame> frame_;
};

/// A straight pull without contacts, as a complete run.
run::TrialEnd tryStraightPull(const BareScene& bare, const run::AssembledState& nearest,
                              const std::function<bool()>& shouldContinue) {
  scene::Scene trial = scene::withoutEnvironment(bare.scene);
  trial.path.kind = scene::PathKind::Straight;
  trial.stop = scene::StopRules{};  // the run's own time may be too short for any path
  run::OverlapWatch overlaps(bare.scene);
  const run::Run* running = nullptr;
  run::RunObservers watch;
  watch.sampleInterval = kCheckTime;
  watch.sample = [&](const trajectory::Sample& sample) {
    overlaps.observe(sample.poses);
    return true;
  };
  watch.step = [&](const trajectory::StepRecord&) {
    return shouldContinue() && !isJammed(running->cost());
  };
  run::Run run(trial, nearest, watch);
  running = &run;
  run.markAsTrial();
  const run::DeploymentResult result = run.finish();
  run::TrialEnd end;
  end.jams = isJammed(result.cost);
  end.arrives = result.outcome != run::Outcome::Diverged && !end.jams &&
                run::isNearest(trial.model, result.accuracy.targetErrorEnd, nearest.restError);
  end.isCollisionFree =
      overlaps.grown(result.accuracy) <= run::kAllowedOverlap * model::tileSize(trial.model);
  end.work = result.cost.took.work;
  return end;
}

/// Whether exact joints jam along the path. With redundant joints the smallest misfit of the tiles
/// prevents any motion, and most steps are halved without success.
bool exactJointsJam(const scene::Scene& scene, run::SearchBudget& budget,
                    const run::TrialObserver& observer) {
  scene::Scene trial = scene::withoutEnvironment(BareScene(scene).scene);
  trial.stop.duration = kJamTime;
  trial.path = {scene::PathKind::Straight};
  // The run's constructor already calls the observer, before `running` is set.
  const run::Run* running = nullptr;
  run::RunObservers watch;
  watch.step = [&](const trajectory::StepRecord&) {
    return observer({"exact joints", budget.share()}) && !(running && isJammed(running->cost()));
  };
  run::Run run(trial, {}, watch);
  running = &run;
  run.markAsTrial();
  const run::DeployCost cost = run.finish().cost;
  budget.spend(cost.took.work);
  return 2 * cost.took.halved > cost.took.steps;
}

/// The contacts of a run whose path is not searched: all if only a pull to the target moves the
/// tiles, and the scene leaves the choice open.
scene::ContactFilter contactsOf(const scene::Scene& scene) {
  const scene::ContactFilter requested = scene.environment.contacts;
  const bool isPulled = scene.model.target && scene.timeline.empty() && scene.springs.pull() &&
                        scene.actuation.drive == scene::Drive::Target &&
                        scene.solver.kind == scene::SolverKind::Direct;
  if (requested != scene::ContactFilter::Auto || isPulled) return contactsIfOn(requested);
  return scene::ContactFilter::None;
}

/// The straight pull, or the planner's path as guide.
DynamicPath searchPath(const scene::Scene& scene, const run::AssembledState& nearest,
                       run::SearchBudget& budget, const run::TrialObserver& observer,
                       std::optional<run::TrialEnd>& straightPull) {
  const BareScene bare(scene);
  const run::AssembledState goal = bare.inAxes(nearest);
  bool isOver = false;
  if (!straightPull) {
    const run::TrialEnd end = tryStraightPull(bare, goal, [&] {
      isOver = isOver || !observer({kStraightPull, budget.share()});
      return !isOver;
    });
    if (!isOver) straightPull = end;
  }
  DynamicPath found{scene.path, "the search was interrupted",
                    contactsIfOn(scene.environment.contacts)};
  found.path.kind = scene::PathKind::Straight;
  if (isOver) return found;
  const run::TrialEnd& straight = *straightPull;
  budget.spend(straight.work);
  const bool isContactOpen = scene.environment.contacts == scene::ContactFilter::Auto;
  const scene::ContactFilter without =
      isContactOpen ? scene::ContactFilter::None : scene.environment.contacts;
  const bool isLoaded = scene.environment.ground || !scene.environment.gravity.isZero(0);
  const bool isNear = goal.restError <= run::kFarError * model::tileSize(scene.model);
  const std::string arrives =
      fmt::format("{} {}{}", kStraightPull,
                  isNear ? "arrives" : "reaches the nearest known state with closed joints",
                  isLoaded ? " without gravity and ground" : "");
  if (straight.arrives && straight.isCollisionFree) {
    found.contacts = without;
    found.reason = arrives;
    return found;
  }
  found.guide = planPath(bare.scene, goal, budget, observer);
  run::GeometricPath& guide = *found.guide.path;
  const bool isFree = isCollisionFree(bare.scene, guide);
  if (!isFree && isContactOpen) {
    found.contacts = without;
    if (straight.arrives) {
      found.reason = arrives + " with overlaps: no path without overlaps was found";
      return found;
    }
  }
  for (Poses& state : guide.path.states) state = bare.inWorld(std::move(state));
  found.path.kind = scene::PathKind::Guided;
  found.path.guideTime = kGuidedPeriods / scene.springs.frequency;
  // Exact joints among bricks that overlap on the guide would jam.
  const bool mayJam = guide.hasCompliantJoints || straight.jams || !isFree;
  if (!scene.path.jointsAreCompliant() && mayJam) {
    found.path.jointRatio = run::kMisfitRatio;
  }
  found.reason = fmt::format("springs guide the tiles along a {}{}", guide.reason,
                             isFree ? "" : ", which does not arrive without overlaps");
  return found;
}

}  // namespace

DynamicPath chooseDynamicPath(const scene::Scene& scene, const run::AssembledState& nearest,
                              run::SearchBudget& budget, const run::TrialObserver& observer,
                              std::optional<run::TrialEnd>& straightPull) {
  const run::TrialObserver watch =
      observer ? observer : [](const run::SearchNews&) { return true; };
  scene::PathSettings straight = scene.path;
  straight.kind = scene::PathKind::Straight;
  const scene::ContactFilter contacts = contactsOf(scene);
  if (scene.path.kind != scene::PathKind::Dynamic) return {scene.path, "requested", contacts};
  if (scene.solver.kind == scene::SolverKind::Bullet)
    return {straight, "the baseline tries no other paths", contacts};
  const scene::Drive drive = scene.actuation.drive;
  const bool isDrivenOtherwise =
      scene.timeline.empty() && drive != scene::Drive::Target && drive != scene::Drive::None;
  if ((std::isfinite(run::roundedJointStiffness(scene.model)) || isDrivenOtherwise) &&
      exactJointsJam(scene, budget, watch)) {
    straight.jointRatio = run::kMisfitRatio;
    return {straight,
            fmt::format(
                "exact joints jam: the tiles do not fit each other in any open state. Joint ratio "
                "{:g}",
                run::kMisfitRatio),
            contacts};
  }
  if (!scene.timeline.empty()) return {straight, "the timeline drives the sheet", contacts};
  if (!scene.model.target) return {straight, "there is no target", contacts};
  if (scene.hinges.areOn()) return {straight, "hinges have springs", contacts};
  if (drive != scene::Drive::Target || !scene.springs.pull())
    return {straight, "nothing pulls to the target", contacts};
  return searchPath(scene, nearest, budget, watch, straightPull);
}

}  // namespace kirireel::path
