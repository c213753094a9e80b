/// Settings and results of a recording.
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
#include "sim/run/result.h"
#include "sim/scene/scene.h"

namespace kirireel::record {

inline constexpr int kMaxFrameRate = 240;         ///< of a video, per second
inline constexpr int kMaxSampleRate = 1'000'000;  ///< of a run, per simulated second

/// Distribution of a snapshot grid's pictures over a run; always includes the first and last.
enum class SnapshotSpacing {
  Time,      ///< equal steps of simulated time
  Progress,  ///< equal fractions of the motion, see MotionCurve
};

/// Relation between a video's time and the run.
enum class Pace {
  Even,  ///< equal motion per frame
  Real,  ///< equal simulated time per frame
};

/// A moment of a run for a separate picture.
struct FrameChoice {
  /// Unit of `value`.
  enum class Unit { Seconds, Share };
  double value = 0;           ///< simulated seconds, or the fraction of the motion, [0, 1]
  Unit unit = Unit::Seconds;  ///< of `value`

  bool operator==(const FrameChoice&) const = default;
};

/// Default size of text in print, points.
inline constexpr double kFontPoints = 7;

/// Selection, style and folder of the pictures of a run. Defaults are those of the command line.
/// record() and render() check the ranges.
struct PictureSettings {
  std::optional<picture::GraphicsLibrary> graphics;  ///< library for drawing; absent: the default
  std::filesystem::path folder;  ///< created if needed; files of a previous run in it are replaced
  picture::FrameSize size;       ///< of video frames and of each snapshot
  /// Of the video, 1 to kMaxFrameRate. Without painted frames only samples of the run have this
  /// rate, 1 to kMaxSampleRate.
  int framesPerSecond = 60;
  Pace pace = Pace::Even;  ///< relation between video time and run
  double length = 8;       ///< of a video at an even pace without title, seconds
  double speed =
      1;  ///< simulated seconds per second of a video at real pace, > 0; < 1 is slow motion
  /// Additional seconds of the video's first and last frame; absent: 0.5 at an even pace, else 0.
  std::optional<double> hold;
  /// Text of a card before the video, UTF-8, with line feeds. No card if title and subtitle are
  /// empty.
  std::string title;
  std::string subtitle;            ///< below the title, UTF-8; empty: none
  picture::Appearance appearance;  ///< of all pictures
  picture::GridShape grid;         ///< of the snapshots
  /// Captions of the grid's pictures and the video's frames. Absent: only in the grid, progress at
  /// an even pace, time at real pace, none if its columns have headers.
  std::optional<picture::CaptionParts> captions;
  /// A scale bar in the grid and the video; requires a parallel projection.
  bool scaleBar = false;
  bool progressBar = false;  ///< under the video
  /// A curve in a corner of the frames, with a dot at their time; see Inset. Empty: none.
  std::string inset;
  std::optional<double> dotsPerInch;  ///< stored in PNG files, for print
  std::optional<double> gridWidth;    ///< of the grid in print, millimetres; absent: not fixed
  /// Size of the grid's text in print; requires gridWidth. Absent: kFontPoints with a gridWidth,
  /// else by the pictures' size.
  std::optional<double> fontPoints;
  std::string font;  ///< family of all text; empty: the program's
  picture::PanelLetters letters = picture::PanelLetters::None;  ///< of the grid
  bool sameView = false;   ///< for all rows of a figure of several runs; else each has its own
  bool sameScale = false;  ///< the same for their scale of length
  bool arrows = false;     ///< from each of the grid's pictures to the next in its row
  std::vector<std::string> columnHeads;  ///< headers of the grid's columns, one each; empty: none
  std::vector<picture::PageFormat>
      pages;           ///< the grid as vector graphics in addition, as snapshots.svg, .pdf
  std::string madeBy;  ///< author and source of the pictures, stored in the files
  SnapshotSpacing spacing = SnapshotSpacing::Progress;  ///< states of the snapshots
  bool video = true;                                    ///< whether to make a video
  std::string videoFile = output::kVideo;               ///< its ending selects the format
  std::optional<int> crf;                               ///< of the video, see VideoSettings
  std::string preset = "auto";                          ///< of the video, see VideoSettings
  std::string encoder;                                  ///< of the video, see VideoSettings
  bool snapshots = true;                                ///< snapshots.png
  bool svg = false;     ///< snapshot_01.svg ..., the grid's pictures as vector graphics
  bool frames = false;  ///< frames/frame_00000.png ..., every frame of the video
  std::vector<FrameChoice> chosenFrames;  ///< the same, only at these moments
  /// Number of painters of a video's frames; absent: one per core. No effect on the output.
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
  /// Resolution of the grid, if it has a width in print.
  double gridDotsPerInch() const { return dotsPerInch.value_or(300); }
  /// The captions of the grid's pictures.
  picture::CaptionParts captionParts() const {
    if (captions || !columnHeads.empty()) return captions.value_or(picture::CaptionParts{});
    return pace == Pace::Even ? picture::CaptionParts{.progress = true}
                              : picture::CaptionParts{.time = true};
  }
};

/// Outputs of a run: its samples, its pictures, and more. The folder is created if needed. Files
/// from elsewhere in it are never overwritten, see FileSet.
struct RecordSettings : PictureSettings {
  std::string order;      ///< fingerprint of all inputs of the run, for summary.json and
                          ///< checkpoints; without it no checkpoints
  std::string sceneText;  ///< all settings as a scene file, for summary.json; empty if unknown
  /// The word that selected PyKirigami's constants as defaults; empty: none.
  std::string peerSpelling;
  std::vector<InputFile> inputs;  ///< input files of the run, for summary.json
  bool resume = false;     ///< continue from the folder's checkpoint if it has the same order
  bool meshes = true;      ///< initial and final, OBJ and PLY
  bool trajectory = true;  ///< trajectory.h5, required for meshes, pictures and exports
  exports::ExportSettings exports;  ///< additional files; none without formats
};

/// Cost of recording, in addition to the deployment's own cost. Seconds of several painters are
/// summed and may exceed the wall time.
struct RecordCost {
  double cpuSecondsRender = 0;       ///< of painters and of the threads of the graphics library
  double cpuSecondsEncode = 0;       ///< of the encoder's thread
  double wallSeconds = 0;            ///< from the start to the last file
  std::int64_t peakMemoryBytes = 0;  ///< largest resident size of the process
};

/// Painted pictures and their cost. Filled while pictures are made. Values of pictures that were
/// not made stay 0 or empty.
struct PictureReport {
  int videoFrames = 0;              ///< frames in the video
  std::optional<double> stoppedAt;  ///< end of the video if the observer ended it, seconds
  std::string stoppedBy;            ///< cause of the end, as in Interruption
  RecordCost recordCost;            ///< of pictures and video
  /// View of all pictures; absent if camera keys move it.
  std::optional<picture::AutomaticView> view;
  std::string graphics;            ///< OpenGL version and vendor; empty if unused
  std::vector<std::string> files;  ///< relative to the folder, in the order written
};

/// The contents of summary.json, without the settings. The trajectory has no samples if the run
/// passed them on.
struct RunSummary : PictureReport, run::DeploymentResult {
  double endTime = 0;  ///< simulated seconds
  /// Time at which the first brick was farther away than pictures show (see kFarthestShown),
  /// simulated seconds. Its data continue.
  std::optional<double> leftOutFrom;
  std::string leftOut;                      ///< why an export is missing; usually empty
  std::vector<output::FileDigest> digests;  ///< of all files but summary.json
};

/// Progress of a run, for a progress line. `stage` is a string literal.
struct Progress {
  const char* stage = "";          ///< "searching a path", "deploying", "painting" or "exporting"
  double share = 0;                ///< completed fraction of this stage, [0, 1]
  std::string remark = {};         ///< a line to print once; usually empty
  bool isRemarkInSummary = false;  ///< the remark is one of RunSummary::warnings
};

/// The cause that ends a stage of a run early, for example "SIGTERM"; absent: it continues.
using Interruption = std::optional<std::string>;

/// Called after each sample and each frame; may end the current stage. The run then counts as
/// interrupted, and existing results are still written.
using ProgressObserver = std::function<Interruption(const Progress&)>;

}  // namespace kirireel::record
