// One run with dynamics: the loop over steps and what decides in it.
//
// Time is counted in looks: a look is one timestep, or four where a tolerance in time is kept. A
// step ends with the next look, or earlier where the timeline or the path has something due. After
// each step the run measures (RunFigures), takes the samples that came due, and asks whether it
// rests.
//
// Rest. Nothing moves faster than settleSpeed times the model's size for settleTime seconds, or
// steps fail and no brick has gone anywhere since they began to. Then, in this order: the springs
// are stiffened, up to 16 times; a probe looks whether the bricks are only slow (rest_probe.h); the
// timeline may wait for rest; else the run ends, settled or locked, by the error that is left.
//
// Path. While tiles are led, a PathFollower's springs pull in place of the scene's; joints may be
// compliant meanwhile, and are closed when the path is done, unless that pushes bricks into each
// other.
//
// A step that loses a brick, or that is ended from within, is taken back: the state, the time and
// the account of energies are those before it.
#include "sim/deploy/run.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include <fmt/format.h>

#include "sim/base/cpu_time.h"
#include "sim/base/interruption.h"
#include "sim/deploy/nudge.h"
#include "sim/deploy/path_choice.h"
#include "sim/deploy/rounded_joints.h"
#include "sim/measure/mobility.h"
#include "sim/scene/hinge_springs.h"

namespace kirireel {
namespace {

// A run has diverged once a brick is this many model sizes away from where it started.
constexpr double kLostDistance = 1e3;
// Of the contacts that hold a run up, so many are named.
constexpr std::size_t kPairsNamed = 3;
// Closing joints may make bricks overlap by this part of a tile.
constexpr double kPushedShare = 1e-4;
// A run that keeps a tolerance in time is looked at after so many timesteps.
constexpr int kStepsAtOnce = 4;

}  // namespace

Run::Run(const Scene& scene, const AssembledState& nearest, const RunObservers& observers,
         Checkpoints* checkpoints)
    : scene_(scene),
      observers_(observers),
      checkpoints_(checkpoints),
      bricks_(makeBricks(scene.model.tiles, scene.brick)),
      pivots_(makePivots(scene.model.joints, bricks_)),
      ties_(dynamicTies(scene, bricks_, hingeSprings(scene, bricks_))),
      motion_{startPoses(scene.model.tiles, bricks_), {}},
      target_(scene.model.target ? &*scene.model.target : nullptr),
      needs_(sceneNeeds(scene)),
      drive_(makeDriveForce(scene, bricks_)),
      opening_(bricks_, springsOf(scene)),
      timeline_(scene.timeline, bricks_, scene.model.fileOrder.countsFrom),
      stiffness_(false),
      hasTolerance_(keepsTolerance(scene)),
      look_(scene.solver.timestep * (hasTolerance_ ? kStepsAtOnce : 1)),
      length_(look_),
      size_(modelSize(scene.model)),
      tileSize_(tileSize(scene.model)),
      springSettings_(springsOf(scene)),
      nearest_(nearest),
      figures_(scene.model, bricks_, pivots_, scene.environment.pivotZone, motion_.poses, nearest),
      restNeeded_(scene.stop.settleTime) {
  dynamics_ = makeSolver();
  actuation_ = [this](double seconds, const Poses& poses, std::vector<Load>& loads) {
    std::fill(loads.begin(), loads.end(), Load{});
    if (timeline_.forcesAreOn()) pull(poses, loads);
    timeline_.addDrags(time() + seconds, poses, loads);
  };
  if (observers_.sample && scene.solver.kind == SolverKind::Direct) {
    mechanics_.emplace(bricks_, ties_.pivots, scene.model.joints.size(), needs_.planar.on,
                       tileSize_, static_cast<const ActingForces&>(*this));
  }
}

std::unique_ptr<Dynamics> Run::makeSolver() const {
  std::unique_ptr<Dynamics> solver =
      makeDynamics(scene_, needs_, bricks_, startPoses(scene_.model.tiles, bricks_));
  if (hasTolerance_) {
    solver->setTolerance({scene_.solver.tolerance, scene_.solver.timestep, look_});
  }
  return solver;
}

/// Joints that give while the tiles are led close again; on a straight path they stay as they are.
bool Run::jointsGiveThroughout() const {
  return scene_.path.kind == PathKind::Straight && scene_.path.jointsGive();
}

/// Holds the joints as the start of the run does. They give a little where tiles do not fit.
void Run::holdJoints(Dynamics& dynamics) const {
  if (scene_.path.jointsGive()) {
    dynamics.setJointStiffness(scene_.path.jointStiffness);
  } else if (misfit_) {
    dynamics.setJointStiffness(kMisfitStiffness);
  }
}

// Heads for a target, null for the model's own: notes where it starts from, how near the tiles can
// come, and ties springs to it.
void Run::goTo(const std::vector<Tile>* target) {
  if (!target && scene_.model.target) target = &*scene_.model.target;
  target_ = target;
  if (!target_) return;
  targetStartError_ = currentTargetError();
  const bool isFinal = scene_.model.target && target_ == &*scene_.model.target;
  leastError_ = isFinal ? nearest_.restError : rigidBound(scene_.model.tiles, *target_);
  departure_ = motion_.poses;
  departureTime_ = time();
  if (!hasSprings()) return;
  openedAt_ = time() + (scene_.path.kind == PathKind::Led ? scene_.path.openTime : 0);
  tieSprings();
  stiffness_ = AdaptiveStiffness(scene_.springs.adaptive);
  stiffness_.observe(targetStartError_, time(), 0);
}

// Back to the start, with a new solver.
void Run::reset() {
  follower_.reset();
  motion_ = {startPoses_, std::vector<Velocity>(bricks_.size())};
  // A solver carries contacts and multipliers from step to step, which do not belong here.
  dynamics_ = makeSolver();
  holdJoints(*dynamics_);
  goTo(nullptr);
  nudgeStart();
}

void Run::quit() {
  end(Outcome::OutOfTime, fmt::format("the timeline ended the run at {:.4g} s", time()));
}

/// Does what the timeline wants now. Returns whether that was anything.
bool Run::followTimeline(bool atRest) {
  if (timeline_.isOver(time())) return false;
  const double error = currentTargetError();
  const TimelineView view = {time(),
                             atRest,
                             error,
                             targetStartError_,
                             atRest && target_ && error <= reachableError(),
                             &motion_.poses};
  if (!timeline_.carryOut(view, *this, result_.trajectory.events)) return false;
  restTime_ = 0;
  return true;
}

// Closes joints, sets the first velocities and measures the start.
void Run::start() {
  // Joints that give need not be closed first, which can push bricks into each other.
  misfit_ = !scene_.path.jointsGive() && !dynamics_->assemble(motion_.poses);
  if (needs_.contacts.on) pushedAtStart_ = figures_.overlapsOf(motion_.poses).grown;
  holdJoints(*dynamics_);
  goTo(nullptr);
  if (scene_.velocities.empty()) {
    motion_.velocities.assign(bricks_.size(), Velocity{});
    nudgeStart();
  } else {
    motion_.velocities = initialVelocities(scene_.velocities, bricks_, motion_.poses);
    if (!scene_.path.jointsGive()) dynamics_->fitVelocities(motion_);
  }
  result_.needs = needs_;
  result_.path = scene_.path;
  static_cast<Subject&>(result_.trajectory) = subjectOf(scene_);
  if (symmetries_) {
    symmetries_->keepThoseOf(motion_.poses);
    symmetries_->restore(motion_, *dynamics_);
  }
  startPoses_ = motion_.poses;
  figures_.begin(motion_.poses, jointsGiveNow());
  if (mechanics_) mechanics_->begin(0, motion_);
  showStep();
}

// Tells the observer of steps, which may end the run.
void Run::showStep() {
  if (observers_.step && !observers_.step(figures_.lastStep())) isAskedToEnd_ = true;
}

/// Takes the samples that became due with this step.
void Run::takeSamples() {
  for (;;) {
    const double due = static_cast<double>(sampleCount_) * observers_.sampleInterval;
    if (!(due <= time() + kSameTime * look_)) return;  // also when not a number
    const bool isAtStep = due >= time() - kSameTime * look_;
    takeSample(isAtStep ? time() : due, isAtStep ? motion_.poses : posesAt(due));
  }
}

/// A run ends with a step, and its last sample shows that.
void Run::takeLastSample() {
  if (lastSampleTime_ < time()) takeSample(time(), motion_.poses);
}

void Run::takeSample(double time, Poses poses) {
  // What may be ended from within comes first.
  const double share = 1 - (this->time() - time) / length_;
  std::optional<Mechanics> mechanics;
  if (mechanics_) mechanics = mechanics_->at(time, motionAt(time, poses), share);
  Sample sample = figures_.sampleAt(time, std::move(poses));
  ++sampleCount_;
  lastSampleTime_ = time;
  sample.mechanics = std::move(mechanics);
  sample.pinned = timeline_.pinnedTiles();
  if (checkpoints_) note(sample);
  if (observers_.sample && !observers_.sample(sample)) isAskedToEnd_ = true;
}

/// The poses at a time within the last step, joints as they come: by the velocities on both sides
/// where a tolerance was kept, else places go straight and rotations by the shortest turn.
Poses Run::openPosesAt(double time) const {
  const double seconds = time - (this->time() - length_);
  if (!wasSmooth_) return interpolate(before_.poses, motion_.poses, seconds / length_);
  return posesBetween(before_, dynamics_->passed(), motion_, length_, seconds);
}

/// The same with the joints closed, where those of the step's two ends are.
Poses Run::posesAt(double time) {
  Poses poses = openPosesAt(time);
  if (!figures_.wereClosed() || scene_.solver.kind != SolverKind::Direct) return poses;
  if (!projection_) {
    Scene alone = scene_;
    alone.environment = Environment{};
    projection_ = makeDynamics(alone, Needs{.planar = needs_.planar}, bricks_, startPoses_);
  }
  projection_->setPinned(pinned());
  projection_->assemble(poses);
  return poses;
}

/// Looks between two steps whether the run is to go on: to the look nearest to its duration.
bool Run::goesOn() {
  if (ended_) return false;
  if (checkpoints_ && (isAskedToEnd_ || checkpoints_->isDue())) saveState();
  if (isAskedToEnd_) interrupt();
  return !ended_ && (sinceLook_ > 0 || time() < scene_.stop.duration - 0.5 * look_);
}

double Run::spentSeconds() const {
  return earlierSeconds_ + threadCpuSeconds() - startSeconds_;
}

/// Closes the joints, unless that pushes bricks into each other, or tiles of rounded coordinates
/// back to where alone they fit. Returns whether they are closed.
bool Run::closeJoints() {
  const Poses open = motion_.poses;
  if (!dynamics_->assemble(motion_.poses)) return false;
  if (std::isfinite(roundedJointStiffness(scene_.model)) &&
      targetError(bottomTiles(bricks_, open), bricks_, motion_.poses) >
          roundedReach(scene_.model)) {
    motion_.poses = open;
    return false;
  }
  if (!needs_.contacts.on) return true;
  const double before = figures_.overlapsOf(open).grown;
  const double after = figures_.overlapsOf(motion_.poses).grown;
  heldOpen_ = after > std::max(before, kPushedShare * tileSize_);
  if (heldOpen_) motion_.poses = open;
  return !heldOpen_;
}

/// Leads the tiles on, or lets them go once the path is done.
void Run::followPath() {
  if (isOpening()) return;
  if (openedAt_ > departureTime_) {
    departure_ = motion_.poses;
    departureTime_ = time();
    tieSprings();
  }
  if (!follower_ || follower_->prepareStep(time() + length_, *dynamics_)) return;
  const bool closed = closeJoints();
  if (scene_.path.jointsGive())
    dynamics_->setJointStiffness(closed ? kExactJoints : kMisfitStiffness);
  misfit_ = misfit_ || !closed;
  follower_.reset();
}

// As many timesteps as make this step, each from the loads at its own start.
StepReport Run::advanceByFixedSteps() {
  const int count = hasTolerance_ ? kStepsAtOnce : 1;
  StepReport report;
  for (int k = 0; k < count; ++k) {
    report += dynamics_->advance(motion_, length_ / count, loadsNow());
    if (symmetries_) symmetries_->restore(motion_, *dynamics_);
  }
  return report;
}

// One step by the solver, with the account of energies around it.
StepReport Run::advanceStep() {
  followPath();
  const bool isExact = hasTolerance_ && !misfit_;
  if (mechanics_) mechanics_->begin(time(), motion_);
  const StepReport report =
      isExact ? dynamics_->advanceToTolerance(motion_, length_, actuation_) : advanceByFixedSteps();
  if (mechanics_) {
    mechanics_->end({time(), length_, before_, motion_, dynamics_->passed(), isExact, report.damped,
                     report.impacted});
  }
  wasSmooth_ = isExact && report.touchingTime == 0 && report.singularTime == 0;
  passTime();
  watchJam(report);
  return report;
}

// Whether a brick has left all bounds, or is nowhere.
bool Run::isLost() const {
  for (std::size_t i = 0; i < startPoses_.size(); ++i) {
    const double distance = (motion_.poses[i].position - startPoses_[i].position).norm();
    if (!(distance <= kLostDistance * size_)) return true;  // also when not a number
    if (!motion_.poses[i].rotation.coeffs().allFinite()) return true;
  }
  return false;
}

// Sets how the run ended, once, as the last event.
void Run::end(Outcome outcome, std::string reason) {
  result_.outcome = outcome;
  result_.reason = std::move(reason);
  result_.trajectory.events.push_back(
      {time(), fmt::format("{}: {}", toString(outcome), result_.reason)});
  ended_ = true;
}

// Settled, or locked short of the target.
void Run::endAtRest() {
  const double error = currentTargetError();
  if (!pullsToTarget()) {
    end(Outcome::Settled, target_ ? "everything came to rest; nothing pulls to the target"
                                  : "everything came to rest; there is no target");
  } else if (hasArrived()) {
    end(Outcome::Settled, fmt::format("came to rest {:.3g} from the target", error));
  } else {
    end(Outcome::Locked,
        fmt::format("came to rest {:.3g} short of the target: {}", error, holdup()));
  }
}

/// Whether the joints leave the tiles no motion but that of the whole.
bool Run::isImmobile() const {
  const Freedom freedom = needs_.planar.on ? Freedom::Plane : Freedom::Space;
  const Mobility found =
      mobility(scene_.model, bottomTiles(bricks_, motion_.poses), freedom, scene_.brick.thickness);
  return found.isCounted && found.freedoms <= 0;
}

/// How a run stands whose time is up.
std::string Run::lateness() const {
  const double speed = fastestSpeed();
  std::string text = fmt::format(
      "{} after {:.4g} s",
      speed < scene_.stop.settleSpeed * size_ ? "not known to be at rest" : "still moving",
      scene_.stop.duration);
  text += fmt::format(", at {:.2g} m/s at most", speed);
  if (pullsToTarget()) text += fmt::format(", {:.3g} from the target", currentTargetError());
  return text;
}

/// What keeps a run from its target that has come to rest.
std::string Run::holdup() const {
  if (isTrial_) return "";
  if (scene_.solver.kind == SolverKind::Bullet) return "the baseline does not tell why";
  std::vector<std::string> contacts = dynamics_->loadedContacts();
  if (contacts.empty() && isStuck()) return "exact joints leave the tiles no way on";
  if (contacts.empty() && isImmobile()) {
    return "the joints leave the tiles no way to move (0 degrees of freedom); joints that give "
           "would "
           "(--path led --joint-stiffness 1e5)";
  }
  if (contacts.empty() && currentTargetError() <= reachableError()) {
    return "no state with closed joints was found nearer";
  }
  if (contacts.empty() && scene_.hinges.areOn()) return "the springs at the hinges hold them";
  if (contacts.empty()) {
    return "a local minimum of the pull, no small move brings the tiles nearer";
  }
  const std::size_t count = contacts.size();
  contacts.resize(std::min(count, kPairsNamed));
  std::string text = fmt::format("contact stops {}", fmt::join(contacts, ", "));
  if (count > kPairsNamed) text += fmt::format(" and {} more", count - kPairsNamed);
  return text;
}

/// What keeps the joints from being as asked for; empty when nothing does.
std::string Run::jointTrouble() const {
  if (misfit_) {
    return fmt::format("{}, so joints give a little, with {:g} N/m",
                       heldOpen_ ? "bricks are in the way of closing joints"
                                 : "the tiles do not quite fit each other",
                       kMisfitStiffness);
  }
  if (pushedAtStart_ <= kPushedShare * tileSize_) return "";
  return fmt::format(
      "closing the joints at the start pushes bricks {:.2g} m into each other, joints "
      "that give would not (--path led --joint-stiffness {:g})",
      pushedAtStart_, kMisfitStiffness);
}

/// Goes on by one step and measures it. One that loses a brick is not counted: the run ends where
/// it began. Nor is one that is ended from within.
void Run::takeStep() {
  before_ = motion_;
  const auto timeBefore = std::pair(lookCount_, sinceLook_);
  const auto account = mechanics_ ? mechanics_->account() : RunMechanics::Account{};
  const auto takeBack = [&] {
    if (mechanics_) mechanics_->goBackTo(account);
    motion_ = before_;
    std::tie(lookCount_, sinceLook_) = timeBefore;
  };
  try {
    const StepReport report = advanceStep();
    if (isLost()) {
      const double lostAt = time();
      takeBack();
      return end(Outcome::Diverged,
                 fmt::format("a brick left all bounds at {:.4g} s; try a shorter --timestep or "
                             "more damping",
                             lostAt));
    }
    figures_.observe(time(), motion_.poses, report, jointsGiveNow());
  } catch (const Interrupted&) {
    takeBack();
    throw;
  }
}

/// A step ends where something of the run comes due, however steps lie, and with the next look.
double Run::nextLength() const {
  double due = timeline_.nextMoment(time());
  if (isOpening()) due = std::min(due, openedAt_);
  const double rested = restMoment();
  if (!isDue(rested)) due = std::min(due, rested);
  const double stalled = stiffness_.nextMoment();
  if (watchesStall() && !isDue(stalled)) due = std::min(due, stalled);
  const double untilLook = look_ - sinceLook_;
  const double untilDue = due - time();
  return untilDue < untilLook - kSameTime * look_ ? untilDue : untilLook;
}

/// Lets the time of a step pass. Looks are counted, so that their times do not gather rounding.
void Run::passTime() {
  sinceLook_ += length_;
  if (sinceLook_ < look_ - kSameTime * look_) return;
  ++lookCount_;
  sinceLook_ = 0;
}

// One step of the loop, pauses included.
void Run::advance() {
  followTimeline(false);
  if (ended_) return;
  wasSmooth_ = false;
  length_ = nextLength();
  if (timeline_.isPaused(time())) {
    before_ = motion_;
    passTime();
    return takeSamples();
  }
  takeStep();
  if (ended_) return;
  showStep();
  updateRest();
  // A stiffer pull has to show that it moves nothing, too.
  if (watchesStall() && stiffness_.observe(currentTargetError(), time(), length_)) restTime_ = 0;
  takeSamples();
  if (!ended_ && isDue(restMoment())) restOrGoOn();
}

/// Where a step is ended from within, the solver is in no state to go on from: the checkpoint
/// before stays.
void Run::advanceToEnd() {
  try {
    const InterruptionCatcher catcher;
    while (goesOn()) advance();
  } catch (const Interrupted&) {
    if (isTrial_) throw;
    interrupt();
  }
}

// The whole run: start or checkpoint, the loop, the end.
DeploymentResult Run::finish() {
  startSeconds_ = threadCpuSeconds();
  start();
  if (checkpoints_ && checkpoints_->run()) {
    goOnFrom(*checkpoints_->run());
  } else {
    takeSample(0, motion_.poses);
  }
  advanceToEnd();
  if (pullsToTarget()) result_.atTarget = hasArrived();
  if (!ended_) end(Outcome::OutOfTime, lateness());
  if (!isReplayed_) takeLastSample();
  figures_.leave(result_);
  noteElasticity();
  result_.pathReason = jointTrouble();
  result_.cost.cpuSeconds = spentSeconds();
  return std::move(result_);
}

}  // namespace kirireel
