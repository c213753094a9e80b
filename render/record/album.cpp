#include "render/record/album.h"

#include <algorithm>

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
  if (!settings.scaleBar) return style;
  const std::optional<double> height = stage.sharedHeight();
  if (!height) {
    throw InputError(
        "error: one scale bar cannot hold all over a picture in perspective or from a moving "
        "camera; add --projection parallel, or leave --scale-bar away");
  }
  style.metresPerPixel = *height / settings.size.height;
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
bool seesRun(const TrajectoryReader& run, const PictureSettings& settings, const Motif& motif) {
  const Stage stage(settings.look, motif, settings.size);
  for (std::size_t i = 0; i < run.times().size(); ++i) {
    const Sample sample = run.sample(i);
    if (!seesAll(stage, {sample.time, sample.poses, {}}, settings.size.aspect())) return false;
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
  const bool fits = fitsEnds(run.subject().model, settings) &&
                    (!choosesCamera(settings) || seesRun(run, settings, motif));
  if (!fits) keepRunInSight(motif, run);
  return motif;
}

void requirePaintable(const Motif& motif, const PictureSettings& settings) {
  if (!settings.paints()) return;
  const Stage stage(settings.look, motif, settings.size);
  if (settings.snapshots) gridStyle(stage, settings);
}

Album::Album(const PictureSettings& settings, Motif motif, PictureReport& report)
    : settings_(settings),
      report_(report),
      studio_(settings.size, settings.look, std::move(motif)) {
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
    if (!frames.push(take(**state, Studio::Scales::Drawn))) return;
  }
  frames.close();
}

void Album::encode(FrameQueue& frames) {
  FrameSink sink(settings_, report_);
  const Style& style = studio_.stage().style();
  if (!settings_.title.empty()) {
    sink.putTitle(titleCard(settings_.title, settings_.size, style.background, style.text));
  }
  while (std::optional<Frame> frame = frames.pop()) sink.put(std::move(*frame));
  if (!frames.isStopped()) sink.finish();
}

Frame Album::take(const FrameState& state, Studio::Scales scales) {
  const CpuTimer timer(report_.recordCost.cpuSecondsRender);
  return studio_.take(stillOf(state), scales);
}

std::string Album::caption(const FrameState& state) const {
  const Motif& motif = studio_.stage().motif();
  const std::vector<double> turned = brickRotations(motif.start, state.sample.poses);
  CaptionValues values{state.moment.progress, state.moment.time, *std::ranges::max_element(turned),
                       std::nullopt, state.sample.jointGap};
  if (motif.target) values.error = state.sample.targetError;
  return captionText(settings_.captionParts(), values);
}

/// The picture of a state as vector graphics.
void Album::writeDrawing(const FrameState& state, int number) {
  const Stage& stage = studio_.stage();
  const Moment moment = stillOf(state);
  report_.files.push_back(snapshotDrawing(number).string());
  writeTextFile(settings_.folder / report_.files.back(),
                svgText(stage.sketch(moment), stage.camera(moment), settings_.size,
                        stage.style().background));
}

void Album::writeGrid(const TrajectoryReader& run, const MotionCurve& motion) {
  const GridStyle style = gridStyle(studio_.stage(), settings_);
  Replay states(run);
  std::vector<GridPicture> pictures;
  for (const FrameMoment& moment : snapshotMoments(motion, settings_, settings_.grid.cells())) {
    const FrameState state{moment, states.at(moment.time)};
    pictures.push_back({take(state, Studio::Scales::None), caption(state)});
    if (settings_.svg) writeDrawing(state, static_cast<int>(pictures.size()));
  }
  trimAlike(pictures);
  writePng(composeGrid(pictures, settings_.grid, style), settings_.folder / output::kSnapshots,
           {.dotsPerInch = settings_.dotsPerInch});
  report_.files.emplace_back(output::kSnapshots);
}

void Album::writeChosenFrames(const TrajectoryReader& run, const MotionCurve& motion) {
  makeFolder(settings_.folder / output::kFrames);
  for (const int number : chooseFrames(run.times(), motion, settings_.chosenFrames)) {
    const Sample sample = run.sample(static_cast<std::size_t>(number));
    const Frame frame =
        take({momentAt(motion, settings_.pace, sample.time), sample}, Studio::Scales::Drawn);
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
    writePng(take({momentAt(motion, settings_.pace, sample.time), sample}, Studio::Scales::Drawn),
             settings_.folder / report_.files.back(), {.dotsPerInch = settings_.dotsPerInch});
  }
}

void Album::writeSnapshots(const TrajectoryReader& run, const MotionCurve& motion) {
  writeMoments(run, motion);
  if (settings_.snapshots) writeGrid(run, motion);
  if (!settings_.chosenFrames.empty()) writeChosenFrames(run, motion);
}

}  // namespace kirireel
