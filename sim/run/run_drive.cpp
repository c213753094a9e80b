// The drive of a run, phase by phase.
//
//   Open ----> Guide ----> Close ----> Settle
//
// Open: expansion from the centre for path.openTime. Guide: every tile follows the given path, or
// its own rigid motion without one (TargetGuide, forces.h). Springs k_f pull its mean and 40 k_f
// its rotation, for path.guideTime and half a second more, in which the tiles catch up. k_f is
// twice that of the scene's frequency.
// Close: compliant joints stiffen geometrically, k(t) = k_0 (1e7 k_p / k_0)^p. k_p is the place
// stiffness (forces.h), and p grows from 0 to 1 in half a second. One small step then closes the
// remaining gaps. Settle: the scene's own drive. Its springs to the target are stiffened up to 16
// times if the error stalls.
//
// A guided path has Guide, Open if openTime > 0, and Close if its joints are compliant. All other
// paths start with Settle. A new target starts the phases again. Phases depend only on the time,
// and a step ends when opening ends.
#include "sim/run/run_drive.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/run/arrival.h"
#include "sim/scene/scene_parts.h"
#include "sim/trajectory/measures.h"

namespace kirireel::run {

// ------------------------------------------------------------------------------------------------
// The current target.

void CurrentTarget::set(const std::vector<model::Tile>* tiles, const Poses& from) {
  const model::Model& model = bricks_.scene.model;
  if (!tiles && model.target) tiles = &*model.target;
  tiles_ = tiles;
  if (!tiles_) return;
  startError_ = error(from);
  if (isOwn()) return;
  scene::Scene other = bricks_.scene;
  other.model.target = *tiles_;
  const AssembledState nearest = assembleAtTarget(other);
  other_ = {nearest.error, nearest.restError};
}

bool CurrentTarget::isOwn() const {
  const std::optional<std::vector<model::Tile>>& own = bricks_.scene.model.target;
  return own && tiles_ == &*own;
}

double CurrentTarget::error(const Poses& poses) const {
  return tiles_ ? trajectory::targetError(*tiles_, bricks_.bricks, poses) : 0;
}

bool CurrentTarget::isAtSpringEquilibrium(double error) const {
  return run::isNearest(bricks_.scene.model, error, least().rest);
}

bool CurrentTarget::isNearest(double error) const {
  return run::isNearest(bricks_.scene.model, error, least().nearest);
}

bool CurrentTarget::isPulledTo() const {
  const scene::Scene& scene = bricks_.scene;
  return hasSprings() && (scene.springs.pull() || scene.path.kind == scene::PathKind::Guided);
}

bool CurrentTarget::hasArrived(const Poses& poses) const {
  return isPulledTo() && run::hasArrived(bricks_.scene.model, error(poses), least().nearest);
}

void CurrentTarget::transfer(StateTape& tape) {
  const scene::Scene& scene = bricks_.scene;
  std::vector<const std::vector<model::Tile>*> targets = {nullptr};
  if (scene.model.target) targets.push_back(&*scene.model.target);
  for (const scene::TimelineEntry& entry : scene.timeline) {
    const auto* going = std::get_if<scene::timeline::GoTo>(&entry.action);
    if (going) targets.push_back(&going->tiles);
  }
  auto number = std::ranges::find(targets, tiles_) - targets.begin();
  tape.transfer(number, startError_, own_.nearest, other_.nearest, other_.rest);
  tiles_ = targets.at(static_cast<std::size_t>(number));
}

// ------------------------------------------------------------------------------------------------
// Creation of a drive. Springs to a target are not created here: the run itself moves, stiffens and
// switches them.

std::unique_ptr<DriveForce> makeDriveForce(const scene::Scene& scene,
                                           const std::vector<brick::Brick>& bricks) {
  const scene::TargetSpringSettings& strength = scene.springs;
  switch (scene.actuation.drive) {
    case scene::Drive::Expansion:
      return std::make_unique<Expansion>(bricks, model::piecesOf(scene.model), strength);
    case scene::Drive::Boundary:
      return std::make_unique<BoundarySprings>(scene.model, bricks, strength,
                                               scene.actuation.boundary);
    case scene::Drive::Auto:
    case scene::Drive::Target:
    case scene::Drive::None:
      break;
  }
  return nullptr;
}

// ------------------------------------------------------------------------------------------------
// Guided tiles.

namespace {

// Time to catch up with a target that has stopped, and time to stiffen compliant joints, seconds.
constexpr double kCatchUp = 0.5;
constexpr double kStiffeningTime = 0.5;
// The final joint ratio: one step can then close the remaining gaps.
constexpr double kClosingRatio = 1e7;

}  // namespace

PathFollower::PathFollower(const scene::Scene& scene, const std::vector<brick::Brick>& bricks,
                           MovingTarget target, double beginTime)
    : path_(scene.path),
      beginTime_(beginTime),
      placeStiffness_(placeStiffness(guideSprings(scene), bricks)),
      target_(std::move(target)),
      springs_(bricks, target_(0), scene.model.pulledTiles, guideSprings(scene)) {}

Phase PathFollower::prepareStep(double time, Dynamics& dynamics) {
  const double elapsed = time - beginTime_;
  springs_.setTarget(target_(std::min(1.0, elapsed / path_.guideTime)));
  const double late = elapsed - path_.guideTime - kCatchUp;
  if (!path_.jointsAreCompliant()) return late <= 0 ? Phase::Guide : Phase::Settle;
  const double part = std::clamp(late / kStiffeningTime, 0.0, 1.0);
  const double range = std::max(1.0, kClosingRatio / path_.jointRatio);
  dynamics.setJointStiffness(path_.jointRatio * placeStiffness_ * std::pow(range, part));
  if (late <= 0) return Phase::Guide;
  return late <= kStiffeningTime ? Phase::Close : Phase::Settle;
}

// ------------------------------------------------------------------------------------------------
// The phases.

RunDrive::RunDrive(const SceneBricks& bricks, const StepClock& clock, const MechanismPath* guide)
    : bricks_(bricks),
      clock_(clock),
      guide_(guide),
      drive_(makeDriveForce(bricks.scene, bricks.bricks)),
      opening_(bricks.bricks, model::piecesOf(bricks.scene.model), bricks.scene.springs) {}

// Compliant joints close after the tiles were guided. On a straight path they stay compliant.
bool RunDrive::jointsAreCompliant() const {
  if (bricks_.ties.pairForces.replaceJoints()) return true;
  const scene::PathSettings& path = bricks_.scene.path;
  return path.jointsAreCompliant() && (isOnPath() || path.kind == scene::PathKind::Straight);
}

// Without a target there is no pull.
void RunDrive::startTowards(const CurrentTarget& target, const Poses& from) {
  springs_.reset();
  follower_.reset();
  phase_ = Phase::Settle;
  departure_ = from;
  departedAt_ = clock_.time();
  if (!target.hasSprings()) return;
  const scene::Scene& scene = bricks_.scene;
  pullTo(*target.tiles());
  stiffness_ = AdaptiveStiffness(scene.springs.adaptive);
  stiffness_.observe(target.startError(), departedAt_, 0);
  if (scene.path.kind != scene::PathKind::Guided) return;
  phase_ = scene.path.openTime > 0 ? Phase::Open : Phase::Guide;
  openedAt_ = departedAt_ + scene.path.openTime;
  if (phase_ == Phase::Guide) guideTo(target);
}

void RunDrive::pullTo(const std::vector<model::Tile>& target) {
  const scene::Scene& scene = bricks_.scene;
  springs_.emplace(bricks_.bricks, target, scene.model.pulledTiles, scene.springs);
}

// Guides from the departure poses and time, or along the given path.
void RunDrive::guideTo(const CurrentTarget& target) {
  MovingTarget moving;
  if (guide_ && target.isOwn()) {
    moving = [this](double progress) {
      return brick::bottomTiles(bricks_.bricks, guide_->at(progress));
    };
  } else {
    const TargetGuide own(brick::bottomTiles(bricks_.bricks, departure_), *target.tiles());
    moving = [own](double progress) { return own.at(progress); };
  }
  follower_.emplace(bricks_.scene, bricks_.bricks, std::move(moving), departedAt_);
}

// The guide starts at the poses that opening has reached.
bool RunDrive::beginStep(const CurrentTarget& target, const Poses& poses, Dynamics& dynamics) {
  if (phase_ == Phase::Open && clock_.isDue(openedAt_)) {
    departure_ = poses;
    departedAt_ = clock_.time();
    guideTo(target);
  }
  if (!follower_) return false;
  phase_ = follower_->prepareStep(clock_.time() + clock_.length(), dynamics);
  if (phase_ != Phase::Settle) return false;
  follower_.reset();
  return true;
}

double RunDrive::nextMoment() const {
  const bool isOpening = phase_ == Phase::Open && !clock_.isDue(openedAt_);
  return isOpening ? openedAt_ : std::numeric_limits<double>::infinity();
}

// Null if springs pull to a target, and if there is no drive.
const DriveForce* RunDrive::activeDrive() const {
  return phase_ == Phase::Open ? &opening_ : drive_.get();
}

// The springs of the guide while tiles are guided, otherwise the springs to the target. Null if
// nothing pulls.
const TargetSprings* RunDrive::activeSprings() const {
  if (follower_) return &follower_->springs();
  return springs_ ? &*springs_ : nullptr;
}

void RunDrive::addLoads(const Poses& poses, std::vector<brick::Load>& loads) const {
  if (const DriveForce* drive = activeDrive()) {
    drive->addLoads(poses, loads);
  } else if (const TargetSprings* springs = activeSprings()) {
    springs->addLoads(poses, stiffness_.factor(), loads);
  }
}

double RunDrive::energy(const Poses& poses) const {
  if (const DriveForce* drive = activeDrive()) return drive->energy(poses);
  const TargetSprings* springs = activeSprings();
  return springs ? springs->energy(poses, stiffness_.factor()) : 0;
}

void RunDrive::addFreeForces(const Poses& poses, std::vector<Vector3>& forces) const {
  if (const DriveForce* drive = activeDrive()) drive->addFreeForces(poses, forces);
}

// Springs are restored from the target and the start of its path.
void RunDrive::transfer(StateTape& tape, const CurrentTarget& target) {
  tape.transfer(phase_, departure_, departedAt_, openedAt_, stiffness_);
  if (!tape.isPlaying()) return;
  springs_.reset();
  follower_.reset();
  if (target.hasSprings()) pullTo(*target.tiles());
  if (phase_ == Phase::Guide || phase_ == Phase::Close) guideTo(target);
}

}  // namespace kirireel::run
