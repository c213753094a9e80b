/// The pictures of a run: video, single frames, snapshot grid.
#pragma once

#include <future>
#include <optional>

#include "render/record/bounded_queue.h"
#include "render/record/frame_pool.h"
#include "render/record/pace.h"
#include "render/record/record.h"
#include "render/record/replay.h"
#include "render/studio/studio.h"
#include "sim/trajectory/trajectory_file.h"

namespace kirireel {

/// A run as a studio sees it before it begins, its start and its target in sight.
Motif motifOf(const Subject& subject);

/// The same of a finished run, with everything in sight that the settings ask for. Where they leave
/// the camera to the program, that is all of the run if anything would be cut off.
Motif motifOf(const TrajectoryReader& run, const PictureSettings& settings);

/// Throws InputError when the look or the grid asks for what the motif cannot give, before anything
/// is deployed. Needs no graphics context.
void requirePaintable(const Motif& motif, const PictureSettings& settings);

/// Writes what pictures say of the states that they show. Holds a copy of the start, from which
/// turns are measured.
class CaptionWriter {
 public:
  CaptionWriter(const CaptionParts& parts, const Motif& motif)
      : parts_(parts), start_(motif.start), hasTarget_(motif.target.has_value()) {}

  /// In the grid to a tenth of a per cent; whole per cents where frames follow each other. One
  /// line, by the parts that were asked for.
  std::string of(const FrameState& state) const;
  std::string inVideo(const FrameState& state) const;
  /// At least as wide as any of a run that ends then, seconds.
  std::string longest(double endTime) const;

 private:
  std::string text(const FrameState& state, double progress) const;

  CaptionParts parts_;
  Poses start_;
  bool hasTarget_;
};

/// What stands under the frames of a video.
StripParts stripParts(const PictureSettings& settings, const CaptionWriter& captions,
                      double endTime);

/// One studio and what it photographs. Belongs to the thread that makes it.
class Album {
 public:
  /// Everything passed must outlive the album. Throws InputError when the look asks for what the
  /// motif lacks, OutputError when no graphics context can be made. Makes a graphics context and
  /// reads what motifOf() reads.
  Album(const TrajectoryReader& run, const PictureSettings& settings, PictureReport& report);

  /// Paints the run's video frames and encodes them at the same time: settings.painters() paint,
  /// one of them on this thread, each other thing has a thread of its own. The bytes depend neither
  /// on their number nor on which is faster. Throws the first error of any of them.
  void makeFrames(const TrajectoryReader& run, const MotionCurve& motion,
                  const ProgressObserver& observer);

  /// Writes the snapshot grid, the timeline's snapshots and chosen frames. Throws OutputError.
  void writeSnapshots(const TrajectoryReader& run, const MotionCurve& motion);

 private:
  /// A state to be painted; its frame is promised to the encoder in the order of states.
  struct FrameOrder {
    SharedState state;
    std::promise<Frame> frame;
  };
  using OrderQueue = BoundedQueue<FrameOrder>;
  using FrameQueue = BoundedQueue<std::future<Frame>>;

  void paint(Studio& studio, OrderQueue& orders, FramePool& pool);
  void encode(FrameQueue& frames, FramePool& pool);
  Frame takeFrame(Studio& studio, const FrameState& state, Frame storage = {}) const;
  Frame takeStill(const FrameState& state);
  void writeGrid(const TrajectoryReader& run, const MotionCurve& motion);
  void writeMoments(const TrajectoryReader& run, const MotionCurve& motion);
  void writeChosenFrames(const TrajectoryReader& run, const MotionCurve& motion);

  const PictureSettings& settings_;
  PictureReport& report_;
  CaptionWriter captions_;
  Studio frames_;                 ///< with a strip under its pictures
  std::optional<Studio> stills_;  ///< the same, smoother: of frames that stand alone
};

}  // namespace kirireel
