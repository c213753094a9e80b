/// The whole job: deploy a scene, then leave its pictures, video, meshes and figures in a folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "render/gl/context.h"
#include "render/grid/grid.h"
#include "render/picture/frame.h"
#include "render/studio/look.h"
#include "sim/deploy/deployment.h"
#include "sim/scene/scene.h"

namespace kirireel {

/// How the pictures of a snapshot grid are spread over a run; the first and last are always in.
enum class SnapshotSpacing {
  Time,      ///< equal steps of simulated time
  Progress,  ///< equal shares of the way that the tiles travel
};

/// What a run leaves, and where.
struct RecordSettings {
  std::optional<GraphicsLibrary> graphics;  ///< that draws; absent: the program's first
  std::filesystem::path folder;  ///< made if need be; a former run's files in it are replaced
  FrameSize size;                ///< of video frames and of each snapshot; even when video is on
  int framesPerSecond = 60;      ///< of the video, and samples a simulated second; 1 to 240
  Look look;                     ///< of all pictures
  GridShape grid;
  CaptionParts captions;              ///< under the grid's pictures
  bool scaleBar = false;              ///< a length under the grid; needs a parallel projection
  std::optional<double> dotsPerInch;  ///< noted in PNG files, for print
  SnapshotSpacing spacing = SnapshotSpacing::Progress;
  bool video = true;      ///< deployment.mp4
  bool snapshots = true;  ///< snapshots.png
  bool svg = false;       ///< snapshot_01.svg ..., the grid's pictures as vector graphics
  bool meshes = true;     ///< initial and final, OBJ and PLY
  bool frames = false;    ///< frames/frame_00000.png ..., every frame of the video
};

/// What recording cost, beside the deployment's own cost. CPU seconds are of the whole process
/// while the stage ran.
struct RecordCost {
  double cpuSecondsRender = 0;
  double cpuSecondsEncode = 0;
  double wallSeconds = 0;            ///< from the start of record() to the summary
  std::int64_t peakMemoryBytes = 0;  ///< largest resident size of the process
};

/// Everything that summary.json says about a run, beside its settings.
struct RunSummary {
  Outcome outcome = Outcome::OutOfTime;
  std::string reason;   ///< one line: why it ended so
  double endTime = 0;   ///< simulated seconds
  int videoFrames = 0;  ///< frames in deployment.mp4
  Needs needs;
  PathSettings path;       ///< that was taken
  std::string pathReason;  ///< one short phrase: why
  Accuracy accuracy;
  double assembledFloor = -1;  ///< metres; negative without a target
  DeployCost deployCost;
  RecordCost recordCost;
  std::string graphics;            ///< version of OpenGL and its maker; empty when none was used
  std::vector<std::string> files;  ///< relative to the folder, in the order written
};

/// How far a run is, for a progress line.
struct Progress {
  const char* stage = "";  ///< "looking for a path", "deploying" or "painting"
  double share = 0;        ///< of this stage, 0 to 1
};

/// Called after each sample and each frame; return false to end the stage that is under way. The
/// run then counts as interrupted, and what exists so far is still written out.
using ProgressObserver = std::function<bool(const Progress&)>;

/// Deploys the scene and writes everything that the settings ask for, then summary.json. A run that
/// diverges or is interrupted leaves its files too, and says so in the summary.
/// Throws InputError for settings out of range, OutputError when a file cannot be written; the
/// folder and the settings are checked before the deployment starts.
RunSummary record(const Scene& scene, const RecordSettings& settings,
                  const ProgressObserver& observer);

}  // namespace kirireel
