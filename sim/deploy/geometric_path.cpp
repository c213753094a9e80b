// Which paths of the mechanism are tried, in which order, and how the one that is taken is walked.
//
// Tried are, until one serves: without contacts, with three weights of turns against places; with
// contacts, where bricks overlapped on the way, from the start and then from the target back, with
// compliant joints for the little that flush bricks at the start leave of it; with compliant joints
// all the way, which open as little as they can (each path found guides the next, with joints ten
// times as stiff). Every path that arrives is judged: how deep bricks overlap beyond the start, how
// far joints open. One that is much longer than its tiles' own motions, or turns back, is made
// shorter (continuation.cpp): first as far as
// that makes tiles turn more evenly, so that a sheet looks regular on the way; a path that is as
// short as can be often is not. One that stays a detour so is shortened further, at the cost of
// even turns, if that makes it none.
//
// A walk has an even pace: state k is reached at T L_k / L, L_k the path's length up to it
// (pathDistance) and T the walking time. Samples lie between two states, with joints closed again.
#include "sim/deploy/geometric_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "sim/base/interruption.h"
#include "sim/deploy/arrival.h"
#include "sim/deploy/assembled_state.h"
#include "sim/deploy/continuation.h"
#include "sim/deploy/dynamics.h"
#include "sim/deploy/run_figures.h"
#include "sim/scene/scene_needs.h"
#include "sim/trajectory/measures.h"

namespace kirireel::deploy {
namespace {

// The paths to try without contacts, the usual first. A heavier turn follows its guide more.
constexpr auto kAlone = std::to_array<ContinuationSettings>({
    {.turnWeight = 100},
    {.turnWeight = 10},
    {.turnWeight = 1},
});
// The paths to try with contacts: where bricks lie flush at the start, a leap would wedge them.
constexpr auto kTouching = std::to_array<ContinuationSettings>({
    {.turnWeight = 100, .leap = 0},
    {.turnWeight = 100, .opening = 1, .leap = 0},
    {.turnWeight = 10, .leap = 1.0 / 600},
});

// The paths to try with compliant joints: the first that arrives is then followed with stiffer
// ones.
constexpr auto kCompliant = std::to_array<ContinuationSettings>({
    {.turnWeight = 100, .leap = 0, .jointStiffness = 1e3},
    {.turnWeight = 100, .leap = 0, .jointStiffness = 1e2},
    {.turnWeight = 1, .leap = 0, .jointStiffness = 1e1},
});
constexpr double kStiffer = 10;
// Among touching bricks, a path that ends this much farther from the target than the nearest state,
// in tiles, is kept for the case that none arrives.
constexpr double kNearShare = 0.02;
// Joints that are compliant near a flush start alone may open there by this part of a tile.
constexpr double kStartOpening = 1e-2;
// Such a path may cost this part of the budget.
constexpr double kFromTargetShare = 0.2;
// Joints that are open by less, in tiles, are closed.
constexpr double kExactShare = 1e-10;

// A path may cost this part of the budget, and as much again for each fifth of it that is found:
// where bricks wedge, or the mechanism is singular, moves are halved again and again.
constexpr double kPathShare = 0.1;
constexpr double kParts = 5;
// Extending without contacts may cost this part of the budget, so that enough is left with them.
constexpr double kAloneShare = 0.6;
// Shortening a path that was found may cost this part of it.
constexpr double kShorteningShare = 0.25;
// Of turns against places, times rho^2, in what a shorter path is: from where tiles turn evenly to
// the length itself.
constexpr auto kTurnWeights = std::to_array<double>({10, 3, 1});

// An extension shorter than this part of a tile is none.
constexpr double kLeastExtension = 1e-3;

// Whether no overlap grew on the path beyond what counts as rounding.
bool isClear(const scene::Scene& scene, const GeometricPath& found) {
  return found.grown <= kClearShare * model::tileSize(scene.model);
}

/// The contacts that bricks have where the scene was given these and they meet on the way.
scene::ContactFilter whereTheyMeet(scene::ContactFilter wanted) {
  return wanted == scene::ContactFilter::Auto ? scene::ContactFilter::All : wanted;
}

/// Measures how deep bricks overlap on a path beyond its first state, and how far compliant joints
/// open; says why bricks had contacts on it, or had none. `wanted`: the contacts that the scene was
/// given with.
void judge(const scene::Scene& scene, GeometricPath& found, scene::ContactFilter wanted) {
  const std::vector<model::Brick> bricks = model::makeBricks(scene.model.tiles, scene.brick);
  const std::vector<model::Pivot> pivots = model::makePivots(scene.model.joints, bricks);
  const std::vector<Poses>& states = found.path.states;
  scene::Environment asked = scene.environment;
  asked.contacts = wanted;
  trajectory::PenetrationMeter meter = overlapMeter(asked, bricks, pivots, states.front());
  found.grown = found.opening = 0;
  for (const Poses& state : states) {
    found.grownAtEnd = meter.at(state).grown;
    found.grown = std::max(found.grown, found.grownAtEnd);
    if (!found.hasCompliantJoints) continue;
    found.opening = std::max(found.opening, trajectory::jointGap(pivots, state).max);
  }
  const bool isAsked = wanted != scene::ContactFilter::None;
  const bool isTouching = found.contacts != scene::ContactFilter::None;
  found.passesThrough = isAsked && !isTouching && !isClear(scene, found);
  const bool isPushed = isAsked && isTouching && !isClear(scene, found);
  found.contactReason =
      !isAsked     ? "not asked for"
      : isPushed   ? "bricks meet on the way, and some pass through each other all the same"
      : isTouching ? "bricks meet on the way"
      : found.passesThrough
          ? "bricks pass through each other, no path among touching ones was found"
          : "no bricks meet on the way";
}

void judge(const scene::Scene& scene, GeometricPath& found) {
  judge(scene, found, scene.environment.contacts);
}

/// A path pulled tight so that tiles turn as evenly on it as they can on a path that is no detour.
/// Where every one is a detour, the one on which they turn most evenly.
MechanismPath evenlyTight(const scene::Scene& scene, const MechanismPath& path, double mostGrown,
                          SearchBudget& budget, const PathObserver& goesOn) {
  std::optional<MechanismPath> mostEven;
  for (const double turnWeight : kTurnWeights) {
    MechanismPath pulled =
        pulledTight(scene, mostEven.value_or(path), turnWeight, mostGrown, budget, goesOn);
    if (!isDetour(scene, pulled)) return pulled;
    if (!mostEven) mostEven = std::move(pulled);
  }
  return *std::move(mostEven);
}

/// Shortens a path that is a detour or turns back, at a part of the budget. Bricks overlap no
/// deeper on it than before, or than counts as clear; where no contacts are wanted, they may
/// overlap. Compliant joints open no farther; their path is only cleared of the places where it
/// turns back.
void shorten(const scene::Scene& scene, GeometricPath& found, scene::ContactFilter wanted,
             SearchBudget& budget, const PathObserver& goesOn) {
  const bool isBack = turnsBack(scene, found.path);
  if (!isBack && (found.hasCompliantJoints || !isDetour(scene, found.path))) return;
  const double mostGrown = wanted == scene::ContactFilter::None
                               ? std::numeric_limits<double>::infinity()
                               : std::max(found.grown, kClearShare * model::tileSize(scene.model));
  if (found.hasCompliantJoints) {
    found.path = withoutKinks(scene, std::move(found.path), found.opening, mostGrown);
    return judge(scene, found, wanted);
  }
  scene::Scene touching = scene;
  // Bricks that did not meet may do so on a shorter path.
  touching.environment.contacts = found.passesThrough ? found.contacts : whereTheyMeet(wanted);
  SearchBudget part(std::min(budget.left() / kWorkPerSecond, kShorteningShare * budget.seconds()));
  found.path = evenlyTight(touching, found.path, mostGrown, part, goesOn);
  if (isDetour(scene, found.path)) {
    found.path = withShortcuts(touching, std::move(found.path), mostGrown, part, goesOn);
  }
  budget.spend(part.spent());
  judge(scene, found, wanted);
}

const char* const kAmongBricks = "a path of the mechanism among touching bricks";
const char* const kFromTarget = "a path of the mechanism from the target back";
const char* const kTouchingReason =
    "a path of the mechanism among touching bricks, nothing given needs dynamics";
const char* const kShortening = "shorter ways along the path that was found";
const char* const kCompliantTried = "a path of the mechanism with compliant joints";

/// Tries the paths of one scene.
class GeometricSearch {
 public:
  GeometricSearch(const scene::Scene& scene, const TargetFindings& atTarget, SearchBudget& budget,
                  const TrialObserver& observer)
      : scene_(scene),
        atTarget_(atTarget),
        budget_(budget),
        observer_(observer),
        tile_(model::tileSize(scene.model)),
        start_(model::startPoses(scene.model.tiles,
                                 model::makeBricks(scene.model.tiles, scene.brick))) {}

  // The order is that of the head of this file. A clear path without contacts ends the search;
  // contacts are tried only where a path passed through bricks; compliant joints come last.
  GeometricPaths find() {
    const scene::ContactFilter wanted = scene_.environment.contacts;
    for (const ContinuationSettings& settings : kAlone) {
      tryAlone(settings);
      if (isOver_) return std::move(found_);
      if (found_.isCutShort || (found_.clear && !isDetour(scene_, found_.clear->path))) break;
    }
    if (found_.clear) return shortened(found_.clear);
    const scene::ContactFilter touching = whereTheyMeet(wanted);
    if (wanted != scene::ContactFilter::None && found_.through) {
      for (const ContinuationSettings& settings : kTouching) {
        tryTouching(settings, touching);
        if (isOver_) return std::move(found_);
        if (found_.clear) break;
      }
      if (!found_.clear) tryFromTarget(touching);
      if (!found_.clear && !found_.compliant) found_.clear = std::move(near_);
      found_.mayBeExact = found_.compliant.has_value();
      if (isOver_ || found_.compliant) return std::move(found_);
      if (found_.clear) return shortened(found_.clear);
    }
    found_.mayBeExact = found_.through || found_.isCutShort;
    tryCompliant(touching);
    if (!found_.compliant && !found_.through && wanted == scene::ContactFilter::Auto) {
      tryCompliant(scene::ContactFilter::None);
    }
    if (!found_.compliant && !found_.through) found_.trouble = trouble();
    return found_.through ? shortened(found_.through) : std::move(found_);
  }

 private:
  /// What was found, with one of its paths shortened.
  GeometricPaths shortened(std::optional<GeometricPath>& path) {
    shorten(scene_, *path, scene_.environment.contacts, budget_,
            [&](double) { return tell(kShortening); });
    return std::move(found_);
  }

  // The guide that every first trial gets: the start and the nearest assembled state alone.
  std::vector<Poses> tilesOwnMotion() const { return {start_, atTarget_.nearest.poses}; }

  // One trial, charged to the budget, with a share of it that grows as the path does.
  MechanismPath follow(std::vector<Poses> guide, const ContinuationSettings& settings,
                       scene::ContactFilter contacts, const char* what) {
    scene::Scene trial = scene_;
    trial.environment.contacts = contacts;
    SearchBudget part(budget_.left() / kWorkPerSecond);
    const double least = kPathShare * budget_.seconds();
    const auto goesOn = [&](double progress) {
      return tell(what) && part.spentSeconds() <= least * (1 + (kParts - 1) * progress);
    };
    MechanismPath path = continueAlong(trial, std::move(guide), settings, part, goesOn);
    budget_.spend(part.spent());
    endAtNearest(path);
    return path;
  }

  /// Tiles of rounded coordinates come to the nearest state within the rounding's reach: it is the
  /// end of their path, unless bricks overlap deeper there. In a singular state, a gap of that size
  /// is a turn by its square root.
  void endAtNearest(MechanismPath& path) const {
    if (path.isStuck || path.isCutShort || !arrives(path)) return;
    if (isNearest(scene_.model, path.error, atTarget_.nearest.error)) return;
    const Poses& nearest = atTarget_.nearest.poses;
    const double reach = roundedReach(scene_.model);
    if (farthestMove(path.states.back(), nearest, tile_) > std::sqrt(reach * tile_)) return;
    const std::vector<model::Brick> bricks = model::makeBricks(scene_.model.tiles, scene_.brick);
    const std::vector<model::Pivot> pivots = model::makePivots(scene_.model.joints, bricks);
    trajectory::PenetrationMeter meter =
        overlapMeter(scene_.environment, bricks, pivots, path.states.front());
    const double grown = meter.at(path.states.back()).grown;
    const bool mayOverlap = scene_.environment.contacts == scene::ContactFilter::None;
    if (!mayOverlap && meter.at(nearest).grown > std::max(grown, kClearShare * tile_)) return;
    path.lengths.push_back(path.length() + pathDistance(bricks, path.states.back(), nearest));
    path.states.push_back(nearest);
    path.error = atTarget_.nearest.error;
    path.isRounded = true;
  }

  /// Whether a path goes to its end. Notes what ended it otherwise.
  bool isWhole(const MechanismPath& path) {
    if (path.isStuck) ++stuck_;
    if (path.isCutShort) found_.isCutShort = true;
    return !path.isCutShort && !path.isStuck;
  }

  /// Whether a path ends where the bricks are known to come nearest to the target, within the
  /// rounding's reach.
  bool arrives(const MechanismPath& path) const {
    return path.error <=
           arrivalLimit(scene_.model, atTarget_.nearest.error) + roundedReach(scene_.model);
  }

  /// Whether a path among bricks, whose contacts may keep them away, ends near enough to be kept.
  bool comesNear(const MechanismPath& path) const {
    const double share = atTarget_.isBlocked ? kFarShare : kNearShare;
    return arrives(path) || path.error <= atTarget_.nearest.error + share * tile_;
  }

  // Without contacts: how deep bricks overlap says whether they are needed.
  void tryAlone(const ContinuationSettings& settings) {
    GeometricPath trial;
    trial.path =
        follow(tilesOwnMotion(), settings, scene::ContactFilter::None, "a path of the mechanism");
    if (!isWhole(trial.path) || !arrives(trial.path)) return;
    trial.hasCompliantJoints = trial.path.isRounded;
    trial.reason = "a path of the mechanism, nothing given needs dynamics";
    judge(scene_, trial);
    if (!trial.passesThrough) {
      const bool isShorter = !found_.clear || trial.path.length() < found_.clear->path.length();
      if (isShorter) found_.clear = std::move(trial);
    } else if (!found_.through || trial.grown < found_.through->grown) {
      found_.through = std::move(trial);
    }
  }

  void tryTouching(const ContinuationSettings& settings, scene::ContactFilter contacts) {
    GeometricPath trial;
    trial.contacts = contacts;
    trial.path = follow(tilesOwnMotion(), settings, contacts, kAmongBricks);
    if (!isWhole(trial.path) || !comesNear(trial.path)) return;
    trial.hasCompliantJoints = trial.path.isRounded;
    trial.reason = kTouchingReason;
    judge(scene_, trial);
    if (!isClear(scene_, trial)) return;
    if (arrives(trial.path)) {
      found_.clear = std::move(trial);
    } else if (!near_ || trial.path.error < near_->path.error) {
      near_ = std::move(trial);
    }
  }

  /// Among bricks that wedge near the start, where a path passes through them.
  void tryFromTarget(scene::ContactFilter contacts) {
    scene::Scene trial = scene_;
    trial.environment.contacts = contacts;
    GeometricPath found;
    found.contacts = contacts;
    SearchBudget part(
        std::min(budget_.left() / kWorkPerSecond, kFromTargetShare * budget_.seconds()));
    found.path =
        continueFromGoal(trial, found_.through->path.states.front(), atTarget_.nearest.poses, part,
                         [&](double) { return tell(kFromTarget); });
    budget_.spend(part.spent());
    if (!isWhole(found.path) || !arrives(found.path)) return;
    found.hasCompliantJoints = true;
    judge(scene_, found);
    if (!isClear(scene_, found) || found.opening > kStartOpening * tile_) return;
    found.hasCompliantJoints = found.opening > kExactShare * tile_;
    if (found.hasCompliantJoints) {
      shorten(scene_, found, scene_.environment.contacts, budget_, [](double) { return true; });
      found.reason = openingReason(
          "a path of the mechanism among touching bricks whose joints are compliant near the start "
          "alone, which",
          found);
      found_.compliant = std::move(found);
    } else {
      found.reason = kTouchingReason;
      found_.clear = std::move(found);
    }
  }

  /// `compliant`: the path's words up to how far its joints open.
  std::string openingReason(const char* compliant, const GeometricPath& found) const {
    return fmt::format("{} open by up to {:.2g} m ({:.2g} tiles): none with exact joints was found",
                       compliant, found.opening, found.opening / tile_);
  }

  /// Tells what is being tried. Returns whether to go on.
  bool tell(const char* what) {
    isOver_ = isOver_ || (observer_ && !observer_({what, budget_.share()}));
    return !isOver_;
  }

  /// Compliant joints, opening as little as they can: once a path is found, it guides the next.
  void tryCompliant(scene::ContactFilter contacts) {
    std::optional<GeometricPath> best;
    for (const ContinuationSettings& settings : kCompliant) {
      std::optional<GeometricPath> found = stiffestPath(settings, contacts);
      const bool isNearer = found && (!best || found->path.error < best->path.error);
      if (isNearer) best = std::move(found);
      if (isOver_ || (best && arrives(best->path))) break;
    }
    if (!best) return;
    shorten(scene_, *best, scene_.environment.contacts, budget_,
            [&](double) { return tell(kShortening); });
    best->reason = openingReason("a path of the mechanism with compliant joints, which", *best);
    (best->passesThrough ? found_.through : found_.compliant) = std::move(best);
  }

  /// The path with joints as stiff as they can be, from these on.
  std::optional<GeometricPath> stiffestPath(ContinuationSettings settings,
                                            scene::ContactFilter contacts) {
    std::optional<GeometricPath> best = compliantPath(tilesOwnMotion(), settings, contacts);
    while (best && !isOver_) {
      settings.jointStiffness *= kStiffer;
      std::optional<GeometricPath> next = compliantPath(best->path.states, settings, contacts);
      if (!next || !(next->opening < best->opening)) break;
      if (arrives(best->path) && !arrives(next->path)) break;
      best = std::move(next);
    }
    return best;
  }

  std::optional<GeometricPath> compliantPath(std::vector<Poses> guide,
                                             const ContinuationSettings& settings,
                                             scene::ContactFilter contacts) {
    GeometricPath trial;
    trial.hasCompliantJoints = true;
    trial.contacts = contacts;
    trial.path = follow(std::move(guide), settings, contacts, kCompliantTried);
    const bool isAmongBricks = contacts != scene::ContactFilter::None;
    if (!isWhole(trial.path)) return std::nullopt;
    if (!(isAmongBricks ? comesNear(trial.path) : arrives(trial.path))) return std::nullopt;
    judge(scene_, trial);
    if (contacts != scene::ContactFilter::None && !isClear(scene_, trial)) return std::nullopt;
    return trial;
  }

  std::string trouble() const {
    if (found_.isCutShort) return "looking for a path of the mechanism was cut short";
    return stuck_ > 0 ? "the mechanism was followed to where it goes no further"
                      : "paths of the mechanism end short of the target";
  }

  const scene::Scene& scene_;
  const TargetFindings& atTarget_;
  SearchBudget& budget_;
  const TrialObserver& observer_;
  double tile_;  // metres
  Poses start_;
  GeometricPaths found_;
  std::optional<GeometricPath> near_;  // among touching bricks, clear, but not arrived
  int stuck_ = 0;
  bool isOver_ = false;
};

const char* const kTracing = "the states of the run that arrives";
const char* const kExtending = "the way to full extension";

// Whether a path is shorter than any extension that counts.
bool standsStill(const scene::Scene& scene, const MechanismPath& path) {
  return path.length() < kLeastExtension * model::tileSize(scene.model);
}

/// The path to full extension with these contacts, unless a share of the budget's rest is not
/// enough.
std::optional<GeometricPath> extension(const scene::Scene& scene, scene::ContactFilter contacts,
                                       double share, SearchBudget& budget,
                                       const TrialObserver& observer) {
  scene::Scene trial = scene;
  trial.environment.contacts = contacts;
  SearchBudget part(share * budget.left() / kWorkPerSecond);
  GeometricPath found;
  found.path = continueToExtension(trial, part, [&](double) {
    return !observer || observer({kExtending, budget.share()});
  });
  budget.spend(part.spent());
  if (found.path.isCutShort) return std::nullopt;
  found.hasCompliantJoints = found.path.isRounded;
  found.contacts = contacts;
  found.reason = "a path of the mechanism, nothing given needs dynamics";
  judge(scene, found);
  return found;
}

/// The paths to full extension, as they are found.
GeometricPaths extensions(const scene::Scene& scene, SearchBudget& budget,
                          const TrialObserver& observer) {
  const scene::ContactFilter wanted = scene.environment.contacts;
  const bool isOpen = wanted == scene::ContactFilter::Auto;
  GeometricPaths found;
  found.trouble = "looking for the way to full extension was cut short";
  std::optional<GeometricPath> alone =
      extension(scene, scene::ContactFilter::None, kAloneShare, budget, observer);
  found.isCutShort = !alone;
  if (alone && !alone->passesThrough) {
    found.clear = std::move(alone);
    return found;
  }
  if (wanted == scene::ContactFilter::None) return found;
  std::optional<GeometricPath> touching =
      extension(scene, whereTheyMeet(wanted), 1, budget, observer);
  found.isCutShort = found.isCutShort || !touching;
  if (touching && !isClear(scene, *touching)) {
    found.trouble = "bricks pass through each other on the way to full extension";
    touching.reset();
  }
  // Flush bricks may hold each other. A sheet that stands still shows nobody how it opens.
  if (touching && !(isOpen && alone && standsStill(scene, touching->path))) {
    found.clear = std::move(touching);
  } else if (isOpen) {
    found.through = std::move(alone);
  }
  return found;
}

// A state between two of a path of rounded tiles lies on a curve through so many.
constexpr std::size_t kSmoothStates = 4;

/// A walk in progress.
class Walk {
 public:
  Walk(const scene::Scene& scene, const GeometricPath& found, const AssembledState& nearest,
       double sampleInterval, const SampleObserver& observer)
      : scene_(scene),
        found_(found),
        symmetries_(scene, found.path.symmetries),
        interval_(sampleInterval),
        observer_(observer),
        bricks_(model::makeBricks(scene.model.tiles, scene.brick)),
        pivots_(model::makePivots(scene.model.joints, bricks_)),
        figures_(scene.model, bricks_, pivots_, scene.environment.pivotZone,
                 model::startPoses(scene.model.tiles, bricks_), nearest) {
    scene::Scene alone = scene;
    alone.environment = scene::Environment{};
    projection_ = makeDynamics(alone, scene::sceneNeeds(alone), bricks_,
                               model::startPoses(scene.model.tiles, bricks_));
  }

  // Walks all states, samples included, and returns the result without outcome and reason.
  DeploymentResult finish() {
    figures_.begin(found_.path.states.front(), found_.hasCompliantJoints);
    takeSample(0, found_.path.states.front());
    try {
      const InterruptionCatcher catcher;
      for (std::size_t k = 1; k < found_.path.states.size() && !isAskedToEnd_; ++k) step(k);
    } catch (const Interrupted&) {
      isAskedToEnd_ = true;  // within a state that lies between two others
    }
    // The last state is sampled though no sample is due.
    if (lastTime_ < time_ && !isAskedToEnd_) takeSample(time_, *poses_);
    DeploymentResult result;
    static_cast<trajectory::Subject&>(result.trajectory) = trajectory::subjectOf(scene_);
    figures_.leave(result);
    return result;
  }

  bool isInterrupted() const { return isAskedToEnd_ && !isWhole_; }
  double time() const { return time_; }

 private:
  /// When a state is reached, seconds.
  double timeAt(std::size_t state) const {
    const double whole = std::min(scene_.path.walkTime, scene_.stop.duration);
    return found_.path.length() > 0 ? whole * (found_.path.lengths[state] / found_.path.length())
                                    : 0;
  }

  // One state of the path, and the samples that came due on the way to it.
  void step(std::size_t state) {
    const double before = time_;
    const double next = timeAt(state);
    isWhole_ = state + 1 == found_.path.states.size();
    if (!(next > before)) return;  // a state that is the one before but for rounding
    time_ = next;
    const Poses& from = *poses_;
    poses_ = &found_.path.states[state];
    StepReport report;
    report.steps = 1;
    figures_.observe(time_, *poses_, report, found_.hasCompliantJoints);
    for (;;) {
      const double due = static_cast<double>(samples_) * interval_;
      if (!(due <= time_) || isAskedToEnd_) return;
      takeSample(due, between(from, state, (due - before) / (time_ - before)));
    }
  }

  bool isOpen(const Poses& state) const {
    return found_.hasCompliantJoints &&
           trajectory::jointGap(pivots_, state).max > kExactShare * model::tileSize(scene_.model);
  }

  /// A state between one of the path and the one before it, on the cubic through the four states
  /// around it (Lagrange). Straight ways of rounded tiles would open their joints by the square of
  /// a turn.
  Poses smoothBetween(std::size_t state, double share) const {
    const std::vector<Poses>& states = found_.path.states;
    const std::size_t count = std::min(kSmoothStates, states.size());
    const std::size_t first = std::min(state > 2 ? state - 2 : 0, states.size() - count);
    const double time = timeAt(state - 1) + share * (timeAt(state) - timeAt(state - 1));
    Poses poses = states[state - 1];
    std::vector<Vector3> turns(poses.size(), Vector3::Zero());
    for (std::size_t k = first; k < first + count; ++k) {
      double weight = 1;
      for (std::size_t m = first; m < first + count; ++m) {
        if (m == k) continue;
        if (timeAt(m) == timeAt(k)) return interpolate(states[state - 1], states[state], share);
        weight *= (time - timeAt(m)) / (timeAt(k) - timeAt(m));
      }
      for (std::size_t i = 0; i < poses.size(); ++i) {
        const Pose& origin = states[state - 1][i];
        poses[i].position += weight * (states[k][i].position - origin.position);
        turns[i] += weight * turnBetween(origin.rotation, states[k][i].rotation);
      }
    }
    for (std::size_t i = 0; i < poses.size(); ++i) {
      poses[i].rotation = (rotationFromVector(turns[i]) * poses[i].rotation).normalized();
    }
    return poses;
  }

  void keepIfMoreClosed(const Poses& tried, Poses& poses) const {
    if (trajectory::jointGap(pivots_, tried).max < trajectory::jointGap(pivots_, poses).max) {
      poses = tried;
    }
  }

  // A state between two of the path. Where joints are closed in both, the straight state is closed
  // again. Compliant joints that are open need not close, so that only its symmetry is restored.
  Poses between(const Poses& from, std::size_t state, double share) {
    if (share >= 1) return *poses_;
    Poses poses = interpolate(from, *poses_, share);
    if (isOpen(from) || isOpen(*poses_)) {
      if (found_.path.isRounded) keepIfMoreClosed(smoothBetween(state, share), poses);
      return model::symmetricMean(poses, found_.path.symmetries);
    }
    closeInPlace(poses, *projection_);
    symmetries_.restore(poses, *projection_);
    return poses;
  }

  // The observer may end the walk here. Samples that are due within the same step are then left
  // out.
  void takeSample(double time, Poses poses) {
    ++samples_;
    lastTime_ = time;
    const trajectory::Sample sample = figures_.sampleAt(time, std::move(poses));
    isAskedToEnd_ = observer_ && !observer_(sample);
  }

  const scene::Scene& scene_;
  const GeometricPath& found_;
  SymmetricStates symmetries_;
  double interval_;  // seconds
  const SampleObserver& observer_;
  std::vector<model::Brick> bricks_;
  std::vector<model::Pivot> pivots_;
  RunFigures figures_;
  std::unique_ptr<Dynamics> projection_;  // closes joints of states between two others
  const Poses* poses_ = &found_.path.states.front();
  double time_ = 0;      // of the last state, seconds
  double lastTime_ = 0;  // of the last sample, seconds
  long samples_ = 0;
  bool isWhole_ = false;
  bool isAskedToEnd_ = false;
};

/// How a walk ends near a target, `error` metres from it. `nearest`: of a state with closed joints,
/// metres.
std::string endNearTarget(const scene::Scene& scene, const GeometricPath& found, double error,
                          double nearest) {
  if (hasArrived(scene.model, error, nearest)) {
    return fmt::format("the path ends {:.3g} from the target", error);
  }
  const std::string words = fmt::format("the path ends {:.3g} short of the target: ", error);
  if (isNearest(scene.model, error, nearest)) {
    return words + "no state with closed joints was found nearer";
  }
  return words + fmt::format("{}, a state with closed joints {:.3g} from it is known",
                             found.contacts == scene::ContactFilter::None
                                 ? "no path was found that comes nearer"
                                 : "among touching bricks no path was found that comes nearer",
                             nearest);
}

/// How a walk ends that nobody interrupts. Errors as in endNearTarget().
std::string endOf(const scene::Scene& scene, const GeometricPath& found, double error,
                  double nearest) {
  const double tile = model::tileSize(scene.model);
  std::string words = "the path ends at full extension";
  if (scene.model.target) {
    words = endNearTarget(scene, found, error, nearest);
  } else if (found.path.endsAtOpenJoints) {
    words = fmt::format(
        "the path ends at the last state with closed joints: beyond it they open by more than ten "
        "times the last digit, {:g} m, of the model's coordinates",
        scene.model.rounding);
  } else if (standsStill(scene, found.path)) {
    words = fmt::format(
        "{}: no small motion of the mechanism takes them farther apart, so that nothing moves",
        found.contacts == scene::ContactFilter::None
            ? "the tiles are at full extension from the start"
            : "the tiles hold each other at the start");
  }
  if (found.hasCompliantJoints) {
    words += fmt::format(", joints open by up to {:.2g} m ({:.2g} tiles) on it", found.opening,
                         found.opening / tile);
  }
  if (found.path.isRounded && found.isFitMeasured) {
    words +=
        fmt::format("; the model's tiles fit each other to {:.1g} m only", scene.model.rounding);
  } else if (found.path.isRounded) {
    words += fmt::format(
        ", {:.2g} of the last digit, {:g} m, of the model's coordinates: tiles so rounded fit each "
        "other no better",
        found.opening / scene.model.rounding, scene.model.rounding);
  }
  return words;
}

/// Joints that are open at the start as read are closed there, whatever is in the way: says so
/// where that pushes bricks into each other.
void addPushedWarning(const scene::Scene& scene, const Poses& closed, DeploymentResult& result) {
  if (scene.environment.contacts == scene::ContactFilter::None) return;
  const double tile = model::tileSize(scene.model);
  const std::vector<model::Brick> bricks = model::makeBricks(scene.model.tiles, scene.brick);
  const std::vector<model::Pivot> pivots = model::makePivots(scene.model.joints, bricks);
  const Poses asRead = model::startPoses(scene.model.tiles, bricks);
  trajectory::PenetrationMeter meter = overlapMeter(scene.environment, bricks, pivots, asRead);
  const double pushed = meter.at(closed).grown;
  if (pushed <= kClearShare * tile) return;
  result.warnings.push_back(fmt::format(
      "closing the joints of the start, which are open by up to {:.2g} m, pushes bricks {:.2g} m "
      "({:.2g} tiles) into each other",
      trajectory::jointGap(pivots, asRead).max, pushed, pushed / tile));
}

}  // namespace

GeometricPaths findGeometricPaths(const scene::Scene& scene, const TargetFindings& atTarget,
                                  SearchBudget& budget, const TrialObserver& observer) {
  return GeometricSearch(scene, atTarget, budget, observer).find();
}

GeometricPath tracedPath(const scene::Scene& scene, const PathChoice& choice,
                         scene::ContactFilter wanted, const TargetFindings& atTarget,
                         SearchBudget& budget, const TrialObserver& observer) {
  scene::Scene traced = scene;
  traced.stop = scene::StopRules{};  // as in its trial
  bool goesOn = true;
  const auto tell = [&](double) {
    goesOn = goesOn && (!observer || observer({kTracing, budget.share()}));
    return goesOn;
  };
  std::vector<Poses> states;
  RunObservers watch;
  watch.sampleInterval = traced.solver.timestep;
  watch.sample = [&](const trajectory::Sample& sample) {
    states.push_back(sample.poses);
    return tell(1);
  };
  Run run(traced, atTarget.nearest, watch);
  run.beTrial();
  run.keepSymmetries();
  budget.spend(run.finish().cost.took.work);
  GeometricPath found;
  found.hasCompliantJoints = choice.path.jointsAreCompliant();
  found.contacts = traced.environment.contacts;
  found.reason = "states of a run are walked: " + choice.reason;
  found.path = continueTo(traced, std::move(states), atTarget.nearest.poses, budget, tell);
  judge(scene, found, wanted);
  shorten(traced, found, wanted, budget, tell);
  // Joints that were closed at the end may have pushed bricks into each other that had contacts.
  found.passesThrough =
      found.passesThrough || (wanted != scene::ContactFilter::None && !isClear(scene, found));
  return found;
}

GeometricPaths findExtension(const scene::Scene& scene, SearchBudget& budget,
                             const TrialObserver& observer) {
  const scene::ContactFilter wanted = scene.environment.contacts;
  GeometricPaths found = extensions(scene, budget, observer);
  const auto goesOn = [&](double) { return !observer || observer({kShortening, budget.share()}); };
  if (found.clear) shorten(scene, *found.clear, wanted, budget, goesOn);
  if (found.through) shorten(scene, *found.through, wanted, budget, goesOn);
  return found;
}

DeploymentResult walk(const scene::Scene& scene, const GeometricPath& found,
                      const AssembledState& nearest, double sampleInterval,
                      const SampleObserver& observer) {
  const double startSeconds = threadCpuSeconds();
  scene::Scene walked = scene;
  walked.environment.contacts = found.contacts;
  walked.path.kind = scene::PathKind::Continuation;
  Walk walk(walked, found, nearest, sampleInterval, observer);
  DeploymentResult result = walk.finish();
  if (!found.hasCompliantJoints) addPushedWarning(scene, found.path.states.front(), result);
  const double error = result.accuracy.targetErrorEnd;
  if (scene.model.target) {
    result.atTarget = hasArrived(scene.model, error, result.assembledError);
  }
  const bool isShort = result.atTarget == false || found.path.endsAtOpenJoints;
  result.outcome = walk.isInterrupted() ? Outcome::Interrupted
                   : isShort            ? Outcome::Locked
                                        : Outcome::Settled;
  result.reason = walk.isInterrupted() ? "ended early by the caller"
                                       : endOf(scene, found, error, result.assembledError);
  result.trajectory.events.push_back(
      {walk.time(), fmt::format("{}: {}", toString(result.outcome), result.reason)});
  result.needs = scene::sceneNeeds(walked);
  result.needs.contacts = {found.contacts != scene::ContactFilter::None, found.contactReason};
  result.path = walked.path;
  result.pathReason = found.reason;
  result.cost.cpuSeconds = threadCpuSeconds() - startSeconds;
  return result;
}

}  // namespace kirireel::deploy
