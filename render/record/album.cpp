#include "render/record/album.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "render/folder/output_folder.h"
#include "render/gl/context.h"
#include "render/grid/grid.h"
#include "render/png/png.h"
#include "render/record/crew.h"
#include "render/record/frame_sink.h"
#include "render/record/samples.h"
#include "render/record/snapshot_choice.h"
#include "render/record/stopwatch.h"
#include "render/record/title_card.h"
#include "render/vector/svg.h"
#include "sim/base/error.h"
#include "sim/base/pending_file.h"
#include "sim/measure/brick_measures.h"

namespace kirireel {
namespace {

/// The camera looks at about this many samples: enough for any smooth motion.
constexpr std::size_t kSamplesFramed = 100;
/// Between painting and encoding, for the same reason as kWaitingSamples.
constexpr std::size_t kWaitingFrames = 4;
/// Half the picture's width and height, with room for rounding.
constexpr double kBorder = 1 + 1e-9;

void keepRunInSight(Motif& motif, const TrajectoryReader& run) {
  const std::size_t count = run.times().size();
  const std::size_t stride = 1 + count / kSamplesFramed;
  for (std::size_t i = 0; i < count; i += stride) keepInSight(motif, run.sample(i).poses);
  keepInSight(motif, run.sample(count - 1).poses);
}

bool fitsEnds(const Model& model, const PictureSettings& settings) {
  if (settings.look.fit == FitScope::Auto) return model.target.has_value();
  return settings.look.fit == FitScope::Ends;
}

GridStyle gridStyle(const Stage& stage, const PictureSettings& settings) {
  GridStyle style;
  style.background = stage.style().background;
  style.text = stage.style().text;
  style.colourScale = stage.colourScale();
  if (settings.scaleBar) style.metresPerPixel = stage.metresPerPixel();
  return style;
}

/// Whether a camera that cuts something off is the program's mistake, not the settings' wish.
bool choosesCamera(const PictureSettings& settings) {
  const CameraChoice& camera = settings.look.camera;
  return settings.look.fit == FitScope::Auto && camera.zoom == 1 && camera.keys.empty() &&
         !camera.distance;
}

bool seesAll(const Stage& stage, const Moment& moment, double aspect) {
  const Eigen::Matrix4d clip = clipFromWorld(stage.camera(moment), aspect);
  const std::vector<Vector3> corners = shownCorners(stage.motif(), moment.poses);
  return std::ranges::all_of(corners, [&](const Vector3& corner) {
    const Eigen::Vector4d point = clip * corner.homogeneous();
    return point.head<2>().cwiseAbs().maxCoeff() <= kBorder * point.w();
  });
}

/// Whether no sample of the run leaves pictures of this motif.
bool seesRun(const TrajectoryReader& run, const Stage& stage) {
  for (std::size_t i = 0; i < run.times().size(); ++i) {
    const Sample sample = run.sample(i);
    if (!seesAll(stage, {sample.time, sample.poses, {}}, stage.pictureSize().aspect())) {
      return false;
    }
  }
  return true;
}

Moment stillOf(const FrameState& state) {
  return {state.moment.time, state.sample.poses, state.sample.pinned, state.moment.turn};
}

}  // namespace

Motif motifOf(const Subject& subject) {
  Motif motif = makeMotif(subject.model, subject.brickRule, subject.ground);
  motif.obstacles = subject.obstacles;
  return motif;
}

Motif motifOf(const TrajectoryReader& run, const PictureSettings& settings) {
  Motif motif = motifOf(run.subject());
  const bool fits =
      fitsEnds(run.subject().model, settings) &&
      (!choosesCamera(settings) || seesRun(run, Stage(settings.look, motif, settings.size)));
  if (!fits) keepRunInSight(motif, run);
  return motif;
}

void requirePaintable(const Motif& motif, const PictureSettings& settings) {
  if (!settings.paints()) return;
  const Stage stage(settings.look, motif, settings.size);
  if (settings.scaleBar) stage.metresPerPixel();
}

std::string CaptionWriter::text(const FrameState& state, double progress) const {
  const std::vector<double> turned = brickRotations(start_, state.sample.poses);
  CaptionValues values{progress, state.moment.time, *std::ranges::max_element(turned), std::nullopt,
                       state.sample.jointGap};
  if (hasTarget_) values.error = state.sample.targetError;
  return captionText(parts_, values);
}

std::string CaptionWriter::of(const FrameState& state) const {
  return text(state, state.moment.progress);
}

std::string CaptionWriter::inVideo(const FrameState& state) const {
  return text(state, 0.01 * std::round(100 * state.moment.progress));
}

std::string CaptionWriter::longest(double endTime) const {
  constexpr double kLongLength = 8.8e-88;  // metres, in the form that has most letters
  CaptionValues values{1, endTime, std::numbers::pi, std::nullopt, kLongLength};
  if (hasTarget_) values.error = kLongLength;
  return captionText(parts_, values);
}

StripParts stripParts(const PictureSettings& settings, const CaptionWriter& captions,
                      double endTime) {
  StripParts parts;
  if (settings.captions) parts.longestCaption = captions.longest(endTime);
  parts.progressBar = settings.progressBar;
  parts.scaleBar = settings.scaleBar;
  parts.colours = true;
  return parts;
}

Album::Album(const TrajectoryReader& run, const PictureSettings& settings, PictureReport& report)
    : settings_(settings),
      report_(report),
      captions_(settings.captionParts(), motifOf(run.subject())),
      frames_(settings.size, settings.look, motifOf(run, settings),
              stripParts(settings, captions_, run.times().back())) {
  report_.graphics = graphicsVersion();
}

void Album::makeFrames(const TrajectoryReader& run, const MotionCurve& motion,
                       const ProgressObserver& observer) {
  const std::vector<FrameMoment> moments = videoMoments(motion, settings_);
  const StateFeed feed = replay(run, moments, observer, report_);
  StateQueue states(kWaitingSamples);
  FrameQueue frames(kWaitingFrames);
  Crew crew([&] {
    states.stop();
    frames.stop();
  });
  crew.start([&] {
    feed([&](const SharedState& state) { return states.push(state); });
    states.close();
  });
  crew.start([&] { encode(frames); });
  crew.run([&] { paint(states, frames); });
  crew.finish();
}

void Album::paint(StateQueue& states, FrameQueue& frames) {
  while (const std::optional<SharedState> state = states.pop()) {
    if (!frames.push(takeFrame(**state))) return;
  }
  frames.close();
}

void Album::encode(FrameQueue& frames) {
  FrameSink sink(settings_, report_);
  const Style& style = frames_.stage().style();
  const Title title{settings_.title, settings_.subtitle};
  if (!title.empty()) {
    sink.putTitle(titleCard(title, settings_.size, style.background, style.text));
  }
  while (std::optional<Frame> frame = frames.pop()) sink.put(std::move(*frame));
  if (!frames.isStopped()) sink.finish();
}

Frame Album::takeFrame(const FrameState& state) {
  const CpuTimer timer(report_.recordCost.cpuSecondsRender);
  return frames_.take(stillOf(state), {captions_.inVideo(state), state.moment.progress});
}

Frame Album::takePicture(const FrameState& state) {
  const CpuTimer timer(report_.recordCost.cpuSecondsRender);
  if (!pictures_) pictures_.emplace(settings_.size, settings_.look, frames_.stage().motif());
  return pictures_->take(stillOf(state));
}

/// The picture of a state as vector graphics.
void Album::writeDrawing(const FrameState& state, int number) {
  const Stage& stage = pictures_->stage();
  const Moment moment = stillOf(state);
  report_.files.push_back(snapshotDrawing(number).string());
  writeTextFile(settings_.folder / report_.files.back(),
                svgText(stage.sketch(moment), stage.camera(moment), settings_.size,
                        stage.style().background));
}

void Album::writeGrid(const TrajectoryReader& run, const MotionCurve& motion) {
  Replay states(run);
  std::vector<GridPicture> pictures;
  for (const FrameMoment& moment : snapshotMoments(motion, settings_, settings_.grid.cells())) {
    const FrameState state{moment, states.at(moment.time)};
    pictures.push_back({takePicture(state), captions_.of(state)});
    if (settings_.svg) writeDrawing(state, static_cast<int>(pictures.size()));
  }
  trimAlike(pictures);
  const GridStyle style = gridStyle(pictures_->stage(), settings_);
  writePng(composeGrid(pictures, settings_.grid, style), settings_.folder / output::kSnapshots,
           {.dotsPerInch = settings_.dotsPerInch});
  report_.files.emplace_back(output::kSnapshots);
}

void Album::writeChosenFrames(const TrajectoryReader& run, const MotionCurve& motion) {
  makeFolder(settings_.folder / output::kFrames);
  for (const int number : chooseFrames(run.times(), motion, settings_.chosenFrames)) {
    const Sample sample = run.sample(static_cast<std::size_t>(number));
    const Frame frame = takeFrame({momentAt(motion, settings_.pace, sample.time), sample});
    writePng(frame, settings_.folder / frameFile(number), {.dotsPerInch = settings_.dotsPerInch});
    report_.files.push_back(frameFile(number).string());
  }
}

/// The pictures that the timeline asked for.
void Album::writeMoments(const TrajectoryReader& run, const MotionCurve& motion) {
  int number = 0;
  for (const std::size_t index : samplesOf("snapshot", run)) {
    const Sample sample = run.sample(index);
    report_.files.push_back(momentFile(output::kSnapshotMoment, ++number, ".png"));
    writePng(takeFrame({momentAt(motion, settings_.pace, sample.time), sample}),
             settings_.folder / report_.files.back(), {.dotsPerInch = settings_.dotsPerInch});
  }
}

void Album::writeSnapshots(const TrajectoryReader& run, const MotionCurve& motion) {
  writeMoments(run, motion);
  if (settings_.snapshots) writeGrid(run, motion);
  if (!settings_.chosenFrames.empty()) writeChosenFrames(run, motion);
}

}  // namespace kirireel
