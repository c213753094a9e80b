/// The pictures of a run: single ones, videos, sheets of several, title cards.
#pragma once

#include <future>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "render/picture/frame.h"
#include "render/picture/png.h"
#include "render/picture/state_painter.h"
#include "render/picture/video.h"
#include "render/record/job.h"
#include "render/record/pace.h"
#include "render/record/pipeline.h"
#include "sim/trajectory/trajectory_file.h"

namespace kirireel::record {

// ------------------------------------------------------------------------------------------------
// The pictures of a run: video, single frames, snapshot grid.

/// What pictures show of a run before it begins, its start and its target in sight.
picture::PictureContent contentOf(const trajectory::Subject& subject);

/// The same of a finished run, with everything in sight that the settings ask for. Where they leave
/// the camera to the program, that is all of the run if anything would be cut off.
picture::PictureContent contentOf(const trajectory::TrajectoryReader& run,
                                  const PictureSettings& settings);

/// Throws InputError if the style or the grid needs data that the content lacks, before anything is
/// deployed. Needs no graphics context.
void requirePaintable(const picture::PictureContent& content, const PictureSettings& settings);

/// Writes the captions of pictures. Holds a copy of the start, from which turns are measured.
class CaptionWriter {
 public:
  /// Captions with these parts for pictures of this content.
  CaptionWriter(const picture::CaptionParts& parts, const picture::PictureContent& content)
      : parts_(parts), start_(content.start), hasTarget_(content.target.has_value()) {}

  /// In the grid to a tenth of a per cent; whole per cents where frames follow each other. One
  /// line, by the parts that were asked for.
  std::string of(const FrameState& state) const;
  /// The caption of a video's frame in this state, one line, UTF-8.
  std::string inVideo(const FrameState& state) const;
  /// At least as wide as any of a run that ends then, seconds.
  std::string longest(double endTime) const;

 private:
  std::string text(const FrameState& state, double progress) const;

  picture::CaptionParts parts_;
  Poses start_;
  bool hasTarget_;
};

/// The text under the frames of a video.
picture::StripParts stripParts(const PictureSettings& settings, const CaptionWriter& captions,
                               double endTime);

/// Paints the pictures of one run. Belongs to the thread that makes it.
class RunPictures {
 public:
  /// Everything passed must outlive the pictures. Throws InputError if the style needs data that
  /// the content lacks, OutputError when no graphics context can be made. Makes a graphics context
  /// and reads what contentOf() reads.
  RunPictures(const trajectory::TrajectoryReader& run, const PictureSettings& settings,
              PictureReport& report);

  /// Paints the run's video frames and encodes them at the same time: settings.painters() paint,
  /// one of them on this thread, each other thing has a thread of its own. The bytes depend neither
  /// on their number nor on which is faster. Throws the first error of any of them.
  void makeFrames(const trajectory::TrajectoryReader& run, const MotionCurve& motion,
                  const ProgressObserver& observer);

  /// Writes the snapshot grid, the timeline's snapshots and chosen frames. Throws OutputError.
  void writeSnapshots(const trajectory::TrajectoryReader& run, const MotionCurve& motion);

 private:
  /// A state to be painted; its frame is promised to the encoder in the order of states.
  struct FrameOrder {
    SharedState state;
    std::promise<picture::Frame> frame;
  };
  using OrderQueue = BoundedQueue<FrameOrder>;
  using FrameQueue = BoundedQueue<std::future<picture::Frame>>;

  void paint(picture::StatePainter& painter, OrderQueue& orders, FramePool& pool);
  void encode(FrameQueue& frames, FramePool& pool);
  picture::Frame paintFrame(picture::StatePainter& painter, const FrameState& state,
                            picture::Frame storage = {}) const;
  picture::Frame paintStill(const FrameState& state);
  void writeGrid(const trajectory::TrajectoryReader& run, const MotionCurve& motion);
  void writeMoments(const trajectory::TrajectoryReader& run, const MotionCurve& motion);
  void writeChosenFrames(const trajectory::TrajectoryReader& run, const MotionCurve& motion);

  const PictureSettings& settings_;
  PictureReport& report_;
  CaptionWriter captions_;
  picture::StatePainter frames_;                 ///< with a strip under its pictures
  std::optional<picture::StatePainter> stills_;  ///< the same, smoother: for single frames
};

// ------------------------------------------------------------------------------------------------
// Where painted frames go: into the video, into single files, or both.
//
// Frames come in the order of the video. The sink keeps the last one, since nobody knows that it
// is the last before finish() is called, and it may have to be shown longer.

/// How the run's video is encoded.
picture::VideoSettings videoSettings(const PictureSettings& settings);

/// How its single pictures are written.
picture::PngSettings pngSettings(const PictureSettings& settings);

/// Encodes and writes frames in order; repeats the first and the last frame for the time in the
/// settings. Belongs to the thread that makes it.
class FrameSink {
 public:
  /// Throws OutputError when the video cannot be made. Settings and report must outlive the sink.
  FrameSink(const PictureSettings& settings, PictureReport& report);

  /// Shows a card before the first frame. Throws OutputError.
  void putTitle(const picture::Frame& card);

  /// Returns a frame that is needed no more, empty at first. Throws OutputError. With `frames` it
  /// also writes frames/frame_00000.png and so on.
  picture::Frame put(picture::Frame frame);

  /// Puts the video in place and reports; without it, no video is left. Throws OutputError.
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
// The card before a video.

/// The text of a card, UTF-8; line feeds begin new lines.
struct Title {
  std::string title;     ///< over the frame, UTF-8; empty: none
  std::string subtitle;  ///< below the title, UTF-8; empty: none

  /// Whether there is neither.
  bool empty() const { return title.empty() && subtitle.empty(); }
};

/// Throws InputError for a text that is not UTF-8, or has a character that the font lacks, and
/// OutputError when the font is missing.
void requireTitle(const Title& title);

/// The title in the middle of a picture, its subtitle below in smaller letters. Lines that would be
/// too wide are wrapped; what is too wide or too high even so is drawn smaller. Throws OutputError
/// when the font is missing. At least one of the texts is not empty.
picture::Frame titleCard(const Title& title, picture::FrameSize size, picture::Colour background,
                         picture::Colour ink);

// ------------------------------------------------------------------------------------------------
// Sheets of pictures: states of one run or of several, side by side, as pixels and as vector
// graphics.

/// States of one run in a row of a sheet. Rows of a figure may have different models; those of one
/// run have one row, which fills all cells.
struct PanelRow {
  picture::Look look;                 ///< of all its pictures
  picture::PictureContent content;    ///< the run that is shown
  std::vector<FrameState> states;     ///< one a picture, from left to right
  std::vector<std::string> captions;  ///< one a state
  std::string head;                   ///< over the row, in a figure of several runs
};

/// The name of the sheet's file in this format. PNG has a special name, see output::kSnapshots.
const char* pageFile(picture::PageFormat format);

/// What a picture of a state shows.
picture::ShownState shownState(const FrameState& state);

/// One sheet. Belongs to the thread that makes it.
class PanelSheet {
 public:
  /// The rows' states fill the shape from its upper left cell on. Rows of several runs have heads,
  /// heights, and scales of their own, unless the settings say otherwise. What is passed must
  /// outlive the sheet.
  PanelSheet(const std::vector<PanelRow>& rows, picture::GridShape shape,
             const PictureSettings& settings, PictureReport& report)
      : rows_(rows), shape_(shape), settings_(settings), report_(report) {}

  /// Writes snapshots.png and the other files of the sheet that the settings request. Throws
  /// OutputError. Paints every picture once, twice where the sheet has a width in print.
  void write();

 private:
  /// How the pictures of a row are shown: enlarged, and cut to a part.
  struct Cut {
    double scale = 1;          ///< to the size of the settings
    picture::PictureBox part;  ///< of the enlarged pictures
  };

  bool hasSeveralRuns() const { return rows_.size() > 1; }
  void paintAll(const std::vector<Cut>& cuts, std::optional<double> pixelsPerInch);
  std::vector<Cut> findCuts();
  std::vector<Cut> enlarged(std::vector<Cut> cuts, double factor) const;
  picture::GridLayout layOut(const std::vector<Cut>& cuts, picture::GridStyle& style) const;
  void writeDrawings();
  double enlargement(const std::vector<Cut>& cuts) const;
  double pixelsPerInch(const picture::GridLayout& layout) const;
  picture::GridStyle gridStyle(const std::vector<Cut>& cuts) const;
  int textSize(const picture::GridLayout& layout) const;
  void writePage(picture::PageFormat format, const std::vector<Cut>& cuts,
                 const picture::GridLayout& layout, const picture::GridStyle& style);

  const std::vector<PanelRow>& rows_;
  picture::GridShape shape_;
  const PictureSettings& settings_;
  PictureReport& report_;
  std::vector<std::unique_ptr<picture::StatePainter>> painters_;  ///< one a row
  std::vector<picture::GridPicture> pictures_;
};

// ------------------------------------------------------------------------------------------------
// Figures of several runs: a row of pictures each.

/// The rows of a figure, settings.grid.columns states of each run. All pictures share one scale of
/// colours; with the settings' sameView they also share the view of the first run, with sameScale
/// one scale of length. Throws InputError where no one scale holds: in perspective or from a moving
/// camera. At least one run. The readers must stay open while rows are made.
std::vector<PanelRow> figureRows(std::span<const trajectory::TrajectoryReader* const> runs,
                                 const PictureSettings& settings);

}  // namespace kirireel::record
