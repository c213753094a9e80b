#include "sim/deploy/path_choice.h"

#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "sim/deploy/run.h"

namespace kirireel {
namespace {

// A trial arrives when it ends within this factor of the floor, or this part of a tile.
constexpr double kArrivedFactor = 1.05;
constexpr double kArrivedShare = 1e-6;
// Trials look at the state this often, seconds.
constexpr double kTrialInterval = 0.25;
// The first look at the straight path takes longer steps: models that need no search are most.
constexpr double kCoarseSteps = 4;

// A trial that has not come nearer to the target by this factor in so many seconds is given up.
constexpr double kImprovement = 0.995;
constexpr double kPatience = 2;

constexpr double kExact = std::numeric_limits<double>::infinity();

/// The paths to try, in this order.
const std::vector<PathSettings>& candidates() {
  static const std::vector<PathSettings> paths = {
      {PathKind::Straight},           {PathKind::Led, 4, 200, kExact},
      {PathKind::Led, 2, 50, kExact}, {PathKind::Led, 8, 1000, kExact},
      {PathKind::Led, 4, 10, 1e8},    {PathKind::Led, 4, 10, 1e7},
      {PathKind::Led, 4, 10, 1e6},    {PathKind::Led, 4, 10, 1e5},
      {PathKind::Led, 4, 10, 1e4},
  };
  return paths;
}

std::string describe(const PathSettings& path) {
  if (path.kind == PathKind::Straight) return "straight pull";
  const std::string way =
      fmt::format("led for {:g} s with {:g} N/m", path.ledTime, path.ledStiffness);
  return std::isfinite(path.jointStiffness)
             ? fmt::format("{}, joints of {:g} N/m", way, path.jointStiffness)
             : way + ", exact joints";
}

/// Ends a trial that gets no nearer to the target any more.
class StallWatch {
 public:
  explicit StallWatch(const Scene& scene)
      : patience_(kPatience + (scene.path.kind == PathKind::Led ? scene.path.ledTime : 0)) {}

  bool operator()(const Sample& sample) {
    if (best_ < 0 || sample.targetError < kImprovement * best_) {
      best_ = sample.targetError;
      bestTime_ = sample.time;
    }
    return sample.time - bestTime_ < patience_;
  }

 private:
  double patience_;  // seconds
  double best_ = -1;
  double bestTime_ = 0;
};

bool arrives(const Scene& scene, double assembledFloor) {
  const SampleObserver watch = StallWatch(scene);
  const DeploymentResult result = Run(scene, kTrialInterval, assembledFloor, watch).finish();
  const double near =
      std::max(kArrivedFactor * assembledFloor, kArrivedShare * tileSize(scene.model));
  return result.outcome != Outcome::Diverged && result.accuracy.targetErrorEnd <= near;
}

}  // namespace

PathChoice choosePath(const Scene& scene, double assembledFloor, const TrialObserver& observer) {
  if (scene.path.kind != PathKind::Auto) return {scene.path, "asked for"};
  PathSettings straight = scene.path;
  straight.kind = PathKind::Straight;
  if (!scene.model.target) return {straight, "there is no target"};
  if (scene.actuation.drive != Drive::Target) return {straight, "nothing pulls to the target"};
  if (!scene.timeline.empty()) return {straight, "the timeline leads"};
  if (scene.solver.kind == SolverKind::Bullet) return {straight, "the baseline tries no others"};

  Scene trial = scene;
  trial.environment = Environment{};
  trial.stop = StopRules{};  // the run's own time may be too short for any path
  trial.path = straight;
  trial.solver.timestep = kCoarseSteps * scene.solver.timestep;
  if (arrives(trial, assembledFloor)) return {straight, "a straight pull arrives"};
  trial.solver.timestep = scene.solver.timestep;
  for (const PathSettings& path : candidates()) {
    const std::string what = describe(path);
    if (observer && !observer(what)) break;
    trial.path = path;
    if (arrives(trial, assembledFloor)) return {path, what + " arrives"};
  }
  return {straight, "no path that was tried arrives"};
}

}  // namespace kirireel
