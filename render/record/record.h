/// The whole job: deploy a scene, then leave its pictures, video, meshes and figures in a folder.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "render/record/job.h"
#include "sim/deploy/deployment.h"
#include "sim/scene/scene.h"

namespace kirireel::record {

/// Deploys a scene, as deployUnkept() does it, or as it was done before.
using Deployer = std::function<deploy::DeploymentResult(
    const scene::Scene& scene, double sampleInterval, const deploy::SampleObserver& observer,
    const deploy::TrialObserver& searching, deploy::Checkpoints* checkpoints)>;

/// The results of a deployment for a summary, before painting and writing. `endTime` in simulated
/// seconds.
RunSummary summaryOf(const deploy::DeploymentResult& result, double endTime);

/// Deploys the scene into trajectory.h5, then makes everything else from that file as the settings
/// ask for, and at last summary.json. Memory does not grow with the length of the run, and the
/// video of a run that is interrupted is whole as far as it goes. A run that diverges or is
/// interrupted writes its files too, with a note in the summary. Until it is over, a checkpoint in
/// the folder lets another call resume it. Throws InputError for settings out of range, OutputError
/// when a file cannot be written; the folder and the settings are checked before the deployment
/// starts.
RunSummary record(const scene::Scene& scene, const RecordSettings& settings,
                  const ProgressObserver& observer,
                  const Deployer& deployer = deploy::deployUnkept);

/// Makes the pictures of a recorded run again, from its trajectory.h5, without simulating. Throws
/// InputError if the file is not a complete trajectory, and as record(). The folder gets
/// contents.json, or a new one; trajectory.h5 stays as it is.
PictureReport render(const std::filesystem::path& trajectory, const PictureSettings& settings,
                     const ProgressObserver& observer);

/// Makes one grid of several recorded runs: a row of settings.grid.columns states each, with one
/// camera and one scale for all. Throws InputError where no one scale holds, and as render().
PictureReport renderFigure(const std::vector<std::filesystem::path>& trajectories,
                           const PictureSettings& settings);

}  // namespace kirireel::record
