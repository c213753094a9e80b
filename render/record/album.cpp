#include "render/record/album.h"

#include <algorithm>
#include <memory>

#include <fmt/format.h>

#include "render/gl/context.h"
#include "render/grid/grid.h"
#include "render/picture/painter.h"
#include "render/png/png.h"
#include "render/record/output_folder.h"
#include "render/record/snapshot_choice.h"
#include "render/record/stopwatch.h"
#include "sim/brick/brick.h"

namespace kirireel {
namespace {

/// The camera looks at about this many samples: enough for any smooth motion.
constexpr std::size_t kSamplesFramed = 100;

void append(std::vector<Vector3>& points, const std::vector<Vector3>& more) {
  points.insert(points.end(), more.begin(), more.end());
}

/// Corners of all bricks at the start, at the target and on the way.
std::vector<Vector3> pointsToFrame(const Scene& scene, const Trajectory& trajectory) {
  std::vector<Vector3> points;
  const std::vector<Sample>& samples = trajectory.samples;
  const std::size_t stride = 1 + samples.size() / kSamplesFramed;
  for (std::size_t i = 0; i < samples.size(); i += stride) {
    append(points, brickCorners(trajectory.bricks, samples[i].poses));
  }
  append(points, brickCorners(trajectory.bricks, samples.back().poses));
  if (scene.model.target) {
    const std::vector<Brick> bricks = makeBricks(*scene.model.target, scene.brick);
    append(points, brickCorners(bricks, startPoses(*scene.model.target, bricks)));
  }
  return points;
}

Style styleFor(const Scene& scene, const Trajectory& trajectory) {
  Style style;
  if (scene.environment.ground) {
    style.plate = groundUnder(pointsToFrame(scene, trajectory), scene.environment.ground->height);
  }
  return style;
}

/// One painter, one camera and the clock of what they cost.
class Photographer {
 public:
  Photographer(const Scene& scene, const Trajectory& trajectory, const RecordSettings& settings,
               double& cpuSeconds)
      : trajectory_(trajectory),
        camera_(cameraFor(scene, trajectory, settings)),
        painter_(settings.size, trajectory.bricks, styleFor(scene, trajectory)),
        cpuSeconds_(cpuSeconds) {}

  Frame take(int sample) {
    const CpuTimer timer(cpuSeconds_);
    return painter_.paint(trajectory_.samples[static_cast<std::size_t>(sample)].poses, camera_);
  }

 private:
  const Trajectory& trajectory_;
  Camera camera_;
  Painter painter_;
  double& cpuSeconds_;
};

void writeSnapshots(Photographer& photographer, const Trajectory& trajectory,
                    const RecordSettings& settings, RunSummary& summary) {
  std::vector<GridPicture> pictures;
  for (const int sample : chooseSnapshots(trajectory, settings.grid.cells(), settings.spacing)) {
    const double time = trajectory.samples[static_cast<std::size_t>(sample)].time;
    pictures.push_back({photographer.take(sample), timeCaption(time)});
  }
  writePng(composeGrid(pictures, settings.grid), settings.folder / output::kSnapshots);
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
      writePng(frame, settings_.folder / frameFile(number));
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
    sink.put(photographer.take(i), i);
    const bool goOn = observer({"painting", (i + 1.0) / count});
    if (!goOn && i + 1 < count) {
      markInterrupted(summary, trajectory.samples[static_cast<std::size_t>(i)].time);
      break;
    }
  }
  sink.finish();
}

}  // namespace

Camera cameraFor(const Scene& scene, const Trajectory& trajectory, const RecordSettings& settings) {
  const std::vector<Vector3> points = pointsToFrame(scene, trajectory);
  CameraFit fit;
  fit.view = settings.view.value_or(defaultView(points));
  // Straight from above or in front, equal lengths should look equal.
  fit.orthographic = fit.view == kTopView || fit.view == kFrontView;
  fit.aspect = settings.size.aspect();
  return fitCamera(points, fit);
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
  Photographer photographer(scene, trajectory, settings, summary.recordCost.cpuSecondsRender);
  summary.graphics = graphicsVersion();
  if (settings.snapshots) writeSnapshots(photographer, trajectory, settings, summary);
  if (paintsFrames) writeFrames(photographer, trajectory, settings, observer, summary);
}

}  // namespace kirireel
