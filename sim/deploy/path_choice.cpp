// Which way of dynamics brings a model to its target: trials, each a run of its own.
//
// The ways, in the order in which they are tried: a straight pull; guided tiles, with exact
// joints; guided tiles on compliant joints, from stiff to soft. Among touching bricks tiles
// are guided after the bricks were pushed apart first. Times are periods of the scene's springs and
// stiffnesses multiples of that which holds a tile at its place, so that a model of another
// size or mass is tried in the same ways. A trial ends when it arrives, when it stops to come
// nearer, when exact joints jam, when bricks overlap that may not, or when a third of the budget's
// rest is spent. Each trial takes the steps that the run itself would take, so that what arrives
// here arrives there.
//
// These ways are what an ablation left of twelve, each tried by itself on models of data/, on four
// that PyKirigami's authors published and on 40 drawn from all families, of up to 64 tiles. Of 54
// rows without contacts, and of 49 among touching bricks, whose target has room for them,
//   a straight pull       brings 41 and 36 to their targets
//   guided                   10 and 8 more: irregular quads, square to disk, hexagons, triangles
//   and
//                         islamic tiles that turn far, a cylinder, saddles; a Moebius band, which
//                         arrives among touching bricks only where it is not pushed apart first
//   pushed apart and guided  2 more among touching bricks: caps, whose start lies flush
//   compliant joints      3 and 2 more, which have no freedom: without contacts all at a ratio of
//                         1e5, among touching bricks two at 1e4; one arrives at 1e3, but opens
//                         too far
// At twice, half or a quarter of the pace, or led by a quarter or a twentieth of the stiffness, no
// row arrived that does not so; joints of a ratio of 100 and 10 opened farther.
//
// Trials that were made before a checkpoint are taken from the list as they ended.
#include "sim/deploy/path_choice.h"

#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/deploy/assembled_state.h"
#include "sim/deploy/dynamics.h"
#include "sim/deploy/forces.h"
#include "sim/deploy/run.h"
#include "sim/model/contact.h"
#include "sim/model/sheet_frame.h"
#include "sim/scene/scene_needs.h"
#include "sim/trajectory/measures.h"
#include "sim/trajectory/sheet.h"

namespace kirireel::deploy {
namespace {

// In the plane the first look at the straight path takes longer steps where bricks may not touch:
// models that need no search are most. In space steps decide too often in which local minimum a
// pull ends, and among bricks whether they keep clear.
constexpr double kCoarseSteps = 4;

// A trial that has not come nearer to the target by this factor in so many seconds is given up.
constexpr double kImprovement = 0.995;
constexpr double kPatienceSeconds = 2;

// How far joints may open on such a path, in tiles: farther, bricks could slip past each other.
constexpr double kOpeningShare = 1e-2;
// A trial may cost this part of what is left of the budget: where bricks wedge, steps are halved
// again and again.
constexpr double kTrialShare = 1.0 / 3;

// By this factor a later path has to come nearer than an earlier one to be taken instead.
constexpr double kNearer = 0.99;

// Whether exact joints jam is looked at for so many seconds.
constexpr double kJamTime = 0.5;
// They do once most steps, and so many, have failed at their shortest: those of two whole ones.
constexpr long kJammedSteps = 512;

// Periods of the springs' frequency in which tiles are guided, and for which bricks that lie flush
// are pushed apart before.
constexpr double kGuidedPeriods = 12;
constexpr double kOpenPeriods = 4;
// Ratios of compliant joints, from stiff to soft: the first that arrives opens least.
constexpr std::array kCompliantRatios = {1e5, 1e4, 1e3};

/// The ways to the scene's target, in the order in which they are tried.
std::vector<scene::PathSettings> waysOf(const scene::Scene& scene, bool areAmongBricks) {
  const double period = 1 / scene.springs.frequency;
  scene::PathSettings guided{scene::PathKind::Guided};
  guided.guideTime = kGuidedPeriods * period;
  std::vector<scene::PathSettings> ways = {{scene::PathKind::Straight}};
  if (areAmongBricks) {
    ways.push_back(guided);
    ways.back().openTime = kOpenPeriods * period;
  }
  ways.push_back(guided);
  for (const double ratio : kCompliantRatios) {
    ways.push_back(guided);
    ways.back().jointRatio = ratio;
  }
  return ways;
}

// The words for a path in reasons and in what is told of the search.
std::string describe(const scene::PathSettings& path) {
  if (path.kind == scene::PathKind::Straight) return "straight pull";
  std::string way = fmt::format("guided for {:.3g} s", path.guideTime);
  if (path.openTime > 0) way = fmt::format("opened for {:.3g} s, {}", path.openTime, way);
  return path.jointsAreCompliant() ? fmt::format("{}, joint ratio {:g}", way, path.jointRatio)
                                   : way + ", exact joints";
}

/// Watches a trial that may cost so much.
class WorkLimit {
 public:
  explicit WorkLimit(const SearchBudget& budget) : most_(kTrialShare * budget.left()) {}

  bool allows(const DeployCost& cost) {
    isReached_ = isReached_ || cost.took.work > most_;
    return !isReached_;
  }
  bool isReached() const { return isReached_; }

 private:
  double most_;
  bool isReached_ = false;
};

/// Ends a trial that gets no nearer to the target any more.
class StallWatch {
 public:
  explicit StallWatch(const scene::Scene& scene)
      : patience_(kPatienceSeconds + (scene.path.kind == scene::PathKind::Guided
                                          ? scene.path.openTime + scene.path.guideTime
                                          : 0)) {}

  // Whether the trial goes on. Time that tiles are opened and guided counts as patience: the error
  // may grow in it.
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

// Whether steps fail so often that the joints cannot be held exactly.
bool isJammed(const DeployCost& cost) {
  return cost.took.unconverged > kJammedSteps && 2 * cost.took.unconverged > cost.took.steps;
}

/// Whether joints cannot be held exactly on the way: with redundant joints the least misfit of the
/// tiles forbids any motion, and most steps are halved in vain.
bool exactJointsJam(const scene::Scene& scene, SearchBudget& budget,
                    const TrialObserver& observer) {
  scene::Scene trial = scene;
  trial.environment = scene::Environment{};
  trial.stop.duration = kJamTime;
  trial.path = {scene::PathKind::Straight};
  // The observer is called in the run's constructor already, when there is no run to ask yet.
  const Run* running = nullptr;
  WorkLimit limit(budget);
  RunObservers watch;
  watch.step = [&](const trajectory::StepRecord&) {
    return observer({"exact joints", budget.share()}) &&
           (!running || (limit.allows(running->cost()) && !isJammed(running->cost())));
  };
  Run run(trial, {}, watch);
  running = &run;
  run.beTrial();
  const DeployCost cost = run.finish().cost;
  budget.spend(cost.took.work);
  return 2 * cost.took.halved > cost.took.steps;
}

/// Whether bricks that may touch keep out of each other in a trial, whatever touches in it. A run's
/// own figures are of all pairs; where joined bricks may pass through each other, samples are
/// looked at pair by pair.
class TrialClearance {
 public:
  /// `wanted`: which pairs may touch.
  TrialClearance(const scene::Scene& scene, scene::ContactFilter wanted)
      : isOfUnjoined_(wanted == scene::ContactFilter::Unjoined),
        most_(kClearShare * model::tileSize(scene.model)),
        zone_(scene.environment.pivotZone),
        bricks_(model::makeBricks(scene.model.tiles, scene.brick)),
        pivots_(model::makePivots(scene.model.joints, bricks_)) {}

  /// Makes the trial's samples known to this, where it needs them.
  void watch(RunObservers& observers) {
    if (!isOfUnjoined_) return;
    observers.sampleInterval = kLookTime;
    observers.sample = [this](const trajectory::Sample& sample) {
      look(sample.poses);
      return true;
    };
  }

  bool holds(const Accuracy& accuracy) const {
    return isOfUnjoined_ ? isClear_ : accuracy.penetrationGrownMax <= most_;
  }

 private:
  // Seconds from one look to the next.
  static constexpr double kLookTime = 1.0 / 60;

  // The first state is the start, whose overlaps are given.
  void look(const Poses& poses) {
    const bool isStart = !atStart_;
    if (isStart) atStart_.emplace();
    const auto joined = model::sharedCorners(pivots_);
    for (const trajectory::Penetration& found : trajectory::penetrationsOutsidePivots(
             bricks_, pivots_, zone_, poses, isStart ? 0 : most_)) {
      const std::pair pair(found.brickA, found.brickB);
      if (joined.contains(pair)) continue;
      double& given = (*atStart_)[pair];
      if (isStart) given = found.depth;
      isClear_ = isClear_ && found.depth - given <= most_;
    }
  }

  bool isOfUnjoined_;
  double most_;  // metres that an overlap may grow
  double zone_;
  std::vector<model::Brick> bricks_;
  std::vector<model::Pivot> pivots_;
  bool isClear_ = true;
  std::optional<std::map<std::pair<int, int>, double>> atStart_;  // metres, of pairs
};

/// Runs a scene as the deployment itself would, so that what arrives here arrives there, for as
/// long as `shouldContinue` says so and the budget allows. `wanted`: which pairs may touch in the
/// end.
TrialEnd tryPath(const scene::Scene& scene, scene::ContactFilter wanted,
                 const TargetFindings& atTarget, const SearchBudget& budget,
                 const std::function<bool(double work)>& shouldContinue) {
  const AssembledState& nearest = atTarget.nearest;
  StallWatch stalls(scene);
  const Run* running = nullptr;
  WorkLimit limit(budget);
  const bool isAmongBricks = scene.environment.contacts != scene::ContactFilter::None;
  TrialClearance clearance(scene, wanted);
  RunObservers watch;
  clearance.watch(watch);
  watch.step = [&](const trajectory::StepRecord& step) {
    if (!shouldContinue(running->cost().took.work) || !stalls(step)) return false;
    if (!limit.allows(running->cost())) return false;
    return isAmongBricks ? clearance.holds(running->accuracy()) : !isJammed(running->cost());
  };
  Run run(scene, nearest, watch);
  running = &run;
  run.beTrial();
  const DeploymentResult result = run.finish();
  const Accuracy& accuracy = result.accuracy;
  TrialEnd end;
  end.jams = !isAmongBricks && isJammed(result.cost);
  end.error = accuracy.targetErrorEnd;
  end.opening = accuracy.jointOpeningMax;
  end.work = result.cost.took.work;
  // The springs bring a trial to where they rest. From there on the nearest state is sought.
  end.arrives = result.outcome != Outcome::Diverged && !end.jams &&
                isNearest(scene.model, end.error, nearest.restError);
  end.cutShort = limit.isReached() && !end.arrives && !end.jams;
  // Compliant joints may yet open where a trial was cut short.
  const bool isOpenEnded =
      scene.path.jointsAreCompliant() && result.outcome == Outcome::Interrupted && !end.arrives;
  end.keepsClear = clearance.holds(accuracy) && !run.isHeldOpen() && !isOpenEnded;
  return end;
}

/// Where bricks are in the way all the same, joints are not to be compliant in vain: a straight
/// pull then takes the path's place.
scene::PathSettings withExactJoints(const scene::PathSettings& path) {
  return path.jointsAreCompliant() ? scene::PathSettings{scene::PathKind::Straight} : path;
}

/// Looks for a path of one scene.
class PathSearch {
 public:
  PathSearch(const scene::Scene& scene, TargetFindings atTarget, SearchBudget& budget,
             const TrialObserver& observer, std::vector<TrialEnd>& trials)
      : scene_(scene),
        atTarget_(std::move(atTarget)),
        budget_(budget),
        observer_(observer),
        trials_(trials) {}

  // Without contacts first: those trials are cheap, and where bricks keep clear on a path that
  // arrives it serves as it is.
  PathChoice find() {
    const bool fitsAtTarget = !atTarget_.isBlocked;
    PathChoice choice = findWithoutContacts();
    const bool contacts = scene_.environment.contacts != scene::ContactFilter::None;
    choice.isFound = last_.arrives && (!contacts || last_.keepsClear);
    choice.isClear = last_.arrives && last_.keepsClear;
    choice.isCutShort = !choice.isFound && isCutShort();
    const bool isWanting = contacts && !choice.isFound;
    if (isOver_ || !isWanting) return choice;
    if (!last_.arrives) {
      // Without contacts the straight pull goes on to where it ends, nearer than wedged bricks.
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
    TrialEnd end;
  };

  /// Whether a path arrives; not when the search ends before that is known.
  bool arrives(const scene::PathSettings& path, const scene::Environment& environment,
               const std::string& what, double stepFactor = 1) {
    scene::Scene trial = scene_;
    trial.environment = environment;
    trial.stop = scene::StopRules{};  // the run's own time may be too short for any path
    trial.path = path;
    trial.solver.timestep = stepFactor * scene_.solver.timestep;
    // Trials that a checkpoint brought along are not made again: their ends are the same.
    if (count_ == trials_.size()) {
      const TrialEnd end = tryPath(trial, scene_.environment.contacts, atTarget_, budget_,
                                   [&](double work) { return tell(what, work); });
      if (isOver_) return false;
      trials_.push_back(end);
    }
    last_ = trials_[count_++];
    budget_.spend(last_.work);
    budget_.limitByFirst(last_.work, scene_.path.searchEffort);
    if (last_.cutShort) ++cutShort_;
    return last_.arrives;
  }

  /// Tells what is being tried, with the work of this trial so far. Returns whether to go on.
  bool tell(const std::string& what, double work) {
    SearchBudget soFar = budget_;
    soFar.spend(work);
    isOver_ = isOver_ || !observer_({what, soFar.share()});
    return !isOver_;
  }

  /// Whether there is leave, and budget, for another trial.
  bool mayTry(const std::string& what) {
    if (!tell(what, 0)) return false;
    if (budget_.isSpent()) isIncomplete_ = true;
    return !isIncomplete_;
  }

  bool isCutShort() const { return cutShort_ > 0 || isIncomplete_; }

  /// What the budget kept from being known; empty when nothing.
  std::string untried() const {
    if (!isCutShort()) return "";
    std::vector<std::string> parts;
    if (cutShort_ > 0) {
      parts.push_back(fmt::format("{} trial{} cut short", cutShort_, cutShort_ == 1 ? "" : "s"));
    }
    if (isIncomplete_) parts.push_back("others not made");
    return fmt::format(" ({} by the search budget; raise `search_effort`)", fmt::join(parts, ", "));
  }

  /// What a path does that comes to where the scene's springs rest.
  std::string arriving() const {
    return atTarget_.nearest.restError <= kFarShare * model::tileSize(scene_.model)
               ? " arrives"
               : " comes as near as joints that stay closed were found to";
  }

  // In the plane a coarse look at the straight pull comes first, but where bricks are to keep
  // clear.
  PathChoice findWithoutContacts() {
    scene::PathSettings straight = scene_.path;
    straight.kind = scene::PathKind::Straight;
    const scene::Environment empty;
    bool jams = false;
    const bool mayTouch = scene_.environment.contacts != scene::ContactFilter::None;
    if (scene::sceneNeeds(scene_).planar.on && !mayTouch) {
      if (!mayTry(describe(straight))) return {straight, noneArrives()};
      if (arrives(straight, empty, describe(straight), kCoarseSteps))
        return {straight, describe(straight) + arriving()};
      jams = last_.jams;
    }
    for (const scene::PathSettings& path : waysOf(scene_, false)) {
      if (jams && !path.jointsAreCompliant()) continue;
      const std::string what = describe(path);
      if (!mayTry(what)) break;
      if (arrives(path, empty, what)) return {path, what + arriving()};
      if (path.kind == scene::PathKind::Straight) jams = last_.jams;
    }
    return {straight, noneArrives()};
  }

  std::string noneArrives() const {
    return (count_ == 0 ? "no path was tried" : "no path that was tried arrives") + untried();
  }

  /// Where bricks meet on the way, other ways are tried with contacts.
  PathChoice findAmongBricks(const PathChoice& first, bool fitsAtTarget) {
    if (const auto path = pathAmongBricks(waysOf(scene_, true))) {
      return {*path, describe(*path) + " among touching bricks" + arriving(), true};
    }
    std::string reason = first.reason + " where bricks pass through each other";
    if (fitsAtTarget) {
      reason +=
          "; no path that was tried arrives among bricks that touch" + untried() + widerJoints();
    }
    if (!nearest_) return {withExactJoints(first.path), reason};
    return {nearest_->path, fmt::format("{}; {} comes nearest among bricks that touch", reason,
                                        describe(nearest_->path))};
  }

  /// The first path on which bricks arrive without overlap, joints hardly open.
  std::optional<scene::PathSettings> pathAmongBricks(
      const std::vector<scene::PathSettings>& paths) {
    scene::Environment bricks = scene_.environment;
    // Ground and weight would decide which trial arrives; a path is sought for the mechanism alone.
    bricks.ground.reset();
    bricks.gravity.setZero();
    for (const scene::PathSettings& path : paths) {
      const std::string what = describe(path) + " among touching bricks";
      if (!mayTry(what)) return {};
      const bool found = arrives(path, bricks, what);
      if (isOver_ || !last_.keepsClear) continue;
      if (last_.opening > kOpeningShare * model::tileSize(scene_.model)) {
        if (found && !wide_) wide_ = {path, last_};
        continue;
      }
      if (found) return path;
      if (!nearest_ || last_.error < kNearer * nearest_->end.error) nearest_ = {path, last_};
    }
    return {};
  }

  /// Which joints arrive that open too far, for the summary; empty when none do.
  std::string widerJoints() const {
    if (!wide_) return "";
    return fmt::format("; {} does, but joints open by {}", describe(wide_->path),
                       lengthText(wide_->end.opening, scene_.model.unit, 2));
  }

  const scene::Scene& scene_;
  TargetFindings atTarget_;
  SearchBudget& budget_;
  const TrialObserver& observer_;
  std::vector<TrialEnd>& trials_;
  std::size_t count_ = 0;      // of trials so far
  bool isOver_ = false;        // the observer said so
  int cutShort_ = 0;           // of the trials
  bool isIncomplete_ = false;  // the budget ended before all paths were tried
  TrialEnd last_;
  std::optional<Attempt> nearest_;  // of those among bricks that do not arrive
  std::optional<Attempt> wide_;     // arrives, but joints open too far
};

std::string jamming() {
  return fmt::format(
      "exact joints jam, the tiles fit each other in no open state; joint ratio {:g}",
      kMisfitRatio);
}

}  // namespace

// The first rule that applies decides. Everything up to the last lines names a case in which a
// search would make no sense, or in which another force than the pull leads.
PathChoice choosePath(const scene::Scene& scene, const TargetFindings& atTarget,
                      SearchBudget& budget, const TrialObserver& observer,
                      std::vector<TrialEnd>& trials) {
  const TrialObserver watch = observer ? observer : [](const SearchNews&) { return true; };
  if (scene.path.kind != scene::PathKind::Dynamic) return {scene.path, "asked for", true};
  scene::PathSettings straight = scene.path;
  straight.kind = scene::PathKind::Straight;
  if (scene.solver.kind == scene::SolverKind::Bullet)
    return {straight, "the baseline tries no others"};
  if (std::isfinite(roundedJointStiffness(scene.model)) && exactJointsJam(scene, budget, watch)) {
    straight.jointRatio = kMisfitRatio;
    return {straight, jamming(), true};
  }
  if (!scene.timeline.empty()) return {straight, "the timeline leads"};
  const scene::Drive drive = scene.actuation.drive;
  if (drive != scene::Drive::Target && drive != scene::Drive::None &&
      exactJointsJam(scene, budget, watch)) {
    straight.jointRatio = kMisfitRatio;
    return {straight, jamming()};
  }
  if (!scene.model.target) return {straight, "there is no target"};
  if (scene.hinges.areOn()) return {straight, "hinges have springs, whose forces count"};
  if (drive != scene::Drive::Target || !scene.springs.pull())
    return {straight, "nothing pulls to the target"};
  return PathSearch(scene, atTarget, budget, watch, trials).find();
}

// ------------------------------------------------------------------------------------------------
// Warnings about a target that rigid, jointed tiles cannot reach, said before the run. They look at
// the data alone: how far joints are open at the target, whether the sheet is turned over, how near
// tiles can come to it one by one (measures.cpp), and whether the alignment has moved the start
// although ground or obstacles make its place count.

namespace {

// A start that was moved less, in tiles, stayed where it was.
constexpr double kMovedShare = 1e-6;
// Bounds that differ less are one.
constexpr double kAboveBound = 1.1;

bool isWanted(const scene::Scene& scene) {
  return scene.model.target && scene.actuation.drive == scene::Drive::Target;
}

// Joints that are open in the target's own data.
std::string tornWarning(const scene::Scene& scene) {
  const double tile = model::tileSize(scene.model);
  const double gap = trajectory::largestJointGap(scene.model.joints, *scene.model.target);
  if (gap <= kOpenJoints * tile) return "";
  return fmt::format(
      "the target is torn: its own joints are open by {} there ({:.2g} tiles), so that closed "
      "joints cannot reach it",
      lengthText(gap, scene.model.unit), gap / tile);
}

/// Tiles of a folded target face many ways; a sheet of which all do the other way is turned over.
std::string turnedWarning(const scene::Scene& scene) {
  const model::Model& model = scene.model;
  const auto count = static_cast<int>(model.tiles.size());
  const int turned = model::countTurnedOver(model.tiles, *model.target);
  const double flat = model::flatTolerance(model);
  const std::optional<model::SheetFrame> frame = model::sheetFrame(model.tiles, flat);
  const bool areFlat = frame && model::isParallel(*frame, *model.target, flat);
  if (turned == 0 || (!areFlat && turned < count)) return "";
  return fmt::format(
      "the target is turned over: {} of {} tiles face the other way there than at the start",
      turned, count);
}

// Tiles of other shapes than the target's.
std::string rigidWarning(const scene::Scene& scene) {
  const double tile = model::tileSize(scene.model);
  const double bound = trajectory::rigidBound(scene.model.tiles, *scene.model.target);
  if (bound <= kFarShare * tile) return "";
  return fmt::format(
      "the target is out of reach: its tiles have other shapes, and rigid ones cannot come nearer "
      "than {}",
      model::lengthInTiles(bound, scene.model, 3));
}

// Where the place matters, a start that was moved onto its target is told.
std::string movedWarning(const scene::Scene& scene) {
  const scene::StartAlignment& alignment = scene.alignment;
  const scene::Environment& environment = scene.environment;
  const bool placeCounts = environment.ground || !environment.obstacles.empty();
  const bool isMoved = alignment.moved > kMovedShare * model::tileSize(scene.model);
  return placeCounts && isMoved ? scene::describe(alignment, scene.model.unit) : "";
}

}  // namespace

std::vector<std::string> targetWarnings(const scene::Scene& scene) {
  std::vector<std::string> warnings;
  if (!isWanted(scene)) return warnings;
  for (const auto& warn : {tornWarning, turnedWarning, rigidWarning, movedWarning}) {
    std::string warning = warn(scene);
    if (!warning.empty()) warnings.push_back(std::move(warning));
  }
  return warnings;
}

std::string reachWarning(const scene::Scene& scene, const AssembledState& nearest) {
  const double tile = model::tileSize(scene.model);
  if (!isWanted(scene) || nearest.error <= kFarShare * tile) return "";
  const double bound = trajectory::rigidBound(scene.model.tiles, *scene.model.target);
  if (nearest.error <= kAboveBound * bound) return "";
  return fmt::format(
      "the target is out of reach: the search for the nearest state with closed joints ended {} "
      "from it",
      model::lengthInTiles(nearest.error, scene.model, 3));
}

}  // namespace kirireel::deploy
