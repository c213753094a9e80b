#include "render/record/album.h"

#include <algorithm>

#include <fmt/format.h>

#include "render/folder/output_folder.h"
#include "render/gl/context.h"
#include "render/grid/grid.h"
#include "render/png/png.h"
#include "render/record/crew.h"
#include "render/record/frame_sink.h"
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

}  // namespace

bool choosesCamera(const PictureSettings& settings) {
  const CameraChoice& camera = settings.look.camera;
  return settings.look.fit == FitScope::Auto && camera.zoom == 1 && camera.keys.empty() &&
         !camera.distance;
}

bool paintsAlong(const Model& model, const PictureSettings& settings) {
  return settings.paintsFrames() && fitsEnds(model, settings) && settings.look.camera.orbit == 0;
}

Motif motifOf(const Subject& subject) {
  Motif motif = makeMotif(subject.model, subject.brickRule, subject.ground);
  motif.obstacles = subject.obstacles;
  return motif;
}

Motif motifOf(const TrajectoryReader& run, const PictureSettings& settings, bool whole) {
  Motif motif = motifOf(run.subject());
  motif.endTime = run.times().back();
  if (whole || !fitsEnds(run.subject().model, settings)) keepRunInSight(motif, run);
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

bool Album::makeFrames(const SampleFeed& feed) {
  SampleQueue samples(kWaitingSamples);
  FrameQueue frames(kWaitingFrames);
  Crew crew([&] {
    samples.stop();
    frames.stop();
  });
  crew.start([&] {
    feed([&](const SharedSample& sample) { return samples.push(sample); });
    samples.close();
  });
  crew.start([&] { encode(frames); });
  crew.run([&] { paint(samples, frames); });
  crew.finish();
  return !lostSight_;
}

void Album::paint(SampleQueue& samples, FrameQueue& frames) {
  while (const std::optional<SharedSample> sample = samples.pop()) {
    if (lostSight_) continue;  // the run goes on
    lostSight_ = watchesSight_ && !isInSight(**sample);
    if (lostSight_) {
      frames.stop();
    } else if (!frames.push(take(**sample, Studio::Scales::Drawn))) {
      return;
    }
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

bool Album::isInSight(const Sample& sample) const {
  const Camera camera = studio_.stage().camera({sample.time, sample.poses, {}});
  const Eigen::Matrix4d clip = clipFromWorld(camera, settings_.size.aspect());
  const std::vector<Vector3> corners = shownCorners(studio_.stage().motif(), sample.poses);
  return std::ranges::all_of(corners, [&](const Vector3& corner) {
    const Eigen::Vector4d point = clip * corner.homogeneous();
    return point.head<2>().cwiseAbs().maxCoeff() <= kBorder * point.w();
  });
}

bool Album::sees(const TrajectoryReader& run) const {
  for (std::size_t i = 0; i < run.times().size(); ++i) {
    if (!isInSight(run.sample(i))) return false;
  }
  return true;
}

Frame Album::take(const Sample& sample, Studio::Scales scales) {
  const CpuTimer timer(report_.recordCost.cpuSecondsRender);
  return studio_.take({sample.time, sample.poses, sample.pinned}, scales);
}

std::string Album::caption(const Sample& sample, bool hasTarget) const {
  const std::vector<double> turned = brickRotations(studio_.stage().motif().start, sample.poses);
  CaptionValues values{sample.time, *std::ranges::max_element(turned), std::nullopt,
                       sample.jointGap};
  if (hasTarget) values.error = sample.targetError;
  return captionText(settings_.captions, values);
}

/// The picture of a sample as vector graphics.
void Album::writeDrawing(const Sample& sample, int number) {
  const Stage& stage = studio_.stage();
  const Moment moment{sample.time, sample.poses, sample.pinned};
  report_.files.push_back(snapshotDrawing(number).string());
  writeTextFile(settings_.folder / report_.files.back(),
                svgText(stage.sketch(moment), stage.camera(moment), settings_.size,
                        stage.style().background));
}

void Album::writeGrid(const TrajectoryReader& run) {
  const bool hasTarget = run.subject().model.target.has_value();
  const GridStyle style = gridStyle(studio_.stage(), settings_);
  std::vector<GridPicture> pictures;
  for (const int number :
       chooseSnapshots(marksOf(run, settings_.spacing), settings_.grid.cells())) {
    const Sample sample = run.sample(static_cast<std::size_t>(number));
    pictures.push_back({take(sample, Studio::Scales::None), caption(sample, hasTarget)});
    if (settings_.svg) writeDrawing(sample, static_cast<int>(pictures.size()));
  }
  trimAlike(pictures);
  writePng(composeGrid(pictures, settings_.grid, style), settings_.folder / output::kSnapshots,
           {.dotsPerInch = settings_.dotsPerInch});
  report_.files.emplace_back(output::kSnapshots);
}

void Album::writeChosenFrames(const TrajectoryReader& run) {
  makeFolder(settings_.folder / output::kFrames);
  for (const int number : chooseFrames(run, settings_.chosenFrames)) {
    const Frame frame = take(run.sample(static_cast<std::size_t>(number)), Studio::Scales::Drawn);
    writePng(frame, settings_.folder / frameFile(number), {.dotsPerInch = settings_.dotsPerInch});
    report_.files.push_back(frameFile(number).string());
  }
}

/// The pictures that the timeline asked for.
void Album::writeMoments(const TrajectoryReader& run) {
  int number = 0;
  for (const std::size_t sample : samplesOf("snapshot", run)) {
    report_.files.push_back(momentFile(output::kSnapshotMoment, ++number, ".png"));
    writePng(take(run.sample(sample), Studio::Scales::Drawn),
             settings_.folder / report_.files.back(), {.dotsPerInch = settings_.dotsPerInch});
  }
}

void Album::writeSnapshots(const TrajectoryReader& run) {
  writeMoments(run);
  if (settings_.snapshots) writeGrid(run);
  if (!settings_.chosenFrames.empty()) writeChosenFrames(run);
}

}  // namespace kirireel
