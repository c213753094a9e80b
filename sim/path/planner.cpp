// Selection of a kinematic path.
//
// There is one list of candidates (kCandidates), one evaluation (evaluate), one order (isBetter),
// and one stop rule: the search ends at the first path that arrives without overlaps and whose
// joints count as closed (kAllowedOpening). Costly candidates are tried only if none is known whose
// joints open by less than the order counts (kOpeningStep). A candidate has a guide, contacts or
// none, and joints that are exact or of stiffness r. r is relative to the stiffness of one tile's
// position. If a candidate stiffens, its path guides the next one with r ten times as large, as
// long as the joint openings decrease.
//
// Overlaps are measured at the states and between them, as in the run. At the end of a branch of
// the mechanism the path jumps, and its states do not show the overlaps of the jump.
//
// A selected path is improved as a whole if it is rough, overlaps or opens joints (smoothing.cpp).
// If that makes it worse, the original path is kept.
#include "sim/path/planner.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "sim/path/continuation.h"
#include "sim/path/fold_guide.h"
#include "sim/path/smoothing.h"
#include "sim/run/arrival.h"
#include "sim/run/assembled_state.h"
#include "sim/run/dynamics.h"
#include "sim/run/mechanism_path.h"
#include "sim/run/run.h"
#include "sim/scene/scene_needs.h"
#include "sim/trajectory/measures.h"

namespace kirireel::path {
namespace {

// ------------------------------------------------------------------------------------------------
// The candidates.

/// The motion that a candidate follows.
enum class Guide {
  OwnMotion,     ///< each tile's own motion to the goal
  FromTarget,    ///< the same backwards from the goal; joints may be compliant near the start
  GuidedRun,     ///< a run with dynamics in which springs guide the tiles; see guidedRun()
  PreviousPath,  ///< the last path without contacts and with compliant joints
};

struct Candidate {
  Guide guide;
  bool hasContacts;
  double jointStiffness;      ///< see ContinuationSettings
  bool stiffens = false;      ///< whether stiffer joints are tried along the resulting path
  bool isLastResort = false;  ///< tried only if no collision-free path is known

  bool hasExactJoints() const { return std::isinf(jointStiffness); }
  /// Exact joints with contacts cost most from the start on, where bricks often touch.
  bool isCostly() const { return hasContacts && hasExactJoints() && guide != Guide::FromTarget; }
};

// The candidates in the order of the search. The first brings most designs to their targets.
// Without contacts, soft joints give the smoothest paths. These guide the candidates with contacts.
constexpr auto kCandidates = std::to_array<Candidate>({
    {Guide::OwnMotion, false, run::kExactJoints},
    {Guide::FromTarget, true, run::kExactJoints},
    {Guide::OwnMotion, false, 10, true},
    {Guide::GuidedRun, true, run::kExactJoints, false, true},
    {Guide::PreviousPath, true, 10},
    {Guide::PreviousPath, true, 100},
    {Guide::OwnMotion, true, 1e3, true},
    {Guide::OwnMotion, true, 1e2, true, true},
    {Guide::OwnMotion, true, run::kExactJoints},
    {Guide::FromTarget, true, run::kExactJoints, false, true},
});
constexpr double kStiffer = 10;
// Joints are stiffened as long as each step leaves less than this fraction of the opening.
constexpr double kOpeningLeft = 0.9;

/// The candidates of a scene: kCandidates, or those with the scene's own joint ratio.
std::vector<Candidate> candidatesOf(const scene::PathSettings& path) {
  if (!path.jointsAreCompliant()) return {kCandidates.begin(), kCandidates.end()};
  return {{Guide::OwnMotion, false, path.jointRatio},
          {Guide::PreviousPath, true, path.jointRatio},
          {Guide::OwnMotion, true, path.jointRatio, false, true}};
}

/// The name of a candidate in summary.json.
std::string candidateName(const char* guide, bool hasContacts, double jointStiffness) {
  return fmt::format("{}, contacts {}, {}", guide, hasContacts ? "on" : "off",
                     std::isinf(jointStiffness) ? "exact joints"
                                                : fmt::format("joint ratio {:g}", jointStiffness));
}

std::string candidateName(const Candidate& candidate) {
  const char* guide = candidate.guide == Guide::OwnMotion    ? "motion of each tile"
                      : candidate.guide == Guide::FromTarget ? "backwards from the target"
                      : candidate.guide == Guide::GuidedRun  ? "guided run"
                                                             : "previous path";
  return candidateName(guide, candidate.hasContacts, candidate.jointStiffness);
}

// A candidate may use this fraction of the budget, and the same again for each fifth of the guide
// that it has followed.
constexpr double kPathShare = 0.1;
constexpr double kParts = 5;
// Duration of a guided run in periods of the springs, and the number of its states.
constexpr double kRunPeriods = 12;
constexpr double kGuidedStates = 200;
// A final move to the nearest state is at most this fraction of a tile.
constexpr double kLastMove = 1e-3;
// One path to full extension may use this fraction of the budget, the last one all of it.
constexpr double kExtensionShare = 0.6;
// ------------------------------------------------------------------------------------------------
// The evaluation.

// Number of frames for roughness, and the angle above which a frame is rough, radians.
constexpr int kFrames = 360;
constexpr double kRoughAngle = 30 * kDegree;

/// The vertices of all tiles.
std::vector<Vector3> verticesOf(const std::vector<brick::Brick>& bricks, const Poses& poses) {
  std::vector<Vector3> vertices;
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    for (const Vector3& point : bricks[i].bottom) vertices.push_back(poses[i].apply(point));
  }
  return vertices;
}

/// Measures the variation of the tiles' motion between frames, along a path at constant speed.
void measureRoughness(const std::vector<brick::Brick>& bricks, const run::MechanismPath& path,
                      run::PathEvaluation& evaluation) {
  evaluation.roughFrames = 0;
  evaluation.stepChange = evaluation.largestTurn = 0;
  if (!(path.length() > 0)) return;
  Poses before = path.states.front();
  std::vector<Vector3> vertices = verticesOf(bricks, before), steps;
  Eigen::VectorXd velocities;  // relative to the time between frames
  std::vector<double> meanSteps;
  for (int frame = 1; frame <= kFrames; ++frame) {
    Poses now = path.at(static_cast<double>(frame) / kFrames);
    std::vector<Vector3> there = verticesOf(bricks, now);
    Eigen::VectorXd fresh = run::displacement(bricks, before, now);
    if (velocities.size() > 0) {
      const double norms = fresh.norm() * velocities.norm();
      const double cosine = norms > 0 ? std::clamp(fresh.dot(velocities) / norms, -1.0, 1.0) : 1;
      const double turn = std::acos(cosine);
      evaluation.largestTurn = std::max(evaluation.largestTurn, turn);
      if (turn > kRoughAngle) ++evaluation.roughFrames;
    }
    double sum = 0;
    for (std::size_t k = 0; k < there.size(); ++k) {
      const Vector3 step = there[k] - vertices[k];
      sum += step.norm();
      if (frame == 1) {
        steps.push_back(step);
        continue;
      }
      evaluation.stepChange = std::max(evaluation.stepChange, (step - steps[k]).norm());
      steps[k] = step;
    }
    meanSteps.push_back(sum / static_cast<double>(there.size()));
    before = std::move(now);
    vertices = std::move(there);
    velocities = std::move(fresh);
  }
  const auto middle = meanSteps.begin() + kFrames / 2;
  std::ranges::nth_element(meanSteps, middle);
  evaluation.stepChange = *middle > 0 ? evaluation.stepChange / *middle : 0;
}

/// Whether the scene allows contacts.
bool mayTouch(const scene::Scene& scene) {
  return scene.environment.contacts != scene::ContactFilter::None;
}

/// Measures a path except for its end, error and work. The scene has the contacts that were
/// requested.
void evaluate(const scene::Scene& scene, run::GeometricPath& found) {
  const std::vector<brick::Brick> bricks = brick::makeBricks(scene.model.tiles, scene.brick);
  const std::vector<brick::Pivot> pivots = brick::makePivots(scene.model.joints, bricks);
  const std::vector<Poses>& states = found.path.states;
  run::PathEvaluation& evaluation = found.evaluation;
  trajectory::PenetrationMeter meter =
      run::overlapMeter(scene.environment, bricks, pivots, states.front());
  run::StatesBetween between(scene, found);
  evaluation.overlapGrowth = evaluation.overlapGrowthAtEnd = evaluation.opening = 0;
  const auto noteOpening = [&](const Poses& poses) {
    evaluation.opening = std::max(evaluation.opening, trajectory::jointGap(pivots, poses).max);
  };
  if (found.hasCompliantJoints) noteOpening(states.front());
  for (std::size_t k = 1; k < states.size(); ++k) {
    if (found.hasCompliantJoints) {
      noteOpening(between.at(k, 0.5));
      noteOpening(states[k]);
    }
    if (!mayTouch(scene)) continue;
    const std::vector<Poses> moments = between.moments(k);
    std::vector<const Poses*> measured;
    for (const Poses& moment : moments) measured.push_back(&moment);
    measured.push_back(&states[k]);
    constexpr double kAny = std::numeric_limits<double>::infinity();
    evaluation.overlapGrowth =
        meter.atLeastEach({kAny, kAny, evaluation.overlapGrowth}, measured).back().grown;
  }
  if (mayTouch(scene)) evaluation.overlapGrowthAtEnd = meter.grownAt(states.back());
  evaluation.length = found.path.length();
  measureRoughness(bricks, found.path, evaluation);
}

// ------------------------------------------------------------------------------------------------
// The order.

// Openings that differ by less than this fraction of a tile are equal.
constexpr double kOpeningStep = 0.02;

/// Whether a path is better than another. A path with folds on the wrong side comes last. A path
/// that arrives without overlaps comes first. Next is the smaller opening in steps of kOpeningStep,
/// then smoothness, then the exact opening. With overlaps, the smaller overlap is better. Before
/// the target, the nearer end is better. If the user requests contacts, a path with overlaps is the
/// last choice.
class PathOrder {
 public:
  explicit PathOrder(const scene::Scene& scene)
      : tile_(model::tileSize(scene.model)),
        mustTouch_(mayTouch(scene) && scene.environment.contacts != scene::ContactFilter::Auto) {}

  bool isBetter(const run::PathEvaluation& a, const run::PathEvaluation& b) const {
    return keyOf(a) < keyOf(b);
  }

 private:
  using Key = std::tuple<int, double, int, double>;

  Key keyOf(const run::PathEvaluation& path) const {
    const bool arrives = path.end == run::PathEnd::Arrived;
    const bool isOverlapping = path.overlapGrowth > run::kAllowedOverlap * tile_;
    if (arrives && !isOverlapping) {
      return {0, std::floor(path.opening / (kOpeningStep * tile_)), path.roughFrames, path.opening};
    }
    if (path.end == run::PathEnd::WrongFolds) {
      return {4, path.overlapGrowth, path.roughFrames, path.opening};
    }
    if (isOverlapping && (arrives || mustTouch_)) {
      return {mustTouch_ ? 3 : 1, path.overlapGrowth, path.roughFrames, path.opening};
    }
    return {2, path.error, path.roughFrames, path.opening};
  }

  double tile_;     // metres
  bool mustTouch_;  // the user requests contacts
};

// ------------------------------------------------------------------------------------------------
// Improvement of the selected path.

// A path is smooth if no step changes by more than this fraction of the typical step. The
// velocities of all tiles together must rotate by at most kSmoothTurn between frames, radians.
constexpr double kSmoothStepChange = 0.2;
constexpr double kSmoothTurn = 10 * kDegree;
// Bricks with a larger overlap, as a fraction of a tile, are not pushed apart: another path is
// needed.
constexpr double kSmallOverlap = 0.1;
// Smoothing has a budget of its own: this fraction of the search's. Paths with open joints have
// another one. One path may use half of a budget.
constexpr double kSmoothingShare = 0.2;
constexpr double kOpenSmoothingShare = 4;

/// Improves a path as a whole if it is rough, overlaps or opens joints. Keeps the improved path if
/// it is smoother, opens less or no longer overlaps, without larger overlaps or openings that
/// count. Returns the figures of the improved path, if there is one.
std::optional<run::PathEvaluation> improve(const scene::Scene& scene, run::GeometricPath& found,
                                           run::SearchBudget& budget,
                                           const PathObserver& shouldContinue) {
  const run::PathEvaluation& before = found.evaluation;
  const double tile = model::tileSize(scene.model);
  const double allowed = run::kAllowedOverlap * tile;
  const auto isSmooth = [](const run::PathEvaluation& path) {
    return path.stepChange <= kSmoothStepChange && path.largestTurn <= kSmoothTurn;
  };
  if (isSmooth(before) && before.overlapGrowth <= allowed && before.opening == 0)
    return std::nullopt;
  run::SearchBudget part(std::min(budget.left(), 0.5 * budget.all()));
  run::GeometricPath better = found;
  const bool arePushedApart = mayTouch(scene) && before.overlapGrowth <= kSmallOverlap * tile;
  const scene::ContactFilter contacts =
      arePushedApart ? contactsIfOn(scene.environment.contacts) : scene::ContactFilter::None;
  auto path = smoothed(scene, found, contacts, part, shouldContinue);
  budget.spend(part.spent());
  if (!path) return std::nullopt;
  better.path = *std::move(path);
  // Without overlaps on the found path, a path near it needs no contacts.
  if (before.overlapGrowth > allowed) better.contacts = contacts;
  evaluate(scene, better);
  run::PathEvaluation& after = better.evaluation;
  const std::string prefix = "smoothed: ";
  if (!before.candidate.starts_with(prefix)) after.candidate = prefix + before.candidate;
  after.work = part.spent();
  const run::PathEvaluation improved = after;
  const bool isFreed = before.overlapGrowth > allowed && after.overlapGrowth <= allowed;
  // Smaller openings are equal, but tiles of rounded coordinates stay closed within the rounding. A
  // path without overlaps may open more.
  const double closed = found.path.isRounded ? run::roundedGap(scene.model)
                        : isFreed            ? std::numeric_limits<double>::infinity()
                                             : kOpeningStep * tile;
  const bool isImproved = isFreed || after.stepChange < before.stepChange ||
                          (isSmooth(after) && after.opening < before.opening);
  if (isImproved && after.overlapGrowth <= std::max(before.overlapGrowth, allowed) &&
      after.opening <= std::max(before.opening, closed)) {
    found = std::move(better);
  }
  return improved;
}

// ------------------------------------------------------------------------------------------------
// Description of a path, for the summary.

const char* const kSmoothing = "smoothing of the path";
const char* const kExtending = "the path to full extension";

/// Sets the reasons for the path and its contacts, from its figures.
void addReasons(const scene::Scene& scene, run::GeometricPath& found) {
  const bool isTouching = found.contacts != scene::ContactFilter::None;
  const bool isOverlapping = overlaps(scene, found);
  found.contactReason = !mayTouch(scene)              ? "not requested"
                        : isTouching && isOverlapping ? "bricks touch on the path, and some overlap"
                        : isTouching                  ? "bricks touch on the path"
                        : isOverlapping ? "bricks overlap, and no path with contacts was found"
                                        : "no bricks touch on the path";
  const bool isOpen = found.hasCompliantJoints && !found.path.isRounded;
  const double opening = found.evaluation.opening;
  found.reason = fmt::format(
      "kinematic path{}{}", isTouching ? " with contacts" : "",
      isOpen
          ? fmt::format(", compliant joints open by up to {}: no path with exact joints was found",
                        model::lengthInTiles(opening, scene.model))
          : "");
}

// ------------------------------------------------------------------------------------------------
// The search.

class Planner {
 public:
  Planner(const scene::Scene& scene, const run::AssembledState& nearest, run::SearchBudget& budget,
          const run::TrialObserver& observer, bool mustBeClosed)
      : scene_(scene),
        nearest_(nearest),
        mustBeClosed_(mustBeClosed),
        order_(scene),
        budget_(budget),
        observer_(observer),
        tile_(model::tileSize(scene.model)),
        bricks_(brick::makeBricks(scene.model.tiles, scene.brick)),
        pivots_(brick::makePivots(scene.model.joints, bricks_)),
        start_(brick::startPoses(scene.model.tiles, bricks_)),
        folds_(nearest.poses, scene.model, bricks_, pivots_) {}

  PlannedPath find() {
    for (const Candidate& candidate : candidatesOf(scene_.path)) {
      if (planned_.path && candidate.isCostly() && !isBlocked()) improveSelected();
      if (planned_.path && (isOver_ || !isWorthTrying(candidate))) continue;
      if (planned_.path && budget_.isSpent()) {
        planned_.isCutShort = true;
        break;
      }
      tryCandidate(candidate);
      if (!budget_.isLimited()) limitBudget();
      if (mayEndSearch()) improveSelected();
      if (isGood(*planned_.path, run::kAllowedOpening)) break;
    }
    improveSelected();
    // A candidate that ran out of budget matters only if no other is collision-free.
    planned_.isCutShort =
        planned_.isCutShort ||
        (!isCollisionFree(scene_, *planned_.path) &&
         std::ranges::any_of(planned_.candidates, [](const run::PathEvaluation& candidate) {
           return candidate.end == run::PathEnd::OutOfBudget;
         }));
    addReasons(scene_, *planned_.path);
    return std::move(planned_);
  }

 private:
  /// Whether joints open by less than a fraction of a tile, or are compliant by request.
  bool isClosed(const run::GeometricPath& found, double opening) const {
    return found.path.isRounded || scene_.path.jointsAreCompliant() ||
           found.evaluation.opening < opening * tile_;
  }

  bool isGood(const run::GeometricPath& found, double opening) const {
    return isClosed(found, opening) && isCollisionFree(scene_, found);
  }

  /// Whether the selected path, improved, could end the search. A path with contacts overlaps only
  /// between its states.
  bool mayEndSearch() const {
    const run::GeometricPath& found = *planned_.path;
    return isClosed(found, run::kAllowedOpening) &&
           (found.evaluation.hasContacts || !overlaps(scene_, found));
  }

  /// Improves the selected path, if it arrives. Continues later if overlaps remain.
  void improveSelected() {
    run::GeometricPath& selected = *planned_.path;
    if (isImproved_ || selected.evaluation.end != run::PathEnd::Arrived) return;
    if (mustBeClosed_ && !isClosed(selected, run::kAllowedOpening)) return;
    const double before = selected.evaluation.overlapGrowth;
    run::SearchBudget& budget =
        isClosed(selected, run::kAllowedOpening) ? smoothing_ : openSmoothing_;
    const auto improved =
        improve(scene_, selected, budget, [&](double) { return report(kSmoothing); });
    if (improved) planned_.candidates.push_back(*improved);
    isImproved_ = !overlaps(scene_, selected) || !(selected.evaluation.overlapGrowth < before);
  }

  /// Limits the search by the work of the first candidate. If this was stuck early, its work is
  /// scaled to kMinStates states.
  void limitBudget() {
    const auto states = static_cast<double>(planned_.path->path.states.size());
    const double work = planned_.candidates.front().work * std::max(1.0, kMinStates / states);
    budget_.limitByFirst(work, scene_.path.searchEffort);
    smoothing_ = run::SearchBudget(kSmoothingShare * budget_.left());
    openSmoothing_ = run::SearchBudget(kOpenSmoothingShare * budget_.left());
  }

  bool isWorthTrying(const Candidate& candidate) {
    const bool isRun = candidate.guide == Guide::GuidedRun;
    if (candidate.hasContacts && !mayTouch(scene_) && !isRun) return false;
    // Bricks that overlap at the goal block any path with contacts. One such path then shows where
    // the sheet stops.
    if (isBlocked()) {
      const bool isStiffest = candidate.hasExactJoints() || scene_.path.jointsAreCompliant();
      return candidate.hasContacts ? candidate.guide == Guide::OwnMotion && isStiffest
                                   : !firstArrives();
    }
    // If exact joints do not arrive without contacts, they do not arrive with contacts either,
    // except along another motion. From the target back they are then the last resort, as they cost
    // most there.
    const bool isBackAtLast = candidate.guide == Guide::FromTarget && candidate.isLastResort;
    if (candidate.hasExactJoints() && firstArrives() == isBackAtLast && !isRun) return false;
    if (candidate.isLastResort && isCollisionFree(scene_, *planned_.path)) return false;
    if (candidate.guide == Guide::PreviousPath) return !previous_.empty();
    if (isRun) return scene_.springs.pull();
    return !candidate.isCostly() || !isGood(*planned_.path, kOpeningStep);
  }

  /// Whether the first candidate, whose joints are exact, arrives.
  bool firstArrives() const {
    return !planned_.candidates.empty() && planned_.candidates.front().end == run::PathEnd::Arrived;
  }

  /// Whether bricks that may touch overlap at the goal by more than at the start.
  bool isBlocked() {
    if (!isBlocked_) isBlocked_ = mayTouch(scene_) && growthAt(nearest_.poses) > allowedGrowth();
    return *isBlocked_;
  }

  double allowedGrowth() const { return run::kAllowedOverlap * tile_; }

  /// The growth of overlaps at a state, for bricks that may touch, metres.
  double growthAt(const Poses& state) const {
    return run::overlapMeter(scene_.environment, bricks_, pivots_, start_).grownAt(state);
  }

  void tryCandidate(Candidate candidate) {
    candidate.hasContacts = candidate.hasContacts && mayTouch(scene_);
    std::vector<Poses> guide = candidate.guide == Guide::PreviousPath ? previous_
                               : candidate.guide == Guide::GuidedRun  ? guidedRun()
                                                                      : folds_.from(start_);
    std::optional<run::PathEvaluation> last;
    while (true) {
      run::GeometricPath found = follow(candidate, guide);
      const run::PathEvaluation evaluation = found.evaluation;
      const bool arrives = evaluation.end == run::PathEnd::Arrived;
      if (arrives) guide = found.path.states;
      const bool isBack = candidate.guide == Guide::FromTarget;
      consider(std::move(found), isBack && !arrives);
      const bool isStiffer = !last || evaluation.opening < kOpeningLeft * last->opening;
      if (!arrives || !isStiffer || isOver_) break;
      if (!candidate.hasContacts && !candidate.hasExactJoints()) previous_ = guide;
      if (!candidate.stiffens) break;
      if (candidate.hasContacts && evaluation.overlapGrowth > allowedGrowth()) break;
      last = evaluation;
      candidate.jointStiffness *= kStiffer;
      candidate.guide = Guide::PreviousPath;
    }
  }

  /// The states of a run with dynamics in which springs guide the tiles to the target. Where a
  /// kinematic path jams or leads nowhere, their inertia can take bricks past each other.
  std::vector<Poses> guidedRun() {
    scene::Scene trial = scene_;
    trial.environment.contacts = contactsIfOn(scene_.environment.contacts);
    trial.stop = scene::StopRules{};
    trial.path = {scene::PathKind::Guided};
    trial.path.guideTime = kRunPeriods / scene_.springs.frequency;
    std::vector<Poses> states;
    const run::Run* running = nullptr;  // the run's constructor already takes the first sample
    run::RunObservers watch;
    watch.sampleInterval = trial.path.guideTime / kGuidedStates;
    watch.sample = [&](const trajectory::Sample& sample) {
      states.push_back(sample.poses);
      return report("guided run") &&
             (!running || running->cost().took.work <= kParts * kPathShare * budget_.left());
    };
    run::Run run(trial, nearest_, watch);
    running = &run;
    run.markAsTrial();
    budget_.spend(run.finish().cost.took.work);
    states.push_back(nearest_.poses);
    return states;
  }

  /// Follows a guide and evaluates the path.
  run::GeometricPath follow(const Candidate& candidate, const std::vector<Poses>& guide) {
    scene::Scene trial = scene_;
    run::GeometricPath found;
    found.contacts = candidate.hasContacts ? contactsIfOn(scene_.environment.contacts)
                                           : scene::ContactFilter::None;
    trial.environment.contacts = found.contacts;
    found.evaluation.candidate = candidateName(candidate);
    found.evaluation.hasContacts = candidate.hasContacts;
    run::SearchBudget part(budget_.left());
    const bool isBack = candidate.guide == Guide::FromTarget;
    const auto shouldContinue = [&](double progress) {
      const double share = kPathShare * (1 + (kParts - 1) * progress);
      return report(found.evaluation.candidate) && part.spent() <= share * budget_.all();
    };
    found.hasCompliantJoints = !candidate.hasExactJoints() || isBack;
    if (isBack) {
      found.path = continueFromGoal(trial, folds_.from(closedStart_), part, shouldContinue);
    } else {
      // If bricks are flush at the start, a jump off it would jam them.
      ContinuationSettings settings;
      if (candidate.hasContacts || found.hasCompliantJoints) settings.jump = 0;
      settings.jointStiffness = candidate.jointStiffness;
      found.path = continueAlong(trial, guide, settings, part, shouldContinue);
    }
    endAtNearest(found.path);
    if (closedStart_.empty()) closedStart_ = found.path.states.front();
    found.hasCompliantJoints = found.hasCompliantJoints || found.path.isRounded;
    budget_.spend(part.spent());
    found.evaluation.work = part.spent();
    found.evaluation.error = found.path.error;
    found.evaluation.end = endOf(found.path);
    evaluate(scene_, found);
    if (!found.path.isRounded && found.evaluation.opening <= model::kClosedShare * tile_) {
      found.hasCompliantJoints = false;
    }
    return found;
  }

  /// Ends a path at the known nearest state if it comes near it, unless bricks overlap deeper
  /// there. Tiles of rounded coordinates come near it only within the rounding's reach. In a
  /// singular state, a gap of that size is a rotation by its square root.
  void endAtNearest(run::MechanismPath& path) const {
    if (path.isStuck || path.isCutShort) return;
    if (run::isNearest(scene_.model, path.error, nearest_.error)) return;
    const bool isRounded = std::isfinite(run::roundedJointStiffness(scene_.model));
    const double reach =
        isRounded ? std::sqrt(run::roundedReach(scene_.model) * tile_) : kLastMove * tile_;
    if (run::farthestMove(path.states.back(), nearest_.poses, tile_) > reach) return;
    const double gap = trajectory::jointGap(pivots_, nearest_.poses).max;
    if (!isRounded && gap > model::kClosedShare * tile_) return;
    const double grown = growthAt(path.states.back());
    if (mayTouch(scene_) && growthAt(nearest_.poses) > std::max(grown, allowedGrowth())) return;
    path.lengths.push_back(path.length() +
                           run::pathDistance(bricks_, path.states.back(), nearest_.poses));
    path.states.push_back(nearest_.poses);
    path.error = nearest_.error;
    path.isRounded = isRounded;
  }

  run::PathEnd endOf(const run::MechanismPath& path) const {
    if (path.isCutShort) return run::PathEnd::OutOfBudget;
    if (path.isStuck) return run::PathEnd::Stuck;
    if (!run::isNearestRounded(scene_.model, path.error, nearest_.error)) {
      return run::PathEnd::Short;
    }
    return folds_.isOnWrongSide(path.at(0.5)) ? run::PathEnd::WrongFolds : run::PathEnd::Arrived;
  }

  /// Records a path. Selects it if it is the best so far and begins at the start.
  void consider(run::GeometricPath found, bool isWithoutStart) {
    const run::PathEvaluation& evaluation = found.evaluation;
    planned_.candidates.push_back(evaluation);
    if (isWithoutStart) return;
    if (planned_.path && !order_.isBetter(evaluation, planned_.path->evaluation)) return;
    planned_.path = std::move(found);
    isImproved_ = false;
  }

  /// Reports what is being tried. Returns whether to continue.
  bool report(const std::string& what) {
    isOver_ = isOver_ || (observer_ && !observer_({what, budget_.share()}));
    return !isOver_;
  }

  const scene::Scene& scene_;
  const run::AssembledState& nearest_;
  bool mustBeClosed_;
  PathOrder order_;
  run::SearchBudget& budget_;
  run::SearchBudget smoothing_;      // of selected paths with closed joints
  run::SearchBudget openSmoothing_;  // of selected paths with open joints
  const run::TrialObserver& observer_;
  double tile_;  // metres
  std::vector<brick::Brick> bricks_;
  std::vector<brick::Pivot> pivots_;
  Poses start_, closedStart_;  // as read, and with closed joints
  FoldGuide folds_;
  std::vector<Poses> previous_;  // the last path without contacts and with compliant joints
  std::optional<bool> isBlocked_;
  PlannedPath planned_;
  bool isImproved_ = false;  // the selected path
  bool isOver_ = false;
};

// ------------------------------------------------------------------------------------------------
// Full extension.

/// The path to full extension with these contacts and joints. It may use a share of the remaining
/// budget.
run::GeometricPath extension(const scene::Scene& scene, scene::ContactFilter contacts,
                             double jointStiffness, double share, run::SearchBudget& budget,
                             const run::TrialObserver& observer) {
  scene::Scene trial = scene;
  trial.environment.contacts = contacts;
  run::SearchBudget part(share * budget.left());
  run::GeometricPath found;
  found.path = continueToExtension(trial, jointStiffness, part, [&](double) {
    return !observer || observer({kExtending, budget.share()});
  });
  budget.spend(part.spent());
  found.hasCompliantJoints = found.path.isRounded || std::isfinite(jointStiffness);
  found.contacts = contacts;
  found.evaluation.hasContacts = contacts != scene::ContactFilter::None;
  found.evaluation.candidate =
      candidateName("full extension", found.evaluation.hasContacts, jointStiffness);
  found.evaluation.work = part.spent();
  found.evaluation.end = found.path.isCutShort ? run::PathEnd::OutOfBudget : run::PathEnd::Arrived;
  evaluate(scene, found);
  return found;
}

}  // namespace

scene::ContactFilter contactsIfOn(scene::ContactFilter requested) {
  return requested == scene::ContactFilter::Auto ? scene::ContactFilter::All : requested;
}

bool overlaps(const scene::Scene& scene, const run::GeometricPath& found) {
  return found.evaluation.overlapGrowth > run::kAllowedOverlap * model::tileSize(scene.model);
}

bool isCollisionFree(const scene::Scene& scene, const run::GeometricPath& found) {
  return found.evaluation.end == run::PathEnd::Arrived && !overlaps(scene, found);
}

PlannedPath planPath(const scene::Scene& scene, const run::AssembledState& nearest,
                     run::SearchBudget& budget, const run::TrialObserver& observer,
                     bool mustBeClosed) {
  return Planner(scene, nearest, budget, observer, mustBeClosed).find();
}

bool extendsFarther(const run::GeometricPath& path, const run::GeometricPath& other) {
  constexpr double kFarther = 1.02;
  return path.path.length() > kFarther * other.path.length();
}

// Flush bricks may block each other. If the scene leaves contacts open, a sheet that does not move
// is not accepted. Tiles that do not fit each other may lock long before full extension. Joints
// that open by less than kOpeningStep then lead farther.
PlannedPath planExtension(const scene::Scene& scene, run::SearchBudget& budget,
                          const run::TrialObserver& observer) {
  const scene::ContactFilter requested = scene.environment.contacts;
  PlannedPath planned;
  const auto consider = [&](run::GeometricPath found) {
    planned.candidates.push_back(found.evaluation);
    planned.isCutShort = planned.isCutShort || found.path.isCutShort;
    const bool isHeld = requested == scene::ContactFilter::Auto && planned.path &&
                        !run::isExtension(scene, found.path);
    const bool isBetter =
        !planned.path || PathOrder(scene).isBetter(found.evaluation, planned.path->evaluation);
    if (isBetter && !isHeld) planned.path = std::move(found);
  };
  const double ratio = scene.path.jointRatio;
  consider(extension(scene, scene::ContactFilter::None, ratio, kExtensionShare, budget, observer));
  budget.limitByFirst(planned.candidates.front().work, scene.path.searchEffort);
  if (mayTouch(scene) && !isCollisionFree(scene, *planned.path)) {
    consider(extension(scene, contactsIfOn(requested), ratio, 1, budget, observer));
  }
  if (planned.path->path.isRounded) {
    run::GeometricPath open = extension(scene, planned.path->contacts, run::kMisfitRatio,
                                        kExtensionShare, budget, observer);
    planned.candidates.push_back(open.evaluation);
    const bool isClosed = !open.path.endsAtOpenJoints &&
                          open.evaluation.opening < kOpeningStep * model::tileSize(scene.model);
    const bool isBetter =
        !isCollisionFree(scene, *planned.path) || extendsFarther(open, *planned.path);
    if (isClosed && isBetter && isCollisionFree(scene, open)) planned.path = std::move(open);
  }
  run::SearchBudget smoothing(kSmoothingShare * budget.left());
  const auto improved = improve(scene, *planned.path, smoothing, [&](double) {
    return !observer || observer({kSmoothing, budget.share()});
  });
  if (improved) planned.candidates.push_back(*improved);
  addReasons(scene, *planned.path);
  return planned;
}

std::string overlapWarning(const scene::Scene& scene, const PlannedPath& planned) {
  if (!overlaps(scene, *planned.path)) return "";
  const double tile = model::tileSize(scene.model);
  const run::PathEvaluation& path = planned.path->evaluation;
  const std::string words = fmt::format("tiles overlap by up to {} on the path",
                                        model::lengthInTiles(path.overlapGrowth, scene.model));
  if (path.overlapGrowthAtEnd > run::kAllowedOverlap * tile) {
    const auto touching = std::ranges::find_if(
        planned.candidates, [](const auto& candidate) { return candidate.hasContacts; });
    const bool isStopKnown = touching != planned.candidates.end() && scene.model.target;
    return words +
           fmt::format(", and by {} at its end. {}`contacts = all` shows where the sheet stops",
                       lengthText(path.overlapGrowthAtEnd, scene.model.unit, 2),
                       isStopKnown ? fmt::format("With contacts it ends {} short of the target. ",
                                                 lengthText(touching->error, scene.model.unit))
                                   : "");
  }
  const std::string thinner =
      scene::sceneNeeds(scene).planar.on
          ? ""
          : fmt::format("`thickness = {:.2g}`, ",
                        0.25 * scene.brick.thickness / scene.model.unit.metres);
  return words +
         fmt::format(
             ". No collision-free path was found. Try {}a larger `search_effort`, or `contacts = "
             "all` to see where the sheet stops",
             thinner);
}

}  // namespace kirireel::path
