#include "sim/deploy/deployment.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <random>

#include <fmt/format.h>

#include "sim/actuation/boundary_springs.h"
#include "sim/actuation/expansion.h"
#include "sim/actuation/target_springs.h"
#include "sim/base/error.h"
#include "sim/deploy/dynamics.h"
#include "sim/deploy/timeline_runner.h"

namespace kirireel {
namespace {

// A run has diverged once a brick is this many model sizes away from where it started.
constexpr double kLostDistance = 1e3;
// At rest but farther from the target than its rigid floor plus this part of a tile: locked.
constexpr double kLockedShare = 0.02;
// Initial speeds, in model sizes a second, that let a run leave an unstable equilibrium.
constexpr double kNudge = 1e-6;

double threadSeconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Uniform in [-1, 1) with the same bits from every standard library.
double uniform(std::mt19937& generator) {
  return static_cast<double>(generator()) / 2147483648.0 - 1.0;
}

std::vector<Velocity> nudge(std::size_t count, double speed, unsigned seed) {
  std::mt19937 generator(seed);
  const auto vector = [&] {
    const double x = uniform(generator);
    const double y = uniform(generator);
    const double z = uniform(generator);
    return Vector3(speed * Vector3(x, y, z));
  };
  std::vector<Velocity> velocities(count);
  for (Velocity& velocity : velocities) velocity.linear = vector();
  return velocities;
}

/// One deployment in progress.
class Run : private TimelineStage {
 public:
  Run(const Scene& scene, double sampleInterval, const SampleObserver& observer);
  DeploymentResult finish();

 private:
  void start();
  void pull(const Poses& poses, std::vector<Load>& loads) const;
  void setPinned(const std::vector<bool>& pinned) override { dynamics_->setPinned(pinned); }
  void goTo(const std::vector<Tile>* target) override;
  void reset() override;
  void quit() override;
  bool followTimeline(bool atRest);
  void restOrGoOn();
  void advanceSample();
  void advanceStep();
  void observeStep();
  void updateRest();
  bool isLost() const;
  void takeSample();
  void end(Outcome outcome, std::string reason);
  void endAtRest();
  double time() const { return static_cast<double>(stepCount_) * step_; }
  bool pullsToTarget() const { return scene_.actuation.drive == Drive::Target && target_; }
  double finalTargetError() const;
  double currentTargetError() const;
  double reachableError() const;

  const Scene& scene_;
  const SampleObserver& observer_;
  std::vector<Brick> bricks_;
  std::vector<Pivot> pivots_;
  Motion motion_;
  Poses startPoses_;                 // joints closed
  const std::vector<Tile>* target_;  // the one headed for at present; null when there is none
  double targetStartError_ = 0;      // when it was set
  double targetFloor_ = 0;           // its rigid floor
  Needs needs_;
  std::unique_ptr<Dynamics> dynamics_;
  std::optional<TargetSprings> springs_;
  std::optional<BoundarySprings> boundary_;
  TimelineRunner timeline_;
  AdaptiveStiffness stiffness_;
  LoadSource actuation_;
  int stepsPerSample_;
  double step_;
  double size_;
  double tileSize_;
  long stepCount_ = 0;
  double gapSum_ = 0;
  double restTime_ = 0;
  bool ended_ = false;
  DeploymentResult result_;
};

Run::Run(const Scene& scene, double sampleInterval, const SampleObserver& observer)
    : scene_(scene),
      observer_(observer),
      bricks_(makeBricks(scene.model.tiles, scene.brick)),
      pivots_(makePivots(scene.model.joints, bricks_)),
      motion_{startPoses(scene.model.tiles, bricks_), {}},
      target_(scene.model.target ? &*scene.model.target : nullptr),
      needs_(sceneNeeds(scene)),
      dynamics_(makeDynamics(scene, needs_, bricks_, motion_.poses)),
      timeline_(scene.timeline, bricks_),
      stiffness_(false),
      stepsPerSample_(static_cast<int>(std::ceil(sampleInterval / scene.solver.timestep - 1e-9))),
      step_(sampleInterval / stepsPerSample_),
      size_(modelSize(scene.model)),
      tileSize_(tileSize(scene.model)) {
  if (scene.actuation.drive == Drive::Boundary) {
    boundary_.emplace(scene.model, bricks_, scene.springs, scene.actuation.boundary);
  }
  actuation_ = [this](const Poses& poses, std::vector<Load>& loads) {
    std::fill(loads.begin(), loads.end(), Load{});
    if (timeline_.forcesAreOn()) pull(poses, loads);
    timeline_.addDrags(time(), poses, loads);
  };
}

/// What drives the bricks.
void Run::pull(const Poses& poses, std::vector<Load>& loads) const {
  const Drive drive = scene_.actuation.drive;
  const Vector3 centre = drive == Drive::Expansion ? centreOfMass(bricks_, poses) : Vector3::Zero();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const int brick = static_cast<int>(i);
    if (springs_) loads[i] = springs_->load(brick, poses[i], stiffness_.factor());
    if (boundary_) loads[i] = boundary_->load(brick, poses[i]);
    if (drive == Drive::Expansion) loads[i] = expansionLoad(scene_.springs, centre, poses[i]);
  }
}

/// To the model's own target, which the accuracy figures refer to.
double Run::finalTargetError() const {
  return scene_.model.target ? targetError(*scene_.model.target, bricks_, motion_.poses) : 0;
}

/// To the target headed for at present.
double Run::currentTargetError() const {
  return target_ ? targetError(*target_, bricks_, motion_.poses) : 0;
}

/// What counts as having arrived.
double Run::reachableError() const {
  return targetFloor_ + kLockedShare * tileSize_;
}

void Run::goTo(const std::vector<Tile>* target) {
  if (!target && scene_.model.target) target = &*scene_.model.target;
  target_ = target;
  if (!target_) return;
  targetStartError_ = currentTargetError();
  targetFloor_ = rigidFloor(scene_.model.tiles, *target_);
  if (!pullsToTarget()) return;
  springs_.emplace(bricks_, *target_, scene_.model.pulledTiles, scene_.springs);
  stiffness_ = AdaptiveStiffness(scene_.springs.adaptive);
}

void Run::reset() {
  motion_ = {startPoses_, nudge(bricks_.size(), kNudge * size_, scene_.solver.seed)};
  // A solver carries contacts and multipliers from step to step, which do not belong here.
  dynamics_ = makeDynamics(scene_, needs_, bricks_, startPoses(scene_.model.tiles, bricks_));
  goTo(nullptr);
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

void Run::start() {
  const std::vector<Tile> before = bottomTiles(bricks_, motion_.poses);
  dynamics_->assemble(motion_.poses);
  goTo(nullptr);
  motion_.velocities = nudge(bricks_.size(), kNudge * size_, scene_.solver.seed);
  Accuracy& accuracy = result_.accuracy;
  accuracy.assemblyMove = targetError(before, bricks_, motion_.poses);
  accuracy.targetErrorStart = accuracy.targetErrorMin = finalTargetError();
  if (scene_.model.target) {
    accuracy.rigidFloor = rigidFloor(scene_.model.tiles, *scene_.model.target);
  }
  result_.needs = needs_;
  static_cast<Subject&>(result_.trajectory) = subjectOf(scene_);
  startPoses_ = motion_.poses;
  takeSample();
}

void Run::takeSample() {
  Sample sample;
  sample.time = time();
  sample.poses = motion_.poses;
  sample.pinned = timeline_.pinnedTiles();
  sample.jointGap = jointGap(pivots_, motion_.poses).max;
  sample.targetError = finalTargetError();
  Accuracy& accuracy = result_.accuracy;
  accuracy.jointGapEnd = sample.jointGap;
  accuracy.targetErrorEnd = sample.targetError;
  sample.penetration = deepestPenetration(bricks_, motion_.poses).depth;
  accuracy.penetrationMax = std::max(accuracy.penetrationMax, sample.penetration);
  accuracy.penetrationOutsidePivotsMax = std::max(
      accuracy.penetrationOutsidePivotsMax,
      deepestPenetrationOutsidePivots(bricks_, pivots_, scene_.environment.pivotZone, motion_.poses)
          .depth);
  if (!observer_(sample)) end(Outcome::Interrupted, "ended early by the caller");
}

void Run::advanceStep() {
  const StepReport report = dynamics_->advance(motion_, step_, actuation_);
  result_.cost.steps += report.steps;
  result_.cost.halvedSteps += report.halved;
  result_.cost.unconvergedSteps += report.unconverged;
  ++stepCount_;
}

void Run::observeStep() {
  Accuracy& accuracy = result_.accuracy;
  const JointGap gap = jointGap(pivots_, motion_.poses);
  accuracy.jointGapMax = std::max(accuracy.jointGapMax, gap.max);
  gapSum_ += gap.mean;
  accuracy.targetErrorMin = std::min(accuracy.targetErrorMin, finalTargetError());
  if (pullsToTarget() && timeline_.forcesAreOn()) {
    stiffness_.observe(currentTargetError(), step_);
  }
}

void Run::updateRest() {
  double fastest = 0;
  for (const Velocity& velocity : motion_.velocities) {
    const double speed = velocity.linear.norm() + velocity.angular.norm() * tileSize_;
    fastest = std::max(fastest, speed);
  }
  restTime_ = fastest < scene_.stop.settleSpeed * size_ ? restTime_ + step_ : 0;
}

bool Run::isLost() const {
  for (std::size_t i = 0; i < startPoses_.size(); ++i) {
    const double distance = (motion_.poses[i].position - startPoses_[i].position).norm();
    if (!(distance <= kLostDistance * size_)) return true;  // also when not a number
  }
  return false;
}

void Run::end(Outcome outcome, std::string reason) {
  result_.outcome = outcome;
  result_.reason = std::move(reason);
  result_.trajectory.events.push_back(
      {time(), fmt::format("{}: {}", toString(outcome), result_.reason)});
  ended_ = true;
}

void Run::endAtRest() {
  const double error = currentTargetError();
  if (!pullsToTarget()) {
    end(Outcome::Settled, target_ ? "everything came to rest; nothing pulls to the target"
                                  : "everything came to rest; there is no target");
  } else if (error <= reachableError()) {
    end(Outcome::Settled, fmt::format("came to rest {:.3g} from the target", error));
  } else {
    end(Outcome::Locked, fmt::format("came to rest {:.3g} short of the target", error));
  }
}

/// Steps to the next sample, unless the run diverges on the way.
void Run::advanceSample() {
  for (int i = 0; i < stepsPerSample_; ++i) {
    followTimeline(false);
    // A run that is to end goes on to the next sample, so that samples stay equally spaced.
    if (ended_ && i == 0) return;
    if (timeline_.isPaused(time())) {
      ++stepCount_;
      continue;
    }
    advanceStep();
    if (isLost()) {
      end(Outcome::Diverged,
          fmt::format(
              "a brick left all bounds at {:.4g} s; try a shorter --timestep or more damping",
              time()));
      return;
    }
    observeStep();
    updateRest();
  }
  takeSample();
  if (!ended_ && restTime_ >= scene_.stop.settleTime) restOrGoOn();
}

/// Nothing moves: a stiffer pull or the timeline may change that, else the run is over.
void Run::restOrGoOn() {
  const bool stiffer = pullsToTarget() && timeline_.forcesAreOn() && !stiffness_.exhausted();
  if (stiffer && currentTargetError() > 1e-6 * size_) {
    stiffness_.stiffen();
    restTime_ = 0;
  } else if (timeline_.isOver(time())) {
    endAtRest();
  } else if (!followTimeline(true) && timeline_.waitsForState()) {
    end(Outcome::Locked, fmt::format("came to rest, yet {}", timeline_.pending()));
  }
}

DeploymentResult Run::finish() {
  const double startSeconds = threadSeconds();
  start();
  while (!ended_ && time() < scene_.stop.duration - 0.5 * step_) advanceSample();
  if (!ended_)
    end(Outcome::OutOfTime, fmt::format("still moving after {:.4g} s", scene_.stop.duration));
  if (stepCount_ > 0) result_.accuracy.jointGapMean = gapSum_ / static_cast<double>(stepCount_);
  result_.cost.cpuSeconds = threadSeconds() - startSeconds;
  return std::move(result_);
}

void requirePositive(double value, const char* name) {
  if (value > 0 && std::isfinite(value)) return;
  throw InputError(fmt::format("{} is {}, but must be a positive number of seconds", name, value));
}

void requireShare(double value, const char* name) {
  if (value >= 0 && value < 1) return;
  throw InputError(fmt::format(
      "{} is {}, but must be the part of the velocity lost a second: from 0 to less than 1", name,
      value));
}

/// An entry that could never happen is a mistake.
void requireInTime(const Timeline& timeline, double duration) {
  for (const TimelineEntry& entry : timeline) {
    if (entry.when.kind != Occasion::Kind::AtTime || entry.when.value <= duration) continue;
    throw inputErrorAt(
        entry.where, fmt::format("this happens at {:g} s, but the run lasts {:g} s at most; raise "
                                 "--duration",
                                 entry.when.value, duration));
  }
}

}  // namespace

std::string toString(Outcome outcome) {
  switch (outcome) {
    case Outcome::Settled:
      return "settled";
    case Outcome::Locked:
      return "locked";
    case Outcome::OutOfTime:
      return "out_of_time";
    case Outcome::Diverged:
      return "diverged";
    case Outcome::Interrupted:
      return "interrupted";
  }
  return "unknown";
}

DeploymentResult deployUnkept(const Scene& scene, double sampleInterval,
                              const SampleObserver& observer) {
  requirePositive(sampleInterval, "the time between samples");
  requirePositive(scene.solver.timestep, "the timestep");
  requirePositive(scene.stop.duration, "the duration");
  requireShare(scene.environment.linearDamping, "the linear damping");
  requireShare(scene.environment.angularDamping, "the angular damping");
  requireInTime(scene.timeline, scene.stop.duration);
  if (scene.model.tiles.empty())
    throw InputError("the model has no tiles; add one to vertices.txt");
  return Run(scene, sampleInterval, observer).finish();
}

DeploymentResult deploy(const Scene& scene, double sampleInterval, const SampleObserver& observer) {
  std::vector<Sample> samples;
  DeploymentResult result = deployUnkept(scene, sampleInterval, [&](const Sample& sample) {
    samples.push_back(sample);
    return !observer || observer(sample);
  });
  result.trajectory.samples = std::move(samples);
  return result;
}

}  // namespace kirireel
