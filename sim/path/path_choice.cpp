// Selects a dynamic path to the target. Each trial is a complete run.
//
// The candidates, in order: a straight pull, guided tiles with exact joints, and guided tiles with
// compliant joints from stiff to soft. With contacts, the first guided candidates also push the
// bricks apart before the guide starts. Times are periods of the scene's springs. Joint stiffnesses
// are multiples of the stiffness that holds a tile at its place. Candidates are therefore the same
// for models of any size or mass. A trial ends when it reaches the target, stops improving, its
// exact joints jam, forbidden overlaps appear, or it has used a third of the remaining budget.
// Trials take the same steps as the run itself, so a path that arrives in a trial also arrives in
// the run.
//
// An ablation selected these candidates from twelve. Each was tried separately on the models of
// data/, on four models that PyKirigami's authors published and on 40 drawn from all families, of
// up to 64 tiles. Of 54 cases without contacts and 49 with contacts, whose target has room for the
// bricks,
//   a straight pull         brings 41 and 36 to their targets
//   guided                  10 and 8 more: irregular quads, square to disk, hexagons, triangles and
//                           islamic tiles with large rotations, a cylinder, saddles; a Moebius
//                           band, which arrives with contacts only if it is not pushed apart first
//   pushed apart, guided    2 more with contacts: caps, whose start is flush
//   compliant joints        3 and 2 more, which have no freedom: without contacts all at a ratio
//                           of 1e5, with contacts two at 1e4; one arrives at 1e3, but opens far
// At twice, half or a quarter of the speed, or guided with a quarter or a twentieth of the
// stiffness, no further case arrived. Joints of a ratio of 100 and 10 opened farther.
//
// Trials made before a checkpoint are read from the list of trial results.
#include "sim/path/path_choice.h"

#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/words.h"
#include "sim/brick/contact.h"
#include "sim/model/sheet_frame.h"
#include "sim/run/assembled_state.h"
#include "sim/run/dynamics.h"
#include "sim/run/forces.h"
#include "sim/run/run.h"
#include "sim/scene/scene_needs.h"
#include "sim/trajectory/measures.h"
#include "sim/trajectory/sheet.h"

namespace kirireel::path {
namespace {

// In the plane and without contacts, the first trial of the straight path takes longer steps: most
// models need no search. In space the step length often decides which local minimum a pull reaches,
// and with contacts whether bricks overlap.
constexpr double kCoarseSteps = 4;

// A trial stops if its target error has not decreased by this factor in this time.
constexpr double kImprovement = 0.995;
constexpr double kPatienceSeconds = 2;

// Maximum opening of compliant joints on a path, in tiles. Wider joints could let bricks slip past
// each other.
constexpr double kOpeningShare = 1e-2;
// A trial may use this fraction of the remaining budget. If bricks jam, steps are halved
// repeatedly.
constexpr double kTrialShare = 1.0 / 3;

// A later path replaces an earlier one only if its error is smaller by this factor.
constexpr double kNearer = 0.99;

// Duration of the test for jammed exact joints, seconds.
constexpr double kJamTime = 0.5;
// Joints are jammed if most steps, and at least this many, failed at the shortest length (two whole
// steps).
constexpr long kJammedSteps = 512;

// Duration of the guide, and of the push that separates flush bricks before it. Both in periods of
// the springs' frequency.
constexpr double kGuidedPeriods = 12;
constexpr double kOpenPeriods = 4;
// Ratios of compliant joints, from stiff to soft. The first that arrives opens least.
constexpr std::array kCompliantRatios = {1e5, 1e4, 1e3};

/// The candidate paths to the scene's target, in order of the trials.
std::vector<scene::PathSettings> candidatePaths(const scene::Scene& scene, bool areAmongBricks) {
  const double period = 1 / scene.springs.frequency;
  scene::PathSettings guided{scene::PathKind::Guided};
  guided.guideTime = kGuidedPeriods * period;
  std::vector<scene::PathSettings> paths = {{scene::PathKind::Straight}};
  if (areAmongBricks) {
    paths.push_back(guided);
    paths.back().openTime = kOpenPeriods * period;
  }
  paths.push_back(guided);
  for (const double ratio : kCompliantRatios) {
    paths.push_back(guided);
    paths.back().jointRatio = ratio;
  }
  return paths;
}

// The name of a path in reasons and in search reports.
std::string describe(const scene::PathSettings& path) {
  if (path.kind == scene::PathKind::Straight) return "straight pull";
  std::string text = fmt::format("guided for {:.3g} s", path.guideTime);
  if (path.openTime > 0) text = fmt::format("opened for {:.3g} s, {}", path.openTime, text);
  return path.jointsAreCompliant() ? fmt::format("{}, joint ratio {:g}", text, path.jointRatio)
                                   : text + ", exact joints";
}

/// Stops a trial that exceeds its share of the budget.
class WorkLimit {
 public:
  explicit WorkLimit(const run::SearchBudget& budget) : most_(kTrialShare * budget.left()) {}

  bool allows(const run::DeployCost& cost) {
    isReached_ = isReached_ || cost.took.work > most_;
    return !isReached_;
  }
  bool isReached() const { return isReached_; }

 private:
  double most_;
  bool isReached_ = false;
};

/// Stops a trial that no longer approaches the target.
class StallWatch {
 public:
  explicit StallWatch(const scene::Scene& scene)
      : patience_(kPatienceSeconds + (scene.path.kind == scene::PathKind::Guided
                                          ? scene.path.openTime + scene.path.guideTime
                                          : 0)) {}

  // Whether to continue. The time of opening and guiding adds to the patience, because the error
  // may grow during it.
  bool operator()(const trajectory::StepRecord& step) {
    if (best_ < 0 || step.targetError < kImprovement * best_) {
      best_ = step.targetError;
      bestTime_ = step.time;
    }
    return step.time - bestTime_ < patience_;
  }

 private:
  double patience_;  // seconds
  double best_ = -1;
  double bestTime_ = 0;
};

// Whether so many steps fail to converge that exact joints are jammed.
bool isJammed(const run::DeployCost& cost) {
  return cost.took.unconverged > kJammedSteps && 2 * cost.took.unconverged > cost.took.steps;
}

/// Whether exact joints jam along the path. With redundant joints the smallest misfit of the tiles
/// prevents any motion, and most steps are halved without success.
bool exactJointsJam(const scene::Scene& scene, run::SearchBudget& budget,
                    const run::TrialObserver& observer) {
  scene::Scene trial = scene::withoutEnvironment(scene);
  if (const auto frame = scene::ownAxes(trial)) trial = scene::inAxes(*frame, trial);
  trial.stop.duration = kJamTime;
  trial.path = {scene::PathKind::Straight};
  // The run's constructor already calls the observer, before `running` is set.
  const run::Run* running = nullptr;
  WorkLimit limit(budget);
  run::RunObservers watch;
  watch.step = [&](const trajectory::StepRecord&) {
    return observer({"exact joints", budget.share()}) &&
           (!running || (limit.allows(running->cost()) && !isJammed(running->cost())));
  };
  run::Run run(trial, {}, watch);
  running = &run;
  run.markAsTrial();
  const run::DeployCost cost = run.finish().cost;
  budget.spend(cost.took.work);
  return 2 * cost.took.halved > cost.took.steps;
}

/// Checks that bricks which may touch do not overlap in a trial, even in a trial without contacts.
/// A run's own figures cover all pairs. If joined bricks may overlap, each sample is checked pair
/// by pair instead.
class TrialOverlaps {
 public:
  /// `requested`: the requested contacts, i.e. which pairs must not overlap.
  TrialOverlaps(const scene::Scene& scene, scene::ContactFilter requested)
      : isOfUnjoined_(requested == scene::ContactFilter::Unjoined),
        most_(run::kAllowedOverlap * model::tileSize(scene.model)),
        zone_(scene.environment.pivotZone),
        bricks_(brick::makeBricks(scene.model.tiles, scene.brick)),
        pivots_(brick::makePivots(scene.model.joints, bricks_)) {}

  /// Subscribes to the trial's samples if they are needed.
  void watch(run::RunObservers& observers) {
    if (!isOfUnjoined_) return;
    observers.sampleInterval = kCheckTime;
    observers.sample = [this](const trajectory::Sample& sample) {
      check(sample.poses);
      return true;
    };
  }

  bool areAllowed(const run::Accuracy& accuracy) const {
    return isOfUnjoined_ ? isCollisionFree_ : accuracy.penetrationGrownMax <= most_;
  }

 private:
  // Interval between two checks, seconds.
  static constexpr double kCheckTime = 1.0 / 60;

  // The first state is the start. Its overlaps are subtracted from later ones.
  void check(const Poses& poses) {
    const bool isStart = !atStart_;
    if (isStart) atStart_.emplace();
    const auto joined = brick::sharedCorners(pivots_);
    for (const trajectory::Penetration& found : trajectory::penetrationsOutsidePivots(
             bricks_, pivots_, zone_, poses, isStart ? 0 : most_)) {
      const std::pair pair(found.brickA, found.brickB);
      if (joined.contains(pair)) continue;
      double& given = (*atStart_)[pair];
      if (isStart) given = found.depth;
      isCollisionFree_ = isCollisionFree_ && found.depth - given <= most_;
    }
  }

  bool isOfUnjoined_;
  double most_;  // allowed growth of an overlap, metres
  double zone_;
  std::vector<brick::Brick> bricks_;
  std::vector<brick::Pivot> pivots_;
  bool isCollisionFree_ = true;
  std::optional<std::map<std::pair<int, int>, double>> atStart_;  // overlap per pair, metres
};

/// Runs a scene with the steps of the deployment itself. What arrives here also arrives there.
/// Stops when `shouldContinue` returns false or the budget is spent. `requested`: the requested
/// contacts.
run::TrialEnd tryPath(const scene::Scene& scene, scene::ContactFilter requested,
                      const TargetFindings& atTarget, const run::SearchBudget& budget,
                      const std::function<bool(double work)>& shouldContinue) {
  // Without gravity, a flat sheet may be planar; see scene::ownAxes().
  if (const auto frame = scene::ownAxes(scene)) {
    TargetFindings findings = atTarget;
    for (Poses* poses : {&findings.nearest.poses, &findings.nearest.restPoses}) {
      for (Pose& pose : *poses) pose = frame->toFrame(pose);
    }
    return tryPath(scene::inAxes(*frame, scene), requested, findings, budget, shouldContinue);
  }
  const run::AssembledState& nearest = atTarget.nearest;
  StallWatch stalls(scene);
  const run::Run* running = nullptr;
  WorkLimit limit(budget);
  const bool isAmongBricks = scene.environment.contacts != scene::ContactFilter::None;
  TrialOverlaps overlaps(scene, requested);
  run::RunObservers watch;
  overlaps.watch(watch);
  watch.step = [&](const trajectory::StepRecord& step) {
    if (!shouldContinue(running->cost().took.work) || !stalls(step)) return false;
    if (!limit.allows(running->cost())) return false;
    return isAmongBricks ? overlaps.areAllowed(running->accuracy()) : !isJammed(running->cost());
  };
  run::Run run(scene, nearest, watch);
  running = &run;
  run.markAsTrial();
  const run::DeploymentResult result = run.finish();
  const run::Accuracy& accuracy = result.accuracy;
  run::TrialEnd end;
  end.jams = !isAmongBricks && isJammed(result.cost);
  end.error = accuracy.targetErrorEnd;
  end.opening = accuracy.jointOpeningMax;
  end.work = result.cost.took.work;
  // The springs pull a trial to their equilibrium. The nearest state is searched from there.
  end.arrives = result.outcome != run::Outcome::Diverged && !end.jams &&
                run::isNearest(scene.model, end.error, nearest.restError);
  end.cutShort = limit.isReached() && !end.arrives && !end.jams;
  // In a trial that was cut short, compliant joints might still open later.
  const bool isOpenEnded = scene.path.jointsAreCompliant() &&
                           result.outcome == run::Outcome::Interrupted && !end.arrives;
  end.isCollisionFree = overlaps.areAllowed(accuracy) && !run.isHeldOpen() && !isOpenEnded;
  return end;
}

/// If bricks overlap anyway, compliant joints bring no benefit. A straight pull then replaces the
/// path.
scene::PathSettings withExactJoints(const scene::PathSettings& path) {
  return path.jointsAreCompliant() ? scene::PathSettings{scene::PathKind::Straight} : path;
}

/// Searches a path for one scene.
class PathSearch {
 public:
  PathSearch(const scene::Scene& scene, TargetFindings atTarget, run::SearchBudget& budget,
             const run::TrialObserver& observer, std::vector<run::TrialEnd>& trials)
      : scene_(scene),
        atTarget_(std::move(atTarget)),
        budget_(budget),
        observer_(observer),
        trials_(trials) {}

  // Starts without contacts: these trials are cheap, and a path that arrives without overlaps is
  // already a solution.
  PathChoice find() {
    const bool fitsAtTarget = !atTarget_.isBlocked;
    PathChoice choice = findWithoutContacts();
    const bool contacts = scene_.environment.contacts != scene::ContactFilter::None;
    choice.isFound = last_.arrives && (!contacts || last_.isCollisionFree);
    choice.isCollisionFree = last_.arrives && last_.isCollisionFree;
    choice.isCutShort = !choice.isFound && isCutShort();
    const bool isWanting = contacts && !choice.isFound;
    if (isOver_ || !isWanting) return choice;
    if (!last_.arrives) {
      // Without contacts the straight pull continues to its end, nearer than jammed bricks.
      choice.through = choice.path;
      choice.throughReason = choice.reason;
      return choice;
    }
    PathChoice among = findAmongBricks(choice, fitsAtTarget);
    among.isCutShort = !among.isFound && isCutShort();
    among.through = choice.path;
    among.throughReason = choice.reason;
    return among;
  }

 private:
  struct Attempt {
    scene::PathSettings path;
    run::TrialEnd end;
  };

  /// Whether a path arrives. False if the search ends before this is known.
  bool arrives(const scene::PathSettings& path, const scene::Environment& environment,
               const std::string& what, double stepFactor = 1) {
    scene::Scene trial = scene_;
    trial.environment = environment;
    trial.stop = scene::StopRules{};  // the run's own time may be too short for any path
    trial.path = path;
    trial.solver.timestep = stepFactor * scene_.solver.timestep;
    // Trials from a checkpoint are not repeated: their results would be the same.
    if (count_ == trials_.size()) {
      const run::TrialEnd end = tryPath(trial, scene_.environment.contacts, atTarget_, budget_,
                                        [&](double work) { return report(what, work); });
      if (isOver_) return false;
      trials_.push_back(end);
    }
    last_ = trials_[count_++];
    budget_.spend(last_.work);
    budget_.limitByFirst(last_.work, scene_.path.searchEffort);
    if (last_.cutShort) ++cutShort_;
    return last_.arrives;
  }

  /// Reports the current trial and its work so far. Returns whether to continue.
  bool report(const std::string& what, double work) {
    run::SearchBudget soFar = budget_;
    soFar.spend(work);
    isOver_ = isOver_ || !observer_({what, soFar.share()});
    return !isOver_;
  }

  /// Whether the observer and the budget allow another trial.
  bool mayTry(const std::string& what) {
    if (!report(what, 0)) return false;
    if (budget_.isSpent()) isIncomplete_ = true;
    return !isIncomplete_;
  }

  bool isCutShort() const { return cutShort_ > 0 || isIncomplete_; }

  /// The results that are unknown because of the budget. Empty if none.
  std::string describeUntried() const {
    if (!isCutShort()) return "";
    std::vector<std::string> parts;
    if (cutShort_ > 0) {
      parts.push_back(counted(cutShort_, "trial") + " stopped");
    }
    if (isIncomplete_) parts.push_back("others not started");
    return fmt::format(" ({}: search budget spent; raise `search_effort`)", fmt::join(parts, ", "));
  }

  /// Describes a path that reaches the equilibrium of the scene's springs.
  std::string describeArrival() const {
    const scene::Environment& environment = scene_.environment;
    const bool isLoaded = environment.ground || !environment.gravity.isZero(0);
    const bool isExact =
        atTarget_.nearest.restError <= run::kFarError * model::tileSize(scene_.model);
    return fmt::format("{}{}",
                       isExact ? " arrives" : " reaches the nearest known state with closed joints",
                       isLoaded ? " without gravity and ground" : "");
  }

  // In the plane without contacts, a straight pull with longer steps is tried first.
  PathChoice findWithoutContacts() {
    scene::PathSettings straight = scene_.path;
    straight.kind = scene::PathKind::Straight;
    const scene::Environment empty;
    bool jams = false;
    const bool mayTouch = scene_.environment.contacts != scene::ContactFilter::None;
    if (scene::sceneNeeds(scene_).planar.on && !mayTouch) {
      if (!mayTry(describe(straight))) return {straight, noPathArrives()};
      if (arrives(straight, empty, describe(straight), kCoarseSteps))
        return {straight, describe(straight) + describeArrival()};
      jams = last_.jams;
    }
    for (const scene::PathSettings& path : candidatePaths(scene_, false)) {
      if (jams && !path.jointsAreCompliant()) continue;
      const std::string what = describe(path);
      if (!mayTry(what)) break;
      if (arrives(path, empty, what)) return {path, what + describeArrival()};
      if (path.kind == scene::PathKind::Straight) jams = last_.jams;
    }
    return {straight, noPathArrives()};
  }

  std::string noPathArrives() const {
    return (count_ == 0 ? "no path was tried" : "no tried path arrives") + describeUntried();
  }

  /// If bricks overlap on the path found, searches another path with contacts.
  PathChoice findAmongBricks(const PathChoice& first, bool fitsAtTarget) {
    if (const auto path = pathAmongBricks(candidatePaths(scene_, true))) {
      return {*path, describe(*path) + " with contacts" + describeArrival(), true};
    }
    std::string reason = first.reason + " with overlaps";
    if (fitsAtTarget) {
      reason += "; no tried path arrives with contacts" + describeUntried() + widerJoints();
    }
    if (!nearest_) return {withExactJoints(first.path), reason};
    return {nearest_->path,
            fmt::format("{}; {} comes nearest with contacts", reason, describe(nearest_->path))};
  }

  /// The first path that arrives without overlaps and with small joint openings.
  std::optional<scene::PathSettings> pathAmongBricks(
      const std::vector<scene::PathSettings>& paths) {
    scene::Environment bricks = scene_.environment;
    // Ground and weight would affect which trial arrives. The search is only about the mechanism.
    bricks.ground.reset();
    bricks.gravity.setZero();
    for (const scene::PathSettings& path : paths) {
      const std::string what = describe(path) + " with contacts";
      if (!mayTry(what)) return {};
      const bool found = arrives(path, bricks, what);
      if (isOver_ || !last_.isCollisionFree) continue;
      if (last_.opening > kOpeningShare * model::tileSize(scene_.model)) {
        if (found && !wide_) wide_ = {path, last_};
        continue;
      }
      if (found) return path;
      if (!nearest_ || last_.error < kNearer * nearest_->end.error) nearest_ = {path, last_};
    }
    return {};
  }

  /// For the summary: compliant joints that arrive but open too far. Empty if there are none.
  std::string widerJoints() const {
    if (!wide_) return "";
    return fmt::format("; {} arrives, but joints open by {}", describe(wide_->path),
                       lengthText(wide_->end.opening, scene_.model.unit, 2));
  }

  const scene::Scene& scene_;
  TargetFindings atTarget_;
  run::SearchBudget& budget_;
  const run::TrialObserver& observer_;
  std::vector<run::TrialEnd>& trials_;
  std::size_t count_ = 0;      // trials so far
  bool isOver_ = false;        // the observer stopped the search
  int cutShort_ = 0;           // number of trials that the budget cut short
  bool isIncomplete_ = false;  // the budget was spent before all paths were tried
  run::TrialEnd last_;
  std::optional<Attempt> nearest_;  // nearest of those with contacts that do not arrive
  std::optional<Attempt> wide_;     // arrives, but joints open too far
};

std::string jamming() {
  return fmt::format(
      "exact joints jam: the tiles do not fit each other in any open state. Joint ratio {:g}",
      run::kMisfitRatio);
}

}  // namespace

// The first rule that applies decides. All rules before the last line are cases in which a search
// is useless, or in which a force other than the pull drives the deployment.
PathChoice choosePath(const scene::Scene& scene, const TargetFindings& atTarget,
                      run::SearchBudget& budget, const run::TrialObserver& observer,
                      std::vector<run::TrialEnd>& trials) {
  const run::TrialObserver watch =
      observer ? observer : [](const run::SearchNews&) { return true; };
  if (scene.path.kind != scene::PathKind::Dynamic) return {scene.path, "requested", true};
  scene::PathSettings straight = scene.path;
  straight.kind = scene::PathKind::Straight;
  if (scene.solver.kind == scene::SolverKind::Bullet)
    return {straight, "the baseline tries no other paths"};
  if (std::isfinite(run::roundedJointStiffness(scene.model)) &&
      exactJointsJam(scene, budget, watch)) {
    straight.jointRatio = run::kMisfitRatio;
    return {straight, jamming(), true};
  }
  if (!scene.timeline.empty()) return {straight, "the timeline drives the sheet"};
  const scene::Drive drive = scene.actuation.drive;
  if (drive != scene::Drive::Target && drive != scene::Drive::None &&
      exactJointsJam(scene, budget, watch)) {
    straight.jointRatio = run::kMisfitRatio;
    return {straight, jamming()};
  }
  if (!scene.model.target) return {straight, "there is no target"};
  if (scene.hinges.areOn()) return {straight, "hinges have springs"};
  if (drive != scene::Drive::Target || !scene.springs.pull())
    return {straight, "nothing pulls to the target"};
  return PathSearch(scene, atTarget, budget, watch, trials).find();
}

// ------------------------------------------------------------------------------------------------
// Warnings before the run about a target that rigid, jointed tiles cannot reach. They use only the
// data: joint gaps at the target, a sheet that is turned over, the distance at which single tiles
// fit their targets (measures.cpp), and a start that was moved by alignment although ground or
// obstacles fix its position.

namespace {

// Smaller moves of the start, in tiles, do not count.
constexpr double kMovedShare = 1e-6;
// Bounds count as equal below this ratio.
constexpr double kAboveBound = 1.1;

bool pullsToTarget(const scene::Scene& scene) {
  return scene.model.target && scene.actuation.drive == scene::Drive::Target;
}

// Warns if joints are open in the target's own data.
std::string openTargetWarning(const scene::Scene& scene) {
  const double tile = model::tileSize(scene.model);
  const double gap = model::largestJointGap(scene.model.joints, *scene.model.target);
  if (gap <= run::kAllowedOpening * tile) return "";
  return fmt::format(
      "the target opens its joints by {} ({:.2g} tiles); closed joints cannot reach it",
      lengthText(gap, scene.model.unit), gap / tile);
}

/// A folded target is turned over only if all its tiles are reversed: they face many
/// directions.
std::string turnedWarning(const scene::Scene& scene) {
  const model::Model& model = scene.model;
  const auto count = static_cast<int>(model.tiles.size());
  const int turned = model::countTurnedOver(model.tiles, *model.target);
  const double flat = model::flatTolerance(model);
  const std::optional<model::SheetFrame> frame = model::sheetFrame(model.tiles, flat);
  const bool areFlat = frame && model::isParallel(*frame, *model.target, flat);
  if (turned == 0 || (!areFlat && turned < count)) return "";
  return fmt::format("the target is turned over: {} of {} tiles face the opposite side there",
                     turned, count);
}

// Warns if the tiles' shapes differ from those of the target.
std::string rigidWarning(const scene::Scene& scene) {
  const double tile = model::tileSize(scene.model);
  const double bound = trajectory::rigidBound(scene.model.tiles, *scene.model.target);
  if (bound <= run::kFarError * tile) return "";
  return fmt::format(
      "the target is out of reach: its tiles have other shapes. Rigid tiles cannot come nearer "
      "than {}",
      model::lengthInTiles(bound, scene.model, 3));
}

// Reports a target that was moved onto the start, if its position matters.
std::string movedWarning(const scene::Scene& scene) {
  const scene::StartAlignment& alignment = scene.alignment;
  const scene::Environment& environment = scene.environment;
  const bool positionMatters = environment.ground || !environment.obstacles.empty();
  const bool isMoved = alignment.moved > kMovedShare * model::tileSize(scene.model);
  return positionMatters && isMoved ? scene::describe(alignment, scene.model.unit) : "";
}

}  // namespace

std::vector<std::string> targetWarnings(const scene::Scene& scene) {
  std::vector<std::string> warnings;
  if (!pullsToTarget(scene)) return warnings;
  for (const auto& warn : {openTargetWarning, turnedWarning, rigidWarning, movedWarning}) {
    std::string warning = warn(scene);
    if (!warning.empty()) warnings.push_back(std::move(warning));
  }
  return warnings;
}

std::string reachWarning(const scene::Scene& scene, const run::AssembledState& nearest) {
  const double tile = model::tileSize(scene.model);
  if (!pullsToTarget(scene) || nearest.error <= run::kFarError * tile) return "";
  const double bound = trajectory::rigidBound(scene.model.tiles, *scene.model.target);
  if (nearest.error <= kAboveBound * bound) return "";
  return fmt::format(
      "the target is out of reach: the nearest state found with closed joints is {} from it",
      model::lengthInTiles(nearest.error, scene.model, 3));
}

}  // namespace kirireel::path
