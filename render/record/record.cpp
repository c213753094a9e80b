#include "render/record/record.h"

#include <algorithm>

#include <fmt/format.h>

#include "render/mesh/mesh.h"
#include "render/record/album.h"
#include "render/record/output_folder.h"
#include "render/record/stopwatch.h"
#include "render/record/summary.h"
#include "render/video/video.h"
#include "sim/base/error.h"
#include "sim/base/pending_file.h"
#include "sim/model/folder.h"
#include "sim/trajectory/trajectory_file.h"

namespace kirireel {
namespace {

/// Poses farther than this many model sizes from the start are not drawn: the rest would shrink to
/// a dot. Only diverged runs get there.
constexpr double kFarthestDrawn = 20;

void requireValidSettings(const RecordSettings& settings) {
  requireValidSize(settings.size);
  if (settings.snapshots) layOutGrid(settings.size, settings.grid);
  if (settings.video) requireValidSettings(output::kVideo, videoSettings(settings));
  if (settings.framesPerSecond < 1 || settings.framesPerSecond > 240) {
    throw InputError(fmt::format("error: {} frames a second are not possible; give --fps 1 to 240",
                                 settings.framesPerSecond));
  }
}

bool isDrawable(const Sample& sample, const Sample& start, double reach) {
  for (std::size_t i = 0; i < sample.poses.size(); ++i) {
    const double moved = (sample.poses[i].position - start.poses[i].position).norm();
    // Written so that NaN fails.
    if (!(moved <= reach) || !sample.poses[i].rotation.coeffs().allFinite()) return false;
  }
  return true;
}

/// Drops the samples from the first that cannot be drawn.
void keepDrawable(Trajectory& trajectory, double modelSize) {
  std::vector<Sample>& samples = trajectory.samples;
  const auto end = std::find_if(samples.begin() + 1, samples.end(), [&](const Sample& sample) {
    return !isDrawable(sample, samples.front(), kFarthestDrawn * modelSize);
  });
  samples.erase(end, samples.end());
}

DeploymentResult deployWatched(const Scene& scene, const RecordSettings& settings,
                               const ProgressObserver& observer) {
  Subject subject = subjectOf(scene);
  subject.settings = settingsText(scene, settings);
  TrajectoryWriter writer(settings.folder / output::kTrajectory, subject);
  DeploymentResult result = deploy(
      scene, 1.0 / settings.framesPerSecond,
      [&](const Sample& sample) {
        writer.append(sample);
        return observer({"deploying", std::min(1.0, sample.time / scene.stop.duration)});
      },
      [&](const std::string&) {
        return observer({"looking for a path", 0});
      });
  writer.finish(result.trajectory.events);
  return result;
}

RunSummary summarize(const DeploymentResult& result) {
  RunSummary summary;
  summary.outcome = result.outcome;
  summary.reason = result.reason;
  summary.endTime = result.trajectory.samples.back().time;
  summary.needs = result.needs;
  summary.accuracy = result.accuracy;
  summary.path = result.path;
  summary.pathReason = result.pathReason;
  summary.assembledFloor = result.assembledFloor;
  summary.deployCost = result.cost;
  return summary;
}

void writeEndState(const Trajectory& trajectory, const RecordSettings& settings,
                   RunSummary& summary) {
  writeTiles(bottomTiles(trajectory.bricks, trajectory.samples.back().poses),
             settings.folder / output::kFinalVertices);
  summary.files.emplace_back(output::kFinalVertices);
}

void writeMeshes(const Trajectory& trajectory, const RecordSettings& settings,
                 RunSummary& summary) {
  const auto write = [&](const char* name, const Sample& sample) {
    for (const char* ending : {".obj", ".ply"}) {
      const std::string file = fmt::format("{}{}", name, ending);
      writeMesh(settings.folder / file, trajectory.bricks, sample.poses);
      summary.files.push_back(file);
    }
  };
  write(output::kInitialMesh, trajectory.samples.front());
  write(output::kFinalMesh, trajectory.samples.back());
}

}  // namespace

RunSummary record(const Scene& scene, const RecordSettings& settings,
                  const ProgressObserver& observer) {
  const Stopwatch stopwatch;
  requireValidSettings(settings);
  prepareOutputFolder(settings.folder);

  DeploymentResult result = deployWatched(scene, settings, observer);
  keepDrawable(result.trajectory, modelSize(scene.model));
  RunSummary summary = summarize(result);
  summary.files.emplace_back(output::kTrajectory);

  // The quick files first, so that a run that must end soon leaves them all.
  writeEndState(result.trajectory, settings, summary);
  if (settings.meshes) writeMeshes(result.trajectory, settings, summary);
  paintAlbum(scene, result.trajectory, settings, observer, summary);

  summary.files.emplace_back(output::kSummary);
  summary.recordCost.wallSeconds = stopwatch.seconds();
  summary.recordCost.peakMemoryBytes = peakMemoryBytes();
  writeTextFile(settings.folder / output::kSummary, summaryJson(scene, settings, summary));
  return summary;
}

}  // namespace kirireel
