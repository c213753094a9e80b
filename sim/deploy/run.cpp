// One run with dynamics: the loop over steps and what decides in it.
//
// Time is counted in looks: a look is one timestep, or four where a tolerance in time is kept. A
// step ends with the next look, or earlier where the timeline or the path has something due. After
// each step the run measures (RunFigures), takes the samples that came due, and asks whether it
// rests.
//
// Rest. Nothing moves faster than settleSpeed times the model's size for settleTime seconds, or
// steps fail and no brick has gone anywhere since they began to. Then, in this order: the springs
// are stiffened, up to 16 times; a probe looks whether the bricks are only slow (run.h); the
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
#include <random>
#include <span>
#include <tuple>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/interruption.h"
#include "sim/deploy/assembled_state.h"
#include "sim/deploy/forces.h"
#include "sim/deploy/path_choice.h"
#include "sim/measure/sheet.h"
#include "sim/scene/scene_parts.h"

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
      exactPivots_(dynamicTies(scene, bricks_, hingeSprings(scene, bricks_)).pivots),
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
    mechanics_.emplace(bricks_, exactPivots_, scene.model.joints.size(), needs_.planar.on,
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
  nudged_ = Nudged::No;
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
  static_cast<Subject&>(result_.trajectory) = subjectOf(scene_);
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

// ------------------------------------------------------------------------------------------------
// What acts on the bricks of a run: springs, expansion, drags, gravity, hinges, contacts.

/// To the target headed for at present, from where that was set or the way to it was opened.
void Run::tieSprings() {
  follower_.reset();
  if (scene_.path.kind == PathKind::Led && !isOpening()) {
    follower_.emplace(scene_, bricks_, departure_, *target_, departureTime_);
  }
  springs_.emplace(bricks_, *target_, scene_.model.pulledTiles, springSettings_);
}

// The springs of the moving guide where tiles are led, else those to the target. Null where nothing
// pulls.
const TargetSprings* Run::targetSprings() const {
  if (follower_) return &follower_->springs();
  return springs_ ? &*springs_ : nullptr;
}

/// What drives the bricks.
void Run::pull(const Poses& poses, std::vector<Load>& loads) const {
  if (const DriveForce* drive = presentDrive()) {
    drive->addLoads(poses, loads);
  } else if (const TargetSprings* springs = targetSprings()) {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      loads[i] = springs->load(static_cast<int>(i), poses[i], stiffness_.factor());
    }
  }
}

// What drive, drags and yielding joints store at a time in these poses, joules. Hinges and
// ligaments are accounted for apart.
double Run::springEnergy(double time, const Poses& poses) const {
  double sum = 0;
  if (timeline_.forcesAreOn()) {
    const DriveForce* drive = presentDrive();
    const TargetSprings* springs = targetSprings();
    if (drive) sum += drive->energy(poses);
    if (!drive && springs) sum += springs->energy(poses, stiffness_.factor());
  }
  for (const DragSpring& grip : timeline_.dragSprings(time)) {
    sum += pointSpringEnergy(grip.spring, poses[grip.tile]);
  }
  const double stiffness = jointStiffness();
  if (!std::isfinite(stiffness)) return sum;
  for (const Pivot& pivot : pivots_) {
    // In the plane both faces' pivots are one.
    if (needs_.planar.on && pivot.isUpper) continue;
    sum += 0.5 * stiffness * std::pow(pivotGap(pivot, poses), 2);
  }
  return sum;
}

// Forces that store no energy here, newtons: gravity, and what of a drive is no spring.
std::vector<Vector3> Run::freeForces(const Poses& poses) const {
  std::vector<Vector3> forces;
  for (const Brick& brick : bricks_) forces.push_back(brick.mass * scene_.environment.gravity);
  const DriveForce* drive = timeline_.forcesAreOn() ? presentDrive() : nullptr;
  if (drive) drive->addFreeForces(poses, forces);
  return forces;
}

// Everything but contacts and joints, with its damping at these velocities: N and N m about the
// centres of mass.
std::vector<Vector6> Run::appliedForces(double time, const Motion& motion) const {
  std::vector<Load> loads(bricks_.size());
  actuation_(time - this->time(), motion.poses, loads);
  addEnvironmentLoads(scene_.environment, bricks_, motion.poses, loads);
  std::vector<Vector6> forces;
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    Vector6 velocity;
    velocity << motion.velocities[i].linear, motion.velocities[i].angular;
    forces.push_back(loads[i].force - loads[i].damping * velocity);
  }
  const std::vector<HingeSpring>& springs = result_.trajectory.hingeSprings;
  const std::vector<double> moments = hingeMoments(springs, motion.poses);
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const Hinge& hinge = springs[s].hinge;
    const double moment = moments[s] - springs[s].damping * hingeRate(hinge, motion);
    const Vector3 onB = moment * (motion.poses[hinge.brickA].rotation * hinge.axis);
    forces[hinge.brickA].tail<3>() -= onB;
    forces[hinge.brickB].tail<3>() += onB;
  }
  for (const Ligament& ligament : result_.trajectory.ligaments) {
    const Vector6 slope = ligamentEnergy(ligament, motion.poses).gradient;
    const auto pull = [&](int brick, const Vector3& by) {
      forces[brick].head<2>() -= by.head<2>();
      forces[brick][5] -= by[2];
    };
    pull(ligament.brickA, slope.head<3>());
    pull(ligament.brickB, slope.tail<3>());
  }
  return forces;
}

// Adds what ligaments push their first brick with to the force of their joint, newtons. The plane's
// two components alone.
void Run::addLigamentForces(const Poses& poses, std::vector<Vector3>& jointForces) const {
  for (const Ligament& ligament : result_.trajectory.ligaments) {
    const Vector6 slope = ligamentEnergy(ligament, poses).gradient;
    jointForces[static_cast<std::size_t>(ligament.joint)].head<2>() -= slope.head<2>();
  }
}

// One entry a brick: whether the timeline holds it at present.
std::vector<bool> Run::pinned() const {
  std::vector<bool> pinned(bricks_.size(), false);
  for (const int tile : timeline_.pinnedTiles()) pinned[static_cast<std::size_t>(tile)] = true;
  return pinned;
}

// Drags as grips, and the contacts of the last step.
std::vector<Hold> Run::holds(double time, const Motion& motion) const {
  std::vector<Hold> holds;
  for (const DragSpring& grip : timeline_.dragSprings(time)) {
    const Pose& pose = motion.poses[grip.tile];
    Load load;
    addPointSpring(grip.spring, pose, load);
    Vector6 velocity;
    velocity << motion.velocities[grip.tile].linear, motion.velocities[grip.tile].angular;
    holds.push_back({HoldKind::Grip, grip.tile, Hold::kGround,
                     (load.force - load.damping * velocity).head<3>(), Vector3::Zero(),
                     pose.apply(grip.spring.point)});
  }
  // Grips come by tile, in the timeline's order within a tile, so that files do not depend on it.
  std::ranges::stable_sort(holds, {}, &Hold::tile);
  const std::vector<Hold> contacts =
      this->time() > 0 ? dynamics_->contacts(motion.poses) : std::vector<Hold>{};
  holds.insert(holds.end(), contacts.begin(), contacts.end());
  return holds;
}

/// How fast the bricks are so many seconds after the last step's start: straight between the states
/// on the way that are known.
std::vector<Velocity> Run::velocitiesAt(double seconds) const {
  const auto passed = wasSmooth_ ? dynamics_->passed() : std::span<const PassedState>{};
  return velocitiesBetween(before_, passed, motion_, length_, seconds);
}

/// How the bricks move in these poses at a time within the last step.
Motion Run::motionAt(double time, const Poses& poses) const {
  if (time == this->time()) return {poses, motion_.velocities};
  return {poses, velocitiesAt(length_ - (this->time() - time))};
}

// ------------------------------------------------------------------------------------------------
// What a run keeps in a checkpoint, and how it goes on from one: its state apart from its figures,
// then each sample with the figures so far, so that samples can be shown again.

/// Keeps a sample with the figures so far, for the next checkpoint.
void Run::note(Sample& sample) {
  checkpoints_->samples().transfer(sample);
  transferFigures(checkpoints_->samples());
}

void Run::transferFigures(StateTape& tape) {
  tape.transfer(lookCount_, sinceLook_, length_, sampleCount_, lastSampleTime_, figures_);
}

/// What the run goes on from, apart from its figures.
void Run::transfer(StateTape& tape) {
  std::vector<const std::vector<Tile>*> targets = {nullptr};
  if (scene_.model.target) targets.push_back(&*scene_.model.target);
  for (const TimelineEntry& entry : scene_.timeline) {
    const auto* going = std::get_if<timeline::GoTo>(&entry.action);
    if (going) targets.push_back(&going->tiles);
  }
  double spent = spentSeconds();
  auto number = std::find(targets.begin(), targets.end(), target_) - targets.begin();
  bool isLed = follower_.has_value();
  transferFigures(tape);
  tape.transfer(motion_, number, targetStartError_, leastError_, departure_, departureTime_,
                openedAt_, isLed, stiffness_, timeline_, nudged_, restTime_, restNeeded_, misfit_,
                heldOpen_, jamStart_, result_.trajectory.events, before_, spent, *dynamics_);
  figures_.transferStates(tape);
  if (mechanics_) tape.transfer(*mechanics_);
  if (!tape.isPlaying()) return;
  earlierSeconds_ = spent;
  target_ = targets.at(static_cast<std::size_t>(number));
  if (hasSprings()) tieSprings();
  if (!isLed) follower_.reset();
}

void Run::saveState() {
  StateTape tape;
  transfer(tape);
  checkpoints_->save({time(), tape.numbers()});
}

/// Shows the samples of the processes before this one, then takes over where they ended.
void Run::goOnFrom(const RunState& state) {
  StateTape tape(state.numbers);
  transfer(tape);
  StateTape figures;
  transferFigures(figures);
  Sample shown;
  checkpoints_->playSamples([&](StateTape& samples) {
    samples.transfer(shown);
    transferFigures(samples);
    isAskedToEnd_ = observers_.sample && !observers_.sample(shown);
    return !isAskedToEnd_;
  });
  if (isAskedToEnd_ && shown.time < state.time) return endWith(shown);
  StateTape latest(figures.numbers());
  transferFigures(latest);
}

/// Ends a run on the way to its checkpoint, which stays as it is. Which states the figures so far
/// were reached in is not known here.
void Run::endWith(const Sample& shown) {
  isReplayed_ = true;
  motion_.poses = shown.poses;
  figures_.endWith(shown);
  std::erase_if(result_.trajectory.events,
                [&](const Event& event) { return event.time > shown.time; });
  interrupt();
}

// ------------------------------------------------------------------------------------------------
// How a run leaves its start, and when it is at rest.
//
// A start that stands in an unstable equilibrium is left by a nudge (see run.h), one that moves
// by itself without. A run rests while its fastest brick is slower than the settle speed, or while
// steps fail however short they are and no brick gets anywhere. Once it has rested for the settle
// time, these are tried in order: a nudge, where a target is pulled to and not reached and the run
// had none yet or only its symmetric part, for an equilibrium that a motion came to may be unstable
// too, as a ring's that closes in symmetry; a stiffer pull; long implicit steps from rest, which
// tell bricks that are only slow; what the timeline has for a state of rest; and a nudge where
// nothing is pulled to a target. Where nothing of this moves the bricks, the run is over.
//
// All of this happens at moments that follow from the motion, not from where steps end: steps are
// made to end there (see Run::nextLength).

namespace {

// At a target, a run that is this near to where springs rest, or to it, is not only slow.
constexpr double kThere = 1.05;
constexpr double kThereShare = 1e-6;
// So much of the model's size from the target is arrived: a stiffer pull is not tried.
constexpr double kArrivedShare = 1e-9;
// Steps that fail, and bring no brick farther than this part of a tile, are no motion.
constexpr double kStuckShare = 1e-3;
// A step is looked at in so many parts for the beginning of rest, and the part halved so often.
constexpr int kRestLooks = 16;
constexpr int kRestHalvings = 30;

}  // namespace

std::unique_ptr<Dynamics> Run::copyOfSolver() {
  std::unique_ptr<Dynamics> copy = makeSolver();
  StateTape recorded;
  recorded.transfer(*dynamics_);
  StateTape(recorded.numbers()).transfer(*copy);
  return copy;
}

/// Gives the bricks, which stand at the start, what they need to leave it: nothing where they move
/// by themselves. An engine's start is not known to its end, and it gets the whole nudge.
void Run::nudgeStart() {
  nudged_ = Nudged::Wholly;
  std::vector<Velocity> whole = nudge(bricks_.size(), size_, scene_.solver.seed);
  if (scene_.solver.kind == SolverKind::Bullet) {
    motion_.velocities = std::move(whole);
    return;
  }
  const std::unique_ptr<Dynamics> dynamics = makeSolver();
  holdJoints(*dynamics);
  Motion trial = {motion_.poses, std::vector<Velocity>(bricks_.size())};
  dynamics->advance(trial, kNudgeTime, loadsNow());
  if (movesByItself(trial.velocities, !pivots_.empty(), tileSize_, size_)) {
    nudged_ = Nudged::No;
    return;
  }
  SymmetricStates symmetries(scene_);
  symmetries.keepThoseOf(motion_.poses);
  if (symmetries.group().size() > 1) {
    std::vector<Velocity> symmetric =
        symmetricNudge(whole, motion_.poses, symmetries.group(), *dynamics);
    if (!symmetric.empty()) {
      nudged_ = Nudged::InSymmetry;
      whole = std::move(symmetric);
    }
  }
  motion_.velocities = std::move(whole);
}

/// A motion may come to an equilibrium that is not stable, as a start may be one.
void Run::nudgeAtRest() {
  nudged_ = Nudged::Wholly;
  restTime_ = 0;
  const std::vector<Velocity> whole = nudge(bricks_.size(), size_, scene_.solver.seed);
  for (std::size_t i = 0; i < whole.size(); ++i) motion_.velocities[i].linear += whole[i].linear;
}

/// Notes where the bricks are when steps begin to fail at their shortest.
void Run::watchJam(const StepReport& report) {
  const bool fails = report.unconverged > 0;
  if (!fails) {
    jamStart_.clear();
  } else if (!isStuck()) {
    jamStart_ = motion_.poses;
  }
}

/// Whether steps fail, and the bricks have stayed since they began to.
bool Run::isStuck() const {
  return !jamStart_.empty() &&
         farthestMove(jamStart_, motion_.poses, tileSize_) < kStuckShare * tileSize_;
}

/// Of all bricks, turns counted at a tile's size, m/s.
double Run::fastestSpeed(const std::vector<Velocity>& velocities) const {
  double fastest = 0;
  for (const Velocity& velocity : velocities) {
    const double speed = velocity.linear.norm() + velocity.angular.norm() * tileSize_;
    fastest = std::max(fastest, speed);
  }
  return fastest;
}

/// Whether bricks that hardly move are only slow: soft springs and heavy bricks are.
bool Run::isOnItsWay() {
  const bool targetPulls = pullsToTarget() && timeline_.forcesAreOn();
  const double arrived = std::max(kThere * leastError_, kThereShare * tileSize_);
  if (isStuck() || scene_.solver.kind == SolverKind::Bullet) return false;
  if (targetPulls ? currentTargetError() <= arrived : !hingesPull()) return false;
  const RestProbe probe = probeRest(*copyOfSolver(), motion_, look_, loadsNow(), tileSize_);
  figures_.addWork(probe.work);
  return probe.movesOn;
}

/// For how long up to the end of the last step the fastest speed has stayed below a limit that it
/// is below then, seconds; the whole step's length where it was never above. Speeds swing: looked
/// at in parts of the step, then by bisection.
double Run::restWithinStep(double limit) const {
  const auto isFast = [&](double seconds) { return fastestSpeed(velocitiesAt(seconds)) >= limit; };
  const double part = length_ / kRestLooks;
  int fast = kRestLooks - 1;
  while (fast >= 0 && !isFast(fast * part)) --fast;
  if (fast < 0) return length_;
  double above = fast * part;
  double below = above + part;
  for (int k = 0; k < kRestHalvings; ++k) {
    const double middle = 0.5 * (above + below);
    (isFast(middle) ? above : below) = middle;
  }
  return length_ - below;
}

void Run::updateRest() {
  const double limit = scene_.stop.settleSpeed * size_;
  const bool isSlow = fastestSpeed() < limit;
  if (isOnPath() || !(isSlow || isStuck())) {
    restTime_ = 0;
    return;
  }
  const double within = isSlow ? restWithinStep(limit) : length_;
  restTime_ = within < length_ ? within : restTime_ + length_;
}

double Run::restMoment() const {
  if (!(restTime_ > 0)) return std::numeric_limits<double>::infinity();
  return time() + restNeeded_ - restTime_;
}

/// Nothing moves: a nudge, a stiffer pull or the timeline may change that, else the run is over.
void Run::restOrGoOn() {
  const bool isPulled = pullsToTarget() && timeline_.forcesAreOn();
  const double error = currentTargetError();
  const bool isShort = isPulled && error > kArrivedShare * size_;
  if (nudged_ != Nudged::Wholly && isShort && error > kThere * leastError_) {
    nudgeAtRest();
  } else if (isShort && !stiffness_.exhausted()) {
    stiffness_.stiffen();
    restTime_ = 0;
  } else if (isOnItsWay()) {
    restTime_ = 0;
    restNeeded_ *= 2;
  } else if (followTimeline(true) || (!timeline_.isOver(time()) && !timeline_.waitsForState())) {
    return;  // something acts now, or will
  } else if (nudged_ != Nudged::Wholly && !isPulled) {
    nudgeAtRest();
  } else if (timeline_.isOver(time())) {
    endAtRest();
  } else {
    end(Outcome::Locked, fmt::format("came to rest, yet {}", timeline_.pending()));
  }
}

// ------------------------------------------------------------------------------------------------
// Is a state that hardly moves at rest, or is it only slow?
//
// From rest, an implicit Euler step of length h moves bricks of mass M, damping D and stiffness K
// under the force F by dx = (M / h^2 + D / h + K)^-1 F. For long h mass and damping drop out, and
// dx comes near to K^-1 F, Newton's step to where the forces vanish. So steps 16 times as long as
// the one before, up to 1e7 s, show where the bricks would go in the end: if none goes a thousandth
// of a tile, the state is at rest.

namespace {

// Steps grow by this factor, up to so many seconds: what forces of rounding would move stays below
// a millionth of a tile.
constexpr double kStepGrowth = 16;
constexpr double kLongest = 1e7;
// So much of a tile is a motion.
constexpr double kMoved = 1e-3;

}  // namespace

double farthestMove(const Poses& from, const Poses& to, double tileSize) {
  double farthest = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const double turn = to[i].rotation.angularDistance(from[i].rotation);
    farthest = std::max(farthest, (to[i].position - from[i].position).norm() + turn * tileSize);
  }
  return farthest;
}

RestProbe probeRest(Dynamics& dynamics, const Motion& motion, double step,
                    const LoadSource& actuation, double tileSize) {
  RestProbe probe;
  Motion trial = motion;
  for (double length = kStepGrowth * step; length < kLongest && !probe.movesOn;
       length *= kStepGrowth) {
    trial.velocities.assign(trial.poses.size(), Velocity{});
    const StepReport report = dynamics.advance(trial, length, actuation);
    probe.work += report.work;
    if (report.unconverged > 0) break;  // what fails tells nothing
    probe.movesOn = farthestMove(motion.poses, trial.poses, tileSize) > kMoved * tileSize;
  }
  return probe;
}

// ------------------------------------------------------------------------------------------------
// A state where forces and joints are in balance is left by nobody but chance. What a run is given
// there, velocities v_i of a millionth of the model's size a second, grows as exp(s t) with the
// equilibrium's rate s, so that it takes ln(1e6) / s = 14 / s until it shows.
//
// Where the start moves by itself the nudge would only differ from seed to seed: 1e-6 of a tile
// after half a second of a cap. It moves by itself if what acts on it makes it faster than the
// nudge within kNudgeTime. At a singular state joints leave rounding of the loads, which is slower.
// A sheet that is pulled as a whole, yet cannot open, has a motion without a difference in angular
// velocities: that does not count.
//
// Symmetries: the mean over the group's images of the v_i keeps a symmetric motion symmetric.

namespace {

constexpr double kSpeed = 1e-6;  // model sizes a second
// Less of the turns that joints leave of a whole nudge is none.
constexpr double kLeft = 1e-3;

/// Uniform in [-1, 1) with the same bits from every standard library.
double uniform(std::mt19937& generator) {
  return static_cast<double>(generator()) / 2147483648.0 - 1.0;
}

/// The largest difference of an angular velocity from the mean, rad/s: 0 where all move as one.
double fastestOpening(const std::vector<Velocity>& velocities) {
  Vector3 mean = Vector3::Zero();
  for (const Velocity& velocity : velocities) mean += velocity.angular;
  mean /= static_cast<double>(velocities.size());
  double fastest = 0;
  for (const Velocity& velocity : velocities) {
    fastest = std::max(fastest, (velocity.angular - mean).norm());
  }
  return fastest;
}

/// What joints leave of velocities at a state.
std::vector<Velocity> fitted(const std::vector<Velocity>& velocities, const Poses& poses,
                             Dynamics& dynamics) {
  Motion motion = {poses, velocities};
  dynamics.fitVelocities(motion);
  return motion.velocities;
}

}  // namespace

std::vector<Velocity> nudge(std::size_t count, double modelSize, unsigned seed) {
  std::mt19937 generator(seed);
  const double speed = kSpeed * modelSize;
  std::vector<Velocity> velocities(count);
  for (Velocity& velocity : velocities) {
    const double x = uniform(generator);
    const double y = uniform(generator);
    const double z = uniform(generator);
    velocity.linear = speed * Vector3(x, y, z);
  }
  return velocities;
}

bool movesByItself(const std::vector<Velocity>& after, bool areJoined, double tileSize,
                   double modelSize) {
  double fastest = areJoined ? fastestOpening(after) * tileSize : 0;
  for (const Velocity& velocity : after) {
    if (areJoined) break;
    fastest = std::max(fastest, velocity.linear.norm() + velocity.angular.norm() * tileSize);
  }
  return fastest > kSpeed * modelSize;
}

std::vector<Velocity> symmetricNudge(const std::vector<Velocity>& whole, const Poses& poses,
                                     std::span<const Symmetry> group, Dynamics& dynamics) {
  std::vector<Velocity> symmetric = symmetricMean(whole, group);
  const double left = fastestOpening(fitted(symmetric, poses, dynamics));
  const double most = fastestOpening(fitted(whole, poses, dynamics));
  if (!(left > kLeft * most)) return {};
  return symmetric;
}

// ------------------------------------------------------------------------------------------------
// Leading tiles: springs k_f at the means and 40 k_f for the turns pull every tile to where its own
// rigid motion has it at the time (forces.h). After the last of it the springs have half a
// second to catch up. Compliant joints then stiffen geometrically, k(t) = k_0 (1e10 / k_0)^p with p
// from 0 to 1 in half a second, so that what is left of their openings is closed in one small step.

namespace {

// Turning counts this much more than place while the tiles are led.
constexpr double kTurnShare = 40;
// Damping while led, N s/m and, at a tile of 1 m, N m s.
constexpr double kForceDamping = 50;
constexpr double kTorqueDamping = 2;
// Seconds to catch up with a target that has stopped, and to stiffen joints that gave.
constexpr double kCatchUp = 0.5;
constexpr double kStiffeningTime = 0.5;
// The joints' stiffness at the end, N/m: what is left of their openings closes in one step.
constexpr double kClosingStiffness = 1e10;

// Their damping does not depend on the scene's: tiles are to follow, not to swing.
TargetSpringSettings leadingSprings(const Scene& scene) {
  const double edge = tileSize(scene.model);
  TargetSpringSettings springs;
  springs.springStiffness = scene.path.ledStiffness;
  springs.torqueStiffness = kTurnShare * scene.path.ledStiffness;
  springs.forceDamping = kForceDamping;
  springs.torqueDamping = kTorqueDamping * edge * edge;
  springs.adaptive = false;
  return springs;
}

}  // namespace

// The guide leads from the bricks' poses at the start of leading, not from the model's start.
PathFollower::PathFollower(const Scene& scene, const std::vector<Brick>& bricks, const Poses& start,
                           const std::vector<Tile>& target, double beginTime)
    : path_(scene.path),
      beginTime_(beginTime),
      guide_(bottomTiles(bricks, start), target),
      springs_(bricks, target, scene.model.pulledTiles, leadingSprings(scene)) {}

// Sets what the step at `time` (seconds) is led by. Returns false once leading is over.
bool PathFollower::prepareStep(double time, Dynamics& dynamics) {
  const double elapsed = time - beginTime_;
  springs_.setTarget(guide_.at(std::min(1.0, elapsed / path_.ledTime)));
  const double late = elapsed - path_.ledTime - kCatchUp;
  if (!path_.jointsGive()) return late <= 0;
  const double part = std::clamp(late / kStiffeningTime, 0.0, 1.0);
  const double range = std::max(1.0, kClosingStiffness / path_.jointStiffness);
  dynamics.setJointStiffness(path_.jointStiffness * std::pow(range, part));
  return late <= kStiffeningTime;
}

// ------------------------------------------------------------------------------------------------
// The timeline as it goes on: entries happen in their order, each as soon as it is due. One that
// waits for a state (rest, a target, an error) is looked at only as the first of a step, since what
// an entry does may change that state. Times are compared with a small allowance for rounding. A
// drag is a spring (forces.h) whose anchor moves along its path at even speed; it ends by
// itself.

namespace {

// Times are sums of steps: what is due within this of a time is due at it.
constexpr double kTimeRounding = 1e-9;

/// The point at a share (0 to 1) of a path's length.
Vector3 pointOnPath(const std::vector<Vector3>& path, double share) {
  double length = 0;
  for (std::size_t k = 1; k < path.size(); ++k) length += (path[k] - path[k - 1]).norm();
  double left = std::clamp(share, 0.0, 1.0) * length;
  for (std::size_t k = 1; k < path.size(); ++k) {
    const double piece = (path[k] - path[k - 1]).norm();
    if (left <= piece && piece > 0) return path[k - 1] + left / piece * (path[k] - path[k - 1]);
    left -= piece;
  }
  return path.back();
}

// Tiles in a file's numbers; an empty list means all of them.
std::string tilesText(std::vector<int> tiles, int countsFrom) {
  for (int& tile : tiles) tile += countsFrom;
  return tiles.empty() ? "all tiles" : fmt::format("tiles {}", fmt::join(tiles, ", "));
}

/// What an action acts on, for the record.
struct Describe {
  int countsFrom;  // of tiles
  std::string operator()(const timeline::Pin& pin) const {
    return tilesText(pin.tiles, countsFrom);
  }
  std::string operator()(const timeline::Unpin& unpin) const {
    return tilesText(unpin.tiles, countsFrom);
  }
  std::string operator()(const timeline::Drag& drag) const {
    return fmt::format("tile {} for {:g} s", countsFrom + drag.tile, drag.seconds);
  }
  std::string operator()(const timeline::Forces& forces) const { return forces.on ? "on" : "off"; }
  std::string operator()(const timeline::Pause& pause) const {
    return fmt::format("{:g} s", pause.seconds);
  }
  std::string operator()(const timeline::GoTo& goTo) const {
    return goTo.file.empty() ? "the model's" : goTo.file.string();
  }
  template <typename Other>
  std::string operator()(const Other&) const {
    return "";
  }
};

/// "pin tiles 3, 4".
std::string describe(const timeline::Action& action, int countsFrom) {
  const std::string what = std::visit(Describe{countsFrom}, action);
  return what.empty() ? actionName(action) : fmt::format("{} {}", actionName(action), what);
}

// What an entry waits for, in words for the reason of an end.
std::string momentText(const Occasion& moment) {
  switch (moment.kind) {
    case Occasion::Kind::AtTime:
      return fmt::format("{:g} s", moment.value);
    case Occasion::Kind::After:
      return fmt::format("{:g} s after the entry before", moment.value);
    case Occasion::Kind::AtRest:
      return "rest";
    case Occasion::Kind::AtTarget:
      return "the target";
    case Occasion::Kind::ErrorBelow:
      return fmt::format("an error below {:g} m", moment.value);
    case Occasion::Kind::ProgressAbove:
      return fmt::format("a progress of {:g}", moment.value);
  }
  return "";
}

}  // namespace

TimelineRunner::TimelineRunner(const Timeline& timeline, const std::vector<Brick>& bricks,
                               int countsFrom)
    : timeline_(timeline),
      bricks_(bricks),
      countsFrom_(countsFrom),
      pinned_(bricks.size(), false) {}

// Drags that are over go first; then entries as far as they are due.
bool TimelineRunner::carryOut(const TimelineView& view, TimelineStage& stage,
                              std::vector<Event>& events) {
  // A drag that ends now must not pull in the coming step.
  std::erase_if(drags_, [&](const ActiveDrag& active) {
    return view.time >= active.from + dragOf(active).seconds - kTimeRounding;
  });
  const std::size_t before = next_;
  // Only the first entry may wait for the state at hand: what it does changes that state.
  while (next_ < timeline_.size() && isDue(timeline_[next_].when, view)) {
    const TimelineEntry& entry = timeline_[next_];
    const bool ofTime = waitsForTime();
    if (next_ > before && !ofTime) break;
    carryOut(entry.action, view, stage);
    events.push_back({view.time, describe(entry.action, countsFrom_)});
    lastTime_ = view.time;
    ++next_;
  }
  return next_ > before;
}

/// When what is due by itself is due, seconds.
double TimelineRunner::dueTime(const Occasion& moment) const {
  return moment.kind == Occasion::Kind::After ? lastTime_ + moment.value : moment.value;
}

// Whether an entry's condition holds. Progress is the part of the error at the target's setting
// that is gone: 1 - error / startError.
bool TimelineRunner::isDue(const Occasion& moment, const TimelineView& view) const {
  switch (moment.kind) {
    case Occasion::Kind::AtTime:
    case Occasion::Kind::After:
      return view.time >= dueTime(moment) - kTimeRounding;
    case Occasion::Kind::AtRest:
      return view.atRest;
    case Occasion::Kind::AtTarget:
      return view.atTarget;
    case Occasion::Kind::ErrorBelow:
      return view.error < moment.value;
    case Occasion::Kind::ProgressAbove:
      return view.error <= (1 - moment.value) * view.startError;
  }
  return false;
}

// One action; `view` is the state before it.
void TimelineRunner::carryOut(const timeline::Action& action, const TimelineView& view,
                              TimelineStage& stage) {
  if (const auto* pinning = std::get_if<timeline::Pin>(&action)) {
    pin(pinning->tiles, true, stage);
  } else if (const auto* unpinning = std::get_if<timeline::Unpin>(&action)) {
    pin(unpinning->tiles, false, stage);
  } else if (const auto* drag = std::get_if<timeline::Drag>(&action)) {
    startDrag(*drag, view);
  } else if (const auto* forces = std::get_if<timeline::Forces>(&action)) {
    forcesOn_ = forces->on;
  } else if (const auto* pause = std::get_if<timeline::Pause>(&action)) {
    pausedUntil_ = view.time + pause->seconds - kTimeRounding;
  } else if (const auto* goTo = std::get_if<timeline::GoTo>(&action)) {
    stage.goTo(goTo->file.empty() ? nullptr : &goTo->tiles);
  } else if (std::holds_alternative<timeline::Reset>(action)) {
    reset(stage);
  } else if (std::holds_alternative<timeline::Quit>(action)) {
    stage.quit();
  }  // snapshots and exports are for those who read the events
}

/// No tiles named means all.
void TimelineRunner::pin(const std::vector<int>& tiles, bool pinned, TimelineStage& stage) {
  if (tiles.empty()) pinned_.assign(pinned_.size(), pinned);
  for (const int tile : tiles) pinned_[tile] = pinned;
  stage.setPinned(pinned_);
}

// The path begins where the point is now.
void TimelineRunner::startDrag(const timeline::Drag& drag, const TimelineView& view) {
  const Vector3 point =
      drag.vertex ? bricks_[drag.tile].bottom[*drag.vertex] : Vector3(Vector3::Zero());
  std::vector<Vector3> path = {(*view.poses)[drag.tile].apply(point)};
  path.insert(path.end(), drag.path.begin(), drag.path.end());
  drags_.push_back({next_, point, std::move(path), view.time});
}

// Drags end, forces act, all tiles are free, and the stage goes back to the start. The timeline
// itself goes on with its next entry.
void TimelineRunner::reset(TimelineStage& stage) {
  drags_.clear();
  forcesOn_ = true;
  pin({}, false, stage);
  stage.reset();
}

// The springs of all drags at a time (seconds), their anchors where they are then. The share of the
// path is that of the time: the speed is even.
std::vector<DragSpring> TimelineRunner::dragSprings(double time) const {
  std::vector<DragSpring> grips;
  for (const ActiveDrag& active : drags_) {
    const timeline::Drag& drag = dragOf(active);
    const double share = (time - active.from) / drag.seconds;
    grips.push_back(
        {drag.tile, {active.point, pointOnPath(active.path, share), drag.stiffness, drag.damping}});
  }
  return grips;
}

void TimelineRunner::addDrags(double time, const Poses& poses, std::vector<Load>& loads) const {
  for (const DragSpring& grip : dragSprings(time))
    addPointSpring(grip.spring, poses[grip.tile], loads[grip.tile]);
}

void TimelineRunner::transfer(StateTape& tape) {
  tape.transfer(next_, lastTime_, pausedUntil_, forcesOn_, pinned_, drags_);
}

// No entry waits, no drag pulls, no pause holds.
bool TimelineRunner::isOver(double time) const {
  return next_ == timeline_.size() && drags_.empty() && !isPaused(time);
}

// Steps end there, so that what is due by itself happens at its own time.
double TimelineRunner::nextMoment(double time) const {
  double next = std::numeric_limits<double>::infinity();
  const auto consider = [&](double moment) {
    if (moment > time + kTimeRounding) next = std::min(next, moment);
  };
  if (waitsForTime()) consider(dueTime(timeline_[next_].when));
  for (const ActiveDrag& active : drags_) consider(active.from + dragOf(active).seconds);
  consider(pausedUntil_ + kTimeRounding);
  return next;
}

// Whether the next entry comes by itself. A run at rest must not end before it.
bool TimelineRunner::waitsForTime() const {
  if (next_ == timeline_.size()) return false;
  const Occasion::Kind kind = timeline_[next_].when.kind;
  return kind == Occasion::Kind::AtTime || kind == Occasion::Kind::After;
}

// Whether only the bricks can bring the next entry about: at rest the run then waits in vain.
bool TimelineRunner::waitsForState() const {
  return next_ < timeline_.size() && !waitsForTime() && drags_.empty();
}

std::vector<int> TimelineRunner::pinnedTiles() const {
  std::vector<int> tiles;
  for (std::size_t i = 0; i < pinned_.size(); ++i) {
    if (pinned_[i]) tiles.push_back(static_cast<int>(i));
  }
  return tiles;
}

// Empty when all entries have happened.
std::string TimelineRunner::pending() const {
  if (next_ == timeline_.size()) return "";
  const TimelineEntry& entry = timeline_[next_];
  return fmt::format("the timeline still waits for {} to {}", momentText(entry.when),
                     actionName(entry.action));
}

}  // namespace kirireel
