/// The pictures of a run: video, single frames, snapshot grid.
#pragma once

#include "render/record/bounded_queue.h"
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
/// is deployed.
void requirePaintable(const Motif& motif, const PictureSettings& settings);

/// One studio and what it photographs. Belongs to the thread that makes it.
class Album {
 public:
  /// Settings and report must outlive the album. Throws InputError when the look asks for what the
  /// motif lacks, OutputError when no graphics context can be made.
  Album(const PictureSettings& settings, Motif motif, PictureReport& report);

  /// Paints the run's video frames and encodes them, both at the same time on threads of their own
  /// (painting on this one). The bytes do not depend on which is faster. Throws the first error of
  /// any of them.
  void makeFrames(const TrajectoryReader& run, const MotionCurve& motion,
                  const ProgressObserver& observer);

  /// Writes the snapshot grid, the timeline's snapshots and chosen frames. Throws OutputError.
  void writeSnapshots(const TrajectoryReader& run, const MotionCurve& motion);

 private:
  using FrameQueue = BoundedQueue<Frame>;
  using StateQueue = BoundedQueue<SharedState>;

  void paint(StateQueue& states, FrameQueue& frames);
  void encode(FrameQueue& frames);
  Frame take(const FrameState& state, Studio::Scales scales);
  std::string caption(const FrameState& state) const;
  void writeDrawing(const FrameState& state, int number);
  void writeGrid(const TrajectoryReader& run, const MotionCurve& motion);
  void writeMoments(const TrajectoryReader& run, const MotionCurve& motion);
  void writeChosenFrames(const TrajectoryReader& run, const MotionCurve& motion);

  const PictureSettings& settings_;
  PictureReport& report_;
  Studio studio_;
};

}  // namespace kirireel
