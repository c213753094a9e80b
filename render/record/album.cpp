// A video is painted and encoded at the same time, by threads with short queues between them:
//
//     feed (1 thread)      gives states in order; for each a promise of its frame
//       orders  ->  painters (several), each with a studio of its own: keep the promises
//       frames  ->  encoder (1 thread): takes the frames in the order of the states
//
// The order of frames is that of the futures in the queue, whichever painter is done first. So the
// bytes do not depend on how many paint. Both queues are bounded: memory holds some tens of frames,
// however long the run is. The first error of any thread stops both queues, and finish() throws it
// (crew.h).
//
// What cameras hold in sight is decided before: the start and the target where nothing else is
// asked for, or about a hundred samples of the run; where the program chose the camera itself and a
// sample would be cut off, the whole run.
#include "render/record/album.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include <fmt/format.h>

#include "render/folder/output_folder.h"
#include "render/gl/context.h"
#include "render/grid/grid.h"
#include "render/png/png.h"
#include "render/record/crew.h"
#include "render/record/frame_sink.h"
#include "render/record/panels.h"
#include "render/record/samples.h"
#include "render/record/snapshot_choice.h"
#include "render/record/stopwatch.h"
#include "render/record/title_card.h"
#include "sim/base/cpu_time.h"
#include "sim/base/error.h"
#include "sim/base/pending_file.h"
#include "sim/measure/brick_measures.h"

namespace kirireel {
namespace {

/// The camera looks at about this many samples: enough for any smooth motion.
constexpr std::size_t kSamplesFramed = 100;
/// Between painting and encoding, beside one a painter, for the same reason as kWaitingSamples.
constexpr std::size_t kWaitingFrames = 4;
/// Half the picture's width and height, with room for rounding.
constexpr double kBorder = 1 + 1e-9;

/// The last sample is always among them.
void keepRunInSight(Motif& motif, const TrajectoryReader& run) {
  const std::size_t count = run.times().size();
  const std::size_t stride = 1 + count / kSamplesFramed;
  for (std::size_t i = 0; i < count; i += stride) keepInSight(motif, run.sample(i).poses);
  keepInSight(motif, run.sample(count - 1).poses);
}

/// For the scale of colours: its bright end is the largest value among these.
void keepStates(Motif& motif, const TrajectoryReader& run) {
  const std::size_t count = run.times().size();
  const std::size_t stride = 1 + count / kSamplesFramed;
  for (std::size_t i = 0; i < count; i += stride) motif.states.push_back(run.sample(i).poses);
  motif.states.push_back(run.sample(count - 1).poses);
}

/// Without a target there is one end alone, so all of the run counts.
bool fitsEnds(const Model& model, const PictureSettings& settings) {
  if (settings.look.fit == FitScope::Auto) return model.target.has_value();
  return settings.look.fit == FitScope::Ends;
}

/// Whether a camera that cuts something off is the program's mistake, not the settings' wish.
bool choosesCamera(const PictureSettings& settings) {
  const CameraChoice& camera = settings.look.camera;
  return settings.look.fit == FitScope::Auto && camera.zoom == 1 && camera.keys.empty() &&
         !camera.distance;
}

/// Clip coordinates beyond -w to w are outside the picture.
bool seesAll(const Stage& stage, const Moment& moment, double aspect) {
  const Eigen::Matrix4d clip = clipFromWorld(stage.camera(moment), aspect);
  const std::vector<Vector3> corners = shownCorners(stage.motif(), moment.poses);
  return std::ranges::all_of(corners, [&](const Vector3& corner) {
    const Eigen::Vector4d point = clip * corner.homogeneous();
    return point.head<2>().cwiseAbs().maxCoeff() <= kBorder * point.w();
  });
}

/// Whether no sample of the run leaves pictures of this motif. Looks at every sample.
bool seesRun(const TrajectoryReader& run, const Stage& stage) {
  for (std::size_t i = 0; i < run.times().size(); ++i) {
    const Sample sample = run.sample(i);
    if (!seesAll(stage, {sample.time, sample.poses, {}}, stage.pictureSize().aspect())) {
      return false;
    }
  }
  return true;
}

}  // namespace

Motif motifOf(const Subject& subject) {
  Motif motif = makeMotif(subject.model, subject.brickRule, subject.ground);
  motif.hingeSprings = subject.hingeSprings;
  motif.obstacles = subject.obstacles;
  return motif;
}

Motif motifOf(const TrajectoryReader& run, const PictureSettings& settings) {
  Motif motif = motifOf(run.subject());
  const bool fits =
      fitsEnds(run.subject().model, settings) &&
      (!choosesCamera(settings) || seesRun(run, Stage(settings.look, motif, settings.size)));
  if (!fits) keepRunInSight(motif, run);
  if (isMeasure(settings.look.colouring) && !settings.look.colourMost) keepStates(motif, run);
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
              stripParts(settings, captions_, run.times().back()), Smoothness::Film) {
  report_.graphics = graphicsVersion();
}

/// This thread paints too, since its studio is there already.
void Album::makeFrames(const TrajectoryReader& run, const MotionCurve& motion,
                       const ProgressObserver& observer) {
  const std::vector<FrameMoment> moments = videoMoments(motion, settings_);
  const double begin = processCpuSeconds(), encoded = report_.recordCost.cpuSecondsEncode;
  double feeding = 0;
  const StateFeed feed = replay(run, moments, observer, report_);
  const int painters = std::min(settings_.painters(), static_cast<int>(moments.size()));
  OrderQueue orders(kWaitingSamples);
  FrameQueue frames(kWaitingFrames + painters);
  FramePool pool;
  Crew crew([&] {
    orders.stop();
    frames.stop();
  });
  crew.start([&] {
    const CpuTimer timer(feeding);
    feed([&](const SharedState& state) {
      FrameOrder order{state, {}};
      return frames.push(order.frame.get_future()) && orders.push(std::move(order));
    });
    orders.close();
    frames.close();
  });
  crew.start([&] { encode(frames, pool); });
  for (int k = 1; k < painters; ++k) {
    crew.start([&] {
      Studio studio(frames_);
      paint(studio, orders, pool);
    });
  }
  crew.run([&] { paint(frames_, orders, pool); });
  crew.finish();
  // What neither of these threads used went into painting, on whichever threads.
  report_.recordCost.cpuSecondsRender +=
      processCpuSeconds() - begin - feeding - (report_.recordCost.cpuSecondsEncode - encoded);
}

/// Ends when the queue is closed or stopped; CPU seconds are added under the lock.
void Album::paint(Studio& studio, OrderQueue& orders, FramePool& pool) {
  while (std::optional<FrameOrder> order = orders.pop()) {
    order->frame.set_value(takeFrame(studio, *order->state, pool.take()));
  }
}

/// On a thread of its own, with the only sink.
void Album::encode(FrameQueue& frames, FramePool& pool) {
  FrameSink sink(settings_, report_);
  const Style& style = frames_.stage().style();
  const Title title{settings_.title, settings_.subtitle};
  if (!title.empty()) {
    sink.putTitle(titleCard(title, settings_.size, style.background, style.text));
  }
  // A painter that fails breaks its promise, and has told the crew why.
  while (std::optional<std::future<Frame>> frame = frames.pop()) {
    Frame spare = sink.put(frame->get());
    if (!spare.pixels.empty()) pool.giveBack(std::move(spare));
  }
  if (!frames.isStopped()) sink.finish();
}

Frame Album::takeFrame(Studio& studio, const FrameState& state, Frame storage) const {
  return studio.take(stillOf(state), {captions_.inVideo(state), state.moment.progress},
                     std::move(storage));
}

Frame Album::takeStill(const FrameState& state) {
  const CpuTimer timer(report_.recordCost.cpuSecondsRender);
  if (!stills_) stills_.emplace(frames_, Smoothness::Still);
  return takeFrame(*stills_, state);
}

/// States are interpolated at the moments of the grid, not taken from the nearest sample.
void Album::writeGrid(const TrajectoryReader& run, const MotionCurve& motion) {
  PanelRow row{settings_.look, frames_.stage().motif(), {}, {}};
  Replay replayed(run);
  for (const FrameMoment& moment : snapshotMoments(motion, settings_, settings_.grid.cells())) {
    row.states.push_back({moment, replayed.at(moment.time)});
    row.captions.push_back(captions_.of(row.states.back()));
  }
  const std::vector<PanelRow> rows = {std::move(row)};
  PanelSheet(rows, settings_.grid, settings_, report_).write();
}

void Album::writeChosenFrames(const TrajectoryReader& run, const MotionCurve& motion) {
  makeFolder(settings_.folder / output::kFrames);
  for (const int number : chooseFrames(run.times(), motion, settings_.chosenFrames)) {
    const Sample sample = run.sample(static_cast<std::size_t>(number));
    const Frame frame = takeStill({momentAt(motion, settings_.pace, sample.time), sample});
    writePng(frame, settings_.folder / frameFile(number), pngSettings(settings_));
    report_.files.push_back(frameFile(number).string());
  }
}

/// The pictures that the timeline asked for.
void Album::writeMoments(const TrajectoryReader& run, const MotionCurve& motion) {
  int number = 0;
  for (const std::size_t index : samplesOf("snapshot", run)) {
    const Sample sample = run.sample(index);
    report_.files.push_back(momentFile(output::kSnapshotMoment, ++number, ".png"));
    writePng(takeStill({momentAt(motion, settings_.pace, sample.time), sample}),
             settings_.folder / report_.files.back(), pngSettings(settings_));
  }
}

void Album::writeSnapshots(const TrajectoryReader& run, const MotionCurve& motion) {
  writeMoments(run, motion);
  if (settings_.snapshots) writeGrid(run, motion);
  if (!settings_.chosenFrames.empty()) writeChosenFrames(run, motion);
}

}  // namespace kirireel
