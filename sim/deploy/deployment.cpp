#include "sim/deploy/deployment.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sim/base/cpu_time.h"
#include "sim/base/error.h"
#include "sim/deploy/assembled_state.h"
#include "sim/deploy/run.h"
#include "sim/deploy/target_warnings.h"

namespace kirireel {
namespace {

// A run that is to last a fraction of a second is not to wait for minutes: so many seconds of
// search, on a reference core, for each of the run.
constexpr double kSearchPerSecond = 30;

// What is tried before any path.
constexpr const char* kAssembling = "the state nearest to the target";

void requirePositive(double value, const char* name) {
  if (value > 0 && std::isfinite(value)) return;
  throw InputError(fmt::format("{} is {}, but must be a positive number of seconds", name, value));
}

void requireFromZero(double value, const char* name) {
  if (value >= 0 && std::isfinite(value)) return;
  throw InputError(
      fmt::format("{} is {}, but must be a number of seconds, at least 0", name, value));
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

void requireSense(const Scene& scene, double sampleInterval) {
  requirePositive(sampleInterval, "the time between samples");
  requirePositive(scene.solver.timestep, "the timestep");
  requirePositive(scene.stop.duration, "the duration");
  requireFromZero(scene.path.openTime, "the time of opening");
  requirePositive(scene.path.ledTime, "the time of being led");
  requireShare(scene.environment.linearDamping, "the linear damping");
  requireShare(scene.environment.angularDamping, "the angular damping");
  requireInTime(scene.timeline, scene.stop.duration);
  if (scene.model.tiles.empty())
    throw InputError("the model has no tiles; add one to vertices.txt");
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
                              const SampleObserver& observer, const TrialObserver& searching,
                              Checkpoints* checkpoints) {
  requireSense(scene, sampleInterval);
  if (scene.solver.kind == SolverKind::Bullet) checkpoints = nullptr;
  double ownSeconds = 0;
  double& searchSeconds = checkpoints ? checkpoints->searchSeconds() : ownSeconds;
  const double startSeconds = threadCpuSeconds() - searchSeconds;
  SearchBudget budget(std::min(scene.path.searchTime, kSearchPerSecond * scene.stop.duration));
  bool goOn = true;
  std::size_t savedTrials = checkpoints ? checkpoints->trials().size() : 0;
  const TrialObserver watchSearch = [&](const SearchNews& news) {
    goOn = goOn && (!searching || searching(news));
    searchSeconds = threadCpuSeconds() - startSeconds;
    const bool isNew = checkpoints && checkpoints->trials().size() > savedTrials;
    if (isNew && (!goOn || checkpoints->isDue())) {
      checkpoints->save({});
      savedTrials = checkpoints->trials().size();
    }
    return goOn;
  };
  watchSearch({kAssembling, 0});
  std::vector<std::string> warnings = targetWarnings(scene);
  for (const std::string& warning : warnings) watchSearch({kAssembling, 0, warning});
  const AssembledState nearest = assembleAtTarget(scene, budget, [&] {
    return watchSearch({kAssembling, budget.share()});
  });
  if (const std::string far = reachWarning(scene, nearest); !far.empty()) {
    warnings.push_back(far);
    watchSearch({kAssembling, budget.share(), far});
  }
  std::vector<BlockingPair> blocking = blockingPairs(scene, nearest.restPoses, budget);
  std::vector<TrialEnd> trials;
  PathChoice choice = choosePath(scene, {nearest, !blocking.empty()}, budget, watchSearch,
                                 checkpoints ? checkpoints->trials() : trials);
  Scene chosen = scene;
  chosen.path = choice.path;
  searchSeconds = threadCpuSeconds() - startSeconds;
  // A search that was ended early ends the run with its start, on a path that may be another's.
  if (!goOn) checkpoints = nullptr;
  const RunObservers watch{
      sampleInterval, [&](const Sample& sample) { return observer(sample) && goOn; }, {}};
  Run run(chosen, nearest, watch, checkpoints);
  DeploymentResult result = run.finish();
  if (!run.seesAllPairs()) {
    warnings.push_back(
        fmt::format("too many bricks lie in one place: overlaps are the deepest of "
                    "the first {} pairs",
                    mostPairs(scene.model.tiles.size())));
  }
  if (!result.pathReason.empty()) choice.reason += "; " + result.pathReason;
  result.pathReason = std::move(choice.reason);
  result.blocking = std::move(blocking);
  result.warnings = std::move(warnings);
  result.cost.searchSeconds = budget.spentSeconds();
  result.cost.searchBudget = budget.seconds();
  result.cost.cpuSecondsSearch = searchSeconds;
  return result;
}

DeploymentResult deploy(const Scene& scene, double sampleInterval, const SampleObserver& observer,
                        const TrialObserver& searching) {
  std::vector<Sample> samples;
  DeploymentResult result = deployUnkept(
      scene, sampleInterval,
      [&](const Sample& sample) {
        samples.push_back(sample);
        return !observer || observer(sample);
      },
      searching);
  result.trajectory.samples = std::move(samples);
  return result;
}

}  // namespace kirireel
