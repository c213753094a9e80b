// Paints and encodes a video concurrently, by threads with short queues between them:
//
//     reader (1 thread)    reads states in order and creates a promise for each frame
//       orders -> painters (several), each on its own thread: fulfil the promises
//       frames  ->  encoder (1 thread): takes the frames in the order of the states
//
// The order of frames is that of the futures in the queue, for any order of completion. The output
// bytes therefore do not depend on the number of painters. Both queues are bounded: memory holds
// some tens of frames for any length of the run. The first error of any thread stops both queues,
// and finish() throws it (pipeline.h).
//
// The view of the camera is set before: the start and the target by default, or about a hundred
// samples of the run on request. If the program chose the camera and would cut off a sample, the
// whole run.
#include "render/record/run_pictures.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <numbers>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "render/output/output_folder.h"
#include "render/picture/canvas.h"
#include "render/picture/gl_context.h"
#include "render/picture/grid.h"
#include "render/picture/label.h"
#include "sim/base/error.h"
#include "sim/base/files.h"
#include "sim/base/interruption.h"
#include "sim/trajectory/run_curves.h"

namespace kirireel::record {
namespace {

/// Number of samples for the fit of the camera, the scale of colours and the range of the depth
/// cue. It is sufficient for any smooth motion.
constexpr std::size_t kSamplesFramed = 100;
/// Frames between painting and encoding, in addition to one per painter; see kWaitingSamples.
constexpr std::size_t kWaitingFrames = 4;
/// Half the picture's width and height, with a margin for rounding.
constexpr double kBorder = 1 + 1e-9;

/// At equal steps of samples, always with the last.
std::vector<Poses> someStates(const trajectory::TrajectoryReader& run) {
  std::vector<Poses> states;
  const std::size_t count = run.times().size();
  const std::size_t stride = 1 + count / kSamplesFramed;
  for (std::size_t i = 0; i < count; i += stride) states.push_back(run.sample(i).poses);
  states.push_back(run.sample(count - 1).poses);
  return states;
}

/// The paths of traced vertices, with all samples.
void keepPaths(picture::PictureContent& content, const trajectory::TrajectoryReader& run,
               const std::vector<picture::TracedVertex>& trails) {
  content.paths.assign(trails.size(), {run.times(), {}});
  for (std::size_t i = 0; i < run.times().size(); ++i) {
    const Poses poses = run.sample(i).poses;
    for (std::size_t k = 0; k < trails.size(); ++k) {
      content.paths[k].points.push_back(picture::vertexPosition(content, poses, trails[k]));
    }
  }
}

/// From the start, the middle of the motion and the end.
void chooseViewOf(const trajectory::TrajectoryReader& run, const picture::Appearance& appearance,
                  picture::PictureContent& content) {
  Replay replayed(run);
  std::vector<Poses> states;
  const MotionCurve motion = motionOf(run);
  for (const double share : {0.0, 0.5, 1.0}) {
    states.push_back(replayed.at(share > 0 ? motion.timeAt(share) : 0).poses);
  }
  picture::setView(appearance, states, content);
}

/// Without a target there is only one end, so the whole run counts.
bool fitsEnds(const model::Model& model, const PictureSettings& settings) {
  if (settings.appearance.fit == picture::FitScope::Auto) return model.target.has_value();
  return settings.appearance.fit == picture::FitScope::Ends;
}

/// Whether the program chose the camera, so it must not cut anything off.
bool choosesCamera(const PictureSettings& settings) {
  const picture::CameraChoice& camera = settings.appearance.camera;
  return settings.appearance.fit == picture::FitScope::Auto && camera.zoom == 1 &&
         camera.keys.empty() && !camera.distance;
}

/// Clip coordinates outside [-w, w] are outside the picture.
bool showsAll(const picture::PictureSetup& setup, const picture::ShownState& state, double aspect) {
  const Eigen::Matrix4d clip = picture::clipFromWorld(setup.camera(state), aspect);
  const std::vector<Vector3> corners = picture::shownCorners(setup.content(), state.poses);
  return std::ranges::all_of(corners, [&](const Vector3& corner) {
    const Eigen::Vector4d point = clip * corner.homogeneous();
    return point.head<2>().cwiseAbs().maxCoeff() <= kBorder * point.w();
  });
}

/// Whether pictures of this content show every sample of the run completely. Checks every sample.
bool showsRun(const trajectory::TrajectoryReader& run, const picture::PictureSetup& setup) {
  for (std::size_t i = 0; i < run.times().size(); ++i) {
    const trajectory::Sample sample = run.sample(i);
    if (!showsAll(setup, {sample.time, sample.poses, {}}, setup.pictureSize().aspect())) {
      return false;
    }
  }
  return true;
}

}  // namespace

picture::PictureContent contentOf(const trajectory::Subject& subject) {
  picture::PictureContent content =
      picture::makeContent(subject.model, subject.brickRule, subject.ground);
  content.pairForces = subject.pairForces;
  content.obstacles = subject.obstacles;
  return content;
}

picture::PictureContent contentOf(const trajectory::TrajectoryReader& run,
                                  const PictureSettings& settings) {
  picture::PictureContent content = contentOf(run.subject());
  content.panels = run.end().panels;
  if (picture::needsView(settings.appearance)) chooseViewOf(run, settings.appearance, content);
  const bool fits =
      fitsEnds(run.subject().model, settings) &&
      (!choosesCamera(settings) ||
       showsRun(run, picture::PictureSetup(settings.appearance, content, settings.size)));
  if (!fits) {
    for (const Poses& poses : someStates(run)) picture::keepInView(content, poses);
  }
  const bool needsScale =
      picture::isMeasure(settings.appearance.colouring) && !settings.appearance.colourMost;
  if (needsScale || settings.appearance.depthCue > 0) content.states = someStates(run);
  picture::requireVertices(settings.appearance.trails, content.bricks);
  if (!settings.appearance.trails.empty()) keepPaths(content, run, settings.appearance.trails);
  return content;
}

std::optional<picture::AutomaticView> viewOf(const trajectory::TrajectoryReader& run,
                                             const picture::Appearance& appearance) {
  if (appearance.camera.view) return picture::AutomaticView{*appearance.camera.view};
  if (!picture::needsView(appearance)) return std::nullopt;
  picture::PictureContent content = contentOf(run.subject());
  chooseViewOf(run, appearance, content);
  return content.view;
}

void requirePaintable(const picture::PictureContent& content, const PictureSettings& settings) {
  if (!settings.paints()) return;
  const picture::PictureSetup setup(settings.appearance, content, settings.size);
  if (settings.scaleBar) setup.metresPerPixel();
  requireInset(settings);
}

std::string CaptionWriter::text(const FrameState& state, double progress) const {
  const std::vector<double> turned = trajectory::brickRotations(start_, state.sample.poses);
  picture::CaptionValues values{
      progress,     state.moment.time,     *std::ranges::max_element(turned),
      std::nullopt, state.sample.jointGap, unit_};
  if (hasTarget_) values.error = state.sample.targetError;
  return picture::captionText(parts_, values);
}

std::string CaptionWriter::of(const FrameState& state) const {
  return text(state, state.moment.progress);
}

std::string CaptionWriter::inVideo(const FrameState& state) const {
  return text(state, 0.01 * std::round(100 * state.moment.progress));
}

std::string CaptionWriter::longest(double endTime) const {
  constexpr double kLongLength = 8.8e-88;  // of the unit, in the form with the most letters
  picture::CaptionValues values{
      1, endTime, std::numbers::pi, std::nullopt, kLongLength * unit_.metres, unit_};
  if (hasTarget_) values.error = values.gap;
  return picture::captionText(parts_, values);
}

namespace {

/// The text under the frames of a video.
picture::StripParts stripParts(const PictureSettings& settings, const std::string& longestCaption,
                               const SideTexts& texts) {
  picture::StripParts parts;
  parts.name = texts.name;
  parts.longestName = texts.longestName;
  if (settings.captions) parts.longestCaption = longestCaption;
  parts.progressBar = settings.progressBar;
  parts.scaleBar = settings.scaleBar;
  parts.colours = true;
  return parts;
}

std::string longestCaption(const trajectory::TrajectoryReader& run, const CaptionWriter& captions) {
  return captions.longest(run.times().back());
}

}  // namespace

FramePainter::FramePainter(const trajectory::TrajectoryReader& run, const PictureSettings& settings,
                           const SideTexts& texts)
    : captions_(
          std::make_shared<const CaptionWriter>(settings.captionParts(), contentOf(run.subject()))),
      painter_(settings.size, settings.appearance, contentOf(run, settings),
               stripParts(settings,
                          texts.longestCaption.empty() ? longestCaption(run, *captions_)
                                                       : texts.longestCaption,
                          texts),
               picture::Smoothness::Film) {
  addInset(run, settings);
}

void FramePainter::addInset(const trajectory::TrajectoryReader& run,
                            const PictureSettings& settings) {
  if (!settings.inset.empty()) inset_ = std::make_shared<const Inset>(run, settings, setup());
}

void FramePainter::show(const trajectory::TrajectoryReader& run, const PictureSettings& settings) {
  painter_.show(settings.appearance, setup().content());
  addInset(run, settings);
}

picture::Frame FramePainter::paint(const FrameState& state, picture::Frame storage) {
  picture::Frame frame = painter_.paint(
      shownState(state), {captions_->inVideo(state), state.moment.progress}, std::move(storage));
  if (inset_) inset_->draw(frame, state.moment.time);
  return frame;
}

namespace {

/// States to be painted, with a promise of their frame in the order of the video.
struct FrameOrder {
  SharedStates states;
  std::promise<picture::Frame> frame;
};
using OrderQueue = BoundedQueue<FrameOrder>;
using FrameQueue = BoundedQueue<std::future<picture::Frame>>;

/// Width of each run's part of a frame, pixels. The rest of the frame's width is empty.
int partWidth(const PictureSettings& settings, std::size_t runs) {
  return settings.size.width / static_cast<int>(runs);
}

/// Paints whole frames of one run or of several. Of several, a part whose state did not change is
/// not painted again.
class FrameComposer {
 public:
  FrameComposer(std::vector<FramePainter>& painters, const PictureSettings& settings)
      : painters_(painters), settings_(settings), parts_(painters.size()) {}

  picture::Frame paint(const std::vector<FrameState>& states, picture::Frame storage) {
    if (states.size() == 1) return painters_.front().paint(states.front(), std::move(storage));
    picture::Frame frame = picture::makeFrame(
        settings_.size, painters_.front().setup().style().background, std::move(storage));
    const int width = partWidth(settings_, states.size());
    for (std::size_t k = 0; k < states.size(); ++k) {
      PaintedPart& part = parts_[k];
      if (part.moment != states[k].moment) {
        part.frame = painters_[k].paint(states[k], std::move(part.frame));
        part.moment = states[k].moment;
      }
      picture::pasteFrame(frame, part.frame, static_cast<int>(k) * width, 0);
    }
    return frame;
  }

 private:
  struct PaintedPart {
    picture::Frame frame;
    std::optional<FrameMoment> moment;  ///< of the frame
  };

  std::vector<FramePainter>& painters_;
  const PictureSettings& settings_;
  std::vector<PaintedPart> parts_;
};

/// Ends when the queue is closed or stopped.
void paintAll(FrameComposer composer, OrderQueue& orders, FramePool& pool) {
  while (std::optional<FrameOrder> order = orders.pop()) {
    try {
      order->frame.set_value(composer.paint(*order->states, pool.take()));
    } catch (...) {
      // The encoder may wait for this frame, so it gets the exception. A broken promise would
      // otherwise be the group's first error.
      order->frame.set_exception(std::current_exception());
      throw;
    }
  }
}

/// On its own thread, with the only sink.
void encodeAll(FrameQueue& frames, FramePool& pool, const picture::Style& style,
               const PictureSettings& settings, PictureReport& report) {
  FrameSink sink(settings, report);
  const Title title{settings.title, settings.subtitle};
  if (!title.empty()) {
    sink.putTitle(titleCard(title, settings.size, style.background, style.text));
  }
  // If a painter fails, get() throws its exception.
  while (std::optional<std::future<picture::Frame>> frame = frames.pop()) {
    picture::Frame spare = sink.put(frame->get());
    if (!spare.pixels.empty()) pool.giveBack(std::move(spare));
  }
  if (!frames.isStopped()) sink.finish();
}

}  // namespace

/// This thread also paints, since it already has painters.
void makeFrames(const std::vector<FilmedRun>& runs, std::vector<FramePainter>& painters,
                const PictureSettings& settings, const ProgressObserver& observer,
                PictureReport& report) {
  const double begin = processCpuSeconds(), encoded = report.recordCost.cpuSecondsEncode;
  double reading = 0;
  const StateSource source = replay(runs, observer, report);
  std::size_t count = 0;
  for (const FilmedRun& filmed : runs) count = std::max(count, filmed.moments.size());
  const int threads = std::min(settings.painters(), static_cast<int>(count));
  OrderQueue orders(kWaitingSamples);
  FrameQueue frames(kWaitingFrames + threads);
  FramePool pool;
  TaskGroup tasks([&] {
    orders.stop();
    frames.stop();
  });
  tasks.start([&] {
    const CpuTimer timer(reading);
    source([&](const SharedStates& states) {
      FrameOrder order{states, {}};
      return frames.push(order.frame.get_future()) && orders.push(std::move(order));
    });
    orders.close();
    frames.close();
  });
  const picture::Style style = painters.front().setup().style();
  tasks.start([&] { encodeAll(frames, pool, style, settings, report); });
  for (int k = 1; k < threads; ++k) {
    tasks.start([&] {
      std::vector<FramePainter> own(painters);
      paintAll({own, settings}, orders, pool);
    });
  }
  tasks.run([&] { paintAll({painters, settings}, orders, pool); });
  tasks.finish();
  // CPU time that is not of these threads was used for painting, on any threads.
  report.recordCost.cpuSecondsRender +=
      processCpuSeconds() - begin - reading - (report.recordCost.cpuSecondsEncode - encoded);
}

RunPictures::RunPictures(const trajectory::TrajectoryReader& run, const PictureSettings& settings,
                         PictureReport& report)
    : settings_(settings), report_(report) {
  painters_.emplace_back(run, settings);
  report_.graphics = picture::graphicsVersion();
  report_.view = painters_.front().setup().content().view;
  if (settings.appearance.camera.view) report_.view = {*settings.appearance.camera.view};
}

void RunPictures::makeFrames(const trajectory::TrajectoryReader& run, const MotionCurve& motion,
                             const ProgressObserver& observer) {
  record::makeFrames({{run, videoMoments(motion, settings_)}}, painters_, settings_, observer,
                     report_);
}

picture::Frame RunPictures::paintStill(const FrameState& state) {
  const CpuTimer timer(report_.recordCost.cpuSecondsRender);
  if (!stills_) stills_.emplace(painters_.front(), picture::Smoothness::Still);
  return stills_->paint(state);
}

namespace {

/// A row of states of a run. They are interpolated at the times of the pictures, which may be
/// between samples.
PanelRow makeRow(const trajectory::TrajectoryReader& run, const MotionCurve& motion,
                 picture::PictureContent content, const PictureSettings& settings, int states) {
  PanelRow row{settings.appearance, std::move(content), {}, {}, run.subject().model.name};
  const CaptionWriter writer(settings.captionParts(), row.content);
  Replay replayed(run);
  for (const FrameMoment& moment : snapshotMoments(motion, settings, states)) {
    row.states.push_back({moment, replayed.at(moment.time)});
    row.captions.push_back(writer.of(row.states.back()));
  }
  return row;
}

}  // namespace

void RunPictures::writeGrid(const trajectory::TrajectoryReader& run, const MotionCurve& motion) {
  const std::vector<PanelRow> rows = {
      makeRow(run, motion, painters_.front().setup().content(), settings_, settings_.grid.cells())};
  PanelSheet(rows, settings_.grid, settings_, report_).write();
}

void RunPictures::writeChosenFrames(const trajectory::TrajectoryReader& run,
                                    const MotionCurve& motion) {
  makeFolder(settings_.folder / output::kFrames);
  for (const int number : chooseFrames(run.times(), motion, settings_.chosenFrames)) {
    const trajectory::Sample sample = run.sample(static_cast<std::size_t>(number));
    const picture::Frame frame =
        paintStill({momentAt(motion, settings_.pace, sample.time), sample});
    picture::writePng(frame, settings_.folder / output::frameFile(number), pngSettings(settings_));
    report_.files.push_back(output::frameFile(number).string());
  }
}

/// The pictures that the timeline requested.
void RunPictures::writeMoments(const trajectory::TrajectoryReader& run, const MotionCurve& motion) {
  int number = 0;
  for (const std::size_t index : samplesOf("snapshot", run)) {
    const trajectory::Sample sample = run.sample(index);
    report_.files.push_back(output::momentFile(output::kSnapshotMoment, ++number, ".png"));
    picture::writePng(paintStill({momentAt(motion, settings_.pace, sample.time), sample}),
                      settings_.folder / report_.files.back(), pngSettings(settings_));
  }
}

void RunPictures::writeSnapshots(const trajectory::TrajectoryReader& run,
                                 const MotionCurve& motion) {
  writeMoments(run, motion);
  if (settings_.snapshots) writeGrid(run, motion);
  if (!settings_.chosenFrames.empty()) writeChosenFrames(run, motion);
}

// ------------------------------------------------------------------------------------------------
// A video shows a title card for two seconds, its first frame 1 + h times, each other frame once,
// and its last frame h times more, with h = hold x frames per second. Frames are repeated here by
// encoding them again, without painting.

namespace {

constexpr double kTitleSeconds = 2;

}  // namespace

picture::VideoSettings videoSettings(const PictureSettings& settings) {
  return {.size = settings.size,
          .framesPerSecond = settings.framesPerSecond,
          .crf = settings.crf,
          .preset = settings.preset,
          .encoder = settings.encoder,
          .transparent = settings.appearance.transparent && picture::hasAlpha(settings.videoFile),
          .description = settings.madeBy};
}

picture::PngSettings pngSettings(const PictureSettings& settings) {
  return {.dotsPerInch = settings.dotsPerInch, .description = settings.madeBy};
}

FrameSink::FrameSink(const PictureSettings& settings, PictureReport& report)
    : settings_(settings), report_(report), heldFrames_(heldFrames(settings)) {
  if (settings.frames) makeFolder(settings.folder / output::kFrames);
  if (settings.video) video_.emplace(settings.folder / settings.videoFile, videoSettings(settings));
}

void FrameSink::encode(const picture::Frame& frame, int times) {
  for (int k = 0; k < times; ++k) {
    checkInterruption();
    video_->write(frame);
  }
  videoFrames_ += times;
}

void FrameSink::putTitle(const picture::Frame& card) {
  const CpuTimer timer(report_.recordCost.cpuSecondsEncode);
  if (video_) encode(card, static_cast<int>(kTitleSeconds * settings_.framesPerSecond));
}

picture::Frame FrameSink::put(picture::Frame frame) {
  const CpuTimer timer(report_.recordCost.cpuSecondsEncode);
  if (video_) encode(frame, number_ == 0 ? 1 + heldFrames_ : 1);
  if (settings_.frames) {
    picture::writePng(frame, settings_.folder / output::frameFile(number_), pngSettings(settings_));
    files_.push_back(output::frameFile(number_).string());
  }
  ++number_;
  std::swap(last_, frame);
  return frame;
}

void FrameSink::finish() {
  const CpuTimer timer(report_.recordCost.cpuSecondsEncode);
  if (video_) {
    encode(last_, heldFrames_);
    video_->finish();
    files_.push_back(settings_.videoFile);
  }
  report_.videoFrames = videoFrames_;
  report_.files.insert(report_.files.end(), files_.begin(), files_.end());
}

// ------------------------------------------------------------------------------------------------
// The em of the title is 7% of the picture's height, that of the subtitle 4.5%. The line spacing is
// 1.35 em. Lines are broken at 90% of the width. If the result is still too wide or too high, all
// lines shrink by one factor.

namespace {

constexpr double kTitleSize = 0.07;      // em, in heights of the picture
constexpr double kSubtitleSize = 0.045;  // the same
constexpr double kCardLineEms = 1.35;    // from line to line
constexpr double kMaxWidth = 0.9;        // of the picture, for text
constexpr double kMaxHeight = 0.9;

/// A line of a card.
struct CardLine {
  std::string text;
  double em = 0;  ///< pixels
};

void append(std::vector<CardLine>& lines, const std::string& text, double em, double most) {
  if (text.empty()) return;
  const picture::LabelWriter writer(std::max(1, static_cast<int>(em)));
  const auto width = [&writer](const std::string& line) -> double { return writer.width(line); };
  for (std::string& line : picture::wrapText(text, width, most))
    lines.push_back({std::move(line), em});
}

/// Reduces all lines by the largest excess of a width or of the total height.
void shrinkToFit(std::vector<CardLine>& lines, picture::FrameSize size) {
  double widest = 1, height = 1;
  for (const CardLine& line : lines) {
    widest = std::max<double>(
        widest, picture::LabelWriter(std::max(1, static_cast<int>(line.em))).width(line.text));
    height += kCardLineEms * line.em;
  }
  const double share =
      std::min({1.0, kMaxWidth * size.width / widest, kMaxHeight * size.height / height});
  for (CardLine& line : lines) line.em *= share;
}

}  // namespace

void requireTitle(const Title& title) {
  picture::requireDrawable("--title", title.title);
  picture::requireDrawable("--subtitle", title.subtitle);
}

picture::Frame titleCard(const Title& title, picture::FrameSize size, picture::Colour background,
                         picture::Colour ink) {
  std::vector<CardLine> lines;
  append(lines, title.title, kTitleSize * size.height, kMaxWidth * size.width);
  append(lines, title.subtitle, kSubtitleSize * size.height, kMaxWidth * size.width);
  shrinkToFit(lines, size);
  double height = 0;
  for (const CardLine& line : lines) height += kCardLineEms * line.em;
  picture::Frame card = picture::makeFrame(size, background);
  double upper = 0.5 * (size.height - height);
  for (const CardLine& line : lines) {
    const picture::LabelWriter writer(std::max(1, static_cast<int>(line.em)));
    writer.draw(card, line.text, (size.width - writer.width(line.text)) / 2,
                picture::wholePixels(upper + line.em), ink);
    upper += kCardLineEms * line.em;
  }
  return card;
}

// ------------------------------------------------------------------------------------------------
// A sheet is made in this order. All pictures are painted at the requested size. Their common empty
// margins are found (filledPart). If the sheet has a width in print, all pictures are painted again
// at the resulting enlargement, because enlarging pixels would blur them. Then all are cut equally,
// laid out, and written as PNG. SVG and PDF draw the same layout from the geometries, without
// pixels.
//
// With W millimetres and d dots per inch the sheet is W d / 25.4 pixels wide. Text of p points is
// p / 72 inches high at any width.

namespace {

/// Outlines have the same width as in the pictures, in pixels of their height.
picture::OutlineStyle outlinesOf(const picture::PictureSetup& setup) {
  const picture::Style& style = setup.style();
  const int height = setup.pictureSize().height;
  return {style.edge, style.slitWidth * height, style.silhouetteWidth * height};
}

picture::PageSettings pageSettings(const picture::PictureSetup& setup, picture::FrameSize size,
                                   const std::string& description) {
  return {.size = size,
          .background = setup.style().background,
          .outlines = outlinesOf(setup),
          .fontFamily = picture::fontFamily(),
          .description = description};
}

}  // namespace

picture::ShownState shownState(const FrameState& state) {
  return {state.moment.time, state.sample.poses, state.sample.pinned, state.moment.turn};
}

/// Sets the size of each row's pictures.
void PanelSheet::setUp(const std::vector<Cut>& cuts, std::optional<double> pixelsPerInch) {
  setups_.clear();
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    const picture::FrameSize size =
        picture::PictureBox{0, 0, settings_.size}.scaled(cuts[row].scale).size;
    picture::Appearance appearance = rows_[row].appearance;
    appearance.pixelsPerInch = pixelsPerInch;
    setups_.push_back(
        std::make_shared<const picture::PictureSetup>(appearance, rows_[row].content, size));
  }
}

/// Paints all pictures again, each row in its size, uncut.
void PanelSheet::paintAll() {
  const CpuTimer timer(report_.recordCost.cpuSecondsRender);
  pictures_.clear();
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    picture::StatePainter painter(setups_[row]);
    for (std::size_t k = 0; k < rows_[row].states.size(); ++k) {
      pictures_.push_back(
          {painter.paint(shownState(rows_[row].states[k])), rows_[row].captions[k]});
    }
  }
}

/// Of pictures painted at the requested size. Each of several rows fills its cells. Cells are as
/// wide as the widest part, and at most three quarters of that high.
std::vector<PanelSheet::Cut> PanelSheet::findCuts() {
  constexpr double kMaxAspect = 0.75;
  std::vector<Cut> cuts;
  std::size_t first = 0;
  int widest = 0;
  for (const PanelRow& row : rows_) {
    const std::vector<picture::GridPicture> pictures(
        pictures_.begin() + static_cast<std::ptrdiff_t>(first),
        pictures_.begin() + static_cast<std::ptrdiff_t>(first + row.states.size()));
    first += row.states.size();
    cuts.push_back({1, picture::filledPart(pictures)});
    widest = std::max(widest, cuts.back().part.size.width);
  }
  if (!hasSeveralRuns() || settings_.sameScale) return cuts;
  for (Cut& cut : cuts) {
    const picture::FrameSize size = cut.part.size;
    cut.scale =
        std::min(static_cast<double>(widest) / size.width, kMaxAspect * widest / size.height);
    cut.part = cut.part.scaled(cut.scale);
  }
  return cuts;
}

std::vector<PanelSheet::Cut> PanelSheet::enlarged(std::vector<Cut> cuts, double factor) const {
  for (Cut& cut : cuts) {
    cut.scale *= factor;
    cut.part = cut.part.scaled(factor);
  }
  return cuts;
}

/// The scales of the first row, unless each row has its own.
picture::GridStyle PanelSheet::gridStyle(const std::vector<Cut>& cuts) const {
  const picture::PictureSetup& setup = *setups_.front();
  picture::GridStyle style;
  style.background = setup.style().background;
  style.text = setup.style().text;
  style.colourScale = setup.colourScale();
  for (const auto& rowSetup : setups_) {
    for (const picture::LegendEntry& entry : rowSetup->legend()) {
      const auto isSame = [&entry](const picture::LegendEntry& other) {
        return other.text == entry.text && other.colour == entry.colour;
      };
      if (std::ranges::none_of(style.legend, isSame)) style.legend.push_back(entry);
    }
  }
  const bool ownScales = hasSeveralRuns() && !settings_.sameScale;
  if (settings_.scaleBar && !ownScales) style.scale = setup.scale();
  style.letters = settings_.letters;
  style.arrows = settings_.arrows;
  style.heads = settings_.columnHeads;
  for (std::size_t row = 0; hasSeveralRuns() && row < rows_.size(); ++row) {
    style.rows.push_back({cuts[row].part.size, rows_[row].head, std::nullopt});
    if (settings_.scaleBar && ownScales) {
      style.rows.back().scale = setups_[row]->scale();
    }
  }
  return style;
}

/// The layout of the cut pictures. Sets the style's text size.
picture::GridLayout PanelSheet::layOut(const std::vector<Cut>& cuts,
                                       picture::GridStyle& style) const {
  picture::FrameSize largest;
  largest.width = largest.height = 1;
  for (const Cut& cut : cuts) {
    largest.width = std::max(largest.width, cut.part.size.width);
    largest.height = std::max(largest.height, cut.part.size.height);
  }
  if (em_ || settings_.gridWidth) {
    style.textSize = textSize(picture::layOutGrid(largest, shape_, style));
  }
  return picture::layOutGrid(largest, shape_, style, picture::captionsOf(pictures_));
}

/// The final layout.
void PanelSheet::layOut() {
  style_ = gridStyle(cuts_);
  layout_ = layOut(cuts_, style_);
}

/// Each picture as vector graphics.
void PanelSheet::writeDrawings() {
  int number = 0;
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    const picture::PictureSetup& setup = *setups_[row];
    for (const FrameState& state : rows_[row].states) {
      const picture::ShownState shown = shownState(state);
      report_.files.push_back(output::snapshotDrawing(++number).string());
      const std::unique_ptr<picture::Canvas> page = picture::makeCanvas(
          picture::PageFormat::Svg, pageSettings(setup, setup.pictureSize(), settings_.madeBy));
      picture::drawGeometry(setup.geometry(shown), setup.camera(shown), setup.pictureSize(), {0, 0},
                            "", *page);
      writeTextFile(settings_.folder / report_.files.back(), page->finish());
    }
  }
}

/// Enlargement of pictures for a width of the sheet, pixels. The sheet is not narrower, unless
/// pictures would be too large, and wider by at most one pixel per column.
double PanelSheet::enlargement(const std::vector<Cut>& cuts, double requested) const {
  const auto widthAt = [&](double factor) {
    const std::vector<Cut> larger = enlarged(cuts, factor);
    picture::GridStyle style = gridStyle(larger);
    return layOut(larger, style).sheet.width;
  };
  double most = picture::kMaxFrameSide;
  for (const Cut& cut : cuts) {
    most = std::min(most, picture::kMaxFrameSide /
                              (cut.scale * std::max(settings_.size.width, settings_.size.height)));
  }
  double factor = std::min(most, requested / widthAt(1));
  factor = std::min(most, factor * requested / widthAt(factor));
  // Rounding to whole pixels may make parts of the sheet too small.
  while (factor < most && widthAt(factor) < requested) {
    factor = std::min(most, factor * (1 + 0.5 / requested));
  }
  return factor;
}

/// Resolution of a sheet with a width in print.
double PanelSheet::pixelsPerInch(const picture::GridLayout& layout) const {
  return layout.sheet.width / *settings_.gridWidth * picture::kMillimetresPerInch;
}

/// Em of text with a size in print, pixels.
int PanelSheet::textSize(const picture::GridLayout& layout) const {
  if (em_) return *em_;
  return picture::emOf(settings_.fontPoints.value_or(kFontPoints), pixelsPerInch(layout));
}

/// Each picture is clipped to its part, as cutOut() does with pixels.
void PanelSheet::drawAll(picture::Canvas& page, const Eigen::Vector2d& corner,
                         const std::string& prefix) {
  page.begin(prefix + "pictures");
  int cell = 0;
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    const picture::PictureSetup& setup = *setups_[row];
    const picture::PictureBox& part = cuts_[row].part;
    for (const FrameState& state : rows_[row].states) {
      const Eigen::Vector2d upperLeft =
          corner + Eigen::Vector2d(layout_.left(cell % shape_.columns, cell / shape_.columns),
                                   layout_.upper(cell / shape_.columns));
      const std::string name = fmt::format("{}picture_{:02}", prefix, ++cell);
      const picture::ShownState shown = shownState(state);
      page.beginWithin(name, upperLeft.x(), upperLeft.y(), part.size.width, part.size.height);
      picture::drawGeometry(setup.geometry(shown), setup.camera(shown), setup.pictureSize(),
                            upperLeft - Eigen::Vector2d(part.left, part.upper), name, page);
      page.end();
    }
  }
  page.end();
  page.begin(prefix + "text");
  picture::ShiftedSurface surface(page, corner.x(), corner.y());
  picture::drawGridText(surface, layout_, style_, picture::captionsOf(pictures_), shape_.columns);
  page.end();
}

void PanelSheet::writePage(picture::PageFormat format) {
  picture::PageSettings page = pageSettings(*setups_.front(), layout_.sheet, settings_.madeBy);
  if (settings_.gridWidth) page.pixelsPerInch = pixelsPerInch(layout_);
  const std::unique_ptr<picture::Canvas> canvas = picture::makeCanvas(format, page);
  drawAll(*canvas, {0, 0}, "");
  report_.files.push_back(picture::pageFile(output::kSnapshotPages, format));
  writeTextFile(settings_.folder / report_.files.back(), canvas->finish());
}

void PanelSheet::write() {
  setUp(std::vector<Cut>(rows_.size()), std::nullopt);
  paintAll();
  if (settings_.svg) writeDrawings();
  cuts_ = findCuts();
  // Lines have the same width in all rows.
  double resolution = picture::pixelsPerInchOf(settings_.size);
  if (settings_.gridWidth) {
    cuts_ = enlarged(cuts_, enlargement(cuts_, *settings_.gridWidth / picture::kMillimetresPerInch *
                                                   settings_.gridDotsPerInch()));
    layOut();
    resolution = pixelsPerInch(layout_);
  }
  const bool isEnlarged = std::ranges::any_of(cuts_, [](const Cut& cut) { return cut.scale != 1; });
  if (settings_.gridWidth || isEnlarged) {
    setUp(cuts_, resolution);
    paintAll();
  }
  std::size_t picture = 0;
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    for (std::size_t k = 0; k < rows_[row].states.size(); ++k, ++picture) {
      pictures_[picture].frame = picture::cutOut(pictures_[picture].frame, cuts_[row].part);
    }
  }
  layOut();
  picture::PngSettings png = pngSettings(settings_);
  if (settings_.gridWidth) png.dotsPerInch = pixelsPerInch(layout_);
  picture::writePng(picture::composeGrid(pictures_, shape_, style_),
                    settings_.folder / output::kSnapshots, png);
  report_.files.emplace_back(output::kSnapshots);
  for (const picture::PageFormat format : settings_.pages) writePage(format);
}

picture::FrameSize PanelSheet::fit(double width, int em, double pixelsPerInch) {
  em_ = em;
  if (painted_.empty()) {
    setUp(std::vector<Cut>(rows_.size()), std::nullopt);
    paintAll();
    painted_ = findCuts();
  }
  cuts_ = enlarged(painted_, enlargement(painted_, width - shape_.columns));
  setUp(cuts_, pixelsPerInch);
  layOut();
  return layout_.sheet;
}

void PanelSheet::draw(picture::Canvas& page, const Eigen::Vector2d& corner,
                      const std::string& name) {
  page.begin(name);
  page.setOutlines(outlinesOf(*setups_.front()));
  const picture::Colour background = setups_.front()->style().background;
  if (background != picture::PageSettings().background) {
    page.box(corner.x(), corner.y(), layout_.sheet.width, layout_.sheet.height, background);
  }
  drawAll(page, corner, name + '_');
  page.end();
}

// ------------------------------------------------------------------------------------------------
// Each of several runs in one figure has its own view and scale, unless a common one is requested.
// A common scale of length needs a parallel projection. Each row's camera is first fitted to its
// own model. With its picture's height h in metres and the largest height H, the zooms are
// multiplied by h / H. The scale of colours ends at the largest value of all rows.

namespace {

/// Throws InputError if a common scale is requested for a perspective or a moving camera.
picture::Appearance sharedAppearance(std::span<const trajectory::TrajectoryReader* const> runs,
                                     const PictureSettings& settings) {
  picture::Appearance appearance = settings.appearance;
  picture::CameraChoice& camera = appearance.camera;
  if (settings.sameScale) {
    if (camera.orthographic == false || camera.orbit != 0 || !camera.keys.empty()) {
      throw InputError(
          "error: --same-scale needs a parallel projection and a fixed camera; remove --projection "
          "perspective, --orbit and --camera-keys");
    }
    camera.orthographic = true;
  }
  if (settings.sameView && picture::needsView(appearance)) {
    const picture::AutomaticView view = *viewOf(*runs.front(), appearance);
    camera.view = view.angles;
    if (!camera.orthographic && view.isFlat && camera.orbit == 0) camera.orthographic = true;
  }
  return appearance;
}

/// Changes the appearances of pictures to the largest scale of length, if requested, and of colour.
/// Returns whether anything changed.
bool shareScales(const PictureSettings& settings,
                 const std::vector<const picture::PictureSetup*>& setups,
                 const std::vector<picture::Appearance*>& appearances) {
  std::vector<double> heights;
  double most = 0;
  for (const picture::PictureSetup* setup : setups) {
    if (settings.sameScale) heights.push_back(setup->metresPerPixel());
    if (setup->colourScale()) most = std::max(most, setup->colourScale()->most);
  }
  for (std::size_t k = 0; k < appearances.size(); ++k) {
    if (settings.sameScale) {
      appearances[k]->camera.zoom *= heights[k] / *std::ranges::max_element(heights);
    }
    if (most > 0) appearances[k]->colourMost = most;
  }
  return settings.sameScale || most > 0;
}

}  // namespace

std::vector<std::string> namesOf(std::span<const trajectory::TrajectoryReader* const> runs,
                                 const std::vector<std::filesystem::path>& trajectories) {
  std::vector<std::string> names, folders;
  for (const trajectory::TrajectoryReader* run : runs) names.push_back(run->subject().model.name);
  for (const std::filesystem::path& trajectory : trajectories) {
    folders.push_back(std::filesystem::absolute(trajectory).parent_path().filename().string());
  }
  const std::set<std::string> distinct(names.begin(), names.end());
  return distinct.size() == names.size() ? names : folders;
}

std::vector<PanelRow> figureRows(std::span<const trajectory::TrajectoryReader* const> runs,
                                 const PictureSettings& asked) {
  PictureSettings settings = asked;
  settings.appearance = sharedAppearance(runs, asked);
  const int states = runs.size() == 1 ? settings.grid.cells() : settings.grid.columns;
  std::vector<PanelRow> rows;
  for (const trajectory::TrajectoryReader* run : runs) {
    rows.push_back(makeRow(*run, motionOf(*run), contentOf(*run, settings), settings, states));
  }
  std::vector<std::unique_ptr<picture::PictureSetup>> made;
  std::vector<const picture::PictureSetup*> setups;
  std::vector<picture::Appearance*> appearances;
  for (PanelRow& row : rows) {
    made.push_back(
        std::make_unique<picture::PictureSetup>(row.appearance, row.content, settings.size));
    setups.push_back(made.back().get());
    appearances.push_back(&row.appearance);
  }
  shareScales(settings, setups, appearances);
  return rows;
}

// ------------------------------------------------------------------------------------------------
// A frame of several runs has parts of equal width, one per run, which are painted like the frames
// of single runs of this size. Lines and insets have the print size of the whole frame.

namespace {

/// The widest text. At least one.
std::string widest(const std::vector<std::string>& texts) {
  constexpr int kAnySize = 64;
  const picture::LabelWriter writer(kAnySize);
  return *std::ranges::max_element(
      texts, {}, [&writer](const std::string& text) { return writer.width(text); });
}

}  // namespace

void makeSideBySide(std::span<const trajectory::TrajectoryReader* const> runs,
                    const std::vector<std::string>& names, const PictureSettings& settings,
                    const ProgressObserver& observer, PictureReport& report) {
  PictureSettings part = settings;
  part.appearance = sharedAppearance(runs, settings);
  part.appearance.pixelsPerInch = picture::pixelsPerInchOf(settings.size);
  part.size.width = partWidth(settings, runs.size());
  std::vector<FilmedRun> filmed;
  std::vector<std::string> captions;
  for (const trajectory::TrajectoryReader* run : runs) {
    filmed.push_back({*run, videoMoments(motionOf(*run), settings)});
    captions.push_back(
        longestCaption(*run, CaptionWriter(settings.captionParts(), contentOf(run->subject()))));
  }
  std::vector<FramePainter> painters;
  painters.reserve(runs.size());
  for (std::size_t k = 0; k < runs.size(); ++k) {
    painters.emplace_back(*runs[k], part, SideTexts{names[k], widest(names), widest(captions)});
  }
  std::vector<PictureSettings> parts(runs.size(), part);
  std::vector<const picture::PictureSetup*> setups;
  std::vector<picture::Appearance*> appearances;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    setups.push_back(&painters[k].setup());
    appearances.push_back(&parts[k].appearance);
  }
  if (shareScales(settings, setups, appearances)) {
    for (std::size_t k = 0; k < runs.size(); ++k) painters[k].show(*runs[k], parts[k]);
  }
  report.graphics = picture::graphicsVersion();
  makeFrames(filmed, painters, settings, observer, report);
}

}  // namespace kirireel::record
