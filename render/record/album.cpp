#include "render/record/album.h"

#include <algorithm>
#include <memory>

#include <fmt/format.h>

#include "render/gl/context.h"
#include "render/grid/grid.h"
#include "render/png/png.h"
#include "render/record/output_folder.h"
#include "render/record/snapshot_choice.h"
#include "render/record/stopwatch.h"
#include "render/studio/studio.h"
#include "render/vector/svg.h"
#include "sim/base/error.h"
#include "sim/base/pending_file.h"
#include "sim/measure/brick_measures.h"

namespace kirireel {
namespace {

/// The camera looks at about this many samples: enough for any smooth motion.
constexpr std::size_t kSamplesFramed = 100;

/// The run as a studio sees it, with everything in sight that the look asks for.
Motif motifFor(const Scene& scene, const Trajectory& trajectory, const RecordSettings& settings) {
  Motif motif = makeMotif(scene.model, scene.brick, scene.environment.ground);
  const std::vector<Sample>& samples = trajectory.samples;
  motif.endTime = samples.back().time;
  if (settings.look.fit == FitScope::Ends) return motif;
  const std::size_t stride = 1 + samples.size() / kSamplesFramed;
  for (std::size_t i = 0; i < samples.size(); i += stride) keepInSight(motif, samples[i].poses);
  keepInSight(motif, samples.back().poses);
  return motif;
}

/// A studio for one trajectory, and the clock of what it costs.
class Photographer {
 public:
  Photographer(const Scene& scene, const Trajectory& trajectory, const RecordSettings& settings,
               double& cpuSeconds)
      : trajectory_(trajectory),
        studio_(settings.size, settings.look, motifFor(scene, trajectory, settings)),
        cpuSeconds_(cpuSeconds) {}

  const Stage& stage() const { return studio_.stage(); }

  Frame take(int number, Studio::Scales scales) {
    const CpuTimer timer(cpuSeconds_);
    return studio_.take(moment(number), scales);
  }

  /// The same picture as vector graphics.
  std::string draw(int number, FrameSize size) const {
    return svgText(stage().sketch(moment(number)), stage().camera(moment(number)), size,
                   stage().style().background);
  }

 private:
  Moment moment(int number) const {
    const Sample& sample = trajectory_.samples[static_cast<std::size_t>(number)];
    return {sample.time, sample.poses, {}};
  }

  const Trajectory& trajectory_;
  Studio studio_;
  double& cpuSeconds_;
};

/// The look of a grid of pictures from this stage.
GridStyle gridStyle(const Stage& stage, const RecordSettings& settings) {
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

std::string captionOf(const Sample& sample, const Scene& scene, const Stage& stage,
                      const CaptionParts& parts) {
  const std::vector<double> turned = brickRotations(stage.motif().start, sample.poses);
  CaptionValues values{sample.time, *std::max_element(turned.begin(), turned.end()), std::nullopt,
                       sample.jointGap};
  if (scene.model.target) values.error = sample.targetError;
  return captionText(parts, values);
}

void writeSnapshots(Photographer& photographer, const Scene& scene, const Trajectory& trajectory,
                    const RecordSettings& settings, RunSummary& summary) {
  const GridStyle style = gridStyle(photographer.stage(), settings);
  std::vector<GridPicture> pictures;
  for (const int number : chooseSnapshots(trajectory, settings.grid.cells(), settings.spacing)) {
    const Sample& sample = trajectory.samples[static_cast<std::size_t>(number)];
    pictures.push_back({photographer.take(number, Studio::Scales::None),
                        captionOf(sample, scene, photographer.stage(), settings.captions)});
    if (!settings.svg) continue;
    summary.files.push_back(snapshotDrawing(static_cast<int>(pictures.size())).string());
    writeTextFile(settings.folder / summary.files.back(), photographer.draw(number, settings.size));
  }
  trimAlike(pictures);
  writePng(composeGrid(pictures, settings.grid, style), settings.folder / output::kSnapshots,
           {.dotsPerInch = settings.dotsPerInch});
  summary.files.emplace_back(output::kSnapshots);
}

/// Where frames go: into the video, into single files, or both.
class FrameSink {
 public:
  FrameSink(const RecordSettings& settings, RunSummary& summary)
      : settings_(settings), summary_(summary) {
    if (settings.frames) makeFolder(settings.folder / output::kFrames);
    if (settings.video) {
      video_ =
          std::make_unique<VideoWriter>(settings.folder / output::kVideo, videoSettings(settings));
    }
  }

  void put(const Frame& frame, int number) {
    if (video_) {
      const CpuTimer timer(summary_.recordCost.cpuSecondsEncode);
      video_->write(frame);
      ++summary_.videoFrames;
    }
    if (settings_.frames) {
      writePng(frame, settings_.folder / frameFile(number), {.dotsPerInch = settings_.dotsPerInch});
      summary_.files.push_back(frameFile(number).string());
    }
  }

  void finish() {
    if (!video_) return;
    const CpuTimer timer(summary_.recordCost.cpuSecondsEncode);
    video_->finish();
    summary_.files.emplace_back(output::kVideo);
  }

 private:
  const RecordSettings& settings_;
  RunSummary& summary_;
  std::unique_ptr<VideoWriter> video_;
};

void markInterrupted(RunSummary& summary, double time) {
  summary.outcome = Outcome::Interrupted;
  summary.reason = fmt::format("stopped while painting; the video ends at {:.4g} s", time);
}

void writeFrames(Photographer& photographer, const Trajectory& trajectory,
                 const RecordSettings& settings, const ProgressObserver& observer,
                 RunSummary& summary) {
  FrameSink sink(settings, summary);
  const int count = static_cast<int>(trajectory.samples.size());
  for (int i = 0; i < count; ++i) {
    sink.put(photographer.take(i, Studio::Scales::Drawn), i);
    const bool goOn = observer({"painting", (i + 1.0) / count});
    if (!goOn && i + 1 < count) {
      markInterrupted(summary, trajectory.samples[static_cast<std::size_t>(i)].time);
      break;
    }
  }
  sink.finish();
}

}  // namespace

void requirePaintable(const Scene& scene, const RecordSettings& settings) {
  if (!settings.snapshots && !settings.video && !settings.frames) return;
  const Motif motif = makeMotif(scene.model, scene.brick, scene.environment.ground);
  const Stage stage(settings.look, motif, settings.size);
  if (settings.snapshots) gridStyle(stage, settings);
}

VideoSettings videoSettings(const RecordSettings& settings) {
  VideoSettings video;
  video.size = settings.size;
  video.framesPerSecond = settings.framesPerSecond;
  return video;
}

void paintAlbum(const Scene& scene, const Trajectory& trajectory, const RecordSettings& settings,
                const ProgressObserver& observer, RunSummary& summary) {
  const bool paintsFrames = settings.video || settings.frames;
  if (!settings.snapshots && !paintsFrames) return;
  if (settings.graphics) setGraphicsLibrary(*settings.graphics);
  Photographer photographer(scene, trajectory, settings, summary.recordCost.cpuSecondsRender);
  summary.graphics = graphicsVersion();
  if (settings.snapshots) writeSnapshots(photographer, scene, trajectory, settings, summary);
  if (paintsFrames) writeFrames(photographer, trajectory, settings, observer, summary);
}

}  // namespace kirireel
