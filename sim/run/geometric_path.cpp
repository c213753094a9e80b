// Playback of a path.
//
// The speed is constant: state k is reached at T L_k / L, with L_k the path's length up to it
// (pathDistance) and T the playback time. Samples are interpolated, with joints closed again.
#include "sim/run/geometric_path.h"

#include <algorithm>

#include <fmt/format.h>

#include "sim/base/interruption.h"
#include "sim/run/arrival.h"
#include "sim/run/assembled_state.h"
#include "sim/run/dynamics.h"
#include "sim/run/mechanism_path.h"
#include "sim/run/run_figures.h"
#include "sim/run/state_interpolator.h"
#include "sim/scene/scene_needs.h"
#include "sim/trajectory/measures.h"

namespace kirireel::run {
namespace {

// A shorter extension, as a fraction of a tile, does not count.
constexpr double kMinExtension = 1e-3;

// Number of states that interpolate a path of rounded tiles.
constexpr std::size_t kSmoothStates = 4;

/// Plays back one path.
class Playback {
 public:
  Playback(const scene::Scene& scene, const GeometricPath& found, const AssembledState& nearest,
           double sampleInterval, const SampleObserver& observer)
      : scene_(scene),
        found_(found),
        interval_(sampleInterval),
        observer_(observer),
        bricks_(brick::makeBricks(scene.model.tiles, scene.brick)),
        pivots_(brick::makePivots(scene.model.joints, bricks_)),
        figures_(scene.model, bricks_, pivots_, scene.environment.pivotZone,
                 brick::startPoses(scene.model.tiles, bricks_), nearest),
        between_(scene, found) {}

  // Plays back all states and samples. Returns the result without outcome and reason.
  DeploymentResult finish() {
    figures_.begin(found_.path.states.front(), found_.hasCompliantJoints);
    takeSample(0, found_.path.states.front());
    try {
      const InterruptionCatcher catcher;
      for (std::size_t k = 1; k < found_.path.states.size() && !shouldStop_; ++k) step(k);
    } catch (const Interrupted&) {
      shouldStop_ = true;  // interrupted while a state was interpolated
    }
    // The last state is always sampled.
    if (lastTime_ < time_ && !shouldStop_) takeSample(time_, *poses_);
    DeploymentResult result;
    static_cast<trajectory::Subject&>(result.trajectory) = trajectory::subjectOf(scene_);
    figures_.copyTo(result);
    return result;
  }

  bool isInterrupted() const { return shouldStop_ && !isWhole_; }
  double time() const { return time_; }

 private:
  /// The time of a state, seconds.
  double timeAt(std::size_t state) const {
    const double whole = std::min(scene_.path.playTime, scene_.stop.duration);
    return found_.path.length() > 0 ? whole * (found_.path.lengths[state] / found_.path.length())
                                    : 0;
  }

  // One state of the path, and the samples that are due before it.
  void step(std::size_t state) {
    const double before = time_;
    const double next = timeAt(state);
    isWhole_ = state + 1 == found_.path.states.size();
    if (!(next > before)) return;  // equal to the previous state up to rounding
    time_ = next;
    poses_ = &found_.path.states[state];
    StepReport report;
    report.steps = 1;
    const StatesWithin within = {before, between_.moments(state)};
    figures_.observe(time_, *poses_, report, found_.hasCompliantJoints, within);
    for (;;) {
      const double due = static_cast<double>(samples_) * interval_;
      if (!(due <= time_) || shouldStop_) return;
      takeSample(due, between_.at(state, (due - before) / (time_ - before)));
    }
  }

  // The observer may end the playback here. Further samples of the same step are then omitted.
  void takeSample(double time, Poses poses) {
    ++samples_;
    lastTime_ = time;
    const trajectory::Sample sample = figures_.sampleAt(time, std::move(poses));
    shouldStop_ = observer_ && !observer_(sample);
  }

  const scene::Scene& scene_;
  const GeometricPath& found_;
  double interval_;  // seconds
  const SampleObserver& observer_;
  std::vector<brick::Brick> bricks_;
  std::vector<brick::Pivot> pivots_;
  RunFigures figures_;
  StatesBetween between_;
  const Poses* poses_ = &found_.path.states.front();
  double time_ = 0;      // of the current state, seconds
  double lastTime_ = 0;  // of the last sample, seconds
  long samples_ = 0;
  bool isWhole_ = false;
  bool shouldStop_ = false;
};

/// How a path ends near a target, `error` metres away. `nearest`: smallest error of a state with
/// closed joints, metres.
std::string endNearTarget(const scene::Scene& scene, const GeometricPath& found, double error,
                          double nearest) {
  const LengthUnit& unit = scene.model.unit;
  if (hasArrived(scene.model, error, nearest)) {
    return fmt::format("the path ends {} from the target", lengthText(error, unit));
  }
  const std::string words =
      fmt::format("the path ends {} short of the target: ", lengthText(error, unit));
  if (isNearest(scene.model, error, nearest)) {
    return words + "no nearer state with closed joints was found";
  }
  return words + fmt::format("{}, although a state with closed joints exists {} from the target",
                             found.contacts == scene::ContactFilter::None
                                 ? "no nearer path was found"
                                 : "no nearer path with contacts was found",
                             lengthText(nearest, unit));
}

/// How a complete path ends. Errors as in endNearTarget().
std::string endOf(const scene::Scene& scene, const GeometricPath& found, double error,
                  double nearest) {
  const bool hasContacts = found.contacts != scene::ContactFilter::None;
  std::string words = hasContacts ? "the path ends at the largest extension found with contacts"
                                  : "the path ends at full extension";
  if (scene.model.target) {
    words = endNearTarget(scene, found, error, nearest);
  } else if (!found.closedWords.empty()) {
    words = found.closedWords;
  } else if (found.path.endsAtOpenJoints && found.hasCompliantJoints && !found.path.isRounded) {
    words = "the path ends at full extension, where joints do not close";
  } else if (found.path.endsAtOpenJoints) {
    words = "the path ends at the last state with closed joints. Beyond it they open";
    words +=
        scene.model.rounding > 0
            ? fmt::format(" by more than ten times {}, to which the model's tiles fit each other",
                          lengthText(scene.model.rounding, scene.model.unit, 1))
            : ", because the tiles do not fit each other";
  } else if (found.path.isCutShort) {
    words = "the path ends where the search stopped";
  } else if (!isExtension(scene, found.path)) {
    words = fmt::format(
        "{}. No small motion of the mechanism moves the tiles farther apart",
        hasContacts ? "contacts lock the tiles at the start" : "the start is fully extended");
  }
  if (found.hasCompliantJoints) {
    words += fmt::format(", joints open by up to {} on the path",
                         model::lengthInTiles(found.evaluation.opening, scene.model));
  }
  if (found.path.isRounded) {
    words += fmt::format("; the model's tiles fit each other only to {}",
                         lengthText(scene.model.rounding, scene.model.unit, 1));
  }
  return words;
}

/// Open joints of the start are closed even if bricks then overlap. Adds a warning in this case.
void addPushedWarning(const scene::Scene& scene, const Poses& closed, DeploymentResult& result) {
  if (scene.environment.contacts == scene::ContactFilter::None) return;
  const double tile = model::tileSize(scene.model);
  const std::vector<brick::Brick> bricks = brick::makeBricks(scene.model.tiles, scene.brick);
  const std::vector<brick::Pivot> pivots = brick::makePivots(scene.model.joints, bricks);
  const Poses asRead = brick::startPoses(scene.model.tiles, bricks);
  trajectory::PenetrationMeter meter = overlapMeter(scene.environment, bricks, pivots, asRead);
  const double pushed = meter.grownAt(closed);
  if (pushed <= kAllowedOverlap * tile) return;
  result.warnings.push_back(fmt::format(
      "the joints are open by up to {} at the start. Closing them makes bricks overlap by {}",
      lengthText(trajectory::jointGap(pivots, asRead).max, scene.model.unit, 2),
      model::lengthInTiles(pushed, scene.model)));
}

}  // namespace

bool isExtension(const scene::Scene& scene, const MechanismPath& path) {
  return path.length() >= kMinExtension * model::tileSize(scene.model);
}

// ------------------------------------------------------------------------------------------------
// Interpolated states.

StatesBetween::StatesBetween(const scene::Scene& scene, const GeometricPath& found)
    : found_(found),
      tile_(model::tileSize(scene.model)),
      symmetries_(scene, found.path.symmetries),
      bricks_(found.path.isRounded ? metricBricks(scene)
                                   : brick::makeBricks(scene.model.tiles, scene.brick)),
      pivots_(brick::makePivots(scene.model.joints, bricks_)),
      closedGap_(roundedGap(scene.model)) {
  const scene::Scene bare = scene::withoutEnvironment(scene);
  projection_ = makeDynamics(bare, scene::sceneNeeds(bare), bricks_,
                             brick::startPoses(scene.model.tiles, bricks_));
  projection_->setFine(true);
  if (found.path.isRounded) projection_->setJointStiffness(roundedJointStiffness(scene.model));
}

bool StatesBetween::isOpen(const Poses& state) const {
  return found_.hasCompliantJoints &&
         trajectory::jointGap(pivots_, state).max > model::kClosedShare * tile_;
}

// The cubic through the four surrounding states (Lagrange).
Poses StatesBetween::smoothAt(std::size_t state, double share) const {
  const std::vector<Poses>& states = found_.path.states;
  const std::vector<double>& lengths = found_.path.lengths;
  const std::size_t count = std::min(kSmoothStates, states.size());
  const std::size_t first = std::min(state > 2 ? state - 2 : 0, states.size() - count);
  const std::span<const double> nodes = std::span(lengths).subspan(first, count);
  if (std::ranges::adjacent_find(nodes) != nodes.end()) {
    return interpolate(states[state - 1], states[state], share);
  }
  const double length = lengths[state - 1] + share * (lengths[state] - lengths[state - 1]);
  return polynomialAt(length, nodes, std::span(states).subspan(first, count), states[state - 1]);
}

// Joints that are closed in both states are closed again. Those of tiles with a misfit close only
// if they open by more than roundedGap(): near a singular state, closing them would move bricks
// far. Open compliant joints need not close: only the symmetry is restored.
Poses StatesBetween::at(std::size_t state, double share) {
  const Poses& from = found_.path.states[state - 1];
  const Poses& to = found_.path.states[state];
  if (share >= 1) return to;
  Poses poses = interpolate(from, to, share);
  if (found_.path.isRounded) {
    if (trajectory::jointGap(pivots_, poses).max > closedGap_) {
      settle(bricks_, closedGap_, *projection_, poses);
    }
    return model::symmetricMean(poses, found_.path.symmetries);
  }
  if (isOpen(from) || isOpen(to)) return model::symmetricMean(poses, found_.path.symmetries);
  if (!closeInPlace(poses, *projection_)) {
    const Poses smooth = smoothAt(state, share);
    if (trajectory::jointGap(pivots_, smooth).max < trajectory::jointGap(pivots_, poses).max) {
      poses = smooth;
    }
  }
  symmetries_.restore(poses, *projection_);
  return poses;
}

std::vector<Poses> StatesBetween::moments(std::size_t state) {
  return momentsThrough(found_.path.states[state - 1], {at(state, 1.0 / 3), at(state, 2.0 / 3)},
                        found_.path.states[state]);
}

// ------------------------------------------------------------------------------------------------

DeploymentResult playBack(const scene::Scene& scene, const GeometricPath& found,
                          const AssembledState& nearest, double sampleInterval,
                          const SampleObserver& observer) {
  const double startSeconds = threadCpuSeconds();
  scene::Scene played = scene;
  played.environment.contacts = found.contacts;
  played.path.kind = scene::PathKind::Continuation;
  Playback playback(played, found, nearest, sampleInterval, observer);
  DeploymentResult result = playback.finish();
  if (!found.hasCompliantJoints) addPushedWarning(scene, found.path.states.front(), result);
  const double error = result.accuracy.targetErrorEnd;
  if (scene.model.target) {
    result.atTarget = hasArrived(scene.model, error, result.assembledError);
  }
  // Without contacts the path is longer, else it would have none.
  const bool isLockedAtStart = !scene.model.target && found.closedWords.empty() &&
                               found.contacts != scene::ContactFilter::None &&
                               !isExtension(scene, found.path);
  const bool isShort = result.atTarget == false || found.path.endsAtOpenJoints || isLockedAtStart;
  result.outcome = playback.isInterrupted() ? Outcome::Interrupted
                   : isShort                ? Outcome::Locked
                                            : Outcome::Settled;
  result.reason = playback.isInterrupted() ? "ended early by the caller"
                                           : endOf(scene, found, error, result.assembledError);
  result.trajectory.events.push_back({playback.time(), endText(result.outcome, result.reason)});
  result.needs = scene::sceneNeeds(played);
  result.needs.contacts = {found.contacts != scene::ContactFilter::None, found.contactReason};
  result.path = played.path;
  result.pathReason = found.reason;
  result.cost.cpuSeconds = threadCpuSeconds() - startSeconds;
  return result;
}

}  // namespace kirireel::run
