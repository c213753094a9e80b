#include "sim/deploy/run.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <fmt/format.h>

#include "sim/base/cpu_time.h"

namespace kirireel {
namespace {

// A run has diverged once a brick is this many model sizes away from where it started.
constexpr double kLostDistance = 1e3;
// At rest but farther from the target than its assembled floor plus this part of a tile: locked.
constexpr double kLockedShare = 0.02;
// Initial speeds, in model sizes a second, that let a run leave an unstable equilibrium.
constexpr double kNudge = 1e-6;

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

}  // namespace

Run::Run(const Scene& scene, double sampleInterval, double assembledFloor,
         const SampleObserver& observer)
    : scene_(scene),
      observer_(observer),
      bricks_(makeBricks(scene.model.tiles, scene.brick)),
      pivots_(makePivots(scene.model.joints, bricks_)),
      motion_{startPoses(scene.model.tiles, bricks_), {}},
      needs_(sceneNeeds(scene)),
      dynamics_(makeDynamics(scene, needs_, bricks_, motion_.poses)),
      stiffness_(scene.springs.adaptive && scene.model.target.has_value()),
      stepsPerSample_(static_cast<int>(std::ceil(sampleInterval / scene.solver.timestep - 1e-9))),
      step_(sampleInterval / stepsPerSample_),
      size_(modelSize(scene.model)),
      tileSize_(tileSize(scene.model)),
      assembledFloor_(assembledFloor) {
  if (scene.model.target) {
    springs_.emplace(bricks_, *scene.model.target, scene.model.pulledTiles, scene.springs);
  }
  actuation_ = [this](const Poses& poses, std::vector<Load>& loads) {
    const TargetSprings* springs = follower_  ? &follower_->springs()
                                   : springs_ ? &*springs_
                                              : nullptr;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      loads[i] =
          springs ? springs->load(static_cast<int>(i), poses[i], stiffness_.factor()) : Load{};
    }
  };
}

double Run::currentTargetError() const {
  return scene_.model.target ? targetError(*scene_.model.target, bricks_, motion_.poses) : 0;
}

void Run::start() {
  const std::vector<Tile> before = bottomTiles(bricks_, motion_.poses);
  dynamics_->assemble(motion_.poses);
  motion_.velocities = nudge(bricks_.size(), kNudge * size_, scene_.solver.seed);
  Accuracy& accuracy = result_.accuracy;
  accuracy.assemblyMove = targetError(before, bricks_, motion_.poses);
  accuracy.targetErrorStart = accuracy.targetErrorMin = currentTargetError();
  if (scene_.model.target) {
    accuracy.rigidFloor = rigidFloor(scene_.model.tiles, *scene_.model.target);
  }
  if (scene_.path.kind == PathKind::Led && scene_.model.target) {
    follower_.emplace(scene_, bricks_, motion_.poses);
  }
  result_.needs = needs_;
  result_.path = scene_.path;
  result_.assembledFloor = assembledFloor_;
  static_cast<Subject&>(result_.trajectory) = subjectOf(scene_);
  startPoses_ = motion_.poses;
  takeSample();
}

void Run::takeSample() {
  Sample sample;
  sample.time = time();
  sample.poses = motion_.poses;
  sample.jointGap = jointGap(pivots_, motion_.poses).max;
  sample.targetError = currentTargetError();
  result_.accuracy.jointGapEnd = sample.jointGap;
  result_.accuracy.targetErrorEnd = sample.targetError;
  sample.penetration = deepestPenetration(bricks_, motion_.poses).depth;
  result_.accuracy.penetrationMax = std::max(result_.accuracy.penetrationMax, sample.penetration);
  if (!observer_(sample)) end(Outcome::Interrupted, "ended early by the caller");
}

/// Leads the tiles on, or lets them go once the path is done.
void Run::followPath() {
  if (!follower_) return;
  if (!follower_->prepareStep(static_cast<double>(stepCount_ + 1) * step_, *dynamics_)) {
    dynamics_->assemble(motion_.poses);
    follower_.reset();
  }
}

void Run::advanceStep() {
  followPath();
  const StepReport report = dynamics_->advance(motion_, step_, actuation_);
  result_.cost.steps += report.steps;
  result_.cost.halvedSteps += report.halved;
  result_.cost.unconvergedSteps += report.unconverged;
  ++stepCount_;
}

void Run::observeStep() {
  Accuracy& accuracy = result_.accuracy;
  const JointGap gap = jointGap(pivots_, motion_.poses);
  const bool jointsGive = follower_ && follower_->jointsGive();
  double& largest = jointsGive ? accuracy.jointOpeningMax : accuracy.jointGapMax;
  largest = std::max(largest, gap.max);
  gapSum_ += gap.mean;
  if (scene_.model.target) {
    const double error = currentTargetError();
    accuracy.targetErrorMin = std::min(accuracy.targetErrorMin, error);
    if (!follower_) stiffness_.observe(error, step_);
  }
}

void Run::updateRest() {
  double fastest = 0;
  for (const Velocity& velocity : motion_.velocities) {
    const double speed = velocity.linear.norm() + velocity.angular.norm() * tileSize_;
    fastest = std::max(fastest, speed);
  }
  restTime_ = !follower_ && fastest < scene_.stop.settleSpeed * size_ ? restTime_ + step_ : 0;
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
  const double reachable = assembledFloor_ + kLockedShare * tileSize_;
  if (!scene_.model.target) {
    end(Outcome::Settled, "everything came to rest; there is no target");
  } else if (error <= reachable) {
    end(Outcome::Settled, fmt::format("came to rest {:.3g} from the target", error));
  } else {
    end(Outcome::Locked, fmt::format("came to rest {:.3g} short of the target", error));
  }
}

/// Steps to the next sample, unless the run diverges on the way.
void Run::advanceSample() {
  for (int i = 0; i < stepsPerSample_; ++i) {
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
  if (!ended_ && restTime_ >= scene_.stop.settleTime) {
    if (stiffness_.exhausted() || currentTargetError() <= 1e-9 * size_) {
      endAtRest();
    } else {
      stiffness_.stiffen();
      restTime_ = 0;
    }
  }
}

DeploymentResult Run::finish() {
  const double startSeconds = threadCpuSeconds();
  start();
  while (!ended_ && time() < scene_.stop.duration - 0.5 * step_) advanceSample();
  if (!ended_)
    end(Outcome::OutOfTime, fmt::format("still moving after {:.4g} s", scene_.stop.duration));
  if (stepCount_ > 0) result_.accuracy.jointGapMean = gapSum_ / static_cast<double>(stepCount_);
  result_.cost.cpuSeconds = threadCpuSeconds() - startSeconds;
  return std::move(result_);
}

}  // namespace kirireel
