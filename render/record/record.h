/// The whole job: deploys a scene and writes its pictures, video, meshes and figures to a folder.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "render/record/job.h"
#include "sim/deploy/deployment.h"
#include "sim/scene/scene.h"

namespace kirireel::record {

/// Deploys a scene like deployUnkept(), or replays an earlier deployment.
using Deployer = std::function<run::DeploymentResult(
    const scene::Scene& scene, double sampleInterval, const run::SampleObserver& observer,
    const run::TrialObserver& searching, run::Checkpoints* checkpoints)>;

/// The results of a deployment for a summary, before painting and writing. `endTime` in simulated
/// seconds.
RunSummary summaryOf(const run::DeploymentResult& result, double endTime);

/// Deploys the scene to trajectory.h5, then makes all other requested files from it, and finally
/// summary.json. Memory does not grow with the length of the run. The video of an interrupted run
/// is complete up to there. A run that diverges or is interrupted also writes its files, with a
/// note in the summary. During the run a checkpoint in the folder lets another call resume it.
/// Throws InputError for settings out of range, OutputError if a file cannot be written. The folder
/// and the settings are checked before the deployment starts.
RunSummary record(const scene::Scene& scene, const RecordSettings& settings,
                  const ProgressObserver& observer,
                  const Deployer& deployer = deploy::deployUnkept);

/// Makes the pictures of a recorded run again from its trajectory.h5, without simulation. Throws
/// InputError if the file is not a complete trajectory, and like record(). Creates or updates
/// contents.json in the folder; trajectory.h5 stays unchanged.
PictureReport render(const std::filesystem::path& trajectory, const PictureSettings& settings,
                     const ProgressObserver& observer);

/// Makes one grid of several recorded runs, a row of settings.grid.columns states each, and a video
/// with the runs side by side, as far as the settings request them. Throws InputError if there is
/// no common scale, and like render().
PictureReport renderSeveral(const std::vector<std::filesystem::path>& trajectories,
                            const PictureSettings& settings, const ProgressObserver& observer);

}  // namespace kirireel::record
