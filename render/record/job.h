/// What a recording is asked for, and what it reports of itself.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "render/export/export.h"
#include "render/output/output_folder.h"
#include "render/picture/canvas.h"
#include "render/picture/frame.h"
#include "render/picture/gl_context.h"
#include "render/picture/grid.h"
#include "render/picture/state_painter.h"
#include "sim/base/files.h"
#include "sim/deploy/result.h"
#include "sim/scene/scene.h"

namespace kirireel::record {

/// How the pictures of a snapshot grid are spread over a run; the first and last are always in.
enum class SnapshotSpacing {
  Time,      ///< equal steps of simulated time
  Progress,  ///< equal shares of the motion, see MotionCurve
};

/// How a video's time follows the run.
enum class Pace {
  Even,  ///< each frame brings the same motion
  Real,  ///< each frame brings the same simulated time
};

/// A moment of a run for a separate picture.
struct FrameChoice {
  /// What `value` counts.
  enum class Unit { Seconds, Share };
  double value = 0;           ///< simulated seconds, or the share of the motion, 0 to 1
  Unit unit = Unit::Seconds;  ///< of `value`

  bool operator==(const FrameChoice&) const = default;
};

/// The pictures of a run: which ones, their style, and their folder. Defaults are those of the
/// command line. Ranges are checked by record() and render().
struct PictureSettings {
  std::optional<picture::GraphicsLibrary> graphics;  ///< that draws; absent: the program's first
  std::filesystem::path folder;  ///< made if need be; a former run's files in it are replaced
  picture::FrameSize size;       ///< of video frames and of each snapshot
  int framesPerSecond = 60;      ///< of the video, 1 to 240
  Pace pace = Pace::Even;        ///< how time passes in the video
  double length = 8;             ///< of a video at an even pace, seconds, without a title
  double speed =
      1;  ///< simulated seconds in a second of video at real pace; below 1 is slow motion
  /// Seconds that the video shows its first and its last frame longer; absent: 0.5 at an even pace,
  /// else none.
  std::optional<double> hold;
  /// Of a card shown before the video, UTF-8, line feeds begin new lines; no card when both are
  /// empty.
  std::string title;
  std::string subtitle;     ///< below the title, UTF-8; empty: none
  picture::Look look;       ///< of all pictures
  picture::GridShape grid;  ///< of the snapshots
  /// Under the grid's pictures and the video's frames; absent: only under the grid, progress at an
  /// even pace, time at real pace, nothing where its columns have heads.
  std::optional<picture::CaptionParts> captions;
  /// A length under the grid and the video; needs a parallel projection.
  bool scaleBar = false;
  bool progressBar = false;           ///< under the video
  std::optional<double> dotsPerInch;  ///< noted in PNG files, for print
  std::optional<double> gridWidth;    ///< of the grid in print, millimetres; absent: as it comes
  std::optional<double> fontPoints;   ///< size of its text in print; needs gridWidth
  std::string font;                   ///< family of all text; empty: the program's
  picture::PanelLetters letters = picture::PanelLetters::None;  ///< of the grid
  bool sameView = false;   ///< of all rows of a figure of several runs; else each has its own
  bool sameScale = false;  ///< the same of their scale of length
  bool arrows = false;     ///< from each of the grid's pictures to the next in its row
  std::vector<std::string> columnHeads;  ///< over the grid's columns, one each; none when empty
  std::vector<picture::PageFormat>
      pages;           ///< the grid as vector graphics too, as snapshots.svg, .pdf
  std::string madeBy;  ///< who makes the pictures from what, noted in the files
  SnapshotSpacing spacing = SnapshotSpacing::Progress;  ///< which states the snapshots show
  bool video = true;                                    ///< whether there is one
  std::string videoFile = output::kVideo;               ///< its ending chooses the format
  std::optional<int> crf;                               ///< of the video, see VideoSettings
  std::string preset = "auto";                          ///< of the video, see VideoSettings
  std::string encoder;                                  ///< of the video, see VideoSettings
  bool snapshots = true;                                ///< snapshots.png
  bool svg = false;     ///< snapshot_01.svg ..., the grid's pictures as vector graphics
  bool frames = false;  ///< frames/frame_00000.png ..., every frame of the video
  std::vector<FrameChoice> chosenFrames;  ///< the same, only of these moments
  /// That paint a video's frames at the same time; absent: one a core. Decides no bytes.
  std::optional<int> painterCount;

  /// Whether frames of a video are painted.
  bool paintsFrames() const { return video || frames; }
  /// Whether any picture is painted.
  bool paints() const { return paintsFrames() || snapshots || !chosenFrames.empty(); }
  /// At most 16, unless a number was given.
  int painters() const;
  /// Simulated seconds from one sample of the run to the next.
  double sampleInterval() const { return (pace == Pace::Real ? speed : 1) / framesPerSecond; }
  /// Seconds for which the video holds its first and last frame.
  double heldSeconds() const { return hold.value_or(pace == Pace::Even ? 0.5 : 0); }
  /// Of the grid in print, where it has a width.
  double gridDotsPerInch() const { return dotsPerInch.value_or(300); }
  /// The captions of the grid's pictures.
  picture::CaptionParts captionParts() const {
    if (captions || !columnHeads.empty()) return captions.value_or(picture::CaptionParts{});
    return pace == Pace::Even ? picture::CaptionParts{.progress = true}
                              : picture::CaptionParts{.time = true};
  }
};

/// What a run leaves: its samples, its pictures, and more. The folder is made if need be; files of
/// others in it are never overwritten, see FileSet.
struct RecordSettings : PictureSettings {
  std::string order;      ///< fingerprint of all that decides the run, for summary.json and for
                          ///< checkpoints, which runs without one do not make
  std::string sceneText;  ///< all settings as a scene file, for summary.json; empty when not known
  /// The word that selected PyKirigami's constants for what was not given; empty: none.
  std::string peerSpelling;
  std::vector<InputFile> inputs;  ///< files that the run is made from, for summary.json
  bool resume = false;     ///< continue from the folder's checkpoint, if it is of the same order
  bool meshes = true;      ///< initial and final, OBJ and PLY
  bool trajectory = true;  ///< trajectory.h5, which meshes, pictures and exports bring too
  exports::ExportSettings exports;  ///< further files; none without formats
};

/// What recording cost, besides the deployment's own cost. Seconds of several painters are summed
/// and may exceed the wall time.
struct RecordCost {
  double cpuSecondsRender = 0;       ///< of painters and of the threads of the graphics library
  double cpuSecondsEncode = 0;       ///< of the encoder's thread
  double wallSeconds = 0;            ///< from the start to the last file
  std::int64_t peakMemoryBytes = 0;  ///< largest resident size of the process
};

/// What was painted, and what it cost. Filled in while pictures are made; what was not made stays 0
/// or empty.
struct PictureReport {
  int videoFrames = 0;              ///< frames in the video
  std::optional<double> stoppedAt;  ///< where the video ends when the observer ended it, seconds
  std::string stoppedBy;            ///< what stopped it, as in Interruption
  RecordCost recordCost;            ///< of pictures and video
  /// That of all pictures; absent where camera keys move it.
  std::optional<picture::AutomaticView> view;
  std::string graphics;            ///< version of OpenGL and its maker; empty when none was used
  std::vector<std::string> files;  ///< relative to the folder, in the order written
};

/// The contents of summary.json, without the settings.
struct RunSummary : PictureReport {
  deploy::Outcome outcome = deploy::Outcome::OutOfTime;  ///< how the run ended
  std::string reason;                                    ///< one line: why it ended so
  std::optional<bool> atTarget;  ///< at the end; absent where nothing pulls to a target
  std::string shortfall;         ///< why the run does not count as done; empty if it does
  double forbiddenOverlap = 0;   ///< see deploy::DeploymentResult; metres
  double endTime = 0;            ///< simulated seconds
  /// When the first brick was farther away than pictures show (see kFarthestShown), simulated
  /// seconds; its data go on.
  std::optional<double> leftOutFrom;
  scene::Needs needs;                              ///< what was modelled, and why
  scene::PathSettings path;                        ///< that was taken
  std::string pathReason;                          ///< one short phrase: why
  std::vector<deploy::PathEvaluation> candidates;  ///< kinematic paths that were tried, in order
  deploy::Accuracy accuracy;                       ///< gaps, errors and overlaps
  std::optional<double> timeError;                 ///< tiles; see deploy::DeploymentResult
  double assembledError = -1;                      ///< metres; negative when not computed
  std::vector<deploy::BlockingPair> blocking;      ///< bricks in each other's way at the target
  std::vector<std::string> warnings;               ///< about the target, one line each
  std::vector<trajectory::Event> events;           ///< what the timeline did, and how the run ended
  deploy::DeployCost deployCost;                   ///< of the run itself
  std::optional<mechanics::LoadCurve> loadCurve;   ///< of a scene with grips
  std::optional<model::Elasticity> elasticity;     ///< absent where no hinge has a spring
  std::string leftOut;                             ///< why an export is missing; mostly empty
  std::vector<output::FileDigest> digests;         ///< of all files but summary.json
};

/// How far a run is, for a progress line. `stage` lives as long as the program.
struct Progress {
  const char* stage = "";          ///< "searching a path", "deploying", "painting" or "exporting"
  double share = 0;                ///< of this stage, 0 to 1
  std::string remark = {};         ///< a line to print once; mostly empty
  bool isRemarkInSummary = false;  ///< the remark is one of RunSummary::warnings
};

/// Who ends a stage of a run early, for example "SIGTERM"; absent: it continues.
using Interruption = std::optional<std::string>;

/// Called after each sample and each frame; may end the stage that is under way. The run then
/// counts as interrupted, and what exists so far is still written out.
using ProgressObserver = std::function<Interruption(const Progress&)>;

}  // namespace kirireel::record
