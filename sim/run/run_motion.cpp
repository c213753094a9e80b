// Motion of the bricks of a run. The solver takes the steps. This class stores the state at the
// start of the step and the solver's intermediate states. States within the step are interpolated
// from them:
//
// - If a tolerance in time was kept: cubics through the intermediate states, with velocities on
//   both sides. Velocities are interpolated linearly.
// - Otherwise: linear positions, and rotations by the shortest path, between the ends of the step.
//
// A separate solver closes the joints of such states. Sampling therefore does not change the run.
#include "sim/run/run_motion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include <fmt/format.h>

#include "sim/mechanics/extrapolation.h"
#include "sim/run/assembled_state.h"
#include "sim/run/forces.h"
#include "sim/scene/scene_needs.h"
#include "sim/scene/scene_parts.h"
#include "sim/trajectory/measures.h"

namespace kirireel::run {
namespace {

// A run has diverged if a brick has moved this many model sizes relative to all bricks together.
constexpr double kLostDistance = 1e3;
// Closing joints may cause overlaps up to this fraction of a tile.
constexpr double kPushedShare = 1e-4;
// Timesteps per check in a run that keeps a tolerance in time.
constexpr int kStepsAtOnce = 4;

}  // namespace

SceneBricks::SceneBricks(const scene::Scene& given)
    : scene(given),
      bricks(brick::makeBricks(given.model.tiles, given.brick)),
      pivots(brick::makePivots(given.model.joints, bricks)),
      ties(scene::dynamicTies(given, bricks)),
      needs(scene::sceneNeeds(given)),
      size(model::modelSize(given.model)),
      tileSize(kirireel::model::tileSize(given.model)) {}

// ------------------------------------------------------------------------------------------------
// Time.

// A due time that equals the next check up to rounding is moved to that check.
void StepClock::beginStep(double due) {
  const double untilCheck = checkInterval_ - sinceCheck_;
  const double untilDue = due - time();
  length_ = untilDue < untilCheck - kSameTime * checkInterval_ ? untilDue : untilCheck;
}

void StepClock::endStep() {
  sinceCheck_ += length_;
  if (sinceCheck_ < checkInterval_ - kSameTime * checkInterval_) return;
  ++checks_;
  sinceCheck_ = 0;
}

// ------------------------------------------------------------------------------------------------
// The bricks in motion.

RunMotion::RunMotion(const SceneBricks& bricks, const StepClock& clock)
    : bricks_(bricks),
      clock_(clock),
      wantsTolerance_(keepsTolerance(bricks.scene)),
      now_{brick::startPoses(bricks.scene.model.tiles, bricks.bricks), {}},
      contactStart_(now_.poses),
      solver_(makeSolver()) {}

double RunMotion::checkIntervalOf(const scene::Scene& scene) {
  return scene.solver.timestep * (keepsTolerance(scene) ? kStepsAtOnce : 1);
}

std::unique_ptr<Dynamics> RunMotion::makeSolver() const {
  const scene::Scene& scene = bricks_.scene;
  std::unique_ptr<Dynamics> solver =
      makeDynamics(scene, bricks_.needs, bricks_.bricks, contactStart_);
  if (wantsTolerance_) {
    solver->setTolerance({scene.solver.tolerance, scene.solver.timestep, clock_.checkInterval()});
  }
  return solver;
}

std::unique_ptr<Dynamics> RunMotion::copyOfSolver() {
  std::unique_ptr<Dynamics> copy = makeSolver();
  StateTape recorded;
  recorded.transfer(*solver_);
  StateTape(recorded.numbers()).transfer(*copy);
  return copy;
}

void RunMotion::beginContactsHere() {
  contactStart_ = now_.poses;
  solver_ = makeSolver();
}

void RunMotion::beginHere() {
  start_ = now_.poses;
}

// A new solver discards the contacts and multipliers of earlier steps.
void RunMotion::goBack() {
  now_ = {start_, std::vector<Velocity>(bricks_.bricks.size())};
  solver_ = makeSolver();
}

void RunMotion::beginStep() {
  before_ = now_;
  isSmooth_ = false;
}

// Each fixed step uses the loads at its own start.
StepReport RunMotion::advance(const mechanics::TimedLoads& loads, bool isToTolerance) {
  if (isToTolerance) {
    const StepReport report = solver_->advanceToTolerance(now_, clock_.length(), loads);
    isSmooth_ = report.touchingTime == 0 && report.singularTime == 0;
    return report;
  }
  const mechanics::LoadSource loadsNow = [&](const Poses& poses, std::vector<brick::Load>& out) {
    loads(0, poses, out);
  };
  const int count = wantsTolerance_ ? kStepsAtOnce : 1;
  StepReport report;
  for (int k = 0; k < count; ++k) {
    report += solver_->advance(now_, clock_.length() / count, loadsNow);
  }
  return report;
}

bool RunMotion::isLost() const {
  Vector3 together = Vector3::Zero();
  for (std::size_t i = 0; i < start_.size(); ++i) {
    together += (now_.poses[i].position - start_[i].position) / static_cast<double>(start_.size());
  }
  for (std::size_t i = 0; i < start_.size(); ++i) {
    const double distance = (now_.poses[i].position - start_[i].position - together).norm();
    if (!(distance <= kLostDistance * bricks_.size)) return true;  // also when not a number
    if (!now_.poses[i].rotation.coeffs().allFinite()) return true;
  }
  return false;
}

StepSpan RunMotion::span(double begin, const StepReport& report, bool isToTolerance) const {
  return {begin,         clock_.length(), before_,        now_, solver_->passed(),
          isToTolerance, report.damped,   report.impacted};
}

Poses RunMotion::posesAt(double time) const {
  return posesAfter(time - (clock_.time() - clock_.length()));
}

Poses RunMotion::posesAfter(double seconds) const {
  if (!isSmooth_) return interpolate(before_.poses, now_.poses, seconds / clock_.length());
  return mechanics::posesBetween(before_, solver_->passed(), now_, clock_.length(), seconds);
}

Poses RunMotion::closedPosesAt(double time, const std::vector<bool>& pinned) {
  Poses poses = posesAt(time);
  if (bricks_.scene.solver.kind != scene::SolverKind::Direct) return poses;
  if (!projection_) {
    const scene::Scene bare = scene::withoutEnvironment(bricks_.scene);
    projection_ =
        makeDynamics(bare, scene::Needs{.planar = bricks_.needs.planar}, bricks_.bricks, start_);
  }
  projection_->setPinned(pinned);
  projection_->assemble(poses);
  return poses;
}

std::vector<Velocity> RunMotion::velocitiesAt(double seconds) const {
  const auto passed = isSmooth_ ? solver_->passed() : std::span<const mechanics::PassedState>{};
  return mechanics::velocitiesBetween(before_, passed, now_, clock_.length(), seconds);
}

Motion RunMotion::motionAfter(double seconds) const {
  return {posesAfter(seconds), velocitiesAt(seconds)};
}

Motion RunMotion::motionAt(double time, const Poses& poses) const {
  if (time == clock_.time()) return {poses, now_.velocities};
  return {poses, velocitiesAt(clock_.length() - (clock_.time() - time))};
}

// ------------------------------------------------------------------------------------------------
// Exactness of the joints.

void JointFit::closeAtStart(RunMotion& motion, RunFigures& figures) {
  isMisfit_ =
      !bricks_.scene.path.jointsAreCompliant() && !motion.solver().assemble(motion.now().poses);
  if (bricks_.needs.contacts.on) pushedAtStart_ = figures.overlapsOf(motion.poses()).grown;
  // Contacts that refer to the open start would be violated from the first step.
  if (pushedAtStart_ > 0) motion.beginContactsHere();
  hold(motion.solver());
}

void JointFit::closeAtEndOfPath(RunMotion& motion, RunFigures& figures) {
  const bool isClosed = close(motion, figures);
  if (bricks_.scene.path.jointsAreCompliant()) {
    motion.solver().setJointStiffness(isClosed ? kExactJoints
                                               : misfitStiffness(bricks_.scene, bricks_.bricks));
  }
  isMisfit_ = isMisfit_ || !isClosed;
}

// Returns whether the joints are now closed. If not, the poses are unchanged.
bool JointFit::close(RunMotion& motion, RunFigures& figures) {
  const model::Model& model = bricks_.scene.model;
  const Poses open = motion.poses();
  Poses& poses = motion.now().poses;
  if (!motion.solver().assemble(poses)) return false;
  if (std::isfinite(roundedJointStiffness(model)) &&
      trajectory::targetError(brick::bottomTiles(bricks_.bricks, open), bricks_.bricks, poses) >
          roundedReach(model)) {
    poses = open;
    return false;
  }
  if (!bricks_.needs.contacts.on) return true;
  const double before = figures.overlapsOf(open).grown;
  const double after = figures.overlapsOf(poses).grown;
  isHeldOpen_ = after > std::max(before, kPushedShare * bricks_.tileSize);
  if (isHeldOpen_) poses = open;
  return !isHeldOpen_;
}

// If tiles misfit, the joints are slightly compliant.
void JointFit::hold(Dynamics& solver) const {
  const scene::PathSettings& path = bricks_.scene.path;
  if (path.jointsAreCompliant()) {
    solver.setJointStiffness(jointStiffnessOf(bricks_.scene, bricks_.bricks));
  } else if (isMisfit_) {
    solver.setJointStiffness(misfitStiffness(bricks_.scene, bricks_.bricks));
  }
}

std::string JointFit::trouble() const {
  const double misfit = misfitStiffness(bricks_.scene, bricks_.bricks);
  if (isMisfit_) {
    return fmt::format(
        "{}. Joints are slightly compliant, with {:.2g} N/m",
        isHeldOpen_ ? "contacts prevent closed joints" : "the tiles do not fit each other exactly",
        misfit);
  }
  if (pushedAtStart_ <= kPushedShare * bricks_.tileSize) return "";
  return fmt::format(
      "closing the joints at the start makes bricks overlap by {}. Compliant joints avoid this "
      "(`path = guided` with `joint_ratio = {:g}`)",
      lengthText(pushedAtStart_, bricks_.scene.model.unit, 2), kMisfitRatio);
}

}  // namespace kirireel::run
