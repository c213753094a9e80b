// One run with dynamics: the loop over steps and its decisions.
//
//   start: close joints, set the initial velocities, measure
//   while the run continues:
//     the timeline executes due entries
//     the clock sets the end of the step: the next check, or an earlier due time
//     the drive enters the phase of the step (open, guide, close, settle; run_drive.h)
//     the solver moves the bricks under the acting forces (run_motion.h, run_mechanics.h)
//     the recorder measures the step and reports it (run_recorder.h)
//     rest and stalls are detected (rest.h, AdaptiveStiffness)
//     at rest: an action restarts the motion, or the run ends
//   end: the last sample, and the reason for the end (RunReasons)
//
// At rest these actions are tried in order:
// 1. A perturbation, if there is a pull to a target that is not reached, and the run had no
//    perturbation or only its symmetric part. An equilibrium after a motion may also be unstable,
//    for example that of a ring that closes symmetrically.
// 2. Stiffer springs.
// 3. Long implicit steps from rest, which detect slow bricks.
// 4. Timeline entries that wait for rest.
// 5. A perturbation, if there is no pull to a target.
//
// If none of these moves the bricks, the run ends. It is settled or locked, depending on the
// remaining error. If only the pull acts, a last step moves bricks near the nearest state with
// closed joints into that state.
//
// If a step loses a brick or is interrupted, the run restores the state, the time and the energy
// account from before the step.
#include "sim/run/run.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/run/forces.h"
#include "sim/scene/scene_parts.h"
#include "sim/trajectory/measures.h"
#include "sim/trajectory/sheet.h"

namespace kirireel::run {
namespace {

// Below this target error, as a fraction of the model's size, springs are not stiffened further.
constexpr double kArrivedShare = 1e-9;
// At rest, bricks within this fraction of a tile of the nearest state move into it. So do bricks
// within this multiple of that state's joint gap.
constexpr double kSettlingShare = 1e-3;
constexpr double kSettlingGaps = 10;
// Energy gain of the steps that causes no warning, as a fraction of the energy input.
constexpr double kEnergyGain = 0.01;

}  // namespace

Run::Run(const scene::Scene& scene, const AssembledState& nearest, const RunObservers& observers,
         Checkpoints* checkpoints, const MechanismPath* guide)
    : bricks_(scene),
      clock_(RunMotion::checkIntervalOf(scene)),
      target_(bricks_, nearest),
      drive_(bricks_, clock_, guide),
      timeline_(scene.timeline, bricks_.bricks, scene.model.fileOrder.countsFrom, scene.model.unit),
      motion_(bricks_, clock_),
      forces_(bricks_, clock_, timeline_, drive_, motion_),
      joints_(bricks_),
      rest_(bricks_),
      perturber_(bricks_),
      recorder_(bricks_, clock_, motion_, forces_, observers, nearest, checkpoints),
      checkpoints_(checkpoints) {}

// ------------------------------------------------------------------------------------------------
// The loop.

// The whole run: start or checkpoint, the loop, the end.
DeploymentResult Run::finish() {
  spent_.begin();
  start();
  if (checkpoints_ && checkpoints_->run()) {
    resumeFrom(*checkpoints_->run());
  } else {
    recorder_.takeSample();
  }
  advanceToEnd();
  if (!ending_) end(reasons().late(time()));
  recorder_.takeLastSample();
  return result();
}

// Closes joints, executes the timeline's entries for the start, sets the velocities and measures.
void Run::start() {
  const scene::Scene& scene = bricks_.scene;
  Motion& now = motion_.now();
  joints_.closeAtStart(motion_, recorder_.figures());
  now.velocities.assign(bricks_.bricks.size(), Velocity{});
  motion_.beginHere();
  goTo(nullptr);
  followTimeline(false);
  if (scene.velocities.empty()) {
    perturber_.giveAtStart(motion_, forces_.loadsNow(), joints_, timeline_.pinned());
  } else {
    now.velocities = scene::initialVelocities(scene.velocities, bricks_.bricks, now.poses);
    if (!scene.path.jointsAreCompliant()) motion_.solver().fitVelocities(now);
  }
  motion_.beginHere();
  recorder_.begin(drive_.jointsAreCompliant());
}

// After an interrupted step the solver's state is invalid. The last checkpoint is therefore kept.
void Run::advanceToEnd() {
  try {
    const InterruptionCatcher catcher;
    while (shouldContinue()) advance();
  } catch (const Interrupted&) {
    if (isTrial_) throw;
    interrupt();
  }
}

// Whether to continue after a step.
bool Run::shouldContinue() {
  if (ending_) return false;
  const bool shouldStop = recorder_.shouldStop();
  if (checkpoints_ && (shouldStop || checkpoints_->isDue())) saveState();
  if (shouldStop) interrupt();
  return !ending_ && !clock_.isDue(bricks_.scene.stop.duration);
}

// One iteration of the loop, including pauses.
void Run::advance() {
  followTimeline(false);
  if (ending_) return;
  clock_.beginStep(nextMoment());
  motion_.beginStep();
  if (timeline_.isPaused(time())) {
    clock_.endStep();
    return recorder_.takeSamples();
  }
  takeStep();
  if (ending_) return;
  recorder_.showStep();
  // The run is at rest only if the stiffer springs move nothing either.
  if (stiffensIfStalled()) rest_.restartCount();
  recorder_.takeSamples();
  if (!ending_ && clock_.isDue(rest_.moment(time()))) restOrContinue();
}

// A step ends when an event of the run is due, and at the end of the run.
double Run::nextMoment() const {
  double due =
      std::min({timeline_.nextMoment(time()), drive_.nextMoment(), bricks_.scene.stop.duration});
  const double rested = rest_.moment(time());
  if (!clock_.isDue(rested)) due = std::min(due, rested);
  const double stalled = drive_.stiffness().nextMoment();
  if (watchesStall() && !clock_.isDue(stalled)) due = std::min(due, stalled);
  return due;
}

// Takes and measures one step. A step that loses a brick or is interrupted does not count: the run
// ends at its beginning.
void Run::takeStep() {
  const StepClock clockBefore = clock_;
  const RunMechanics::Account account = recorder_.account();
  const auto takeBack = [&] {
    recorder_.goBackTo(account);
    motion_.takeBack();
    clock_ = clockBefore;
  };
  try {
    const StepReport report = advanceBricks();
    if (std::string fault = faultOfStep(); !fault.empty()) {
      takeBack();
      return end({Outcome::Diverged, std::move(fault)});
    }
    recorder_.observe(report, drive_.jointsAreCompliant());
    rest_.observe(motion_, clock_.length(), report, drive_.isOnPath());
  } catch (const Interrupted&) {
    takeBack();
    throw;
  }
}

// Why the last step does not count; empty if it does.
std::string Run::faultOfStep() const {
  if (motion_.isLost()) {
    const bool areLoose = bricks_.scene.model.joints.empty();
    return fmt::format("{} left all bounds at {:.4g} s. Try {}",
                       areLoose ? "a brick without joints" : "a brick", time(),
                       areLoose ? "a shorter `duration`, or `actuation = none`"
                                : "a shorter `timestep` or more damping");
  }
  const auto bricks = bricks_.ties.pairForces.findJump(motion_.before().poses, motion_.poses());
  if (!bricks) return {};
  const int countsFrom = bricks_.scene.model.fileOrder.countsFrom;
  return fmt::format(
      "the hinge of tiles {} and {} turned by more than a full turn at {:.4g} s; its spring has no "
      "angle there. Try `contacts = all`",
      countsFrom + bricks->first, countsFrom + bricks->second, time());
}

// The phase of the step, then the solver, with the energy account before and after.
StepReport Run::advanceBricks() {
  if (drive_.beginStep(target_, motion_.poses(), motion_.solver())) {
    joints_.closeAtEndOfPath(motion_, recorder_.figures());
  }
  const bool isToTolerance = motion_.wantsTolerance() && !joints_.isMisfit();
  recorder_.beginStep();
  const StepReport report = motion_.advance(forces_.timedLoads(), isToTolerance);
  recorder_.endStep(report, isToTolerance);
  clock_.endStep();
  return report;
}

// Records the end of the run once, as the last event.
void Run::end(RunEnding ending) {
  recorder_.events().push_back({time(), endText(ending.outcome, ending.reason)});
  ending_ = std::move(ending);
}

// All results of the run.
DeploymentResult Run::result() {
  DeploymentResult result;
  trajectory::Trajectory& trajectory = result.trajectory;
  static_cast<trajectory::Subject&>(trajectory) = trajectory::subjectOf(bricks_.scene);
  trajectory.events = std::move(recorder_.events());
  recorder_.figures().copyTo(result);
  result.outcome = ending_->outcome;
  result.reason = ending_->reason;
  target_.noteOwnError(recorder_.figures().assembledError());
  if (target_.isPulledTo()) result.atTarget = target_.hasArrived(motion_.poses());
  if (!trajectory.pairForces.empty()) {
    result.elasticity =
        brick::elasticityOf(trajectory.pairForces, motion_.start(), motion_.poses());
  }
  warnOfEnergy(result.warnings);
  result.needs = bricks_.needs;
  result.path = bricks_.scene.path;
  result.pathReason = joints_.trouble();
  result.cost.cpuSeconds = spent_.seconds();
  return result;
}

// First-order steps and stiff springs can add energy without any input. Steps to a tolerance may
// move the bricks by this tolerance, which changes their potential energy. No warning for that.
void Run::warnOfEnergy(std::vector<std::string>& warnings) const {
  if (bricks_.scene.actuation.drive != scene::Drive::None) return;
  const RunMechanics::Account account = recorder_.account();
  const double gain = -account.now.integrated();
  const double source = account.largestWork;
  double allowed = kEnergyGain * source;
  if (keepsTolerance(bricks_.scene)) {
    double weight = 0;
    for (const brick::Brick& brick : bricks_.bricks) {
      weight += brick.mass * bricks_.scene.environment.gravity.norm();
    }
    const double move = bricks_.scene.solver.tolerance * model::tileSize(bricks_.scene.model);
    allowed = std::max(allowed, move * weight);
  }
  if (!(gain > allowed)) return;
  warnings.push_back(fmt::format(
      "energy grows by {:.3g} J ({:.2g}% of the input) without a drive. Use a smaller `{}`", gain,
      100 * gain / source, keepsTolerance(bricks_.scene) ? "tolerance" : "timestep"));
}

// ------------------------------------------------------------------------------------------------
// Actions at rest and when the pull stalls.

// Whether stiffer springs may reduce the error of the current target.
bool Run::watchesStall() const {
  return target_.isPulledTo() && !drive_.isOnPath() && timeline_.forcesAreOn();
}

bool Run::stiffensIfStalled() {
  return watchesStall() && drive_.stiffness().observe(targetErrorNow(), time(), clock_.length());
}

// At rest: tries a perturbation, stiffer springs and the timeline. Otherwise the run ends.
void Run::restOrContinue() {
  const bool isPulled = target_.isPulledTo() && timeline_.forcesAreOn();
  const double error = targetErrorNow();
  const bool isShort = isPulled && error > kArrivedShare * bricks_.size;
  if (perturber_.canGive() && isShort && !target_.isAtSpringEquilibrium(error)) {
    perturber_.giveAtRest(motion_);
    rest_.restartCount();
  } else if (isShort && !drive_.stiffness().exhausted()) {
    drive_.stiffness().stiffen();
    rest_.restartCount();
  } else if (isOnlySlow()) {
    rest_.doubleRestTime();
  } else if (followTimeline(true) || (!timeline_.isOver(time()) && !timeline_.waitsForState())) {
    return;  // an entry acts now or later
  } else if (perturber_.canGive() && !isPulled) {
    perturber_.giveAtRest(motion_);
    rest_.restartCount();
  } else if (timeline_.isOver(time())) {
    settleAtNearest();
    settleAtEquilibrium();
    end(reasons().atRest(isTrial_));
  } else {
    end({Outcome::Locked, fmt::format("came to rest, but {}", timeline_.pending())});
  }
}

// The run may have found a nearer state than the search.
RunReasons Run::reasons() {
  target_.noteOwnError(recorder_.figures().assembledError());
  return {bricks_, target_, motion_, forces_, rest_};
}

// Whether bricks that hardly move are still in motion: soft springs and heavy bricks are slow.
// Springs at hinges count too, but not expansion, which would never end.
bool Run::isOnlySlow() {
  if (rest_.isStuck(motion_.poses()) || bricks_.scene.solver.kind == scene::SolverKind::Bullet)
    return false;
  if (target_.isPulledTo() && timeline_.forcesAreOn()) {
    if (target_.isAtSpringEquilibrium(targetErrorNow())) return false;
  } else if (!areOnSprings()) {
    return false;
  }
  return probe().movesOn;
}

// Whether the bricks have an equilibrium by springs at their hinges.
bool Run::areOnSprings() const {
  return bricks_.scene.hinges.areOn() && !drive_.isEndless();
}

// Where the bricks would move in the long run.
RestProbe Run::probe() {
  RestProbe probe = probeRest(*motion_.copyOfSolver(), motion_.now(), clock_.checkInterval(),
                              forces_.loadsNow(), bricks_.tileSize);
  recorder_.figures().addWork(probe.work);
  return probe;
}

// ------------------------------------------------------------------------------------------------
// Last step to the nearest state or to the equilibrium.

// Whether only the pull to the target acts on the bricks, apart from joints and contacts.
bool Run::isOnlyPulled() const {
  const scene::Scene& scene = bricks_.scene;
  const scene::Environment& around = scene.environment;
  const bool isFree = timeline_.forcesAreOn() && forces_.pinnedTiles().empty() &&
                      timeline_.dragSprings(time()).empty();
  return isFree && target_.isPulledTo() && scene.solver.kind == scene::SolverKind::Direct &&
         bricks_.ties.pairForces.empty() && around.gravity.isZero(0) && !around.ground &&
         around.obstacles.empty();
}

// Springs slow down near the target, and their equilibrium is the least sum of squares. One last
// step moves the bricks to the nearest state with closed joints, if it is near and adds no overlap.
void Run::settleAtNearest() {
  const Poses* nearest = target_.nearestPoses();
  if (!nearest || !isOnlyPulled() || target_.isNearest(targetErrorNow())) return;
  const double tile = bricks_.tileSize;
  const double gap = trajectory::jointGap(bricks_.pivots, *nearest).max;
  const double reach =
      std::max({kSettlingShare * tile, kSettlingGaps * gap, roundedReach(bricks_.scene.model)});
  if (farthestMove(motion_.poses(), *nearest, tile) > reach) return;
  RunFigures& figures = recorder_.figures();
  const double allowed =
      std::max(figures.overlapsOf(motion_.poses()).grown, kAllowedOverlap * tile);
  if (bricks_.needs.contacts.on && figures.overlapsOf(*nearest).grown > allowed) return;
  endAt(*nearest);
}

// Bricks at the settle speed are near their equilibrium: their forces are out of balance by this
// speed times a frequency. The last step moves them into the equilibrium. With contacts, long steps
// are not exact enough.
void Run::settleAtEquilibrium() {
  if (!areOnSprings() || target_.isPulledTo() || bricks_.needs.contacts.on ||
      bricks_.scene.solver.kind != scene::SolverKind::Direct || isTrial_)
    return;
  const RestProbe found = probe();
  if (found.isConverged) endAt(found.poses);
}

// The last step, which ends at rest in these poses.
void Run::endAt(const Poses& poses) {
  if (clock_.isDue(bricks_.scene.stop.duration)) return;
  clock_.beginStep(nextMoment());
  motion_.beginStep();
  recorder_.beginStep();
  motion_.now() = {poses, std::vector<Velocity>(bricks_.bricks.size())};
  const StepReport report = {.steps = 1};
  recorder_.endStep(report, false);
  clock_.endStep();
  recorder_.observe(report, drive_.jointsAreCompliant());
  recorder_.showStep();
  recorder_.takeSamples();
}

// ------------------------------------------------------------------------------------------------
// The timeline.

// Executes the due entries of the timeline. Returns whether there were any.
bool Run::followTimeline(bool atRest) {
  if (timeline_.isOver(time())) return false;
  const double error = targetErrorNow();
  const bool isAtTarget = atRest && target_.tiles() && target_.isAtSpringEquilibrium(error);
  const TimelineView view = {time(),     atRest,          error, target_.startError(),
                             isAtTarget, &motion_.poses()};
  if (!timeline_.carryOut(view, *this, recorder_.events())) return false;
  rest_.restartCount();
  return true;
}

// A pin that stops a moving tile is an impact without rebound: the other tiles keep the nearest
// velocities, in the metric of the masses, that the joints allow. Bullet stops pinned tiles itself.
void Run::setPinned(const std::vector<bool>& pinned) {
  motion_.solver().setPinned(pinned);
  if (bricks_.scene.solver.kind != scene::SolverKind::Direct) return;
  Motion& now = motion_.now();
  const Motion before = now;
  bool areStopped = false;
  for (std::size_t i = 0; i < pinned.size(); ++i) {
    Velocity& velocity = now.velocities[i];
    if (!pinned[i] || (velocity.linear.isZero(0) && velocity.angular.isZero(0))) continue;
    velocity = {};
    areStopped = true;
  }
  if (!areStopped) return;
  if (!std::isfinite(motion_.solver().jointStiffness())) motion_.solver().fitVelocities(now);
  recorder_.addImpact(before, now);
}

// Null selects the model's own target.
void Run::goTo(const std::vector<model::Tile>* target) {
  perturber_.reset();
  target_.set(target, motion_.poses());
  drive_.startTowards(target_, motion_.poses());
}

// Restores the initial state of the run.
void Run::reset() {
  motion_.goBack();
  joints_.hold(motion_.solver());
  goTo(nullptr);
  perturber_.giveAtStart(motion_, forces_.loadsNow(), joints_, timeline_.pinned());
}

void Run::quit() {
  end({Outcome::OutOfTime, fmt::format("the timeline ended the run at {:.4g} s", time())});
}

// ------------------------------------------------------------------------------------------------
// Checkpoints. A checkpoint stores the state of the run, then each sample with the figures at that
// time. A run that continues from it can therefore deliver the samples again.

void Run::transfer(StateTape& tape) {
  tape.transfer(motion_, target_);
  recorder_.transfer(tape);
  drive_.transfer(tape, target_);
  tape.transfer(timeline_, joints_, rest_, perturber_, spent_);
}

void Run::saveState() {
  StateTape tape;
  transfer(tape);
  checkpoints_->save({time(), tape.numbers()});
}

// Delivers the samples of earlier processes, then continues from their last state. If the run ends
// during this, the checkpoint stays as it is.
void Run::resumeFrom(const RunState& state) {
  StateTape tape(state.numbers);
  transfer(tape);
  const std::optional<trajectory::Sample> last = recorder_.showAgain(state.time);
  if (!last) return;
  motion_.now().poses = last->poses;
  interrupt();
}

// ------------------------------------------------------------------------------------------------
// Reasons for the end of a run. If it misses its target, the first reason that applies is reported.
// Each states a fact that was measured in the last state:
// 1. The timeline switched the springs off.
// 2. Friction on the ground can hold each tile, but joints without friction would not.
// 3. Contacts carry load, and nothing but the pull can press them.
// 4. Steps fail, and no brick moves.
// 5. The joints leave no freedom.
// 6. No state with closed joints is known that is nearer.
// 7. The pull is in equilibrium with other forces: gravity, springs between tiles, pins, contacts.
// 8. Only the pull acts. It is in equilibrium, although a nearer state is known.

namespace {

// With this joint ratio, tiles without freedom can usually move.
constexpr double kCompliantRatio = 100;

// Maximum number of contacts or tiles in the reason.
constexpr std::size_t kNamed = 3;

// Tiles lie on the ground if they are no higher than this fraction of a tile above it.
constexpr double kLyingShare = 1e-3;

// Forces below this fraction of the largest force of the pull do not count.
constexpr double kActingShare = 1e-3;

/// For example "tiles 3 and 4, tile 5 and the ground and 2 more".
std::string listed(std::vector<std::string> names) {
  const std::size_t count = names.size();
  names.resize(std::min(count, kNamed));
  std::string text = fmt::format("{}", fmt::join(names, ", "));
  if (count > kNamed) text += fmt::format(" and {} more", count - kNamed);
  return text;
}

/// The largest force, newtons. Moments count at the radius `tileSize`.
double largestOf(const std::vector<Vector6>& forces, double tileSize) {
  double largest = 0;
  for (const Vector6& force : forces) {
    largest = std::max({largest, force.head<3>().norm(), force.tail<3>().norm() / tileSize});
  }
  return largest;
}

}  // namespace

RunEnding RunReasons::atRest(bool isTrial) const {
  if (!target_.isPulledTo()) {
    return {Outcome::Settled, target_.tiles() ? "came to rest; nothing pulls to the target"
                                              : "came to rest; there is no target"};
  }
  const double error = target_.error(motion_.poses());
  const LengthUnit& unit = bricks_.scene.model.unit;
  if (target_.hasArrived(motion_.poses())) {
    return {Outcome::Settled,
            fmt::format("came to rest {} from the target", lengthText(error, unit))};
  }
  return {Outcome::Locked, fmt::format("came to rest {} short of the target: {}",
                                       lengthText(error, unit), isTrial ? "" : stopReason())};
}

RunEnding RunReasons::late(double time) const {
  const double speed = fastestCorner(bricks_.bricks, motion_.now());
  const bool isSlow = speed < bricks_.scene.stop.settleSpeed * bricks_.size;
  std::string text =
      fmt::format("{} after {:.4g} s", isSlow ? "not known to be at rest" : "still moving", time);
  const LengthUnit& unit = bricks_.scene.model.unit;
  text += fmt::format(", at {}/s at most", lengthText(speed, unit, 2));
  if (target_.isPulledTo()) {
    text += fmt::format(", {} from the target", lengthText(target_.error(motion_.poses()), unit));
  }
  if (const std::string held = isSlow ? friction() : ""; !held.empty()) text += ": " + held;
  return {Outcome::OutOfTime, text};
}

// Whether the joints allow only rigid motions of the whole sheet.
bool RunReasons::isImmobile() const {
  const trajectory::Freedom freedom =
      bricks_.needs.planar.on ? trajectory::Freedom::Plane : trajectory::Freedom::Space;
  const trajectory::Mobility found =
      trajectory::mobility(bricks_.scene.model, brick::bottomTiles(bricks_.bricks, motion_.poses()),
                           freedom, bricks_.scene.brick.thickness);
  return found.isCertain() && found.freedoms <= 0;
}

// Forces of everything but joints, pins and contacts on the bricks at rest.
std::vector<Vector6> RunReasons::forcesAtRest() const {
  const Motion atRest = {motion_.poses(), std::vector<Velocity>(bricks_.bricks.size())};
  return forces_.appliedForces(forces_.time(), atRest);
}

// Whether the ground's friction can hold each tile against all other forces except contacts. The
// condition is |F| <= mu m g for the horizontal force F. Empty if it fails, if there is nothing to
// hold, or if the tiles do not lie on the ground.
std::string RunReasons::friction() const {
  const scene::Environment& environment = bricks_.scene.environment;
  if (!environment.ground) return "";
  const std::vector<mechanics::Support> supports = frictionOnGround(environment, bricks_.bricks);
  if (supports.empty()) return "";
  const double highest =
      environment.ground->height + bricks_.scene.brick.thickness + kLyingShare * bricks_.tileSize;
  for (const model::Tile& tile : brick::bottomTiles(bricks_.bricks, motion_.poses())) {
    for (const Vector3& vertex : tile.vertices) {
      if (vertex.z() > highest) return "";
    }
  }
  std::vector<double> maxForce(bricks_.bricks.size(), 0);
  for (const mechanics::Support& support : supports) {
    maxForce[static_cast<std::size_t>(support.brick)] += support.largestForce;
  }
  const std::vector<Vector6> forces = forcesAtRest();
  double pull = 0, most = 1;
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const double force = forces[i].head<2>().norm();
    if (force > maxForce[i]) return "";
    if (pull * maxForce[i] > force * most) continue;
    pull = force;
    most = maxForce[i];
  }
  if (pull == 0) return "";
  return fmt::format(
      "friction on the ground holds the tiles: the drive pulls each with at most {:.3g} N, "
      "friction holds up to mu m g = {:.3g} N. Lower `ground_friction` or raise `spring_stiffness`",
      pull, most);
}

// Whether gravity acts on the motion. The plane of a planar scene carries the part across it.
bool RunReasons::isGravityActing() const {
  const Vector3& gravity = bricks_.scene.environment.gravity;
  return bricks_.needs.planar.on ? !gravity.head<2>().isZero(0) : !gravity.isZero(0);
}

// Whether friction on the ground carries a part of the pull, as in the last step.
bool RunReasons::isFrictionActing() const {
  const Motion atRest = {motion_.poses(), std::vector<Velocity>(bricks_.bricks.size())};
  const double least = kActingShare * largestOf(forcesAtRest(), bricks_.tileSize);
  return std::ranges::any_of(
      forces_.holds(forces_.time(), atRest), [&](const trajectory::Hold& hold) {
        const bool isOfGround =
            hold.kind == trajectory::HoldKind::Contact && hold.other == trajectory::Hold::kGround;
        return isOfGround && hold.force.head<2>().norm() > least;
      });
}

// The tiles whose pins carry load, from the reactions of the state at rest.
std::vector<std::string> RunReasons::loadedPins() const {
  const std::vector<bool>& pinned = forces_.pinned();
  std::vector<std::string> names;
  if (std::ranges::find(pinned, true) == pinned.end()) return names;
  const Motion atRest = {motion_.poses(), std::vector<Velocity>(bricks_.bricks.size())};
  std::vector<Vector6> applied = forcesAtRest();
  const double least = kActingShare * largestOf(applied, bricks_.tileSize);
  for (const trajectory::Hold& hold : forces_.holds(forces_.time(), atRest)) {
    if (hold.kind == trajectory::HoldKind::Contact) addContact(hold, motion_.poses(), applied);
  }
  const mechanics::Reactions reactions =
      mechanics::makeReactionSolver(bricks_.bricks, bricks_.ties.pivots, bricks_.needs.planar.on,
                                    bricks_.tileSize)
          ->solve(atRest, applied, pinned, forces_.jointStiffness());
  for (std::size_t i = 0; i < pinned.size(); ++i) {
    if (!pinned[i] || largestOf({reactions.pinForces[i]}, bricks_.tileSize) <= least) continue;
    names.push_back(
        fmt::format("tile {}", bricks_.scene.model.fileOrder.countsFrom + static_cast<int>(i)));
  }
  return names;
}

// What else acts on the bricks, besides the pull and the joints.
std::vector<std::string> RunReasons::otherForces() const {
  std::vector<std::string> others;
  if (isGravityActing()) others.emplace_back("gravity");
  if (isFrictionActing()) others.emplace_back("friction on the ground");
  std::vector<Vector6> between(bricks_.bricks.size(), Vector6::Zero());
  const Motion atRest = {motion_.poses(), std::vector<Velocity>(bricks_.bricks.size())};
  for (const std::shared_ptr<const brick::PairForce>& force : bricks_.ties.pairForces) {
    force->addForces(atRest, between);
  }
  if (largestOf(between, bricks_.tileSize) >
      kActingShare * largestOf(forcesAtRest(), bricks_.tileSize)) {
    others.emplace_back("springs between tiles");
  }
  if (const std::vector<std::string> pins = loadedPins(); !pins.empty()) {
    others.push_back("the pins of " + listed(pins));
  }
  return others;
}

// Why no step moves the bricks.
std::string RunReasons::failingSteps() const {
  std::string text = "no further step keeps the joints closed";
  if (bricks_.needs.contacts.on) text += " and the tiles apart";
  std::vector<std::string> pinned;
  for (const int tile : forces_.pinnedTiles()) {
    pinned.push_back(fmt::format("{}", bricks_.scene.model.fileOrder.countsFrom + tile));
  }
  return pinned.empty() ? text : fmt::format("{}, with pinned tiles {}", text, listed(pinned));
}

// The reason why a run at rest has not reached its target.
std::string RunReasons::stopReason() const {
  if (bricks_.scene.solver.kind == scene::SolverKind::Bullet)
    return "the baseline solver reports no reason";
  if (!forces_.isDriveOn()) return "the timeline switched the springs off";
  if (const std::string held = friction(); !held.empty() && !isImmobile()) return held;
  std::vector<std::string> others = otherForces();
  const std::vector<std::string> contacts = motion_.solver().loadedContacts();
  if (others.empty() && !contacts.empty()) return "contact stops " + listed(contacts);
  if (rest_.isStuck(motion_.poses())) return failingSteps();
  if (isImmobile()) {
    return fmt::format(
        "the joints allow no motion (0 degrees of freedom). Compliant joints may (`path = guided` "
        "with `joint_ratio = {:g}`)",
        kCompliantRatio);
  }
  const double error = target_.error(motion_.poses());
  if (target_.isNearest(error)) return "no nearer state with closed joints was found";
  if (!contacts.empty()) others.push_back("contacts of " + listed(contacts));
  if (!others.empty()) {
    return fmt::format("the pull is in equilibrium with {}", fmt::join(others, ", "));
  }
  const std::string known =
      fmt::format("a state with closed joints exists {} from the target",
                  lengthText(target_.nearestError(), bricks_.scene.model.unit));
  return target_.isAtSpringEquilibrium(error)
             ? "the springs are in equilibrium, although " + known
             : "stuck in a local energy minimum, although " + known;
}

}  // namespace kirireel::run
