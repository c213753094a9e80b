/// The pictures of a run: single pictures, videos, sheets, title cards.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "render/picture/frame.h"
#include "render/picture/png.h"
#include "render/picture/state_painter.h"
#include "render/picture/video.h"
#include "render/record/inset.h"
#include "render/record/job.h"
#include "render/record/pace.h"
#include "render/record/pipeline.h"
#include "sim/trajectory/trajectory_file.h"

namespace kirireel::record {

// ------------------------------------------------------------------------------------------------
// The pictures of a run: video, single frames, snapshot grid.

/// The content of pictures of a run before it begins, with its start and target in view.
picture::PictureContent contentOf(const trajectory::Subject& subject);

/// The same for a finished run, with everything in view that the settings request. With an
/// automatic camera, the whole run if anything would be cut off.
picture::PictureContent contentOf(const trajectory::TrajectoryReader& run,
                                  const PictureSettings& settings);

/// The view of a finished run's pictures: the one given, or the one that is chosen for the motion.
/// Null if the camera follows keys. Of the appearance, only the camera and the ground matter.
std::optional<picture::AutomaticView> viewOf(const trajectory::TrajectoryReader& run,
                                             const picture::Appearance& appearance);

/// Throws InputError before a deployment if the style or the grid needs data that the content
/// lacks. Needs no graphics context.
void requirePaintable(const picture::PictureContent& content, const PictureSettings& settings);

/// Writes the captions of pictures. Keeps a copy of the start, the reference of rotations.
class CaptionWriter {
 public:
  /// Captions with these parts for pictures of this content.
  CaptionWriter(const picture::CaptionParts& parts, const picture::PictureContent& content)
      : parts_(parts),
        start_(content.start),
        hasTarget_(content.target.has_value()),
        unit_(content.unit) {}

  /// One line with the requested parts. Progress has a tenth of a per cent in the grid, whole per
  /// cents in consecutive frames.
  std::string of(const FrameState& state) const;
  /// The caption of a video's frame in this state, one line, UTF-8.
  std::string inVideo(const FrameState& state) const;
  /// A caption at least as wide as any in a run with this end time, seconds.
  std::string longest(double endTime) const;

 private:
  std::string text(const FrameState& state, double progress) const;

  picture::CaptionParts parts_;
  Poses start_;
  bool hasTarget_;
  LengthUnit unit_;
};

/// The runs of a video side by side: texts with the same size in all parts.
struct SideTexts {
  std::string name;            ///< of this part's run; empty: not shown
  std::string longestName;     ///< of all parts
  std::string longestCaption;  ///< of all parts
};

/// Paints the frames of a run's video, or its part of them. Use it only in the thread that makes
/// it.
class FramePainter {
 public:
  /// Reads the same data as contentOf(). `texts`: of runs side by side. Throws InputError if the
  /// style needs data that the content lacks or the run lacks the curve of the inset, OutputError
  /// if there is no graphics context.
  FramePainter(const trajectory::TrajectoryReader& run, const PictureSettings& settings,
               const SideTexts& texts = {});
  /// Another painter of the same frames, for the thread that makes it.
  FramePainter(const FramePainter& other) = default;
  /// The same with another smoothness.
  FramePainter(const FramePainter& other, picture::Smoothness smoothness)
      : captions_(other.captions_), inset_(other.inset_), painter_(other.painter_, smoothness) {}
  FramePainter& operator=(const FramePainter&) = delete;

  /// The frame of a state with its strip and its inset. storage: an unused frame.
  picture::Frame paint(const FrameState& state, picture::Frame storage = {});

  /// Paints with another appearance from now on.
  void show(const trajectory::TrajectoryReader& run, const PictureSettings& settings);

  const picture::PictureSetup& setup() const { return painter_.setup(); }

 private:
  void addInset(const trajectory::TrajectoryReader& run, const PictureSettings& settings);

  std::shared_ptr<const CaptionWriter> captions_;
  std::shared_ptr<const Inset> inset_;  ///< may be null
  picture::StatePainter painter_;
};

/// Paints the frames of a video and encodes them concurrently. Several runs are side by side in
/// each frame, from left to right. `painters` has one entry per run. settings.painters() threads
/// paint, including this one. Reader and encoder have their own threads. The bytes depend neither
/// on the number of threads nor on their speed. Throws the first error of any of them.
void makeFrames(const std::vector<FilmedRun>& runs, std::vector<FramePainter>& painters,
                const PictureSettings& settings, const ProgressObserver& observer,
                PictureReport& report);

/// Makes the video of several runs side by side. Each has an equal part of the frames with its name
/// below. Views and scales are those of a figure, see figureRows(). A run whose video would be
/// shorter stays at its end. Throws InputError like figureRows() and FramePainter.
void makeSideBySide(std::span<const trajectory::TrajectoryReader* const> runs,
                    const std::vector<std::string>& names, const PictureSettings& settings,
                    const ProgressObserver& observer, PictureReport& report);

/// Paints the pictures of one run. Use it only in the thread that makes it.
class RunPictures {
 public:
  /// All arguments must outlive the pictures. Throws like FramePainter.
  RunPictures(const trajectory::TrajectoryReader& run, const PictureSettings& settings,
              PictureReport& report);

  /// Makes the video, see the function with this name.
  void makeFrames(const trajectory::TrajectoryReader& run, const MotionCurve& motion,
                  const ProgressObserver& observer);

  /// Writes the snapshot grid, the timeline's snapshots and chosen frames. Throws OutputError.
  void writeSnapshots(const trajectory::TrajectoryReader& run, const MotionCurve& motion);

 private:
  picture::Frame paintStill(const FrameState& state);
  void writeGrid(const trajectory::TrajectoryReader& run, const MotionCurve& motion);
  void writeMoments(const trajectory::TrajectoryReader& run, const MotionCurve& motion);
  void writeChosenFrames(const trajectory::TrajectoryReader& run, const MotionCurve& motion);

  const PictureSettings& settings_;
  PictureReport& report_;
  std::vector<FramePainter> painters_;  ///< one, with a strip below its pictures
  std::optional<FramePainter> stills_;  ///< the same, smoother: for single frames
};

// ------------------------------------------------------------------------------------------------
// Outputs of painted frames: the video, single files, or both.
//
// Frames come in the order of the video. The sink keeps the last one, because only finish() shows
// that it is the last, and it may be shown longer.

/// Encoding settings of the run's video.
picture::VideoSettings videoSettings(const PictureSettings& settings);

/// Settings of its single pictures.
picture::PngSettings pngSettings(const PictureSettings& settings);

/// Encodes and writes frames in order. Repeats the first and the last frame for the time in the
/// settings. Use it only in the thread that makes it.
class FrameSink {
 public:
  /// Throws OutputError if the video cannot be made. Settings and report must outlive the sink.
  FrameSink(const PictureSettings& settings, PictureReport& report);

  /// Shows a card before the first frame. Throws OutputError.
  void putTitle(const picture::Frame& card);

  /// Returns an unused frame for reuse, empty at first. With `frames` it also writes
  /// frames/frame_00000.png and so on. Throws OutputError.
  picture::Frame put(picture::Frame frame);

  /// Completes the video and the report; otherwise no video remains. Throws OutputError.
  void finish();

 private:
  void encode(const picture::Frame& frame, int times);

  const PictureSettings& settings_;
  PictureReport& report_;
  std::optional<picture::VideoWriter> video_;
  int heldFrames_;
  int number_ = 0;  ///< of the next frame
  picture::Frame last_;
  int videoFrames_ = 0;
  std::vector<std::string> files_;
};

// ------------------------------------------------------------------------------------------------
// The title card of a video.

/// The text of a card, UTF-8; line feeds begin new lines.
struct Title {
  std::string title;     ///< over the frame, UTF-8; empty: none
  std::string subtitle;  ///< below the title, UTF-8; empty: none

  /// Whether both are empty.
  bool empty() const { return title.empty() && subtitle.empty(); }
};

/// Throws InputError for a text that is not UTF-8, or has a character missing in the font, and
/// OutputError if the font is missing.
void requireTitle(const Title& title);

/// The title in the middle of a picture, its subtitle below in smaller letters. Wide lines are
/// wrapped. Text that is still too wide or too high is drawn smaller. Throws OutputError if the
/// font is missing. At least one text must not be empty.
picture::Frame titleCard(const Title& title, picture::FrameSize size, picture::Colour background,
                         picture::Colour ink);

// ------------------------------------------------------------------------------------------------
// Sheets of pictures: states of one run or of several, side by side, as pixels and as vector
// graphics.

/// States of one run in a row of a sheet. Rows of a figure may have different models. A single run
/// has one row, which fills all cells.
struct PanelRow {
  picture::Appearance appearance;     ///< of all its pictures
  picture::PictureContent content;    ///< of the run
  std::vector<FrameState> states;     ///< one per picture, from left to right
  std::vector<std::string> captions;  ///< one per state
  std::string head;                   ///< above the row, in a figure of several runs
};

/// The state for a picture.
picture::ShownState shownState(const FrameState& state);

/// One sheet. Use it only in the thread that makes it.
class PanelSheet {
 public:
  /// The rows' states fill the cells from the upper left. Rows of several runs have their own
  /// headers, heights and scales, unless the settings specify otherwise. All arguments must outlive
  /// the sheet.
  PanelSheet(const std::vector<PanelRow>& rows, picture::GridShape shape,
             const PictureSettings& settings, PictureReport& report)
      : rows_(rows), shape_(shape), settings_(settings), report_(report) {}

  /// Writes snapshots.png and the other requested files of the sheet. Throws OutputError. Paints
  /// every picture once, or twice if the sheet has a width in print.
  void write();

  /// Fits the sheet to a page: at most `width` pixels wide, with text of `em` pixels. Paints every
  /// picture once, at the first call. Returns the sheet's size.
  picture::FrameSize fit(double width, int em, double pixelsPerInch);

  /// Draws the fitted sheet on a page as a part with this name, from this corner on.
  void draw(picture::Canvas& page, const Eigen::Vector2d& corner, const std::string& name);

 private:
  /// Enlargement and cut of the pictures in a row.
  struct Cut {
    double scale = 1;          ///< relative to the size in the settings
    picture::PictureBox part;  ///< of the enlarged pictures
  };

  bool hasSeveralRuns() const { return rows_.size() > 1; }
  void setUp(const std::vector<Cut>& cuts, std::optional<double> pixelsPerInch);
  void paintAll();
  std::vector<Cut> findCuts();
  std::vector<Cut> enlarged(std::vector<Cut> cuts, double factor) const;
  picture::GridLayout layOut(const std::vector<Cut>& cuts, picture::GridStyle& style) const;
  void layOut();
  void writeDrawings();
  double enlargement(const std::vector<Cut>& cuts, double width) const;
  double pixelsPerInch(const picture::GridLayout& layout) const;
  picture::GridStyle gridStyle(const std::vector<Cut>& cuts) const;
  int textSize(const picture::GridLayout& layout) const;
  void drawAll(picture::Canvas& page, const Eigen::Vector2d& corner, const std::string& prefix);
  void writePage(picture::PageFormat format);

  const std::vector<PanelRow>& rows_;
  picture::GridShape shape_;
  const PictureSettings& settings_;
  PictureReport& report_;
  std::vector<std::shared_ptr<const picture::PictureSetup>> setups_;  ///< one per row
  std::vector<picture::GridPicture> pictures_;
  std::optional<int> em_;     ///< of text on a page, see fit()
  std::vector<Cut> painted_;  ///< of the pictures as painted first
  std::vector<Cut> cuts_;     ///< of the final layout, with the next two
  picture::GridStyle style_;
  picture::GridLayout layout_;
};

// ------------------------------------------------------------------------------------------------
// Figures of several runs, one row of pictures each.

/// Names for runs in one figure: of their models, or of their folders if models have the same name.
/// `trajectories`: the files of the runs.
std::vector<std::string> namesOf(std::span<const trajectory::TrajectoryReader* const> runs,
                                 const std::vector<std::filesystem::path>& trajectories);

/// The rows of a figure with settings.grid.columns states of each run. A single run has as many
/// states as the grid has cells. All pictures have a common colour scale. With sameView they have
/// the view of the first run, with sameScale a common scale of length. Throws InputError if there
/// is no common scale: in perspective or with a moving camera. At least one run. The readers must
/// stay open while rows are made.
std::vector<PanelRow> figureRows(std::span<const trajectory::TrajectoryReader* const> runs,
                                 const PictureSettings& settings);

}  // namespace kirireel::record
